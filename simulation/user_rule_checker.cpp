#include "musher/simulation/user_rule_checker.hpp"

namespace musher::simulation {

void UserRuleChecker::SetRules(const UserRules& rules) {
  rules_ = rules;
  stable_coverage_.assign(rules.stable.size(), {});
  timed_checks_.assign(rules.timed.size(), {});
}

State UserRuleChecker::StateOf(const Machine& machine, std::optional<ActuatorIndex> subject) const {
  if (!subject) return machine.state;
  const ActuatorReport* report = robot_.ReportOf(*subject, machine.actuators[*subject].report);
  return report == nullptr ? State() : report->state;
}

// The state of an actuator that publishes a false one is not known.
void UserRuleChecker::CheckAtRest(const Machine& machine) {
  if (machine.phase == Phase::kStopped || !context_.false_reporters.empty()) return;
  const auto state_of = [&](std::optional<ActuatorIndex> subject) {
    return StateOf(machine, subject);
  };
  for (std::size_t i = 0; i < rules_.stable.size(); ++i) {
    const StableRule& rule = rules_.stable[i];
    if (rule.IsViolated(state_of, stable_coverage_[i])) {
      ReportViolation(Invariant::kUserRules, rule.text);
    }
  }
}

void UserRuleChecker::AfterEvent() {
  if (rules_.timed.empty()) return;
  const bool is_known = robot_.leaders() == 1 && context_.false_reporters.empty();
  UpdateTimed(is_known ? robot_.leader() : nullptr);
}

void UserRuleChecker::UpdateTimed(const SimulatedController* leader) {
  const Machine* machine = leader == nullptr ? nullptr : &leader->shell().machine();
  const auto goal = machine == nullptr ? std::nullopt : GoalOf(config_, *machine);
  for (std::size_t i = 0; i < rules_.timed.size(); ++i) {
    const TimedRule& rule = rules_.timed[i];
    const auto state =
        machine == nullptr ? std::nullopt : std::optional(StateOf(*machine, rule.subject));
    if (!timed_checks_[i].Update(rule, goal, state, robot_.network().now())) continue;
    ReportViolation(Invariant::kUserRules, rule.text);
  }
}

UserRulesCoverage UserRuleChecker::coverage() const {
  UserRulesCoverage coverage;
  coverage.stable = stable_coverage_;
  for (const TimedRuleCheck& check : timed_checks_) coverage.timed.push_back(check.coverage());
  return coverage;
}

}  // namespace musher::simulation
