// binds_to: an actuator that cannot do without another is taken to rest while that one is not up,
// and is driven to where the machine is when it is back. What matters is how things stand, not how
// they came to be so; a chain of bindings comes down and up link by link.

#include <algorithm>

#include "musher/lifecycle/decision.hpp"

namespace musher {

// Whether others can build on it.
bool Decision::IsUp(std::size_t i) const {
  const ActuatorRecord& record = Of(i);
  return record.presence == Presence::kPresent && record.checked && !record.parked &&
         record.health != Health::kHung && !record.restart_asked;
}

// One that `i` is bound to and that is not up; null when all are.
const std::string* Decision::MissingFor(std::size_t i) const {
  const std::vector<std::string>& needed = ConfigOf(i).binds_to;
  const auto missing = std::find_if(needed.begin(), needed.end(), [this](const std::string& name) {
    return !IsUp(*config_.IndexOf(name));
  });
  return missing == needed.end() ? nullptr : &*missing;
}

bool Decision::ParkAndUnpark() {
  if (machine_.phase != Phase::kRunning || machine_.current) return false;
  bool changed = false;
  for (std::size_t i = 0; i < machine_.actuators.size(); ++i) {
    ActuatorRecord& record = Of(i);
    const bool free =
        record.presence == Presence::kPresent && !record.order && !record.report.busy();
    if (!free || !record.checked) continue;
    const std::string* missing = MissingFor(i);
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
  record.due = false;
  Degrade(i, kCodeStatusError, "it rests: " + missing + ", which it is bound to, is not up",
          Of(*config_.IndexOf(missing)).cause);
  const auto own = config_.RankOf(record.state());
  for (const std::string_view rest : {kDeActive, kLowPower}) {
    const auto rank = config_.RankOf(rest);
    if (!ConfigOf(i).Lists(rest) || !own || !rank || *rank >= *own) continue;
    return Issue(i, machine_.number + 1, State(rest), config_.TimeFor(i, rest));
  }
}

}  // namespace musher
