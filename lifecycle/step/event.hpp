#pragma once
// What happens to the machine: the input of Step() (coordinator.hpp).

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "musher/lifecycle/field.hpp"
#include "musher/lifecycle/machine/machine.hpp"
#include "musher/lifecycle/machine/start_progress.hpp"
#include "musher/lifecycle/per_actuator.hpp"

namespace musher {

namespace event {

// Starts the machine: with `by_hand` only SetUp, the rest follows by requests. `running[i]`: a
// process of actuator i already runs on this host; `processes[i]` is its pid if its exit can be
// detected, else 0; `ended[i]`: a process that an earlier controller had started has ended since
// that controller led, and none runs. `epoch`, `stops`, `policy`, `stop_intent`, `remote` and
// `actuators` were read from disk. `restarted`: a supervisor restarts the controller, not a person;
// with `stop_intent` the controller finishes the TearDown that was begun, and the machine stays
// down. A person's start clears the intent. `supervised`: a supervisor starts the controller, at
// boot or again; only a person's start is a request to switch on what an emergency stop has
// switched off. `at_boot`: it is the first start of that kind since the host was booted, and undoes
// no person's takeover either.
struct Begin {
  bool by_hand = false;
  Epoch epoch = 0;
  PerActuator<bool> running;
  std::string host = {};  // of the controller
  StoredStops stops = {};
  PerActuator<std::int32_t> processes = {};
  StoredPolicy policy = {};
  bool stop_intent = false;
  bool restarted = false;
  std::vector<RemoteActuator> remote = {};
  bool supervised = false;
  bool at_boot = false;
  std::vector<StoredActuator> actuators = {};
  PerActuator<bool> ended = {};
  friend bool operator==(const Begin&, const Begin&) = default;
};
// An actuator's latched status was received.
struct StatusSeen {
  ActuatorIndex actuator = 0;
  ActuatorReport report;
  friend bool operator==(const StatusSeen&, const StatusSeen&) = default;
};
// An actuator replied to command `number`, or to the query about it (`query`).
struct Replied {
  ActuatorIndex actuator = 0;
  CommandNumber number = 0;
  bool query = false;
  Verdict verdict = Verdict::kDone;
  std::int32_t code = kCodeOk;
  std::string message;
  ActuatorReport report;
  friend bool operator==(const Replied&, const Replied&) = default;
};
// The actuator of this incarnation was lost: its process exited or its writer was lost.
struct Vanished {
  ActuatorIndex actuator = 0;
  Incarnation incarnation = 0;
  bool for_good = false;  // its process has exited; otherwise it may connect again
  std::string how;        // "its process 4711 ended", kOutOfReach
  bool taken = false;     // it runs on, and follows the controller of another machine on its host
  // The pid of a taken process, from its status there: no status of it may have arrived before.
  std::int32_t pid = 0;
  std::string host{};
  bool clean = false;  // `for_good`, and its exit code is known to be 0
  friend bool operator==(const Vanished&, const Vanished&) = default;
};
struct ProcessStarted {
  ActuatorIndex actuator = 0;
  std::int32_t pid = 0;
  std::string host{};  // its HostId(), if it runs on another host than the controller
  bool found = false;  // it ran there already
  friend bool operator==(const ProcessStarted&, const ProcessStarted&) = default;
};
struct ProcessNotStarted {
  ActuatorIndex actuator = 0;
  std::string why;
  bool waits = false;  // for its host, which is out of reach: it is started once that is reached
  friend bool operator==(const ProcessNotStarted&, const ProcessNotStarted&) = default;
};
// The result of action::FindProcesses: for each actuator the pid of the process that runs and is
// watched now, or 0.
struct ProcessesFound {
  PerActuator<std::int32_t> processes;
  // Where another host runs the actuator's command: its HostId(), and why it was not asked.
  PerActuator<std::string> hosts = {};
  PerActuator<std::string> unreached = {};
  friend bool operator==(const ProcessesFound&, const ProcessesFound&) = default;
};
// A process that this controller started has exited.
struct ProcessEnded {
  ActuatorIndex actuator = 0;
  std::int32_t pid = 0;
  bool clean = false;          // exit code 0
  std::string how;             // "exit code 3", "killed by SIGKILL"
  std::int32_t exit_code = 0;  // of a process that exited by itself; 0 otherwise, or where unknown
  friend bool operator==(const ProcessEnded&, const ProcessEnded&) = default;
};
// The health monitor's verdict on a running process.
struct HealthChanged {
  ActuatorIndex actuator = 0;
  Incarnation incarnation = 0;
  Health health = Health::kWell;
  bool silent = false;  // it does not answer either
  std::string how;
  friend bool operator==(const HealthChanged&, const HealthChanged&) = default;
};
// The backtrace of a hung process, or why there is none.
struct BacktraceTaken {
  ActuatorIndex actuator = 0;
  std::int32_t pid = 0;
  std::string text;
  friend bool operator==(const BacktraceTaken&, const BacktraceTaken&) = default;
};
// A person requests a restart of an actuator's process.
struct RestartRequested {
  RequestId request = 0;
  std::string actuator;
  std::string by{};  // the person or program; "" = not known
  friend bool operator==(const RestartRequested&, const RestartRequested&) = default;
};
// A heartbeat of another controller of this machine was received.
struct RivalSeen {
  Epoch epoch = 0;
  std::string rival;            // "process 4711 on this host"
  bool has_precedence = false;  // where both have the same epoch
  bool elsewhere = false;       // on another host, with another state folder
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
  std::vector<StopId> seen = {};  // those that the person has seen; empty: all that are engaged
  friend bool operator==(const ReleaseRequested&, const ReleaseRequested&) = default;
};
struct SetStateRequested {
  RequestId request = 0;
  State target;
  std::optional<std::string> actuator = {};
  AfterTearDown after = AfterTearDown::kStaysDown;  // of a TearDown of the machine
  Requester by = {};
  friend bool operator==(const SetStateRequested&, const SetStateRequested&) = default;
};
// Answer when all actuators are set up, or when that has failed.
struct SetUpAwaited {
  RequestId request = 0;
  friend bool operator==(const SetUpAwaited&, const SetUpAwaited&) = default;
};
// A sample of the battery. Of each publisher, only a changed sample becomes an event, and then the
// next samples that confirm it. A value out of range is recorded and otherwise ignored.
struct BatterySeen {
  std::int32_t percent = 0;
  bool charging = false;
  std::uint32_t source = 0;  // the publisher, numbered by the shell
  friend bool operator==(const BatterySeen&, const BatterySeen&) = default;
};
// One of several publishers of the battery has sent no sample for its time.
struct BatterySourceSilent {
  std::uint32_t source = 0;
  friend bool operator==(const BatterySourceSilent&, const BatterySourceSilent&) = default;
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
// just before any other event.
struct ClockReceived {
  Time clock{};
  bool jumped = false;  // a world was restarted, or a recording skipped: no time has passed
  friend bool operator==(const ClockReceived&, const ClockReceived&) = default;
};
struct PolicyRequested {
  RequestId request = 0;
  PolicyRequest what = PolicyRequest::kWakeUp;
  State state;             // of kSwitch and kKeep
  std::int64_t ticks = 0;  // of kKeep, in seconds
  bool enable = false;     // of kOta and the low-power switch
  std::string by{};        // the person or program; "" = not known
  friend bool operator==(const PolicyRequested&, const PolicyRequested&) = default;
};
// The save of that number has ended. A failed save may still succeed later; then this event comes
// again.
struct SaveEnded {
  Stored what = Stored::kEpoch;
  SaveNumber save = 0;
  bool ok = false;
  std::string why;  // of a failure
  friend bool operator==(const SaveEnded&, const SaveEnded&) = default;
};
// What the kernel reports of a process that has not announced itself as the actuator in time.
struct StartExamined {
  ActuatorIndex actuator = 0;
  std::int32_t pid = 0;
  StartProgress progress = StartProgress::kUnknown;
  friend bool operator==(const StartExamined&, const StartExamined&) = default;
};

// Only time has passed.
struct TimePassed {
  friend bool operator==(const TimePassed&, const TimePassed&) = default;
};

}  // namespace event

using Event = std::variant<
    event::Begin, event::StatusSeen, event::Replied, event::Vanished, event::ProcessStarted,
    event::ProcessNotStarted, event::ProcessesFound, event::ProcessEnded, event::HealthChanged,
    event::BacktraceTaken, event::RestartRequested, event::RivalSeen, event::EmergencyStopSeen,
    event::ReleaseRequested, event::SetStateRequested, event::SetUpAwaited, event::BatterySeen,
    event::BatterySourceSilent, event::MotionSeen, event::InputSilent, event::ClockReceived,
    event::PolicyRequested, event::SaveEnded, event::TimePassed, event::StartExamined>;

}  // namespace musher

namespace musher::fields {

template <>
inline constexpr std::string_view kEventName<event::Begin> = "Begin";
template <>
inline constexpr std::tuple kFields<event::Begin> = {
    Field{"by_hand", &event::Begin::by_hand},
    Field{"epoch", &event::Begin::epoch},
    Field{"running", &event::Begin::running},
    Field{"processes", &event::Begin::processes},
    Field{"host", &event::Begin::host},
    Field{"stops", &event::Begin::stops},
    Field{"policy", &event::Begin::policy},
    Field{"stop_intent", &event::Begin::stop_intent},
    Field{"restarted", &event::Begin::restarted},
    Field{"remote", &event::Begin::remote},
    Field{"supervised", &event::Begin::supervised},
    Field{"at_boot", &event::Begin::at_boot},
    Field{"actuators", &event::Begin::actuators},
    Field{"ended", &event::Begin::ended},
};

template <>
inline constexpr std::string_view kEventName<event::StatusSeen> = "StatusSeen";
template <>
inline constexpr std::tuple kFields<event::StatusSeen> = {
    Field{"actuator", &event::StatusSeen::actuator},
    Field{"report", &event::StatusSeen::report},
};

template <>
inline constexpr std::string_view kEventName<event::Replied> = "Replied";
template <>
inline constexpr std::tuple kFields<event::Replied> = {
    Field{"actuator", &event::Replied::actuator}, Field{"number", &event::Replied::number},
    Field{"query", &event::Replied::query},       Field{"verdict", &event::Replied::verdict},
    Field{"code", &event::Replied::code},         Field{"message", &event::Replied::message},
    Field{"report", &event::Replied::report},
};

template <>
inline constexpr std::string_view kEventName<event::Vanished> = "Vanished";
template <>
inline constexpr std::tuple kFields<event::Vanished> = {
    Field{"actuator", &event::Vanished::actuator},
    Field{"incarnation", &event::Vanished::incarnation},
    Field{"for_good", &event::Vanished::for_good},
    Field{"how", &event::Vanished::how},
    Field{"taken", &event::Vanished::taken},
    Field{"pid", &event::Vanished::pid},
    Field{"host", &event::Vanished::host},
    Field{"clean", &event::Vanished::clean},
};

template <>
inline constexpr std::string_view kEventName<event::ProcessStarted> = "ProcessStarted";
template <>
inline constexpr std::tuple kFields<event::ProcessStarted> = {
    Field{"actuator", &event::ProcessStarted::actuator},
    Field{"pid", &event::ProcessStarted::pid},
    Field{"host", &event::ProcessStarted::host},
    Field{"found", &event::ProcessStarted::found},
};

template <>
inline constexpr std::string_view kEventName<event::ProcessNotStarted> = "ProcessNotStarted";
template <>
inline constexpr std::tuple kFields<event::ProcessNotStarted> = {
    Field{"actuator", &event::ProcessNotStarted::actuator},
    Field{"why", &event::ProcessNotStarted::why},
    Field{"waits", &event::ProcessNotStarted::waits},
};

template <>
inline constexpr std::string_view kEventName<event::ProcessesFound> = "ProcessesFound";
template <>
inline constexpr std::tuple kFields<event::ProcessesFound> = {
    Field{"processes", &event::ProcessesFound::processes},
    Field{"hosts", &event::ProcessesFound::hosts},
    Field{"unreached", &event::ProcessesFound::unreached},
};

template <>
inline constexpr std::string_view kEventName<event::ProcessEnded> = "ProcessEnded";
template <>
inline constexpr std::tuple kFields<event::ProcessEnded> = {
    Field{"actuator", &event::ProcessEnded::actuator},   Field{"pid", &event::ProcessEnded::pid},
    Field{"clean", &event::ProcessEnded::clean},         Field{"how", &event::ProcessEnded::how},
    Field{"exit_code", &event::ProcessEnded::exit_code},
};

template <>
inline constexpr std::string_view kEventName<event::HealthChanged> = "HealthChanged";
template <>
inline constexpr std::tuple kFields<event::HealthChanged> = {
    Field{"actuator", &event::HealthChanged::actuator},
    Field{"incarnation", &event::HealthChanged::incarnation},
    Field{"health", &event::HealthChanged::health},
    Field{"silent", &event::HealthChanged::silent},
    Field{"how", &event::HealthChanged::how},
};

template <>
inline constexpr std::string_view kEventName<event::BacktraceTaken> = "BacktraceTaken";
template <>
inline constexpr std::tuple kFields<event::BacktraceTaken> = {
    Field{"actuator", &event::BacktraceTaken::actuator},
    Field{"pid", &event::BacktraceTaken::pid},
    Field{"text", &event::BacktraceTaken::text},
};

template <>
inline constexpr std::string_view kEventName<event::RestartRequested> = "RestartRequested";
template <>
inline constexpr std::tuple kFields<event::RestartRequested> = {
    Field{"request", &event::RestartRequested::request},
    Field{"actuator", &event::RestartRequested::actuator},
    Field{"by", &event::RestartRequested::by},
};

template <>
inline constexpr std::string_view kEventName<event::RivalSeen> = "RivalSeen";
template <>
inline constexpr std::tuple kFields<event::RivalSeen> = {
    Field{"epoch", &event::RivalSeen::epoch},
    Field{"rival", &event::RivalSeen::rival},
    Field{"has_precedence", &event::RivalSeen::has_precedence},
    Field{"elsewhere", &event::RivalSeen::elsewhere},
};

template <>
inline constexpr std::string_view kEventName<event::EmergencyStopSeen> = "EmergencyStopSeen";
template <>
inline constexpr std::tuple kFields<event::EmergencyStopSeen> = {
    Field{"stop", &event::EmergencyStopSeen::stop},
    Field{"engaged", &event::EmergencyStopSeen::engaged}};

template <>
inline constexpr std::string_view kEventName<event::ReleaseRequested> = "ReleaseRequested";
template <>
inline constexpr std::tuple kFields<event::ReleaseRequested> = {
    Field{"request", &event::ReleaseRequested::request},
    Field{"by", &event::ReleaseRequested::by},
    Field{"seen", &event::ReleaseRequested::seen},
};

template <>
inline constexpr std::string_view kEventName<event::SetStateRequested> = "SetStateRequested";
template <>
inline constexpr std::tuple kFields<event::SetStateRequested> = {
    Field{"request", &event::SetStateRequested::request},
    Field{"target", &event::SetStateRequested::target},
    Field{"actuator", &event::SetStateRequested::actuator},
    Field{"after", &event::SetStateRequested::after},
    Field{"by", &event::SetStateRequested::by},
};

template <>
inline constexpr std::string_view kEventName<event::SetUpAwaited> = "SetUpAwaited";
template <>
inline constexpr std::tuple kFields<event::SetUpAwaited> = {
    Field{"request", &event::SetUpAwaited::request}};

template <>
inline constexpr std::string_view kEventName<event::BatterySeen> = "BatterySeen";
template <>
inline constexpr std::tuple kFields<event::BatterySeen> = {
    Field{"percent", &event::BatterySeen::percent},
    Field{"charging", &event::BatterySeen::charging},
    Field{"source", &event::BatterySeen::source},
};

template <>
inline constexpr std::string_view kEventName<event::BatterySourceSilent> = "BatterySourceSilent";
template <>
inline constexpr std::tuple kFields<event::BatterySourceSilent> = {
    Field{"source", &event::BatterySourceSilent::source},
};

template <>
inline constexpr std::string_view kEventName<event::MotionSeen> = "MotionSeen";
template <>
inline constexpr std::tuple kFields<event::MotionSeen> = {
    Field{"motion", &event::MotionSeen::motion},
};

template <>
inline constexpr std::string_view kEventName<event::InputSilent> = "InputSilent";
template <>
inline constexpr std::tuple kFields<event::InputSilent> = {
    Field{"input", &event::InputSilent::input},
};

template <>
inline constexpr std::string_view kEventName<event::ClockReceived> = "ClockReceived";
template <>
inline constexpr std::tuple kFields<event::ClockReceived> = {
    Field{"clock", &event::ClockReceived::clock},
    Field{"jumped", &event::ClockReceived::jumped},
};

template <>
inline constexpr std::string_view kEventName<event::PolicyRequested> = "PolicyRequested";
template <>
inline constexpr std::tuple kFields<event::PolicyRequested> = {
    Field{"request", &event::PolicyRequested::request},
    Field{"what", &event::PolicyRequested::what},
    Field{"state", &event::PolicyRequested::state},
    Field{"ticks", &event::PolicyRequested::ticks},
    Field{"enable", &event::PolicyRequested::enable},
    Field{"by", &event::PolicyRequested::by},
};

template <>
inline constexpr std::string_view kEventName<event::SaveEnded> = "SaveEnded";
template <>
inline constexpr std::tuple kFields<event::SaveEnded> = {
    Field{"what", &event::SaveEnded::what},
    Field{"save", &event::SaveEnded::save},
    Field{"ok", &event::SaveEnded::ok},
    Field{"why", &event::SaveEnded::why},
};

template <>
inline constexpr std::string_view kEventName<event::TimePassed> = "TimePassed";
template <>
inline constexpr std::tuple<> kFields<event::TimePassed> = {};

template <>
inline constexpr std::string_view kEventName<event::StartExamined> = "StartExamined";
template <>
inline constexpr std::tuple kFields<event::StartExamined> = {
    Field{"actuator", &event::StartExamined::actuator},
    Field{"pid", &event::StartExamined::pid},
    Field{"progress", &event::StartExamined::progress},
};

}  // namespace musher::fields
