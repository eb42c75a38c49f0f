#pragma once
// What anybody on the network can see of a machine, with the time at which it came, and the calls
// that anybody can make. The fault-injection suite judges by this alone, not by the controller's
// insides.
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

#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/transport/node_thread.hpp"
#include "musher/transport/service.hpp"

namespace musher::fault_injection {

// A person wants the fault-injection suite to end.
struct Interrupted {};
// From a signal's handler: waits end with Interrupted from now on.
void Interrupt();
void ThrowIfInterrupted();

class Observer {
 public:
  Observer(int domain, TransportProfile profile, const std::string& name_space);
  ~Observer();
  Observer(const Observer&) = delete;
  Observer& operator=(const Observer&) = delete;

  using Is = std::function<bool(const msg::MachineStatus&)>;

  // When the first status since `since` came that is so; none: not within `patience`.
  std::optional<Time> AwaitSince(Time since, const Is& is, Duration patience);
  // When the machine is so, which it may be already.
  std::optional<Time> Await(const Is& is, Duration patience);
  std::optional<msg::MachineStatus> Latest();
  std::vector<msg::MachineStatus> Since(Time since);
  // Waits until the latest that each actuator has said of itself is that it is in `state`; what
  // was said before comes no more then. False: not within `patience`.
  bool AwaitAllIn(const std::string& state, Duration patience);
  // Everything from before is forgotten but the latest.
  void Forget();

  // What actuators said of themselves since Forget(), in order.
  std::vector<msg::ActuatorStatus> Said();
  std::map<std::string, msg::ActuatorStatus> LatestOfActuators();
  // Runs `act` once, on the loop, as soon as an actuator says something for which `when` holds.
  using When = std::function<bool(const msg::ActuatorStatus&)>;
  std::shared_future<void> Once(When when, std::function<void()> act);
  void ForgetTriggers();

  std::shared_future<Result<msg::SetState::Response>> SetState(const std::string& target,
                                                               const std::string& actuator = "");
  Result<msg::RestartActuator::Response> Restart(const std::string& actuator);
  Result<msg::MachineStatus> GetStatus();
  // As `musher estop` does: it is told, latched, and whoever has told it is gone in the end.
  void EngageEmergencyStop(std::uint64_t id);
  Result<msg::ReleaseEmergencyStop::Response> ReleaseEmergencyStop();

 private:
  struct Seen {
    Time at;
    std::optional<msg::MachineStatus> status;  // none: its writer is gone
  };
  struct Trigger {
    When when;
    std::function<void()> act;
    std::promise<void> done;
  };

  void Make(const std::string& name_space);
  void OnMachine(std::optional<msg::MachineStatus> status);
  void OnActuator(const msg::ActuatorStatus& status);
  std::optional<Time> AwaitUntil(Time deadline, const std::function<std::optional<Time>()>& found);
  // Sends the request as soon as the service of who leads now has been discovered: one who has just
  // died is still matched.
  template <msg::Service S>
  std::shared_future<Result<typename S::Response>> Call(
      std::unique_ptr<transport::Client<S>>& client, const typename S::Request& request);

  std::shared_ptr<transport::NodeThread> node_;
  std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  std::vector<Seen> machine_;
  std::vector<msg::ActuatorStatus> actuators_;
  std::map<std::string, msg::ActuatorStatus> latest_of_actuators_;

  std::list<Trigger> triggers_;   // on the loop, as all that follows
  transport::PeerId leader_ = 0;  // the participant that told of the machine last
  std::string emergency_stop_topic_;
  std::unique_ptr<transport::Publisher<msg::EmergencyStop>> emergency_stop_;
  std::unique_ptr<transport::Client<msg::SetState>> set_state_;
  std::unique_ptr<transport::Client<msg::RestartActuator>> restart_;
  std::unique_ptr<transport::Client<msg::GetStatus>> get_status_;
  std::unique_ptr<transport::Client<msg::ReleaseEmergencyStop>> release_;
  std::vector<std::unique_ptr<transport::Subscription>> subscriptions_;
};

// Waits for what has to come within a minute; throws std::runtime_error when it does not.
template <class Future>
auto Answer(const Future& future) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (future.wait_for(Milliseconds(50)) != std::future_status::ready) {
    ThrowIfInterrupted();
    if (std::chrono::steady_clock::now() > deadline) throw std::runtime_error("no answer at all");
  }
  return future.get();
}

}  // namespace musher::fault_injection
