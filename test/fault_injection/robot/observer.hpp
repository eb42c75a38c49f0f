#pragma once
// The public statuses of a machine, with their times of receipt, and the public calls. The
// fault-injection suite checks by these alone, not by internals of the controller.
//
// Threads: calls from the fault-injection suite's thread; triggers run on the observer's loop, at
// once. Errors: throws std::runtime_error when the network cannot be used, Interrupted out of a
// wait.

#include <condition_variable>
#include <functional>
#include <future>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "musher/lifecycle/ids.hpp"
#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/transport/dds/node_thread.hpp"
#include "musher/transport/service.hpp"

namespace musher::fault_injection {

// The fault-injection suite was interrupted by a signal.
struct Interrupted {};
// From a signal's handler: waits end with Interrupted from now on.
void Interrupt();
void ThrowIfInterrupted();

class Observer {
 public:
  // Of the machine kMachine. `beside_another`: there is another one in the namespace.
  Observer(int domain, TransportProfile profile, const std::string& name_space,
           bool beside_another);
  ~Observer();
  Observer(const Observer&) = delete;
  Observer& operator=(const Observer&) = delete;

  using Is = std::function<bool(const msg::MachineStatus&)>;

  // The time of the first status since `since` for which `is` holds; none: not within `timeout`.
  std::optional<Time> AwaitSince(Time since, const Is& is, Duration timeout);
  // The same for the latest status, or a later one.
  std::optional<Time> Await(const Is& is, Duration timeout);
  std::optional<msg::MachineStatus> Latest();
  std::vector<msg::MachineStatus> Since(Time since);
  // Waits until the latest report of each actuator is in `state`; no earlier report arrives after
  // that. False: not within `timeout`.
  bool AwaitAllIn(const std::string& state, Duration timeout);
  // Discards all statuses but the latest.
  void Forget();

  // The actuators' reports since Forget(), in order.
  std::vector<msg::ActuatorStatus> Reports();
  std::map<std::string, msg::ActuatorStatus> LatestOfActuators();
  // Runs `act` once, on the loop, as soon as an actuator publishes a report for which `when` holds.
  using When = std::function<bool(const msg::ActuatorStatus&)>;
  std::shared_future<void> Once(When when, std::function<void()> act);
  void ForgetTriggers();

  std::shared_future<Result<msg::SetState::Response>> SetState(const std::string& target,
                                                               const std::string& actuator = "");
  Result<msg::RestartActuator::Response> Restart(const std::string& actuator);
  Result<msg::MachineStatus> GetStatus();
  // Publishes a latched stop, as `musher estop` does; ReleaseEmergencyStop() removes the publisher.
  void EngageEmergencyStop(StopId id);
  Result<msg::ReleaseEmergencyStop::Response> ReleaseEmergencyStop();

 private:
  struct Seen {
    Time at;
    std::optional<msg::MachineStatus> status;  // none: its publisher is lost
  };
  struct Trigger {
    When when;
    std::function<void()> act;
    std::promise<void> done;
  };

  void Make(const std::string& name_space);
  void OnMachine(std::optional<msg::MachineStatus> status);
  void OnActuator(const msg::ActuatorStatus& status);
  const Seen* OfTheLeader() const;  // null: no status; under the mutex
  std::optional<Time> AwaitUntil(Time deadline, const std::function<std::optional<Time>()>& found);
  // Sends the request as soon as the service of the current leader is discovered: the service of a
  // controller that has just ended is still matched.
  template <msg::Service S>
  std::shared_future<Result<typename S::Response>> Call(
      std::unique_ptr<transport::Client<S>>& client, const typename S::Request& request);

  const bool beside_another_;
  std::shared_ptr<transport::NodeThread> node_;
  std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  std::vector<Seen> machine_;
  std::vector<msg::ActuatorStatus> actuators_;
  std::map<std::string, msg::ActuatorStatus> latest_of_actuators_;

  std::list<Trigger> triggers_;          // on the loop, as all that follows
  transport::ParticipantId leader_ = 0;  // the participant of the latest machine status
  std::string emergency_stop_topic_;
  std::unique_ptr<transport::Publisher<msg::EmergencyStop>> emergency_stop_;
  std::unique_ptr<transport::Client<msg::SetState>> set_state_;
  std::unique_ptr<transport::Client<msg::RestartActuator>> restart_;
  std::unique_ptr<transport::Client<msg::GetStatus>> get_status_;
  std::unique_ptr<transport::Client<msg::ReleaseEmergencyStop>> release_;
  std::vector<std::unique_ptr<transport::Subscription>> subscriptions_;
};

// Waits for a future for at most a minute; then throws std::runtime_error.
template <class Future>
auto AwaitFuture(const Future& future) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (future.wait_for(Milliseconds(50)) != std::future_status::ready) {
    ThrowIfInterrupted();
    if (std::chrono::steady_clock::now() > deadline)
      throw std::runtime_error("no reply within a minute");
  }
  return future.get();
}

}  // namespace musher::fault_injection
