#include "musher/lifecycle/machine/switch_result.hpp"

namespace musher {

std::string_view DirectionName(Direction direction) {
  return fields::NameOf(direction);
}

std::string_view OutcomeName(ActuatorOutcome outcome) {
  return fields::NameOf(outcome);
}

std::string_view OutcomeName(SwitchOutcome outcome) {
  return fields::NameOf(outcome);
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
