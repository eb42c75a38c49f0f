#include "musher/lifecycle/recovery/joining.hpp"

#include <algorithm>

#include "musher/lifecycle/config/flow.hpp"

namespace musher {

bool Joining::DriveLateOnes() {
  if (machine_.phase != Phase::kRunning || machine_.current || machine_.waiting) return false;
  bool changed = false;
  for (std::size_t i = 0; i < machine_.actuators.size(); ++i) {
    const ActuatorRecord& record = Of(i);
    const bool free = record.presence == Presence::kPresent && !record.command &&
                      !record.report.busy() && record.health != Health::kHung && !record.given_up &&
                      !record.restart_requested;
    const bool unchecked = !record.checked && !record.join_tried && !config_.RankOf(record.state());
    if (!free || record.held) continue;
    if (!record.due && !unchecked) {
      const bool had_a_fault = record.fault.has_value();
      commands_.ReportUnchecked(i);
      changed |= !had_a_fault && record.fault;
      continue;
    }
    std::string blocker;
    if (!MayJoin(i, blocker)) {
      if (blocker.empty()) continue;
      changed |= !record.fault;  // the actuators after it are evaluated in turn
      Degrade(i, kCodeStatusError, blocker, CauseOfBlocker(i));
      continue;
    }
    Join(i);
    changed = true;
  }
  return changed;
}

// Whether the actuators in its `after` are present, for a self-check, or up, for going up itself.
bool Joining::MayJoin(std::size_t i, std::string& blocker) const {
  const ActuatorRecord& record = Of(i);
  const auto own = config_.RankOf(record.state());
  const State place = PlaceOf(i);
  const auto target = config_.RankOf(place);
  const bool goes_up = record.due && target && (!own || *own < *target);
  const bool elsewhere = record.due && record.state() != place;
  const bool refused = goes_up || (elsewhere && SwitchesOnAgain(config_, record.state(), place));
  // Its command could overtake the release on the way to it.
  const bool stopped = machine_.emergency_stop || record.report.emergency_stop != 0;
  if (refused && stopped && machine_.state != kError) return false;
  if (record.due && !goes_up) return true;
  if (!NeedsMet(i, blocker)) {
    if (blocker.empty()) blocker = WaitsForSuspended(i);
    return false;
  }
  return !goes_up || std::all_of(ConfigOf(i).after.begin(), ConfigOf(i).after.end(),
                                 [this](const std::string& name) {
                                   const ActuatorRecord& needed = Of(*config_.IndexOf(name));
                                   return needed.held || needed.state() == machine_.state;
                                 });
}

void Joining::Join(std::size_t i) {
  ActuatorRecord& record = Of(i);
  if (!record.due) {
    return commands_.Issue(i, machine_.number + 1, State(kSelfCheck),
                           config_.TimeFor(i, kSelfCheck));
  }
  record.due = false;
  const State place = PlaceOf(i);
  if (record.state() == place) {
    if (record.checked && !record.suspended) record.fault.reset();
  } else if (!config_.RankOf(place)) {
    return;  // the machine is between states; the next switch includes this actuator
  } else if (!ConfigOf(i).Lists(place)) {
    Degrade(i, kCodeUnSupport, "has no state '" + place + "'", record.cause);
  } else {
    commands_.Issue(i, machine_.number + 1, place, config_.TimeFor(i, place));
  }
}

}  // namespace musher
