#pragma once
// The recorded fields of every Event, and of the types that Machine shares with them.

#include "musher/lifecycle/coordinator/coordinator.hpp"
#include "musher/lifecycle/fields/field.hpp"

namespace musher::fields {

template <>
inline constexpr std::array<std::string_view, 3> kValueNames<Verdict> = {"done", "refused",
                                                                         "failed"};
template <>
inline constexpr std::array<std::string_view, 7> kValueNames<Phase> = {
    "idle", "starting", "running", "failed", "stopping", "stopped", "fenced"};
template <>
inline constexpr std::array<std::string_view, 4> kValueNames<Presence> = {"absent", "starting",
                                                                          "present", "lost"};
template <>
inline constexpr std::array<std::string_view, 4> kValueNames<Direction> = {"up", "down", "level",
                                                                           "check"};
template <>
inline constexpr std::array<std::string_view, 6> kValueNames<Purpose> = {
    "requested", "start-up check", "start-up activate", "fallback", "stop", "policy"};
template <>
inline constexpr std::array<std::string_view, 4> kValueNames<Launch> = {
    "none", "blocked", "under-way", "found-running"};
template <>
inline constexpr std::array<std::string_view, 3> kValueNames<Stopping::Signal> = {
    "none", "terminate", "kill"};
template <>
inline constexpr std::array<std::string_view, 3> kValueNames<Stopping::Look> = {
    "not-yet", "under-way", "done"};
template <>
inline constexpr std::array<std::string_view, 3> kValueNames<Leg::Progress> = {
    "waiting", "under-way", "ended"};
template <>
inline constexpr std::array<std::string_view, 8> kValueNames<ActuatorOutcome> = {
    "done", "refused", "failed", "overdue", "lost", "undone", "skipped", "unsupported"};
template <>
inline constexpr std::array<std::string_view, 5> kValueNames<SwitchOutcome> = {
    "done", "refused", "undone", "done-degraded", "superseded"};

template <>
inline constexpr std::array<std::string_view, 5> kValueNames<Health> = {"well", "starved", "hung",
                                                                        "crashed", "partitioned"};
template <>
inline constexpr std::array<std::string_view, 2> kValueNames<PolicyInput> = {"battery", "motion"};
template <>
inline constexpr std::array<std::string_view, 4> kValueNames<BatteryLevel> = {"free", "protected",
                                                                              "low-power", "empty"};
template <>
inline constexpr std::array<std::string_view, 8> kValueNames<PolicyRequest> = {
    "switch",          "keep",    "OTA",       "low-power switch",
    "low-power store", "wake-up", "power-off", "reboot"};

template <>
inline constexpr std::array<std::string_view, 6> kValueNames<Stored> = {
    "epoch", "emergency stops", "policy", "stop intent", "remote actuators", "journal"};

template <>
inline constexpr std::array<std::string_view, 3> kValueNames<AfterTearDown> = {
    "stays down", "may start", "starts again"};

template <>
inline constexpr std::array<std::string_view, kEventNames.size()> kValueNames<EventName> =
    kEventNames;

// The last value has the last name: so no value before it is missing.
template <class T>
constexpr bool EndsWith(T last) {
  return static_cast<std::size_t>(last) + 1 == kValueNames<T>.size();
}
static_assert(EndsWith(Verdict::kFailed) && EndsWith(Phase::kFenced) && EndsWith(Presence::kLost) &&
              EndsWith(Direction::kCheck) && EndsWith(Purpose::kPolicy) &&
              EndsWith(Launch::kFoundRunning) && EndsWith(Stopping::Signal::kKill) &&
              EndsWith(Leg::Progress::kEnded) && EndsWith(ActuatorOutcome::kUnsupported) &&
              EndsWith(SwitchOutcome::kSuperseded) && EndsWith(Health::kPartitioned) &&
              EndsWith(PolicyInput::kMotion) && EndsWith(BatteryLevel::kEmpty) &&
              EndsWith(PolicyRequest::kReboot) && EndsWith(Stored::kJournal) &&
              EndsWith(AfterTearDown::kStartsAgain));

template <>
inline constexpr std::tuple kFields<Error> = {Field{"code", &Error::code},
                                              Field{"message", &Error::message}};

template <>
inline constexpr std::tuple kFields<ActuatorReport> = {
    Field{"state", &ActuatorReport::state},
    Field{"target", &ActuatorReport::target},
    Field{"busy_number", &ActuatorReport::busy_number},
    Field{"epoch", &ActuatorReport::epoch},
    Field{"number", &ActuatorReport::number},
    Field{"outcome_number", &ActuatorReport::outcome_number},
    Field{"outcome_code", &ActuatorReport::outcome_code},
    Field{"outcome_message", &ActuatorReport::outcome_message},
    Field{"incarnation", &ActuatorReport::incarnation},
    Field{"pid", &ActuatorReport::pid},
    Field{"host", &ActuatorReport::host},
    Field{"config_hash", &ActuatorReport::config_hash},
    Field{"detached", &ActuatorReport::detached},
    Field{"emergency_stop", &ActuatorReport::emergency_stop},
    Field{"held_by_stop", &ActuatorReport::held_by_stop},
    Field{"degraded_code", &ActuatorReport::degraded_code},
    Field{"degraded_reason", &ActuatorReport::degraded_reason},
    Field{"emergency_stop_by", &ActuatorReport::emergency_stop_by},
    Field{"emergency_stop_reason", &ActuatorReport::emergency_stop_reason},
    Field{"released_stop", &ActuatorReport::released_stop},
    Field{"other_stops", &ActuatorReport::other_stops},
    Field{"stamp", &ActuatorReport::stamp},
};

template <>
inline constexpr std::tuple kFields<Requester> = {
    Field{"name", &Requester::name},
    Field{"manager", &Requester::manager},
};

template <>
inline constexpr std::tuple kFields<EmergencyStop> = {
    Field{"id", &EmergencyStop::id},
    Field{"by", &EmergencyStop::by},
    Field{"reason", &EmergencyStop::reason},
};

template <>
inline constexpr std::tuple kFields<StoredStops> = {
    Field{"engaged", &StoredStops::engaged},
    Field{"released", &StoredStops::released},
};

template <>
inline constexpr std::tuple kFields<RemoteActuator> = {
    Field{"name", &RemoteActuator::name},
    Field{"host", &RemoteActuator::host},
};

template <>
inline constexpr std::tuple kFields<Lowering> = {
    Field{"from", &Lowering::from}, Field{"to", &Lowering::to}, Field{"epoch", &Lowering::epoch}};
template <>
inline constexpr std::tuple kFields<StoredPolicy> = {
    Field{"low_power", &StoredPolicy::low_power},
    Field{"lowering", &StoredPolicy::lowering},
    Field{"level", &StoredPolicy::level},
};

template <>
inline constexpr std::string_view kEventName<event::Begin> = "Begin";
template <>
inline constexpr std::tuple kFields<event::Begin> = {
    Field{"by_hand", &event::Begin::by_hand},     Field{"epoch", &event::Begin::epoch},
    Field{"running", &event::Begin::running},     Field{"processes", &event::Begin::processes},
    Field{"host", &event::Begin::host},           Field{"stops", &event::Begin::stops},
    Field{"policy", &event::Begin::policy},       Field{"stop_intent", &event::Begin::stop_intent},
    Field{"restarted", &event::Begin::restarted}, Field{"remote", &event::Begin::remote},
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
};
template <>
inline constexpr std::string_view kEventName<event::ProcessStarted> = "ProcessStarted";
template <>
inline constexpr std::tuple kFields<event::ProcessStarted> = {
    Field{"actuator", &event::ProcessStarted::actuator},
    Field{"pid", &event::ProcessStarted::pid},
};
template <>
inline constexpr std::string_view kEventName<event::ProcessNotStarted> = "ProcessNotStarted";
template <>
inline constexpr std::tuple kFields<event::ProcessNotStarted> = {
    Field{"actuator", &event::ProcessNotStarted::actuator},
    Field{"why", &event::ProcessNotStarted::why},
};
template <>
inline constexpr std::string_view kEventName<event::ProcessesFound> = "ProcessesFound";
template <>
inline constexpr std::tuple kFields<event::ProcessesFound> = {
    Field{"processes", &event::ProcessesFound::processes},
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
};
template <>
inline constexpr std::string_view kEventName<event::RivalSeen> = "RivalHeard";
template <>
inline constexpr std::tuple kFields<event::RivalSeen> = {
    Field{"epoch", &event::RivalSeen::epoch},
    Field{"who", &event::RivalSeen::rival},
    Field{"has_precedence", &event::RivalSeen::has_precedence},
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
inline constexpr std::string_view kEventName<event::ClockReceived> = "ClockHeard";
template <>
inline constexpr std::tuple kFields<event::ClockReceived> = {
    Field{"clock", &event::ClockReceived::clock},
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

}  // namespace musher::fields
