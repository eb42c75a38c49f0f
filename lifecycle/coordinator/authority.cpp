#include "musher/lifecycle/coordinator/authority.hpp"

#include <utility>

namespace musher {

// The controller with the higher epoch leads. The other releases control at once and changes
// nothing more.
void Authority::On(const event::RivalSeen& rival) {
  const bool leads =
      rival.epoch <= kLastEpoch &&
      (rival.epoch > machine_.epoch || (rival.epoch == machine_.epoch && rival.has_precedence));
  const bool at_work = machine_.phase != Phase::kIdle && machine_.phase != Phase::kStopped &&
                       machine_.phase != Phase::kFenced;
  if (!leads || !at_work) return;
  const std::string why = "another controller, " + rival.rival +
                          ", leads this machine with epoch " + ToString(rival.epoch);
  const Error fenced{kCodePermissionDenied, why};
  const RecordId recorded =
      RecordMachine(fenced.code, texts::ControllerFenced(machine_.epoch, why));
  switching_.EndWaiting(fenced, recorded);
  if (machine_.current) {
    SwitchResult result = SwitchConclusion(config_, machine_).Conclude(*machine_.current, false);
    result.outcome = SwitchOutcome::kSuperseded;
    result.code = fenced.code;
    result.reason = fenced.message;
    RecordEnd(*machine_.current, result, recorded);
    switching_.Answer(machine_.current->requests, result);
    if (machine_.stopping) machine_.stopping->result = result;
    machine_.current.reset();
  }
  if (machine_.stopping) {
    const SwitchResult result = tear_down_.Conclude(fenced.code, rival.rival);
    switching_.Answer(machine_.stopping->requests, result);
  }
  for (const RequestId request : std::exchange(machine_.start_up.requests, {})) {
    Do(action::AnswerCall{request, fenced});
  }
  for (ActuatorRecord& record : machine_.actuators) {
    for (const RequestId request : std::exchange(record.restart.requests, {})) {
      Do(action::AnswerCall{request, fenced});
    }
  }
  machine_.phase = Phase::kFenced;
  Do(action::Fenced{why});
}

}  // namespace musher
