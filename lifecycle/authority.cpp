// Authority: other controllers of the same machine, other processes with an actuator's name, and
// the emergency stop.

#include <algorithm>

#include "musher/lifecycle/decision.hpp"

namespace musher {
namespace {

// So many ids of emergency stops that are over are remembered, here and on disk.
constexpr std::size_t kMostReleasedKept = 64;
// So many are engaged beside the first one at most; more change nothing.
constexpr std::size_t kMostStopsKnown = 64;

}  // namespace

// The controller with the higher epoch leads. The other releases control at once and changes
// nothing more.
void Decision::On(const event::RivalSeen& rival) {
  const bool leads =
      rival.epoch <= kLastEpoch &&
      (rival.epoch > machine_.epoch || (rival.epoch == machine_.epoch && rival.has_precedence));
  const bool at_work = machine_.phase != Phase::kIdle && machine_.phase != Phase::kStopped &&
                       machine_.phase != Phase::kFenced;
  if (!leads || !at_work) return;
  const std::string why = "another controller, " + rival.who + ", leads this machine with epoch " +
                          std::to_string(rival.epoch);
  const Error fenced{kCodePermissionDenied, why};
  RecordMachine(fenced.code, "this controller (epoch " + std::to_string(machine_.epoch) +
                                 ") releases control: " + why);
  EndWaiting(fenced, 0);
  if (machine_.current) {
    SwitchResult result = Conclude(*machine_.current, false);
    result.outcome = SwitchOutcome::kSuperseded;
    result.code = fenced.code;
    result.reason = fenced.message;
    RecordEnd(*machine_.current, result,
              "switch " + std::to_string(result.number) + " is superseded: " + why, 0);
    Answer(machine_.current->requests, result);
    if (machine_.stopping) machine_.stopping->result = result;
    machine_.current.reset();
  }
  if (machine_.stopping) {
    const SwitchResult result = StopResult(
        {fenced.code, "had not ended when another controller, " + rival.who + ", took over"});
    Answer(machine_.stopping->requests, result);
  }
  for (const RequestId request : std::exchange(machine_.set_up_requests, {})) {
    Do(action::AnswerCall{request, fenced});
  }
  for (ActuatorRecord& record : machine_.actuators) {
    for (const RequestId request : std::exchange(record.restart_requests, {})) {
      Do(action::AnswerCall{request, fenced});
    }
  }
  machine_.phase = Phase::kFenced;
  Do(action::Fenced{why});
}

void Decision::Decline(const Event& event) {
  const Error fenced{kCodePermissionDenied, "another controller leads this machine"};
  if (const auto* requested = std::get_if<event::SetStateRequested>(&event)) return On(*requested);
  if (const auto* restart = std::get_if<event::RestartRequested>(&event)) {
    Do(action::AnswerCall{restart->request, fenced});
  } else if (const auto* release = std::get_if<event::ReleaseRequested>(&event)) {
    Do(action::AnswerCall{release->request, fenced});
  } else if (const auto* awaited = std::get_if<event::SetUpAwaited>(&event)) {
    Do(action::AnswerCall{awaited->request, fenced});
  } else if (const auto* requested = std::get_if<event::PolicyRequested>(&event)) {
    Do(action::AnswerCall{requested->request, fenced});
  }
}

// A process on another host publishes as this actuator while the known process still answers.
bool Decision::IsImpostor(std::size_t i, const ActuatorReport& report) {
  ActuatorRecord& record = Of(i);
  if (report.host == record.report.host) return false;
  const bool known = record.other && record.other->host == report.host &&
                     record.other->incarnation == report.incarnation;
  record.other = report;
  if (known) return true;
  RecordActuator(i, kCodePermissionDenied,
                 "another process publishes as " + ConfigOf(i).name + ": process " +
                     std::to_string(report.pid) + " of host " + report.host.substr(0, 64) +
                     "; it is ignored while process " + std::to_string(record.report.pid) +
                     " answers");
  return true;
}

// A rebooted host counts as another host: the status that its actuators published while the
// processes from before the reboot were still present is used when those are lost.
void Decision::TakeUpOthers() {
  for (std::size_t i = 0; i < machine_.actuators.size(); ++i) {
    ActuatorRecord& record = Of(i);
    if (!record.other || record.presence == Presence::kPresent) continue;
    const ActuatorReport other = *std::exchange(record.other, std::nullopt);
    if (record.presence == Presence::kLost) On(event::StatusSeen{i, other});
  }
}

StoredStops Merge(const StoredStops& stored, const StoredStops& received) {
  StoredStops stops;
  for (const auto* from : {&stored, &received}) {
    for (const std::uint64_t id : from->released) {
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

// Only the controller that leads releases a stop; the releases that other controllers published
// before came with Begin.
void Decision::On(const event::EmergencyStopSeen& seen) {
  if (machine_.phase == Phase::kIdle || !seen.engaged) return;
  if (Add(seen.stop)) Engage(seen.stop);
}

bool Decision::IsReleased(std::uint64_t id) const {
  const auto& released = machine_.released_stops;
  return std::find(released.begin(), released.end(), id) != released.end();
}

// Adds a stop to the engaged ones. Returns whether it has new information.
bool Decision::Add(const EmergencyStop& stop) {
  if (stop.id == 0 || IsReleased(stop.id)) return false;
  auto& first = machine_.emergency_stop;
  if (!first) {
    first = stop;
    return true;
  }
  auto& others = machine_.other_stops;
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

// Both are published, so that a panel that still publishes "engaged" does not engage a released
// stop.
void Decision::BeginStops(const StoredStops& stops) {
  machine_.released_stops = stops.released;
  for (const std::uint64_t id : stops.released)
    Do(action::PublishEmergencyStop{{id, "", ""}, false});
  for (const EmergencyStop& stop : stops.engaged) {
    if (Add(stop)) Engage(stop);
  }
  if (stops != StoredStops{}) Save(Stored::kEmergencyStops);
}

StoredStops Decision::Stops() const {
  StoredStops stops;
  if (machine_.emergency_stop) stops.engaged.push_back(*machine_.emergency_stop);
  stops.engaged.insert(stops.engaged.end(), machine_.other_stops.begin(),
                       machine_.other_stops.end());
  stops.released = machine_.released_stops;
  return stops;
}

// The actuators have latched the stop themselves by now, or do so when they receive it from this
// controller. It is published first and saved after.
void Decision::Engage(const EmergencyStop& stop) {
  Do(action::PublishEmergencyStop{stop, true});
  Save(Stored::kEmergencyStops);
  const std::string origin = (stop.by.empty() ? "an unknown source" : stop.by) +
                             (stop.reason.empty() ? "" : ": " + stop.reason);
  const std::uint64_t recorded =
      RecordMachine(kCodeProtectedError, "emergency stop engaged by " + origin,
                    machine_.other_stops.empty() ? 0 : machine_.stop_cause);
  if (machine_.other_stops.empty()) machine_.stop_cause = recorded;
  if (machine_.current) machine_.current->stopped = true;
}

void Decision::On(const event::ReleaseRequested& requested) {
  // It publishes no more, although its last replies may still be on their way.
  if (machine_.phase == Phase::kStopped) {
    return Do(action::AnswerCall{
        requested.request, Error{kCodeStateInvalid,
                                 "the machine is stopped; start it (`musher up`), then release "
                                 "the emergency stop"}});
  }
  if (!machine_.emergency_stop) {
    return Do(action::AnswerCall{requested.request,
                                 Error{kCodeStateInvalid, "no emergency stop is engaged"}});
  }
  const std::vector<EmergencyStop> engaged = Stops().engaged;
  machine_.emergency_stop.reset();
  machine_.other_stops.clear();
  for (const EmergencyStop& stop : engaged) Release(stop.id);
  Save(Stored::kEmergencyStops);
  RecordMachine(kCodeOk, "emergency stop released by " +
                             (requested.by.empty() ? "an unknown source" : requested.by) +
                             "; no state changes");
  Do(action::AnswerCall{requested.request, Ok()});
}

void Decision::Release(std::uint64_t id) {
  auto& released = machine_.released_stops;
  released.push_back(id);
  if (released.size() > kMostReleasedKept) released.erase(released.begin());
  Do(action::PublishEmergencyStop{{id, "", ""}, false});
}

// An actuator may have latched a stop that this controller missed: then it is engaged for the
// machine. It may have missed a release: then the release is published again.
void Decision::HoldTo(const ActuatorReport& report, std::size_t i) {
  const std::uint64_t id = report.emergency_stop;
  if (id == 0 || machine_.phase == Phase::kIdle) return;
  if (IsReleased(id)) return Do(action::PublishEmergencyStop{{id, "", ""}, false});
  const bool origin_known =
      !report.emergency_stop_by.empty() || !report.emergency_stop_reason.empty();
  const EmergencyStop stop{
      id, report.emergency_stop_by,
      origin_known ? report.emergency_stop_reason : ConfigOf(i).name + " had latched it"};
  if (Add(stop)) Engage(stop);
}

}  // namespace musher
