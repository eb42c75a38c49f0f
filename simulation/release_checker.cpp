#include "musher/simulation/release_checker.hpp"

#include <algorithm>
#include <utility>

#include "musher/lifecycle/config/flow.hpp"
#include "musher/lifecycle/policy/policy.hpp"

namespace musher::simulation {

void ReleaseChecker::OnBegin(const SimulatedController& controller, bool by_supervisor) {
  if (!by_supervisor && TakesNothingOver(controller)) {
    begun_by_a_person_[controller.serial()] = ++context_.order;
  }
  if (robot_.FindsUnreadFolder(controller)) unanswered_.insert(controller.serial());
}

void ReleaseChecker::OnStopPublished(const SimulatedController& controller,
                                     const msg::EmergencyStop& stop) {
  if (stop.engaged) {
    stopped_on_[controller.host()] = seen_[controller.serial()].stop_order = ++context_.order;
    release_order_.erase(StopId(stop.id));
  } else {
    release_order_.try_emplace(StopId(stop.id), ++context_.order);
  }
}

// A stop that its controller had released when the actuator received it, as after a freeze, is over
// since then: a command that was sent after the release may begin.
void ReleaseChecker::NoteLatched(const std::pair<std::string, std::size_t>& actuator,
                                 const ActuatorReport& before, const ActuatorReport& report) {
  const auto latches = [](const ActuatorReport& of, StopId id) {
    return of.emergency_stop == id || std::ranges::count(of.other_stops, id) != 0;
  };
  const auto note = [&](StopId id) {
    if (id == 0 || latches(before, id)) return;
    const auto released = release_order_.find(id);
    auto& order = latched_[actuator];
    order = std::max(order, released != release_order_.end() ? released->second : ++context_.order);
  };
  note(report.emergency_stop);
  for (const StopId id : report.other_stops) note(id);
}

// Whether the start of a controller takes nothing over: no other controller leads, and no process
// runs that a controller has started.
bool ReleaseChecker::TakesNothingOver(const SimulatedController& controller) const {
  const auto runs = [&](const ActuatorConfig& actuator) {
    return !actuator.command.empty() &&
           robot_.processes().IsAlive(actuator.name, controller.host());
  };
  return !controller.shell().rival() && std::ranges::none_of(config_.actuators, runs);
}

// A requested switch down of the machine switches on what a stop has left below the target.
void ReleaseChecker::NoteRaised(const Machine& machine, const State& target) {
  for (const ActuatorIndex i : config_.actuators.Indices()) {
    const ActuatorReport* report = robot_.ReportOf(i, machine.actuators[i].report);
    if (report == nullptr || !config_.actuators[i].Lists(target)) continue;
    if (!SwitchesOnAgain(config_, report->state, target)) continue;
    since_stop_.push_back({++context_.order, i, target, true});
  }
}

bool ReleaseChecker::AllSwitchedOnSince(std::uint64_t stopped) const {
  for (const ActuatorIndex i : config_.actuators.Indices()) {
    const bool any = std::ranges::any_of(since_stop_, [&](const SinceStop& one) {
      return one.order > stopped && one.up && one.actuator.value_or(i) == i;
    });
    if (!any) return false;
  }
  return true;
}

// A request that leads somewhere, after a stop: a switch begins by it, or it joins one. A person's
// start that begins with the first state is one, too; so is any start once each actuator was
// requested to be switched on.
void ReleaseChecker::NoteRequest(const SimulatedController& controller,
                                 const action::Record& record) {
  Seen& seen = seen_[controller.serial()];
  const Machine& machine = controller.shell().machine();
  const auto note = [&](const State& from, const State& target, bool starts = false) {
    if (machine.emergency.stop) return;
    const bool up = starts || SwitchesOnAgain(config_, from, target);
    since_stop_.push_back({++context_.order, record.actuator, target, up});
    if (!up && !record.actuator) NoteRaised(machine, target);
  };
  // A start may lead up if a person has begun it since the last stop, or each actuator was
  // requested to be switched on since then.
  const auto may_start = [&] {
    const std::uint64_t stopped = LastStopOf(controller.serial());
    const auto begun = begun_by_a_person_.find(controller.serial());
    return (begun != begun_by_a_person_.end() && begun->second > stopped) ||
           AllSwitchedOnSince(stopped);
  };
  switch (record.event) {
    case EventName::kSwitchRequested:
      unanswered_.erase(controller.serial());
      if (machine.current && machine.current->target == TargetOf(record)) {
        note(machine.current->from, TargetOf(record));
      }
      seen.requests.insert(record.id);
      return;
    case EventName::kPolicyRequested:
      unanswered_.erase(controller.serial());
      if (std::exchange(seen.requests_up, false)) seen.up.insert(record.id);
      seen.requests.insert(record.id);
      return;
    case EventName::kSwitchWaiting:
      seen.requests.insert(record.id);
      return;
    case EventName::kBatteryLimitsStart:  // the start leads to Active, once the battery allows it
      if (may_start()) note(machine.state, State(kActive));
      return;
    case EventName::kSwitchStarted: {
      const action::SwitchNote& begun = *record.of_switch;
      CheckStart(controller, begun);
      const bool starts = !config_.RankOf(begun.state) && may_start();
      if (!starts && !seen.requests.contains(record.cause)) return;
      // A wake-up, for one, leads up as far as the battery permits, and the battery the rest later.
      const bool up = seen.up.contains(record.cause);
      note(begun.state, up ? CeilingState(config_, BatteryLevel::kFree) : begun.target, starts);
      return;
    }
    default:
      return;
  }
}

// A start does not know whether a stop is engaged in a folder that it may not read.
void ReleaseChecker::CheckStart(const SimulatedController& controller,
                                const action::SwitchNote& begun) {
  const bool up = begun.target == kSelfCheck || Rises(config_, kDeActive, begun.target);
  if (!up || config_.RankOf(begun.state) || !unanswered_.contains(controller.serial())) return;
  ReportViolation(Invariant::kNoUnrequestedActivation,
                  "a start begins " + begun.target +
                      " although it may not read the emergency stops of another folder");
}

// When a controller last knew a stop: its disk keeps those of the controllers before it on its
// host. 0: none.
std::uint64_t ReleaseChecker::LastStopOf(std::uint64_t controller) {
  std::uint64_t stopped = seen_[controller].stop_order;
  for (std::size_t which = 0; which < 2; ++which) {
    const SimulatedController* one = robot_.controller(which);
    if (one == nullptr || one->serial() != controller || context_.state_lost) continue;
    stopped = std::max(stopped, stopped_on_[one->host()]);
  }
  return stopped;
}

// Whether a controller may bring an actuator to a state: it knows of no stop, or the state, or a
// more active one, was requested since the last one.
bool ReleaseChecker::IsRequestedSinceStop(std::uint64_t controller, ActuatorIndex i,
                                          const State& target) {
  const std::uint64_t stopped = LastStopOf(controller);
  const auto rank = config_.RankOf(target);
  if (stopped == 0 || !rank || target == kError) return true;
  return std::any_of(since_stop_.begin(), since_stop_.end(), [&](const SinceStop& one) {
    const bool meant = !one.actuator || *one.actuator == i;
    return one.order > stopped && meant && config_.RankOf(one.target).value_or(0) >= *rank;
  });
}

// A callback that may switch the actuator on, or on again, has begun by that command.
void ReleaseChecker::CheckAfterRelease(const std::string& name, std::size_t host,
                                       const ActuatorReport& before, const ActuatorReport& report,
                                       const Basis& sent) {
  // To undo a failed callback that led up leads down.
  const ActuatorCore* core = robot_.processes().CoreOf(name, host);
  const bool undoes = core != nullptr && core->unsettled && !core->half_way_down;
  const bool again =
      report.held_by_stop && !undoes && SwitchesOnAgain(config_, report.state, report.target);
  if (!again && !MaySwitchOn(config_, report.state, report.target)) return;
  if (report.target == kError || context_.false_reporters.contains(name)) return;
  const std::string what = name + " begins " + report.target + " in " + report.state;
  if (!sent.requested) {
    return ReportViolation(Invariant::kReleaseSwitchesNothingOn,
                           what + ", which was not requested since the last emergency stop");
  }
  const auto latched = latched_.find({name, host});
  if (latched == latched_.end() || before.incarnation != report.incarnation) return;
  if (sent.order < latched->second) {
    ReportViolation(Invariant::kReleaseSwitchesNothingOn,
                    what + ", by a command from before the emergency stop that it has latched");
  }
}

}  // namespace musher::simulation
