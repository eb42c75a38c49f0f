#pragma once
// Checks the rules of the user: those of stable states in them, those with a time after each event.
// Also counts how often what they name was reached.
//
// Invariants: kUserRules.

#include <vector>

#include "musher/lifecycle/config/user_rules.hpp"
#include "musher/lifecycle/machine/timed_rule_check.hpp"
#include "musher/simulation/subject_checker.hpp"

namespace musher::simulation {

class UserRuleChecker : public SubjectChecker {
 public:
  explicit UserRuleChecker(CheckerContext& context) : SubjectChecker(context) {}

  // Call before the first event.
  void SetRules(const UserRules& rules);
  // The machine is in a stable state.
  void CheckAtRest(const Machine& machine);
  // After every event of the network: where no controller leads the machine, or two do, the times
  // begin again.
  void AfterEvent();
  UserRulesCoverage coverage() const;

 private:
  // The real one of the actuator; empty: its process does not run. Of none, the machine's.
  State StateOf(const Machine& machine, std::optional<ActuatorIndex> subject) const;
  void UpdateTimed(const SimulatedController* leader);

  UserRules rules_;
  std::vector<RuleCoverage> stable_coverage_;  // of each stable rule
  std::vector<TimedRuleCheck> timed_checks_;   // of each rule with a time
};

}  // namespace musher::simulation
