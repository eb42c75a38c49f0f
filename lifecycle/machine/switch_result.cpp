#include "musher/lifecycle/machine/switch_result.hpp"

namespace musher {

std::string_view DirectionName(Direction direction) {
  switch (direction) {
    case Direction::kUp:
      return "up";
    case Direction::kDown:
      return "down";
    case Direction::kLevel:
      return "level";
    case Direction::kCheck:
      break;
  }
  return "check";
}

std::string_view OutcomeName(ActuatorOutcome outcome) {
  switch (outcome) {
    case ActuatorOutcome::kDone:
      return "done";
    case ActuatorOutcome::kRefused:
      return "refused";
    case ActuatorOutcome::kFailed:
      return "failed";
    case ActuatorOutcome::kOverdue:
      return "overdue";
    case ActuatorOutcome::kLost:
      return "lost";
    case ActuatorOutcome::kUndone:
      return "undone";
    case ActuatorOutcome::kSkipped:
      return "skipped";
    case ActuatorOutcome::kUnsupported:
      break;
  }
  return "unsupported";
}

std::string_view OutcomeName(SwitchOutcome outcome) {
  switch (outcome) {
    case SwitchOutcome::kDone:
      return "done";
    case SwitchOutcome::kRefused:
      return "refused";
    case SwitchOutcome::kUndone:
      return "undone";
    case SwitchOutcome::kDoneDegraded:
      return "done-degraded";
    case SwitchOutcome::kSuperseded:
      break;
  }
  return "superseded";
}

SwitchResult RefusedSwitch(const State& target, const std::string& actuator, const State& state,
                           const Error& why) {
  SwitchResult result;
  result.target = target;
  result.actuator = actuator;
  result.outcome = SwitchOutcome::kRefused;
  result.code = why.code;
  result.reason = why.message;
  result.state = state;
  return result;
}

}  // namespace musher
