#pragma once
// A whole machine in one test: the real coordinator and real actuator cores, with messages handed
// over in virtual time. Each actuator's callbacks are scripted.

#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "musher/lifecycle/actuator_core.hpp"
#include "musher/lifecycle/coordinator.hpp"

namespace musher::testing {

// What an actuator's callback does.
struct Behaviour {
  Duration takes = Milliseconds(10);
  std::int32_t code = kCodeOk;
  std::string message;
  std::int32_t degraded_code = kCodeOk;  // of a self-check that passes with a part out of order
  std::string degraded_reason;
  bool hangs = false;
  bool ends_when_asked = false;  // a long callback that honours RequestStop, ending with Failed
  int exit_code = 0;             // of "exec": the process ends with it before it says a word
};

class Harness {
 public:
  explicit Harness(MachineConfig config);

  // The script; to be changed at any time. State "" is for all states without their own; "exec" is
  // the start of the process, "TERM" and "KILL" what it does with signals.
  Behaviour& On(const std::string& actuator, const std::string& state);

  // Starts the machine; hand-started actuators (no command) start at once.
  void Begin(bool by_hand = false, std::uint64_t epoch = 0, bool restarted = false);
  // Starts an actuator's process, as a person would.
  void StartActuator(const std::string& name);
  // kill -9.
  void Crash(const std::string& name);
  // Its process ends by itself, not content; the last line that it writes is `words`.
  void Exit(const std::string& name, int code, const std::string& words);
  // No message passes between controller and actuator any more, in that direction or both.
  void Mute(const std::string& name, bool to_actuator, bool from_actuator);
  // What the actuator says takes so much longer to come.
  void DelayReports(const std::string& name, Duration delay) { actors_[Index(name)].delay = delay; }
  // The health monitor's verdict.
  void Find(const std::string& name, Health health, bool silent = false);
  // Somebody engages an emergency stop; all hear it.
  void StopAll(std::uint64_t id, const std::string& by = "the test");
  RequestId Release();
  // Another controller is heard.
  void HearRival(std::uint64_t epoch);
  // Anything else that the controller may hear.
  void Tell(const Event& event);
  // A person restarts an actuator; the answer comes into `calls`.
  RequestId Restart(const std::string& name);
  // Asks the policy; the answer comes into `calls`.
  RequestId AskPolicy(event::PolicyRequested asked);
  // A new controller takes over; the old one is forgotten in the middle of whatever it did.
  // `lost_disk`: it does not know the epochs before it.
  // `restarted`: by a supervisor.
  void RestartController(bool lost_disk = false, bool restarted = false);

  // Asks for a switch and returns at once; the answer comes into `answers`.
  RequestId Ask(const State& target, std::optional<std::string> actuator = std::nullopt);
  // Asks and lets time pass until the answer is there.
  SwitchResult Set(const State& target, std::optional<std::string> actuator = std::nullopt);

  // Lets time pass until nothing but far deadlines is left, or `limit` is over.
  void Rest(Duration limit = std::chrono::seconds(60));
  void RunFor(Duration duration);
  // Lets time pass until `done` holds; false when it did not within a simulated hour.
  bool RunUntil(const std::function<bool()>& done);

  const Machine& machine() const { return machine_; }
  const MachineConfig& config() const { return config_; }
  State StateOf(const std::string& actuator) const;
  const ActuatorRecord& RecordOf(const std::string& actuator) const;
  const ActuatorCore& CoreOf(const std::string& actuator) const;
  bool IsAlive(const std::string& actuator) const { return actors_[Index(actuator)].alive; }
  // The callbacks that were begun: "audio:Active".
  const std::vector<std::string>& log() const { return log_; }
  void ClearLog() { log_.clear(); }
  bool usable() const { return start_up_ && start_up_->usable; }
  const std::optional<action::StartUpEnded>& start_up() const { return start_up_; }
  bool stopped() const { return stopped_; }
  std::map<RequestId, SwitchResult> answers;
  std::map<RequestId, Result<>> calls;
  std::vector<std::string> records;
  StoredStops stops_on_disk;
  bool stop_intent_on_disk = false;
  std::optional<Duration> disk_takes = Duration{};  // for a save; none: it never ends
  std::string disk_fails;                           // why a save fails; empty: it does not
  StoredPolicy policy_on_disk;
  std::vector<std::pair<Time, bool>> power;  // when the power command came, and whether to reboot
  std::optional<std::string> fenced;
  std::vector<action::Record> told;  // the same, whole, of the present controller
  std::vector<std::string> signals;  // "audio:TERM"
  std::set<std::string> shared;      // actuators whose process lives on after their TearDown
  std::function<void()> after_step;  // what holds after every step of the controller
  Time now() const { return now_; }
  // Commands written by the test itself, as a stranger might.
  std::vector<ActuatorAction> Inject(const std::string& actuator, const ActuatorEvent& event);

 private:
  struct Actor {
    bool alive = false;
    bool visible = false;
    bool deaf = false;
    bool dumb = false;
    Duration delay{};
    std::int32_t pid = 0;
    int run = 0;  // counts callbacks, so that the end of an old one is not taken for a new one's
    bool hanging = false;
    ActuatorCore core;
    std::map<RequestToken, std::pair<std::uint64_t, bool>> requests;  // number, ask
    std::map<std::string, Behaviour> script;
  };

  void After(Duration delay, std::function<void()> what);
  bool StepTime(Time limit);
  void Perform(std::size_t i, const ActuatorEvent& event);
  void Do(std::size_t i, const ActuatorAction& action);
  void Do(const Action& action);
  void TellActuators(const action::TellEmergencyStop& stop);
  template <class T>
  void Save(Stored what, std::uint64_t save, T& stored, T value);
  Sender ControllerId() const { return static_cast<Sender>(generation_) + 1; }
  void EndProcess(std::size_t i, bool clean, const std::string& how, int exit_code = 0);
  ActuatorReport ReportOf(std::size_t i) const;
  std::size_t Index(const std::string& name) const { return *config_.IndexOf(name); }

  MachineConfig config_;
  Machine machine_;
  int generation_ = 0;  // of the controller
  std::vector<Actor> actors_;
  Time now_{};
  std::multimap<Time, std::function<void()>> later_;
  std::set<std::uint64_t> latched_stops_;  // the topic keeps them for those that come later
  std::vector<std::string> log_;
  std::optional<action::StartUpEnded> start_up_;
  bool stopped_ = false;
  RequestId next_request_ = 1;
  RequestToken next_token_ = 1;
  std::int32_t next_pid_ = 1000;
  std::uint64_t epoch_on_disk_ = 0;
};

// A machine of actuators "a", "b", "c", …, all states of CyberDog, 100 ms each.
MachineConfig MachineOf(int actuators);
ActuatorConfig& ActuatorNamed(MachineConfig& config, const std::string& name);

}  // namespace musher::testing
