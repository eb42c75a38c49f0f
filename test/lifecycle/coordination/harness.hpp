#pragma once
// A whole machine in one test: a fake robot with messages delivered in virtual time. Each
// actuator's callbacks are scripted.

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "musher/base/check.hpp"
#include "musher/lifecycle/machine/machine_invariants.hpp"
#include "musher/search/fake_robot.hpp"

namespace musher::testing {

using search::Disk;
using search::FakeActuator;
using search::FakeController;
using search::FakeRobot;
using search::Message;

// The script of an actuator's callback.
struct Behaviour {
  Duration takes = Milliseconds(10);
  std::int32_t code = kCodeOk;
  std::string message;
  std::int32_t degraded_code = kCodeOk;  // of a self-check that passes as degraded
  std::string degraded_reason;
  bool hangs = false;
  bool ends_when_requested = false;  // a long callback that honours RequestStop, ending with Failed
  int exit_code = 0;                 // of "exec": the process exits with it before its first status
};

// Ends the program when the values of the machine do not agree with each other; also in fuzzers.
inline void CheckInvariants(const MachineConfig& config, const Machine& machine) {
  const std::string broken = BrokenInvariant(config, machine);
  MUSHER_CHECK(broken.empty(), broken);
}

class Harness : public FakeRobot {
 public:
  explicit Harness(MachineConfig config);

  // The script; may be changed at any time. State "" is for all states without their own; "exec" is
  // the start of the process, "TERM" and "KILL" its reaction to signals.
  Behaviour& On(const std::string& actuator, const std::string& state);

  // Starts the machine; hand-started actuators (no command) start at once.
  void Begin(bool by_hand = false, Epoch epoch = 0, bool restarted = false);
  // Starts an actuator's process, as a person would.
  void StartActuator(const std::string& name);
  // kill -9.
  void Crash(const std::string& name);
  // Its process exits by itself, with a code; `words` is the last line of its output.
  void Exit(const std::string& name, int code, const std::string& words);
  // Blocks the messages between controller and actuator, in one direction or both.
  void Mute(const std::string& name, bool to_actuator, bool from_actuator);
  // Its latched status arrives, as the transport ensures for a new controller, and for one that did
  // not receive it as soon as the link works again.
  void RepeatStatus(const std::string& name);
  // Delays the messages of the actuator by this time.
  void DelayReports(const std::string& name, Duration delay) { fakes_[Index(name)].delay = delay; }
  // The health monitor's verdict.
  void Find(const std::string& name, Health health, bool silent = false);
  // Engages an emergency stop; all actuators receive it.
  void StopAll(StopId id, const std::string& by = "the test");
  RequestId Release();
  // Requests a release and advances time until the answer.
  Result<> Released();
  // A heartbeat of another controller arrives.
  void ReceiveRivalHeartbeat(Epoch epoch);
  // Requests a restart of an actuator; the answer is stored in `calls`.
  RequestId Restart(const std::string& name);
  // Sends a request to the policy; the answer is stored in `calls`.
  RequestId SendPolicyRequest(event::PolicyRequested requested);
  // A new controller takes over; the old one is dropped at any point of its work.
  // `lost_disk`: it does not know the previous epochs.
  // `restarted`: by a supervisor.
  void RestartController(bool lost_disk = false, bool restarted = false);

  // Requests a switch and returns at once; the answer is stored in `answers`.
  RequestId RequestSwitch(const State& target, std::optional<std::string> actuator = std::nullopt,
                          const Requester& by = {});
  // Requests a switch and advances time until the answer.
  SwitchResult Set(const State& target, std::optional<std::string> actuator = std::nullopt,
                   const Requester& by = {});

  // Advances time until only far deadlines are left, or `limit` has passed.
  void Rest(Duration limit = std::chrono::seconds(60));
  void RunFor(Duration duration);
  // Advances time until `done` holds; false when it did not within a simulated hour.
  bool RunUntil(const std::function<bool()>& done);

  const Machine& machine() const { return controller_.machine; }
  const MachineConfig& config() const { return config_; }
  State StateOf(const std::string& actuator) const;
  const KnownActuator& RecordOf(const std::string& actuator) const;
  const ActuatorCore& CoreOf(const std::string& actuator) const;
  bool IsAlive(const std::string& actuator) const { return fakes_[Index(actuator)].alive; }
  // The callbacks that were begun: "audio:Active".
  const std::vector<std::string>& log() const { return log_; }
  void ClearLog() { log_.clear(); }
  bool usable() const { return start_up_ && start_up_->usable; }
  const std::optional<action::StartUpEnded>& start_up() const { return start_up_; }
  bool stopped() const { return stopped_; }
  std::map<RequestId, SwitchResult> answers;
  std::map<RequestId, Result<>> calls;
  std::vector<action::Record> records;  // of all controllers
  Disk& disk() { return controller_.disk; }
  std::optional<Duration> disk_takes = Duration{};  // for a save; none: it never ends
  std::string disk_fails;                           // why a save fails; empty: it does not
  std::vector<std::pair<Time, bool>> power;  // when the power command came, and whether to reboot
  std::optional<std::string> fenced;
  std::vector<action::Record> whole_records;  // of the present controller: id n at n - 1
  std::vector<std::string> signals;           // "audio:TERM"
  std::set<std::string> shared;      // actuators whose process still runs after their TearDown
  bool supervised = false;           // a supervisor starts the controllers, at boot or again
  bool lost_stops = false;           // what the controller publishes of stops does not arrive
  std::function<void()> after_step;  // called after every step of the controller
  bool was_timer = false;            // whether that step was of event::TimePassed
  Time now() const { return controller_.now; }
  // An error of the actuator: it is in another state without a command.
  void GoByItself(const std::string& actuator, const State& state) {
    fakes_[Index(actuator)].core.report.state = state;
    Feed(event::StatusSeen{Index(actuator), Report(Index(actuator))});
  }
  // Commands of the test itself, as from an unknown participant.
  void Inject(const std::string& actuator, const ActuatorEvent& event) {
    StepActuator(Index(actuator), event);
  }

 private:
  struct ScriptedActuator : FakeActuator {
    bool rx_blocked = false;
    bool tx_blocked = false;
    Duration delay{};
    int run = 0;  // counts callbacks, so that the end of an old one does not count for a new one
    bool hanging = false;
    std::map<std::string, Behaviour> script;
  };

  void StepController(const Event& event) override;
  void StepActuator(ActuatorIndex i, const ActuatorEvent& event) override;
  FakeActuator& Actuator(ActuatorIndex i) override { return fakes_[i]; }
  RequestToken TokenOf(Sender sender, CommandNumber number, bool query) override;
  void Send(const Message& message) override;
  void Save(Stored what, SaveNumber save, std::function<void(Disk&)> write) override;
  void Do(const Action& action) override;

  void After(Duration delay, std::function<void()> what);
  bool StepTime(Time limit);
  void Do(ActuatorIndex i, const ActuatorAction& action);
  void StartProcess(ActuatorIndex i);
  void PublishStop(StopId id, bool engaged, Sender sender);
  void EndProcess(ActuatorIndex i, bool clean, const std::string& how, int exit_code = 0);
  ActuatorIndex Index(const std::string& name) const { return *config_.IndexOf(name); }

  const MachineConfig own_config_;
  FakeController own_controller_;
  PerActuator<ScriptedActuator> fakes_;
  std::multimap<Time, std::function<void()>> later_;
  // Sender and number of the request with token n, and whether it is a query.
  std::vector<std::tuple<Sender, CommandNumber, bool>> requests_;
  std::set<StopId> latched_stops_;  // kept by the topic for late subscribers
  std::vector<std::string> log_;
  std::optional<action::StartUpEnded> start_up_;
  bool stopped_ = false;
  RequestId next_request_ = 1;
  std::int32_t next_pid_ = 1000;
};

// A machine of actuators "a", "b", "c", …, all states of CyberDog, 100 ms each.
MachineConfig MachineOf(int actuators);
ActuatorConfig& ActuatorNamed(MachineConfig& config, const std::string& name);
// Each actuator lists all states of the machine; 100 ms for those that it did not list.
inline void ListAllStates(MachineConfig& config) {
  for (ActuatorConfig& actuator : config.actuators) {
    actuator.states = config.states;
    actuator.times.resize(config.states.size(), Milliseconds(100));
  }
}

// A machine with Dancing, which is as active as Active.
inline MachineConfig WithDancing(MachineConfig config) {
  config.states.emplace_back("Dancing");
  config.ranks["Dancing"] = *BuiltInRank(kActive);
  config.flow = DefaultFlow(config.states);
  ListAllStates(config);
  return config;
}

}  // namespace musher::testing
