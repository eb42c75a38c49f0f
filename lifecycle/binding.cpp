// binds_to: an actuator that cannot do without another is taken to rest while that one is not up,
// and is driven to where the machine is when that one is there again: in the machine's state, not
// only present. What matters is how things stand, not how they came to be so.

#include "musher/lifecycle/decision.hpp"

namespace musher {

// Whether others can build on it.
bool Decision::IsUp(std::size_t i) const {
  const ActuatorRecord& record = Of(i);
  return record.presence == Presence::kPresent && Fits(i) && !record.given_up &&
         record.health != Health::kHung && !record.restart_asked && record.state() != kTearDown;
}

bool Decision::IsBoundTo(std::size_t i, std::size_t other, std::vector<bool>& seen) const {
  for (const std::string& name : ConfigOf(i).binds_to) {
    const std::size_t needed = *config_.IndexOf(name);
    if (seen[needed]) continue;
    seen[needed] = true;
    if (needed == other || IsBoundTo(needed, other, seen)) return true;
  }
  return false;
}

// Whether `needed` is no reason for `i` to rest. Once `i` rests, `needed` has to be where the
// machine is again, unless it waits for `i` in turn.
bool Decision::Suffices(std::size_t needed, std::size_t i) const {
  if (!IsUp(needed)) return false;
  std::vector<bool> seen(machine_.actuators.size(), false);
  if (!Of(i).parked || IsBoundTo(needed, i, seen)) return true;
  return !Of(needed).order && Of(needed).state() == machine_.state;
}

// One that `bound` is bound to by way of `i`, and that is not up; null when all are. Two that are
// bound to each other do not keep each other down: `seen` closes the circle.
const std::string* Decision::MissingFor(std::size_t bound, std::size_t i,
                                        std::vector<bool>& seen) const {
  for (const std::string& name : ConfigOf(i).binds_to) {
    const std::size_t needed = *config_.IndexOf(name);
    if (seen[needed]) continue;
    seen[needed] = true;
    if (!Suffices(needed, bound)) return &name;
    if (const std::string* missing = MissingFor(bound, needed, seen)) return missing;
  }
  return nullptr;
}

bool Decision::ParkAndUnpark() {
  if (machine_.phase != Phase::kRunning || machine_.current) return false;
  bool changed = false;
  for (std::size_t i = 0; i < machine_.actuators.size(); ++i) {
    ActuatorRecord& record = Of(i);
    const bool free =
        record.presence == Presence::kPresent && !record.order && !record.report.busy();
    if (!free || !record.checked) continue;
    std::vector<bool> seen(machine_.actuators.size(), false);
    seen[i] = true;
    const std::string* missing = MissingFor(i, i, seen);
    if (missing != nullptr && !record.parked && !record.held) {
      Park(i, *missing);
      changed = true;
    } else if (missing == nullptr && record.parked) {
      record.parked = false;
      record.due = true;
      changed = true;
    }
  }
  return changed;
}

void Decision::Park(std::size_t i, const std::string& missing) {
  ActuatorRecord& record = Of(i);
  record.parked = true;
  record.due = true;
  Degrade(i, kCodeStatusError, "it rests: " + missing + ", which it is bound to, is not up",
          Of(*config_.IndexOf(missing)).cause);
}

// Where it belongs: with the machine; while parked, at rest, and never higher than it is.
State Decision::PlaceOf(std::size_t i) const {
  const ActuatorRecord& record = Of(i);
  if (!record.parked) return machine_.state;
  const auto own = config_.RankOf(record.state());
  const auto machine = config_.RankOf(machine_.state);
  for (const std::string_view rest : {kDeActive, kLowPower}) {
    const auto rank = config_.RankOf(rest);
    if (!ConfigOf(i).Lists(rest) || !rank) continue;
    if (!own || *own <= *rank) break;
    return machine && *machine < *rank ? machine_.state : State(rest);
  }
  return record.state();
}

}  // namespace musher
