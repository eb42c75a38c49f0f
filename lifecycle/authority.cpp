// Who has the say: other controllers of the same machine, and the emergency stop.

#include <algorithm>

#include "musher/lifecycle/decision.hpp"

namespace musher {
namespace {

constexpr std::size_t kReleasedKept = 16;

}  // namespace

// The controller with the higher epoch leads. The other lets go at once and touches nothing.
void Decision::On(const event::RivalHeard& rival) {
  const bool leads =
      rival.epoch <= kLastEpoch &&
      (rival.epoch > machine_.epoch || (rival.epoch == machine_.epoch && rival.has_precedence));
  const bool at_work = machine_.phase != Phase::kIdle && machine_.phase != Phase::kStopped &&
                       machine_.phase != Phase::kFenced;
  if (!leads || !at_work) return;
  const std::string why = "another controller, " + rival.who + ", leads this machine with epoch " +
                          std::to_string(rival.epoch);
  const Error fenced{kCodePermissionDenied, why};
  RecordMachine(fenced.code,
                "this controller of epoch " + std::to_string(machine_.epoch) + " lets go: " + why);
  if (machine_.current) {
    SwitchResult result = Conclude(*machine_.current, false);
    result.outcome = SwitchOutcome::kSuperseded;
    result.code = fenced.code;
    result.reason = fenced.message;
    Answer(machine_.current->requests, result);
    if (machine_.stopping) machine_.stopping->result = result;
    machine_.current.reset();
  }
  if (machine_.stopping) Answer(machine_.stopping->requests, *machine_.stopping->result);
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

void Decision::On(const event::EmergencyStopSeen& seen) {
  if (!seen.engaged) return HearRelease(seen.stop.id);
  const auto& released = machine_.released_stops;
  const bool over = std::find(released.begin(), released.end(), seen.stop.id) != released.end();
  if (seen.stop.id == 0 || over) return;
  const auto& engaged = machine_.emergency_stop;
  // An actuator that had latched it may have spoken before whoever engaged it.
  const bool explains =
      engaged && engaged->id == seen.stop.id && engaged->by.empty() && !seen.stop.by.empty();
  if (engaged && !explains) return EngageToo(seen.stop.id);
  Engage(seen.stop);
}

// The controller before us has released it. Once we lead, only we do.
void Decision::HearRelease(std::uint64_t id) {
  if (machine_.phase != Phase::kIdle) return;
  machine_.released_stops.push_back(id);
  std::erase(machine_.other_stops, id);
  if (!machine_.emergency_stop || machine_.emergency_stop->id != id) return;
  machine_.emergency_stop.reset();
  Do(action::SaveEmergencyStop{});
  RecordMachine(kCodeOk, "the emergency stop was released by the controller before");
}

void Decision::EngageToo(std::uint64_t id) {
  auto& others = machine_.other_stops;
  const bool known = machine_.emergency_stop->id == id ||
                     std::find(others.begin(), others.end(), id) != others.end();
  if (!known) others.push_back(id);
}

// The actuators have latched it themselves by now, or do so when they hear of it from us.
void Decision::Engage(const EmergencyStop& stop) {
  machine_.emergency_stop = stop;
  Do(action::TellEmergencyStop{stop, true});
  Do(action::SaveEmergencyStop{stop});
  machine_.stop_cause =
      RecordMachine(kCodeProtectedError, "emergency stop, engaged by " +
                                             (stop.by.empty() ? "somebody" : stop.by) +
                                             (stop.reason.empty() ? "" : ": " + stop.reason));
  if (machine_.current) machine_.current->stopped = true;
}

void Decision::On(const event::ReleaseRequested& requested) {
  if (!machine_.emergency_stop) {
    return Do(action::AnswerCall{requested.request,
                                 Error{kCodeStateInvalid, "no emergency stop is engaged"}});
  }
  const EmergencyStop stop = *std::exchange(machine_.emergency_stop, std::nullopt);
  Do(action::SaveEmergencyStop{});
  Release(stop.id);
  for (const std::uint64_t id : std::exchange(machine_.other_stops, {})) Release(id);
  RecordMachine(kCodeOk, "the emergency stop is released by " +
                             (requested.by.empty() ? "somebody" : requested.by) +
                             "; no state is changed by that");
  Do(action::AnswerCall{requested.request, Ok()});
}

void Decision::Release(std::uint64_t id) {
  auto& released = machine_.released_stops;
  released.push_back(id);
  if (released.size() > kReleasedKept) released.erase(released.begin());
  Do(action::TellEmergencyStop{{id, "", ""}, false});
}

// An actuator may have latched one that we missed, or missed the release of one: we follow the
// first and repeat the second.
void Decision::HoldTo(const ActuatorReport& report, std::size_t i) {
  const std::uint64_t id = report.emergency_stop;
  if (id == 0) return;
  if (machine_.emergency_stop) return EngageToo(id);
  const auto& released = machine_.released_stops;
  if (std::find(released.begin(), released.end(), id) != released.end()) {
    return Do(action::TellEmergencyStop{{id, "", ""}, false});
  }
  Engage({id, "", ConfigOf(i).name + " had latched it"});  // by whom is not known, or not yet
}

}  // namespace musher
