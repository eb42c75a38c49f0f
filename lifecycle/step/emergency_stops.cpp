#include "musher/lifecycle/step/emergency_stops.hpp"

#include <algorithm>

namespace musher {
namespace {

// So many ids of emergency stops that are over are remembered, here and on disk.
constexpr std::size_t kMostReleasedKept = 64;
// So many are engaged beside the first one at most; more change nothing.
constexpr std::size_t kMostStopsKnown = 64;

}  // namespace

StoredStops Merge(const StoredStops& stored, const StoredStops& received) {
  StoredStops stops;
  for (const auto* from : {&stored, &received}) {
    for (const StopId id : from->released) {
      std::erase(stops.released, id);
      stops.released.push_back(id);
    }
  }
  const auto known = [&stops](const EmergencyStop& stop) {
    const auto& [engaged, released] = stops;
    return std::find(released.begin(), released.end(), stop.id) != released.end() ||
           std::any_of(engaged.begin(), engaged.end(),
                       [&stop](const EmergencyStop& other) { return other.id == stop.id; });
  };
  for (const auto* from : {&stored, &received}) {
    for (const EmergencyStop& stop : from->engaged) {
      if (!known(stop) && stops.engaged.size() <= kMostStopsKnown) stops.engaged.push_back(stop);
    }
  }
  auto& released = stops.released;
  if (released.size() > kMostReleasedKept) {
    released.erase(released.begin(),
                   released.end() - static_cast<std::ptrdiff_t>(kMostReleasedKept));
  }
  return stops;
}

// Both are published, so that a panel that still publishes "engaged" does not engage a released
// stop.
void EmergencyStops::Begin(const StoredStops& stops) {
  machine_.emergency.released = stops.released;
  for (const StopId id : stops.released) Do(action::PublishEmergencyStop{{id, "", ""}, false});
  for (const EmergencyStop& stop : stops.engaged) {
    if (Add(stop)) Engage(stop);
  }
  if (stops != StoredStops{}) saving_.Save(Stored::kEmergencyStops);
}

// Only the controller that leads releases a stop; the releases that other controllers published
// before came with Begin.
void EmergencyStops::On(const event::EmergencyStopSeen& seen) {
  if (machine_.phase == Phase::kIdle || !seen.engaged) return;
  if (Add(seen.stop)) Engage(seen.stop);
}

void EmergencyStops::On(const event::ReleaseRequested& requested) {
  // It publishes no more, although its last replies may still be on their way.
  if (machine_.phase == Phase::kStopped) {
    return Do(action::AnswerCall{
        requested.request, Error{kCodeStateInvalid,
                                 "the machine is stopped; start it (`musher up`), then release "
                                 "the emergency stop"}});
  }
  if (!machine_.emergency.stop) {
    return Do(action::AnswerCall{requested.request,
                                 Error{kCodeStateInvalid, "no emergency stop is engaged"}});
  }
  const std::vector<EmergencyStop> engaged = StopsOf(machine_).engaged;
  machine_.emergency.stop.reset();
  machine_.emergency.others.clear();
  for (const EmergencyStop& stop : engaged) Release(stop.id);
  saving_.Save(Stored::kEmergencyStops);
  RecordMachine(kCodeOk, texts::EmergencyStopReleased(requested.by));
  Do(action::AnswerCall{requested.request, Ok()});
}

// An actuator may have latched a stop that this controller missed: then it is engaged for the
// machine. It may have missed a release: then the release is published again.
void EmergencyStops::Compare(const ActuatorReport& report, ActuatorIndex i) {
  const StopId id = report.emergency_stop;
  if (id == 0 || machine_.phase == Phase::kIdle) return;
  if (IsReleased(id)) return Do(action::PublishEmergencyStop{{id, "", ""}, false});
  const bool origin_known =
      !report.emergency_stop_by.empty() || !report.emergency_stop_reason.empty();
  const EmergencyStop stop{
      id, report.emergency_stop_by,
      origin_known ? report.emergency_stop_reason : ConfigOf(i).name + " had latched it"};
  if (Add(stop)) Engage(stop);
}

// Adds a stop to the engaged ones. Returns whether it has new information.
bool EmergencyStops::Add(const EmergencyStop& stop) {
  if (stop.id == 0 || IsReleased(stop.id)) return false;
  auto& first = machine_.emergency.stop;
  if (!first) {
    first = stop;
    return true;
  }
  auto& others = machine_.emergency.others;
  const auto same = [&](const EmergencyStop& other) { return other.id == stop.id; };
  const auto found = std::find_if(others.begin(), others.end(), same);
  EmergencyStop* known = same(*first) ? &*first : found != others.end() ? &*found : nullptr;
  if (known == nullptr) {
    if (others.size() >= kMostStopsKnown) return false;
    others.push_back(stop);
    return true;
  }
  // An actuator that had latched it may have reported before the sample that engaged it arrived.
  if (!known->by.empty() || stop.by.empty()) return false;
  *known = stop;
  return true;
}

bool EmergencyStops::IsReleased(StopId id) const {
  const auto& released = machine_.emergency.released;
  return std::find(released.begin(), released.end(), id) != released.end();
}

// The actuators have latched the stop themselves by now, or do so when they receive it from this
// controller. It is published first and saved after.
void EmergencyStops::Engage(const EmergencyStop& stop) {
  Do(action::PublishEmergencyStop{stop, true});
  saving_.Save(Stored::kEmergencyStops);
  const RecordId recorded =
      RecordMachine(kCodeProtectedError, texts::EmergencyStopEngaged(stop.by, stop.reason),
                    machine_.emergency.others.empty() ? 0 : machine_.emergency.cause);
  if (machine_.emergency.others.empty()) machine_.emergency.cause = recorded;
  if (machine_.current) machine_.current->stopped = true;
  for (ActuatorRecord& record : machine_.actuators) record.set_again = false;
}

void EmergencyStops::Release(StopId id) {
  auto& released = machine_.emergency.released;
  released.push_back(id);
  if (released.size() > kMostReleasedKept) released.erase(released.begin());
  Do(action::PublishEmergencyStop{{id, "", ""}, false});
}

}  // namespace musher
