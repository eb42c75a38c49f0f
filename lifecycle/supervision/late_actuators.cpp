#include "musher/lifecycle/supervision/late_actuators.hpp"

#include <algorithm>

#include "musher/lifecycle/config/flow.hpp"
#include "musher/lifecycle/switch/plan.hpp"

namespace musher {

bool LateActuators::DriveLateOnes() {
  if (machine_.current || machine_.waiting) return false;
  if (machine_.phase != Phase::kRunning) return LowerLateOnes();
  bool changed = false;
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    const KnownActuator& known = Of(i);
    const bool unchecked = IsToBeChecked(i);
    if (!IsFree(i) || known.held || IsOfAnother(i)) continue;
    if (!known.due && !unchecked) {
      const bool had_a_fault = known.fault.has_value();
      commands_.ReportUnchecked(i);
      changed |= !had_a_fault && known.fault;
      continue;
    }
    if (known.due && WaitsForRequest(i)) {
      Hold(i);
      changed = true;
      continue;
    }
    std::optional<RecordText> blocker;
    if (!MayJoin(i, blocker)) {
      if (!blocker) continue;
      changed |= !known.fault;  // the actuators after it are evaluated in turn
      Degrade(i, kCodeStatusError, *blocker, CauseOfBlocker(i));
      continue;
    }
    Join(i);
    changed = true;
  }
  return changed;
}

// Whether another controller has the actuator, which refuses each command until it is attached
// again.
bool LateActuators::IsOfAnother(ActuatorIndex i) const {
  const auto& fault = Of(i).fault;
  return fault && fault->event == EventName::kControlledByAnother;
}

// Whether it has had no self-check yet, or one has failed and is to be repeated: not while it works
// in the state of the machine.
bool LateActuators::IsToBeChecked(ActuatorIndex i) {
  KnownActuator& known = Of(i);
  std::optional<Time>& again = known.failed_checks.at;
  if (again && now_ >= *again) {
    again.reset();
    // A ROS 2 node that could not be configured waits for a person.
    if (!known.checked && !IsUnconfigured(config_, i, known)) known.join_tried = false;
  }
  // In LowPower the robot sleeps, and a check may wake up its devices.
  if (known.checked)
    return known.state() == kDeActive && machine_.state == kDeActive && IsCheckDue(i);
  const bool before = !config_.RankOf(known.state());
  const bool failed = known.failed_checks.count > 0 && known.state() != machine_.state;
  return !known.join_tried && (before || failed);
}

// For a machine that is not usable yet, or whose start has failed: lowers the actuators that were
// busy or out of reach during the rollback.
bool LateActuators::LowerLateOnes() {
  bool changed = false;
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    const bool late = machine_.start_up.set_up && Of(i).due && !Of(i).held && IsFree(i);
    if (late) changed |= Lower(i);
  }
  return changed;
}

// In a step of a start: drives the actuator to the state to which a rollback leads. Returns whether
// the actuator is more active than that state.
bool LateActuators::Lower(ActuatorIndex i) {
  if (!IsAbovePlace(i)) return false;
  Of(i).due = false;
  const State rest = RestOf(i);
  if (rest.empty()) {
    Degrade(i, kCodeUnSupport, texts::RollbackFailed("", texts::NoStateToGoBackTo().message),
            Of(i).cause);
  } else {
    commands_.Issue(i, machine_.number + 1, rest, config_.TimeFor(i, rest));
  }
  return true;
}

// Whether an emergency stop keeps the actuator from the state of the machine, which may switch it
// on. The release does not switch it on: only a requested switch does.
bool LateActuators::WaitsForRequest(ActuatorIndex i) const {
  const KnownActuator& known = Of(i);
  const State place = PlaceOf(i);
  if (IsFoundBelow(i)) return ConfigOf(i).Lists(place);
  return (IsStopped(i) || MustBeSetAgain(machine_, known)) && place != kError &&
         ConfigOf(i).Lists(place) && RunsCallback(config_, i, known.state(), place) &&
         MaySwitchOn(config_, known.state(), place);
}

// A controller that takes the machine over raises no actuator that it finds below its state: a
// person may have led it down.
bool LateActuators::IsFoundBelow(ActuatorIndex i) const {
  const KnownActuator& known = Of(i);
  return known.found_below && !known.set_again && Rises(config_, known.state(), PlaceOf(i));
}

// The report of the actuator counts, too: a command could overtake the release on its way there.
bool LateActuators::IsStopped(ActuatorIndex i) const {
  return machine_.emergency.stop.has_value() || Of(i).report.emergency_stop != 0;
}

void LateActuators::Hold(ActuatorIndex i) {
  KnownActuator& known = Of(i);
  known.due = false;
  // Keeps a fault that the actuator's own callback has reported.
  const std::int32_t own = known.report.outcome_code;
  const bool reported = own != kCodeOk && known.fault && known.fault->code == own;
  if (known.fault && (reported || known.suspended || !known.checked)) return;
  if (IsFoundBelow(i)) {
    return Degrade(i, kCodeStateInvalid, texts::FoundBelow(known.state(), machine_.state),
                   known.cause);
  }
  Degrade(i, kCodeProtectedError, texts::HeldIn(known.state(), machine_.state),
          machine_.emergency.cause);
}

// Whether the actuators in its `after` are present, for a self-check, or up, for going up itself.
bool LateActuators::MayJoin(ActuatorIndex i, std::optional<RecordText>& blocker) const {
  const KnownActuator& known = Of(i);
  const auto own = config_.RankOf(known.state());
  const State place = PlaceOf(i);
  const auto target = config_.RankOf(place);
  const bool goes_up = known.due && target && (!own || *own < *target);
  if (goes_up && IsStopped(i) && machine_.state != kError) return false;
  if (known.due && !goes_up) return true;
  if (!NeedsMet(i, blocker)) {
    if (!blocker) blocker = WaitsForSuspended(i);
    return false;
  }
  return !goes_up || std::all_of(ConfigOf(i).after.begin(), ConfigOf(i).after.end(),
                                 [this](const std::string& name) {
                                   const KnownActuator& needed = Of(*config_.IndexOf(name));
                                   return needed.held || needed.state() == machine_.state;
                                 });
}

void LateActuators::Join(ActuatorIndex i) {
  KnownActuator& known = Of(i);
  if (!known.due) {
    return commands_.Issue(i, machine_.number + 1, State(kSelfCheck),
                           config_.TimeFor(i, kSelfCheck));
  }
  known.due = false;
  const State place = PlaceOf(i);
  if (known.state() == place) {
    if (known.checked && !known.suspended) known.fault.reset();
    known.held |= IsKeptApart(i) && place == known.kept_in;
  } else if (!config_.RankOf(place)) {
    Lower(i);  // the next switch includes this actuator
  } else if (!ConfigOf(i).Lists(place)) {
    Degrade(i, kCodeUnSupport, texts::NoState(place), known.cause);
  } else {
    commands_.Issue(i, machine_.number + 1, place, config_.TimeFor(i, place), IsKeptApart(i));
  }
}

}  // namespace musher
