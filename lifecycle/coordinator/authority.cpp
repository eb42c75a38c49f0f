#include "musher/lifecycle/coordinator/authority.hpp"

#include <utility>

#include "musher/lifecycle/refusal.hpp"

namespace musher {

bool Authority::AtWork() const {
  return machine_.phase != Phase::kIdle && machine_.phase != Phase::kStopped &&
         machine_.phase != Phase::kFenced;
}

void Authority::On(const event::RivalSeen& rival) {
  const bool leads =
      rival.epoch <= kLastEpoch &&
      (rival.epoch > machine_.epoch || (rival.epoch == machine_.epoch && rival.has_precedence));
  if (leads && AtWork()) Release(rival.rival, rival.epoch, rival.elsewhere);
}

bool Authority::ReleaseIfReplaced(ActuatorIndex i, const ActuatorReport& report) {
  const KnownActuator& known = Of(i);
  const bool here = report.incarnation != 0 && report.host == known.report.host;
  const bool own =
      here && report.incarnation == known.control.incarnation && control_.HasTaken(known);
  // Meanwhile a controller has begun to lead it, whose heartbeat does not arrive here; or the last
  // query of a predecessor, which was killed, has arrived there.
  const bool rises = here && known.control.rival_until &&
                     report.incarnation == known.report.incarnation &&
                     report.epoch > known.report.epoch;
  const bool taken = rises && machine_.start_up.by_supervisor && report.host != machine_.host &&
                     !control_.IsOfPredecessor(report.epoch);
  const bool higher = report.epoch > machine_.epoch && report.epoch < kLastEpoch;
  if (!(own || taken) || !higher || !AtWork()) return false;
  Release("which " + ConfigOf(i).name + " follows", report.epoch, true);
  return true;
}

void Authority::ReleaseIfReplacedElsewhere() {
  if (!AtWork()) return;
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    if (!control_.IsReplacedElsewhere(i)) continue;
    return Release("which " + ConfigOf(i).name + " follows", Of(i).report.epoch, true);
  }
}

// The other one stores the emergency stops that are engaged from now on, and which of them are
// released. Once it has ended, a start with the folder of this one does not know of them.
void Authority::NoteLedElsewhere() {
  StoredStops stops = StopsOf(machine_);
  stops.led_elsewhere = true;
  Do(action::SaveEmergencyStops{std::move(stops), ++machine_.saves.last});
}

// `rival`: which one it is. `elsewhere`: on another host, as one must be whose heartbeat does not
// arrive.
void Authority::Release(const std::string& rival, Epoch epoch, bool elsewhere) {
  const Error fenced = Refused<Refusal::kLedByRival>(rival, epoch);
  const RecordId recorded =
      RecordMachine(fenced.code, texts::ControllerFenced(machine_.epoch, fenced.message));
  switches_.EndWaiting(fenced, recorded);
  if (machine_.current) {
    SwitchResult result = SwitchConclusion(config_, machine_).Conclude(*machine_.current, false);
    result.outcome = SwitchOutcome::kSuperseded;
    result.code = fenced.code;
    result.reason = fenced.message;
    RecordEnd(*machine_.current, result, recorded);
    switches_.Answer(machine_.current->requests, result);
    if (machine_.stopping) machine_.stopping->result = result;
    machine_.current.reset();
  }
  if (machine_.stopping) {
    auto& torn_down = machine_.stopping->result;
    if (!torn_down) torn_down = RefusedSwitch(State(kTearDown), "", machine_.state, fenced);
    const SwitchResult result = tear_down_.Conclude(fenced.code, rival);
    switches_.Answer(machine_.stopping->requests, result);
  }
  for (const RequestId request : std::exchange(machine_.start_up.requests, {})) {
    Do(action::AnswerCall{request, fenced});
  }
  for (KnownActuator& known : machine_.actuators) {
    for (const RequestId request : std::exchange(known.restart.requests, {})) {
      Do(action::AnswerCall{request, fenced});
    }
  }
  if (elsewhere) NoteLedElsewhere();
  machine_.phase = Phase::kFenced;
  Do(action::Fenced{fenced.message});
}

}  // namespace musher
