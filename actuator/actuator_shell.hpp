#pragma once
// The I/O around the actuator's decision code (lifecycle/actuator/actuator_core.hpp): samples and
// the worker's results become events, actions become replies, callbacks and the latched status.
//
// Threads: loop thread only. Runs on any transport; the simulation runs this class, too.

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "musher/actuator/checkpoints.hpp"
#include "musher/actuator/fs_machine.hpp"
#include "musher/actuator/worker.hpp"
#include "musher/lifecycle/actuator/actuator_core.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/machine/machine_identity.hpp"
#include "musher/messages/musher_msgs/actuator_command.hpp"
#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/transport/loop_breaks.hpp"
#include "musher/transport/node.hpp"
#include "musher/transport/service.hpp"
#include "musher/wire/battery_watch.hpp"
#include "musher/wire/managed_node_endpoints.hpp"
#include "musher/wire/node_services.hpp"

namespace musher {

struct ActuatorIdentity {
  Incarnation incarnation = 0;  // not 0; higher with every start on a host
  std::int32_t pid = 0;
  std::string host;
  // Name and id of the machine, from the controller that has started the process. Without one: the
  // name in the config, and no id.
  std::string machine{};
  std::string machine_id{};
};

class ActuatorShell {
 public:
  struct Hooks {
    std::function<Result<>(const State&)> run_callback;  // on the worker
    // Whether process `pid` holds the controller's name of this namespace and domain on this host.
    // Only one process can. The hook may be empty.
    std::function<bool(std::int32_t pid)> leads_here;
    std::function<void(bool)> set_stop_requested;  // false when a callback begins, true to stop it
    // The degraded report of the callback that has ended, code 0: none; may be empty.
    std::function<Error()> take_degraded;
    std::function<void()> on_emergency_stop;  // at once, on the loop; may be empty
    // What on_emergency_stop has not done yet, or could not do; "": all is done. The hook may be
    // empty.
    std::function<std::string()> stop_trouble;
    std::function<void(const ActuatorReport&)> on_report;  // after each step; may be empty
    // The battery level in percent; called only if a capability of this actuator needs it.
    std::function<void(std::optional<int>)> on_battery;
    std::function<void()> on_set_up;         // SetUp is done and the services are available
    std::function<void(Error)> on_finished;  // torn down (code 0), or SetUp failed
    // A line for the actuator's log; may be empty.
    std::function<void(const std::string&)> on_remark;
    // What the tools of ROS 2 are offered after SetUp: the services of every node, or those of a
    // managed node as well.
    enum class Ros2 { kNothing, kNode, kManagedNode };
    Ros2 ros2 = Ros2::kNothing;
  };

  // `config`, `node` and `worker` must outlive the shell.
  static Result<std::unique_ptr<ActuatorShell>> Make(transport::Node& node, Worker& worker,
                                                     const MachineConfig& config,
                                                     ActuatorIndex index, ActuatorIdentity identity,
                                                     Hooks hooks);

  // Runs SetUp; the status is latched from now on.
  void Start();
  // Part of the actuator has failed outside of a callback; code 0: the fault with this message is
  // over. Takes effect in the next turn of the loop.
  void ReportFault(const Error& fault);
  // What the hook stop_trouble returns has changed. From any thread.
  void CompareStopTrouble();
  // No callback begins from now on; a running one continues, and a stop still stops it. The worker
  // may be dropped after that.
  void Close() { closed_ = true; }

  const ActuatorReport& report() const { return core_.report; }
  const ActuatorCore& core() const { return core_; }
  // For the threads of the module; valid as long as the shell.
  Checkpoints& checkpoints() { return checkpoints_; }

 private:
  ActuatorShell(transport::Node& node, Worker& worker, const MachineConfig& config,
                ActuatorIndex index, ActuatorIdentity identity, Hooks hooks);

  using Reply = transport::Server<msg::ActuatorCommand>::Reply;

  Result<> Open();
  Result<> WatchBattery();
  void OnControllerHeartbeat(const msg::ControllerHeartbeat& heartbeat,
                             const transport::SampleInfo& info);
  void OnEmergencyStop(const msg::EmergencyStop& stop, const transport::SampleInfo& info);
  Result<> WatchPermits();
  void OnRequest(const msg::ActuatorCommand::Request& request, Reply reply,
                 transport::ParticipantId sender);
  // Why a manager's command that has just arrived does not switch on: it has no age, and may be as
  // old as a break in which this process could not run. `breaks`: since its service exists. What
  // ended before, such as a stall at boot, has delayed no command.
  std::optional<Error> MayBeLate(const State& target, transport::LoopBreaks& breaks);
  using OnManagerAnswered = std::function<void(const actuator_action::Answer&)>;
  void OnManager(const State& target, transport::LoopBreaks& breaks, OnManagerAnswered answered);
  void OfferToRos2At(Time when);
  void OfferToRos2();
  void OfferManagedNode();
  void ChangeManagedNode(const Ros2Transition& transition,
                         transport::ManagedNodeEndpoints::Done done);
  void FinishAfterLastQuery(const Error& end, Time deadline);
  void Handle(const ActuatorEvent& event);
  void Do(const actuator_action::RunCallback& action);
  void Do(const actuator_action::RequestStop& action);
  void Do(const actuator_action::RunEmergencyStop& action);
  void Do(const actuator_action::Answer& action);
  void Refuse(RequestToken token, const Error& why) {
    Do(actuator_action::Answer{token, Verdict::kRefused, why.code, why.message});
  }
  void Do(const actuator_action::PublishStatus& action);
  void Do(const actuator_action::BecomeVisible& action);
  void Do(const actuator_action::Finish& action);
  void Publish();
  bool CountsWhenClosed(const ActuatorEvent& event);
  void ArmTimer();
  void CheckWork();
  void Heartbeat(const Checkpoints::Look& look);
  msg::ActuatorStatus Status();
  // What an engaged emergency stop has not done yet, or could not do; "": all is done.
  std::string StopTrouble() const;

  transport::Node& node_;
  Worker& worker_;
  const MachineConfig& config_;
  const ActuatorIndex index_;
  const ActuatorConfig& actuator_;
  Hooks hooks_;
  ActuatorCore core_;
  MachineIdentity machine_;  // its id is learned from the controller that takes control
  bool closed_ = false;
  std::string stop_trouble_;  // as it was published last
  RequestToken next_token_ = 1;
  Time last_stamp_{};
  std::map<RequestToken, std::function<void(const actuator_action::Answer&)>> replies_;
  Checkpoints checkpoints_;
  Health sent_work_ = Health::kWell;  // in the last heartbeat
  Time heartbeat_at_{};               // of the last heartbeat
  Time controller_heard_{};           // the last heartbeat of its controller
  std::optional<Time> armed_for_;
  std::unique_ptr<transport::Publisher<msg::ActuatorStatus>> status_;
  std::unique_ptr<transport::Publisher<msg::ActuatorHeartbeat>> heartbeats_;
  transport::LoopHandlePtr look_;
  transport::LoopHandlePtr timer_;
  std::unique_ptr<transport::Subscription> controllers_;
  std::unique_ptr<transport::Subscription> emergency_stops_;
  std::unique_ptr<transport::Subscription> permits_;
  std::unique_ptr<transport::BatteryWatch> battery_;
  transport::LoopHandlePtr publish_later_;
  std::unique_ptr<transport::Server<msg::ActuatorCommand>> server_;
  std::optional<transport::LoopBreaks> fs_machine_breaks_;
  std::unique_ptr<FsMachine> fs_machine_;
  std::optional<transport::NodeServices> services_;  // of a node that is not managed
  std::optional<transport::LoopBreaks> managed_node_breaks_;
  std::unique_ptr<transport::ManagedNodeEndpoints> managed_node_;
  transport::LoopHandlePtr offer_later_;
  transport::LoopHandlePtr finish_later_;
  // Expires before late results arrive.
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);
};

}  // namespace musher
