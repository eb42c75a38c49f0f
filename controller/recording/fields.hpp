#pragma once
// What a recording holds of the decision code's values: the name of every field of Event, Machine
// and what is in them. A field or an event that is added there is one line here, and a field that
// is forgotten does not compile (MemberCount).
//
// Units: times and durations in nanoseconds.

#include <array>
#include <cstddef>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

#include "musher/lifecycle/coordinator.hpp"

namespace musher::recording {

template <class T, class M>
struct Field {
  const char* name;
  M T::*member;
};
template <class T, class M>
Field(const char*, M T::*) -> Field<T, M>;

// The fields of a struct, as a tuple of Field.
template <class T>
inline constexpr auto kFields = nullptr;
template <class T>
concept Struct = !std::is_same_v<decltype(kFields<T>), const std::nullptr_t>;

// The names of an enumeration's values, by value. One without a name is recorded as its number.
template <class T>
inline constexpr std::array<std::string_view, 0> kValueNames{};

// What an event is called.
template <class E>
inline constexpr std::string_view kEventName{};

// How many members an aggregate has.
struct AnyMember {
  template <class T>
  operator T() const;  // NOLINT(google-explicit-constructor): declared only, for MemberCount
};
template <class T, class... Members>
constexpr std::size_t MemberCount() {
  if constexpr (requires { T{std::declval<Members>()..., std::declval<AnyMember&>()}; }) {
    return MemberCount<T, Members..., AnyMember&>();
  } else {
    return sizeof...(Members);
  }
}
template <Struct T>
inline constexpr bool kIsComplete = std::tuple_size_v<std::remove_const_t<decltype(kFields<T>)>> ==
                                    MemberCount<T>();

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
inline constexpr std::array<std::string_view, 5> kValueNames<Purpose> = {
    "requested", "start-up check", "start-up activate", "fallback", "stop"};
template <>
inline constexpr std::array<std::string_view, 3> kValueNames<Leg::Progress> = {
    "waiting", "under way", "ended"};
template <>
inline constexpr std::array<std::string_view, 8> kValueNames<ActuatorOutcome> = {
    "done", "refused", "failed", "overdue", "lost", "undone", "skipped", "unsupported"};
template <>
inline constexpr std::array<std::string_view, 5> kValueNames<SwitchOutcome> = {
    "done", "refused", "undone", "done-degraded", "superseded"};

template <>
inline constexpr std::array<std::string_view, 5> kValueNames<Health> = {"well", "starved", "hung",
                                                                        "crashed", "partitioned"};

// The last value has the last name: one that was put before it has not been forgotten.
template <class T>
constexpr bool EndsWith(T last) {
  return static_cast<std::size_t>(last) + 1 == kValueNames<T>.size();
}
static_assert(EndsWith(Verdict::kFailed) && EndsWith(Phase::kFenced) && EndsWith(Presence::kLost) &&
              EndsWith(Direction::kCheck) && EndsWith(Purpose::kStop) &&
              EndsWith(Leg::Progress::kEnded) && EndsWith(ActuatorOutcome::kUnsupported) &&
              EndsWith(SwitchOutcome::kSuperseded) && EndsWith(Health::kPartitioned));

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
    Field{"apart", &ActuatorReport::apart},
    Field{"emergency_stop", &ActuatorReport::emergency_stop},
    Field{"stamp", &ActuatorReport::stamp},
};

template <>
inline constexpr std::tuple kFields<EmergencyStop> = {
    Field{"id", &EmergencyStop::id},
    Field{"by", &EmergencyStop::by},
    Field{"reason", &EmergencyStop::reason},
};

template <>
inline constexpr std::string_view kEventName<event::Begin> = "Begin";
template <>
inline constexpr std::tuple kFields<event::Begin> = {
    Field{"by_hand", &event::Begin::by_hand},
    Field{"epoch", &event::Begin::epoch},
    Field{"running", &event::Begin::running},
    Field{"processes", &event::Begin::processes},
    Field{"host", &event::Begin::host},
    Field{"emergency_stop", &event::Begin::emergency_stop},
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
    Field{"ask", &event::Replied::ask},           Field{"verdict", &event::Replied::verdict},
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
inline constexpr std::string_view kEventName<event::ProcessEnded> = "ProcessEnded";
template <>
inline constexpr std::tuple kFields<event::ProcessEnded> = {
    Field{"actuator", &event::ProcessEnded::actuator},
    Field{"pid", &event::ProcessEnded::pid},
    Field{"clean", &event::ProcessEnded::clean},
    Field{"how", &event::ProcessEnded::how},
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
inline constexpr std::string_view kEventName<event::RivalHeard> = "RivalHeard";
template <>
inline constexpr std::tuple kFields<event::RivalHeard> = {
    Field{"epoch", &event::RivalHeard::epoch},
    Field{"who", &event::RivalHeard::who},
    Field{"has_precedence", &event::RivalHeard::has_precedence},
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
};
template <>
inline constexpr std::string_view kEventName<event::SetUpAwaited> = "SetUpAwaited";
template <>
inline constexpr std::tuple kFields<event::SetUpAwaited> = {
    Field{"request", &event::SetUpAwaited::request}};
template <>
inline constexpr std::string_view kEventName<event::TimePassed> = "TimePassed";
template <>
inline constexpr std::tuple<> kFields<event::TimePassed> = {};

template <>
inline constexpr std::tuple kFields<Order> = {
    Field{"number", &Order::number}, Field{"target", &Order::target},
    Field{"sent", &Order::sent},     Field{"deadline", &Order::deadline},
    Field{"asked", &Order::asked},
};

template <>
inline constexpr std::tuple kFields<ActuatorRecord> = {
    Field{"presence", &ActuatorRecord::presence},
    Field{"report", &ActuatorRecord::report},
    Field{"clock_theirs", &ActuatorRecord::clock_theirs},
    Field{"clock_ours", &ActuatorRecord::clock_ours},
    Field{"process", &ActuatorRecord::process},
    Field{"dead", &ActuatorRecord::dead},
    Field{"found_running", &ActuatorRecord::found_running},
    Field{"set_up_by", &ActuatorRecord::set_up_by},
    Field{"claimed", &ActuatorRecord::claimed},
    Field{"claim_again", &ActuatorRecord::claim_again},
    Field{"checked", &ActuatorRecord::checked},
    Field{"join_tried", &ActuatorRecord::join_tried},
    Field{"held", &ActuatorRecord::held},
    Field{"due", &ActuatorRecord::due},
    Field{"fault", &ActuatorRecord::fault},
    Field{"order", &ActuatorRecord::order},
    Field{"cause", &ActuatorRecord::cause},
    Field{"health", &ActuatorRecord::health},
    Field{"restarts", &ActuatorRecord::restarts},
    Field{"restart_at", &ActuatorRecord::restart_at},
    Field{"healthy_at", &ActuatorRecord::healthy_at},
    Field{"given_up", &ActuatorRecord::given_up},
    Field{"restart_asked", &ActuatorRecord::restart_asked},
    Field{"restart_requests", &ActuatorRecord::restart_requests},
    Field{"doomed", &ActuatorRecord::doomed},
    Field{"kill_at", &ActuatorRecord::kill_at},
    Field{"killed", &ActuatorRecord::killed},
    Field{"parked", &ActuatorRecord::parked},
    Field{"outbid_at", &ActuatorRecord::outbid_at},
    Field{"free_by", &ActuatorRecord::free_by},
    Field{"hindered", &ActuatorRecord::hindered},
};

template <>
inline constexpr std::tuple kFields<Leg> = {
    Field{"actuator", &Leg::actuator}, Field{"from", &Leg::from},
    Field{"target", &Leg::target},     Field{"needs", &Leg::needs},
    Field{"progress", &Leg::progress}, Field{"outcome", &Leg::outcome},
    Field{"ran", &Leg::ran},           Field{"may_fail", &Leg::may_fail},
    Field{"code", &Leg::code},         Field{"message", &Leg::message},
    Field{"started", &Leg::started},   Field{"duration", &Leg::duration},
};

template <>
inline constexpr std::tuple kFields<ActuatorResult> = {
    Field{"name", &ActuatorResult::name},         Field{"outcome", &ActuatorResult::outcome},
    Field{"code", &ActuatorResult::code},         Field{"message", &ActuatorResult::message},
    Field{"duration", &ActuatorResult::duration}, Field{"state", &ActuatorResult::state},
};

template <>
inline constexpr std::tuple kFields<SwitchResult> = {
    Field{"number", &SwitchResult::number},       Field{"target", &SwitchResult::target},
    Field{"actuator", &SwitchResult::actuator},   Field{"outcome", &SwitchResult::outcome},
    Field{"code", &SwitchResult::code},           Field{"reason", &SwitchResult::reason},
    Field{"state", &SwitchResult::state},         Field{"degraded", &SwitchResult::degraded},
    Field{"actuators", &SwitchResult::actuators},
};

template <>
inline constexpr std::tuple kFields<Switch> = {
    Field{"number", &Switch::number},
    Field{"from", &Switch::from},
    Field{"target", &Switch::target},
    Field{"only", &Switch::only},
    Field{"direction", &Switch::direction},
    Field{"purpose", &Switch::purpose},
    Field{"requests", &Switch::requests},
    Field{"legs", &Switch::legs},
    Field{"others", &Switch::others},
    Field{"stopped", &Switch::stopped},
    Field{"rolling_back", &Switch::rolling_back},
    Field{"back_number", &Switch::back_number},
    Field{"back", &Switch::back},
    Field{"cause", &Switch::cause},
};

template <>
inline constexpr std::tuple kFields<Stopping> = {
    Field{"begun", &Stopping::begun},
    Field{"tear_down_by", &Stopping::tear_down_by},
    Field{"terminate_at", &Stopping::terminate_at},
    Field{"kill_at", &Stopping::kill_at},
    Field{"give_up_at", &Stopping::give_up_at},
    Field{"terminated", &Stopping::terminated},
    Field{"killed", &Stopping::killed},
    Field{"result", &Stopping::result},
    Field{"requests", &Stopping::requests},
};

template <>
inline constexpr std::tuple kFields<Machine> = {
    Field{"phase", &Machine::phase},
    Field{"by_hand", &Machine::by_hand},
    Field{"state", &Machine::state},
    Field{"host", &Machine::host},
    Field{"epoch", &Machine::epoch},
    Field{"number", &Machine::number},
    Field{"last_switch", &Machine::last_switch},
    Field{"set_up", &Machine::set_up},
    Field{"stage", &Machine::stage},
    Field{"actuators", &Machine::actuators},
    Field{"current", &Machine::current},
    Field{"fallback", &Machine::fallback},
    Field{"fallback_cause", &Machine::fallback_cause},
    Field{"stopping", &Machine::stopping},
    Field{"emergency_stop", &Machine::emergency_stop},
    Field{"stop_cause", &Machine::stop_cause},
    Field{"other_stops", &Machine::other_stops},
    Field{"released_stops", &Machine::released_stops},
    Field{"set_up_requests", &Machine::set_up_requests},
    Field{"last_record", &Machine::last_record},
    Field{"told_state", &Machine::told_state},
};

}  // namespace musher::recording
