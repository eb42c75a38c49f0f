#include "musher/lifecycle/supervision/binding.hpp"

#include "musher/lifecycle/config/flow.hpp"

namespace musher {

bool Binding::SuspendAndResume() {
  if (machine_.phase != Phase::kRunning || machine_.current) return false;
  bool changed = false;
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    KnownActuator& known = Of(i);
    const bool free =
        known.presence == Presence::kPresent && !known.command && !known.report.busy();
    if (!free || !known.checked) continue;
    PerActuator<bool> seen(machine_.actuators.size(), false);
    seen[i] = true;
    const std::string* missing = MissingFor(i, i, seen);
    if (missing != nullptr && !known.suspended && !known.held) {
      Suspend(i, *missing);
      changed = true;
    } else if (missing == nullptr && known.suspended) {
      known.suspended = false;
      known.due = true;
      changed = true;
    }
  }
  return changed;
}

// Whether the actuators bound to it may be up.
bool Binding::IsUp(ActuatorIndex i) const {
  const KnownActuator& known = Of(i);
  return known.presence == Presence::kPresent && Fits(i) && !known.restart.given_up &&
         known.health != Health::kHung && !known.restart.requested && known.state() != kTearDown &&
         !IsKeptAtRest(i);
}

// Whether a person has set it alone to DeActive or below, while the machine is above that.
bool Binding::IsKeptAtRest(ActuatorIndex i) const {
  const KnownActuator& known = Of(i);
  return known.held && !Rises(config_, kDeActive, known.state()) &&
         Rises(config_, kDeActive, machine_.state);
}

bool Binding::IsBoundTo(ActuatorIndex i, ActuatorIndex other, PerActuator<bool>& seen) const {
  for (const std::string& name : ConfigOf(i).binds_to) {
    const ActuatorIndex needed = *config_.IndexOf(name);
    if (seen[needed]) continue;
    seen[needed] = true;
    if (needed == other || IsBoundTo(needed, other, seen)) return true;
  }
  return false;
}

// Whether `needed` does not require `i` to be suspended. Once `i` is suspended, `needed` has to be
// in the state of the machine again, unless it waits for `i` in turn.
bool Binding::Suffices(ActuatorIndex needed, ActuatorIndex i) const {
  if (!IsUp(needed)) return false;
  PerActuator<bool> seen(machine_.actuators.size(), false);
  if (!Of(i).suspended || IsBoundTo(needed, i, seen)) return true;
  return !Of(needed).command && Of(needed).state() == machine_.state;
}

// An actuator that `bound` is bound to through `i` and that is not up; null when all are up. Two
// actuators bound to each other do not keep each other down: `seen` breaks the cycle.
const std::string* Binding::MissingFor(ActuatorIndex bound, ActuatorIndex i,
                                       PerActuator<bool>& seen) const {
  for (const std::string& name : ConfigOf(i).binds_to) {
    const ActuatorIndex needed = *config_.IndexOf(name);
    if (seen[needed]) continue;
    seen[needed] = true;
    if (!Suffices(needed, bound)) return &name;
    if (const std::string* missing = MissingFor(bound, needed, seen)) return missing;
  }
  return nullptr;
}

void Binding::Suspend(ActuatorIndex i, const std::string& missing) {
  KnownActuator& known = Of(i);
  known.suspended = true;
  known.due = true;
  Degrade(i, kCodeStatusError, texts::NotUp(missing), Of(*config_.IndexOf(missing)).cause);
}

}  // namespace musher
