#include "musher/controller/wire.hpp"

#include <chrono>

namespace musher {

msg::SetState::Response ToMessage(const SwitchResult& result) {
  msg::SetState::Response response;
  response.switch_number = result.number;
  response.target = result.target;
  response.actuator = result.actuator;
  response.outcome = OutcomeName(result.outcome);
  response.code = result.code;
  response.reason = result.reason;
  response.state = result.state;
  response.degraded = result.degraded;
  for (const ActuatorResult& actuator : result.actuators) {
    const double duration_ms = std::chrono::duration<double, std::milli>(actuator.duration).count();
    response.actuators.push_back({actuator.name, std::string(OutcomeName(actuator.outcome)),
                                  actuator.code, actuator.message, duration_ms, actuator.state});
  }
  return response;
}

msg::GetPlan::Response ToMessage(const MachineConfig& config, const Plan& plan) {
  msg::GetPlan::Response response;
  response.target = plan.target;
  if (plan.only) response.actuator = config.actuators[*plan.only].name;
  response.allowed = !plan.refusal;
  if (plan.refusal) {
    response.code = plan.refusal->code;
    response.reason = plan.refusal->message;
  }
  response.direction = DirectionName(plan.direction);
  response.state = plan.from;
  for (const PlanStep& step : plan.steps) {
    const bool there =
        step.part == PlanStep::Part::kThere || step.part == PlanStep::Part::kHeldThere;
    response.steps.push_back({config.actuators[step.actuator].name, step.wave, step.from, step.to,
                              step.driven() ? ToMilliseconds(step.deadline) : 0,
                              there ? "is there already" : step.note});
  }
  return response;
}

msg::HistoryEntry ToMessage(const JournalEntry& entry) {
  return {entry.id,       entry.wall_ns, entry.epoch,   entry.switch_number, entry.kind,
          entry.actuator, entry.code,    entry.message, entry.cause,         entry.state};
}

}  // namespace musher
