#pragma once
// The controller's decision code: Step(config, machine, event, now) changes the machine and gives
// the actions. Pure and deterministic - no clock, no thread, no IO; the shell (controller/) and the
// simulation turn the world into events and actions into the world.
//
// In layers, each in its own file:
//   arriving.cpp   an actuator publishes its status, and this controller takes control of it
//   commands.cpp   one command to one actuator, with a definite outcome
//   switching.cpp  a switch: legs in the order of the plan, rollback
//   switch_end.cpp the effects of a switch that has ended, and its result
//   waiting.cpp    a request that waits until a late actuator is free
//   starting.cpp   processes, the first stage, adoption, later stages
//   joining.cpp    drives one actuator to the state of the machine
//   recovery.cpp   actuators that crashed, hang or lost their connection; restarts
//   binding.cpp    actuators that go down and up with others (binds_to)
//   authority.cpp  other controllers, the emergency stop
//   policy_rules.cpp, policy_requests.cpp, power.cpp  the manager's rules (policy.hpp)
//   stopping.cpp   TearDown, SIGTERM, SIGKILL within the budget
//   saving.cpp     what has to be on disk, and what is not saved yet

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "musher/lifecycle/machine.hpp"

namespace musher {

// Identifies a caller that waits for an answer; chosen by the shell.
using RequestId = std::uint64_t;

// The fault of an actuator that sends nothing any more, until more is known about it.
inline constexpr const char* kOutOfReach = "connection lost";

namespace event {

// Starts the machine: with `by_hand` only SetUp, the rest comes as requests. `running[i]` says that
// a process of actuator i runs on this host already, `processes[i]` is its pid where its end can be
// seen, else 0. `epoch`, `stops`, `policy`, `stop_intent` and `remote` are what was found on disk.
// `restarted`: a supervisor restarts the controller, not a person; with `stop_intent` the
// controller finishes the TearDown that was begun, and the machine stays down. A person's start
// clears the intent.
struct Begin {
  bool by_hand = false;
  std::uint64_t epoch = 0;
  std::vector<bool> running;
  std::string host = {};  // of the controller
  StoredStops stops = {};
  std::vector<std::int32_t> processes = {};
  StoredPolicy policy = {};
  bool stop_intent = false;
  bool restarted = false;
  std::vector<RemoteActuator> remote = {};
  friend bool operator==(const Begin&, const Begin&) = default;
};
// An actuator's latched status was received.
struct StatusSeen {
  std::size_t actuator = 0;
  ActuatorReport report;
  friend bool operator==(const StatusSeen&, const StatusSeen&) = default;
};
// An actuator replied to command `number`, or to the query about it (`query`).
struct Replied {
  std::size_t actuator = 0;
  std::uint64_t number = 0;
  bool query = false;
  Verdict verdict = Verdict::kDone;
  std::int32_t code = kCodeOk;
  std::string message;
  ActuatorReport report;
  friend bool operator==(const Replied&, const Replied&) = default;
};
// The actuator of this incarnation was lost: its process exited or its writer was lost.
struct Vanished {
  std::size_t actuator = 0;
  std::uint64_t incarnation = 0;
  bool for_good = false;  // its process has exited; otherwise it may connect again
  std::string how;        // "its process 4711 ended", kOutOfReach
  friend bool operator==(const Vanished&, const Vanished&) = default;
};
struct ProcessStarted {
  std::size_t actuator = 0;
  std::int32_t pid = 0;
  friend bool operator==(const ProcessStarted&, const ProcessStarted&) = default;
};
struct ProcessNotStarted {
  std::size_t actuator = 0;
  std::string why;
  friend bool operator==(const ProcessNotStarted&, const ProcessNotStarted&) = default;
};
// The result of action::FindProcesses: for each actuator the pid of the process that runs and is
// watched now, or 0.
struct ProcessesFound {
  std::vector<std::int32_t> processes;
  friend bool operator==(const ProcessesFound&, const ProcessesFound&) = default;
};
// A process that this controller started has exited.
struct ProcessEnded {
  std::size_t actuator = 0;
  std::int32_t pid = 0;
  bool clean = false;          // exit code 0
  std::string how;             // "exit code 3", "killed by SIGKILL"
  std::int32_t exit_code = 0;  // of a process that exited by itself; 0 otherwise, or where unknown
  friend bool operator==(const ProcessEnded&, const ProcessEnded&) = default;
};
// The health monitor's verdict on a running process.
struct HealthChanged {
  std::size_t actuator = 0;
  std::uint64_t incarnation = 0;
  Health health = Health::kWell;
  bool silent = false;  // it does not answer either
  std::string how;
  friend bool operator==(const HealthChanged&, const HealthChanged&) = default;
};
// The backtrace of a hung process, or why there is none.
struct BacktraceTaken {
  std::size_t actuator = 0;
  std::int32_t pid = 0;
  std::string text;
  friend bool operator==(const BacktraceTaken&, const BacktraceTaken&) = default;
};
// A person requests a restart of an actuator's process.
struct RestartRequested {
  RequestId request = 0;
  std::string actuator;
  friend bool operator==(const RestartRequested&, const RestartRequested&) = default;
};
// A heartbeat of another controller of this machine was received.
struct RivalSeen {
  std::uint64_t epoch = 0;
  std::string who;              // "process 4711 on this host"
  bool has_precedence = false;  // where both have the same epoch
  friend bool operator==(const RivalSeen&, const RivalSeen&) = default;
};
// A participant engages an emergency stop, or has released one.
struct EmergencyStopSeen {
  EmergencyStop stop;
  bool engaged = true;
  friend bool operator==(const EmergencyStopSeen&, const EmergencyStopSeen&) = default;
};
struct ReleaseRequested {
  RequestId request = 0;
  std::string by;
  friend bool operator==(const ReleaseRequested&, const ReleaseRequested&) = default;
};
struct SetStateRequested {
  RequestId request = 0;
  State target;
  std::optional<std::string> actuator = {};
  AfterTearDown after = AfterTearDown::kStaysDown;  // of a TearDown of the machine
  friend bool operator==(const SetStateRequested&, const SetStateRequested&) = default;
};
// Answer when all actuators are set up, or when that has failed.
struct SetUpAwaited {
  RequestId request = 0;
  friend bool operator==(const SetUpAwaited&, const SetUpAwaited&) = default;
};
// The battery has changed. A value out of range is recorded and otherwise ignored.
struct BatterySeen {
  std::int32_t percent = 0;
  bool charging = false;
  friend bool operator==(const BatterySeen&, const BatterySeen&) = default;
};
// The body has begun another motion.
struct MotionSeen {
  std::int32_t motion = 0;  // its id
  friend bool operator==(const MotionSeen&, const MotionSeen&) = default;
};
// An input of the policy has timed out: no sample for its time.
struct InputSilent {
  PolicyInput input = PolicyInput::kBattery;
  friend bool operator==(const InputSilent&, const InputSilent&) = default;
};
// The time of /clock, where the policy follows it: sent when NextPolicyDeadline() is reached, and
// just before any other event that concerns the policy.
struct ClockReceived {
  Time clock{};
  friend bool operator==(const ClockReceived&, const ClockReceived&) = default;
};
struct PolicyRequested {
  RequestId request = 0;
  PolicyRequest what = PolicyRequest::kWakeUp;
  State state;             // of kSwitch and kKeep
  std::int64_t ticks = 0;  // of kKeep, in seconds
  bool enable = false;     // of kOta and the low-power switch
  friend bool operator==(const PolicyRequested&, const PolicyRequested&) = default;
};
// The save of that number has ended. A failed save may still succeed later; then this event comes
// again.
struct SaveEnded {
  Stored what = Stored::kEpoch;
  std::uint64_t save = 0;
  bool ok = false;
  std::string why;  // of a failure
  friend bool operator==(const SaveEnded&, const SaveEnded&) = default;
};
// Only time has passed.
struct TimePassed {
  friend bool operator==(const TimePassed&, const TimePassed&) = default;
};

}  // namespace event

using Event =
    std::variant<event::Begin, event::StatusSeen, event::Replied, event::Vanished,
                 event::ProcessStarted, event::ProcessNotStarted, event::ProcessesFound,
                 event::ProcessEnded, event::HealthChanged, event::BacktraceTaken,
                 event::RestartRequested, event::RivalSeen, event::EmergencyStopSeen,
                 event::ReleaseRequested, event::SetStateRequested, event::SetUpAwaited,
                 event::BatterySeen, event::MotionSeen, event::InputSilent, event::ClockReceived,
                 event::PolicyRequested, event::SaveEnded, event::TimePassed>;

namespace action {

struct SendSwitch {
  std::size_t actuator = 0;
  std::uint64_t number = 0;
  State target;
  Duration budget{};
  bool apart = false;  // for this actuator alone, detached from the machine
  friend bool operator==(const SendSwitch&, const SendSwitch&) = default;
};
struct SendQuery {
  std::size_t actuator = 0;
  std::uint64_t number = 0;
  bool stop = false;
  friend bool operator==(const SendQuery&, const SendQuery&) = default;
};
struct StartProcess {
  std::size_t actuator = 0;
  friend bool operator==(const StartProcess&, const StartProcess&) = default;
};
// Find which actuators that have a command run on this host; comes back as ProcessesFound.
struct FindProcesses {
  friend bool operator==(const FindProcesses&, const FindProcesses&) = default;
};
struct SignalProcess {
  std::size_t actuator = 0;
  std::int32_t pid = 0;
  bool kill = false;  // SIGKILL instead of SIGTERM
  friend bool operator==(const SignalProcess&, const SignalProcess&) = default;
};
struct AnswerSetState {
  RequestId request = 0;
  SwitchResult result;
  friend bool operator==(const AnswerSetState&, const AnswerSetState&) = default;
};
// Answers a request that is not a switch.
struct AnswerCall {
  RequestId request = 0;
  Result<> result;
};
// Take a backtrace of a process; the result comes back as BacktraceTaken.
struct TakeBacktrace {
  std::size_t actuator = 0;
  std::int32_t pid = 0;
  friend bool operator==(const TakeBacktrace&, const TakeBacktrace&) = default;
};
// Publish the emergency stop to all actuators, also to those that start later.
struct PublishEmergencyStop {
  EmergencyStop stop;
  bool engaged = false;
  friend bool operator==(const PublishEmergencyStop&, const PublishEmergencyStop&) = default;
};
// What has to survive this controller. A save is requested and not waited for; its end comes back
// as SaveEnded with its number. Of each kind only the last save counts.
struct SaveEpoch {
  std::uint64_t epoch = 0;
  std::uint64_t save = 0;
  friend bool operator==(const SaveEpoch&, const SaveEpoch&) = default;
};
struct SaveEmergencyStops {
  StoredStops stops;
  std::uint64_t save = 0;
  friend bool operator==(const SaveEmergencyStops&, const SaveEmergencyStops&) = default;
};
struct SavePolicy {
  StoredPolicy policy;
  std::uint64_t save = 0;
  friend bool operator==(const SavePolicy&, const SavePolicy&) = default;
};
struct SaveStopIntent {
  bool intended = false;  // false: clears the intent
  std::uint64_t save = 0;
  friend bool operator==(const SaveStopIntent&, const SaveStopIntent&) = default;
};
struct SaveRemoteActuators {
  std::vector<RemoteActuator> actuators;
  std::uint64_t save = 0;
  friend bool operator==(const SaveRemoteActuators&, const SaveRemoteActuators&) = default;
};
// Run the command of [policy.power_off] or [policy.reboot], if there is one. The machine is torn
// down, or its time has expired.
struct RunPowerCommand {
  bool reboot = false;
  friend bool operator==(const RunPowerCommand&, const RunPowerCommand&) = default;
};
// The machine-readable part of a record of a switch: it begins, or how it ended.
struct SwitchNote {
  State target;
  std::optional<SwitchOutcome> outcome;  // none: it begins
  State state;                           // of the machine (of the actuator), now
  friend bool operator==(const SwitchNote&, const SwitchNote&) = default;
};
// For the journal and the log. `cause` is the record that this one follows from, so that a chain of
// records explains what was done.
struct Record {
  std::string kind;  // "machine", "switch", "actuator", "process", "policy"
  std::optional<std::size_t> actuator;
  std::uint64_t switch_number = 0;
  std::int32_t code = kCodeOk;
  std::string message;
  std::uint64_t id = 0;     // grows from 1 within a Machine; 0: not by the decision code
  std::uint64_t cause = 0;  // id of the record it follows from; 0: none
  State state{};            // the machine's, where this record reports its change
  std::string data = {};    // what does not fit in a line: a backtrace
  std::optional<SwitchNote> of_switch = {};
  friend bool operator==(const Record&, const Record&) = default;
};
// Start-up is over: the machine is usable, or it failed.
struct StartUpEnded {
  bool usable = false;
  std::string message;
  friend bool operator==(const StartUpEnded&, const StartUpEnded&) = default;
};
// Another controller has taken over; this one has to exit and change nothing more.
struct Fenced {
  std::string message;
  friend bool operator==(const Fenced&, const Fenced&) = default;
};
// The machine is stopped; the controller may end.
struct Stopped {
  friend bool operator==(const Stopped&, const Stopped&) = default;
};

}  // namespace action

using Action =
    std::variant<action::SendSwitch, action::SendQuery, action::StartProcess, action::FindProcesses,
                 action::SignalProcess, action::AnswerSetState, action::AnswerCall,
                 action::TakeBacktrace, action::PublishEmergencyStop, action::SaveEmergencyStops,
                 action::SaveEpoch, action::SavePolicy, action::SaveStopIntent,
                 action::SaveRemoteActuators, action::RunPowerCommand, action::Record,
                 action::StartUpEnded, action::Fenced, action::Stopped>;

// One step of the decision. Events that are not expected any more (a late reply, an exit that was
// seen already) only update what is known about the actuator.
std::vector<Action> Step(const MachineConfig& config, Machine& machine, const Event& event,
                         Time now);

// When to step next with TimePassed, unless another event comes before; nullopt: never.
std::optional<Time> NextDeadline(const MachineConfig& config, const Machine& machine);

// The same for the deadlines of the policy, by its own clock; NextDeadline() includes them unless
// that clock is a topic.
std::optional<Time> NextPolicyDeadline(const MachineConfig& config, const Machine& machine);

}  // namespace musher
