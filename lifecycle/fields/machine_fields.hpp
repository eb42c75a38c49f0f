#pragma once
// The recorded fields of the decision code's values: the name of every field of Machine and its
// members; for events see event_fields.hpp. A new field needs one line here.
//
// Units: times and durations in nanoseconds.

#include "musher/lifecycle/fields/event_fields.hpp"
#include "musher/lifecycle/fields/field.hpp"

namespace musher::fields {

template <>
inline constexpr std::tuple kFields<PendingCommand> = {
    Field{"number", &PendingCommand::number},   Field{"target", &PendingCommand::target},
    Field{"sent", &PendingCommand::sent},       Field{"deadline", &PendingCommand::deadline},
    Field{"queries", &PendingCommand::queries},
};

template <>
inline constexpr std::tuple kFields<Termination> = {
    Field{"pid", &Termination::pid},
    Field{"terminate_at", &Termination::terminate_at},
    Field{"kill_at", &Termination::kill_at},
    Field{"killed", &Termination::killed},
};

template <>
inline constexpr std::tuple kFields<ActuatorFault> = {
    Field{"code", &ActuatorFault::code},
    Field{"message", &ActuatorFault::message},
    Field{"event", &ActuatorFault::event},
};

template <>
inline constexpr std::tuple kFields<ActuatorProcess> = {
    Field{"pid", &ActuatorProcess::pid},
    Field{"launch", &ActuatorProcess::launch},
    Field{"dead", &ActuatorProcess::dead},
    Field{"termination", &ActuatorProcess::termination},
};

template <>
inline constexpr std::tuple kFields<Restarts> = {
    Field{"restarts", &Restarts::count},
    Field{"restart_at", &Restarts::at},
    Field{"reset_at", &Restarts::reset_at},
    Field{"given_up", &Restarts::given_up},
    Field{"restart_requested", &Restarts::requested},
    Field{"restart_requests", &Restarts::requests},
};

template <>
inline constexpr std::tuple kFields<ControlRecord> = {
    Field{"controlled", &ControlRecord::incarnation},
    Field{"control_again", &ControlRecord::again},
    Field{"rival_until", &ControlRecord::rival_until},
};

template <>
inline constexpr std::tuple kFields<FailedChecks> = {Field{"count", &FailedChecks::count},
                                                     Field{"at", &FailedChecks::at}};

template <>
inline constexpr std::tuple kFields<ActuatorRecord> = {
    Field{"presence", &ActuatorRecord::presence},
    Field{"report", &ActuatorRecord::report},
    Field{"other", &ActuatorRecord::other},
    Field{"clock_theirs", &ActuatorRecord::clock_theirs},
    Field{"clock_ours", &ActuatorRecord::clock_ours},
    Part{&ActuatorRecord::process},
    Part{&ActuatorRecord::restart},
    Part{&ActuatorRecord::control},
    Field{"set_up_by", &ActuatorRecord::set_up_by},
    Field{"checked", &ActuatorRecord::checked},
    Field{"join_tried", &ActuatorRecord::join_tried},
    Field{"failed_checks", &ActuatorRecord::failed_checks},
    Field{"set_again", &ActuatorRecord::set_again},
    Field{"held", &ActuatorRecord::held},
    Field{"due", &ActuatorRecord::due},
    Field{"fault", &ActuatorRecord::fault},
    Field{"tolerated", &ActuatorRecord::tolerated},
    Field{"command", &ActuatorRecord::command},
    Field{"cause", &ActuatorRecord::cause},
    Field{"health", &ActuatorRecord::health},
    Field{"suspended", &ActuatorRecord::suspended},
    Field{"free_by", &ActuatorRecord::free_by},
    Field{"elsewhere", &ActuatorRecord::elsewhere},
};

template <>
inline constexpr std::tuple kFields<ActuatorGoal> = {
    Field{"actuator", &ActuatorGoal::actuator},
    Field{"from", &ActuatorGoal::from},
    Field{"target", &ActuatorGoal::target},
    Field{"needs", &ActuatorGoal::needs},
};

template <>
inline constexpr std::tuple kFields<Leg> = {
    Base<ActuatorGoal>{},
    Field{"progress", &Leg::progress},
    Field{"outcome", &Leg::outcome},
    Field{"ran", &Leg::ran},
    Field{"may_fail", &Leg::may_fail},
    Field{"code", &Leg::code},
    Field{"message", &Leg::message},
    Field{"event", &Leg::event},
    Field{"started", &Leg::started},
    Field{"duration", &Leg::duration},
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
inline constexpr std::tuple kFields<SwitchGoal> = {
    Field{"from", &SwitchGoal::from},
    Field{"target", &SwitchGoal::target},
    Field{"only", &SwitchGoal::only},
    Field{"direction", &SwitchGoal::direction},
};

template <>
inline constexpr std::tuple kFields<Rollback> = {
    Field{"rolling_back", &Rollback::under_way},
    Field{"back_number", &Rollback::number},
    Field{"back", &Rollback::legs},
};

template <>
inline constexpr std::tuple kFields<Switch> = {
    Base<SwitchGoal>{},
    Field{"number", &Switch::number},
    Field{"purpose", &Switch::purpose},
    Field{"requests", &Switch::requests},
    Field{"legs", &Switch::legs},
    Field{"others", &Switch::others},
    Field{"stopped", &Switch::stopped},
    Part{&Switch::rollback},
    Field{"cause", &Switch::cause},
};

template <>
inline constexpr std::tuple kFields<WaitingSwitch> = {
    Field{"target", &WaitingSwitch::target}, Field{"only", &WaitingSwitch::only},
    Field{"until", &WaitingSwitch::until},   Field{"requests", &WaitingSwitch::requests},
    Field{"cause", &WaitingSwitch::cause},   Field{"by", &WaitingSwitch::by},
};

template <>
inline constexpr std::tuple kFields<StandingRequest> = {
    Field{"target", &StandingRequest::target},
    Field{"by", &StandingRequest::by},
    Field{"number", &StandingRequest::number},
};

template <>
inline constexpr std::tuple kFields<Stopping> = {
    Field{"begun", &Stopping::begun},
    Field{"after", &Stopping::after},
    Field{"intent_by", &Stopping::intent_by},
    Field{"tear_down_by", &Stopping::tear_down_by},
    Field{"terminate_at", &Stopping::terminate_at},
    Field{"kill_at", &Stopping::kill_at},
    Field{"give_up_at", &Stopping::give_up_at},
    Field{"sent", &Stopping::sent},
    Field{"look", &Stopping::look},
    Field{"result", &Stopping::result},
    Field{"requests", &Stopping::requests},
};

template <>
inline constexpr std::tuple kFields<Keep> = {
    Field{"state", &Keep::state},
    Field{"seconds", &Keep::seconds},
    Field{"until", &Keep::until},
    Field{"switch_number", &Keep::switch_number},
};
template <>
inline constexpr std::tuple kFields<PowerDown> = {
    Field{"reboot", &PowerDown::reboot},     Field{"tear_down_at", &PowerDown::tear_down_at},
    Field{"force_at", &PowerDown::force_at}, Field{"commanded", &PowerDown::commanded},
    Field{"cause", &PowerDown::cause},
};
template <>
inline constexpr std::tuple kFields<BatterySource> = {
    Field{"source", &BatterySource::source},
    Field{"percent", &BatterySource::percent},
    Field{"charging", &BatterySource::charging},
};
template <>
inline constexpr std::tuple kFields<LevelRun> = {
    Field{"level", &LevelRun::level},
    Field{"since", &LevelRun::since},
    Field{"samples", &LevelRun::samples},
    Field{"higher", &LevelRun::higher},
};

template <>
inline constexpr std::tuple kFields<PolicyState> = {
    Field{"clock", &PolicyState::clock},
    Field{"loaded", &PolicyState::loaded},
    Field{"batteries", &PolicyState::batteries},
    Field{"battery", &PolicyState::battery},
    Field{"charging", &PolicyState::charging},
    Field{"battery_silent", &PolicyState::battery_silent},
    Field{"invalid_recorded", &PolicyState::invalid_recorded},
    Field{"jump_recorded", &PolicyState::jump_recorded},
    Field{"doubled_recorded", &PolicyState::doubled_recorded},
    Field{"level", &PolicyState::level},
    Field{"level_cause", &PolicyState::level_cause},
    Field{"lifting", &PolicyState::lifting},
    Field{"emptying", &PolicyState::emptying},
    Field{"empty", &PolicyState::empty},
    Field{"stored", &PolicyState::stored},
    Field{"withheld", &PolicyState::withheld},
    Field{"low_power", &PolicyState::low_power},
    Field{"still", &PolicyState::still},
    Field{"still_since", &PolicyState::still_since},
    Field{"keep", &PolicyState::keep},
    Field{"power", &PolicyState::power},
    Field{"failures", &PolicyState::failures},
    Field{"retry_at", &PolicyState::retry_at},
    Field{"calls", &PolicyState::calls},
};

template <>
inline constexpr std::tuple kFields<Unsaved> = {
    Field{"what", &Unsaved::what},
    Field{"save", &Unsaved::save},
    Field{"since", &Unsaved::since},
    Field{"why", &Unsaved::why},
};

template <>
inline constexpr std::tuple kFields<StartUpState> = {
    Field{"by_hand", &StartUpState::by_hand},
    Field{"finishing", &StartUpState::finishing},
    Field{"restarted", &StartUpState::restarted},
    Field{"raised", &StartUpState::raised},
    Field{"set_up", &StartUpState::set_up},
    Field{"stage", &StartUpState::stage},
    Field{"set_up_requests", &StartUpState::requests},
};

template <>
inline constexpr std::tuple kFields<PendingRelease> = {
    Field{"requests", &PendingRelease::requests}, Field{"by", &PendingRelease::by},
    Field{"last", &PendingRelease::last},         Field{"again", &PendingRelease::again},
    Field{"until", &PendingRelease::until},
};

template <>
inline constexpr std::tuple kFields<EmergencyStopState> = {
    Field{"emergency_stop", &EmergencyStopState::stop},
    Field{"stop_cause", &EmergencyStopState::cause},
    Field{"other_stops", &EmergencyStopState::others},
    Field{"released_stops", &EmergencyStopState::released},
    Field{"release", &EmergencyStopState::release},
};

template <>
inline constexpr std::tuple kFields<FallbackState> = {
    Field{"fallback", &FallbackState::target},
    Field{"fallback_cause", &FallbackState::cause},
};

template <>
inline constexpr std::tuple kFields<SavesState> = {
    Field{"last_save", &SavesState::last},
    Field{"unsaved", &SavesState::unsaved},
};

template <>
inline constexpr std::tuple kFields<Machine> = {
    Field{"phase", &Machine::phase},
    Field{"state", &Machine::state},
    Field{"host", &Machine::host},
    Field{"epoch", &Machine::epoch},
    Field{"number", &Machine::number},
    Field{"last_switch", &Machine::last_switch},
    Field{"requested_by", &Machine::requested_by},
    Field{"standing", &Machine::standing},
    Part{&Machine::start_up},
    Field{"actuators", &Machine::actuators},
    Field{"current", &Machine::current},
    Field{"waiting", &Machine::waiting},
    Part{&Machine::fallback},
    Field{"stopping", &Machine::stopping},
    Part{&Machine::emergency},
    Field{"last_record", &Machine::last_record},
    Field{"recorded_state", &Machine::recorded_state},
    Part{&Machine::saves},
    Field{"policy", &Machine::policy},
};

}  // namespace musher::fields
