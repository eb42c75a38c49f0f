#pragma once
// Checks the user's rules (config/user_rules.hpp) while the machine runs. It changes nothing: a
// violation is reported, and that is all.
//
// A "never" rule is checked in stable states, in which no switch and no command is under way, no
// process is being started or ended, and no callback runs (under_way.hpp). It is violated once it
// has not held for kViolatedFor in one stable state: what several actuators report arrives one
// after the other. Each violation is reported once, until the rule holds in a stable state again. A
// machine that is torn down is not checked, and neither is a rule about an actuator whose state is
// not known: one that is out of reach, or has not answered yet.
//
// A rule with a time is violated when that is over (timed_rule_check.hpp), once each time that it
// begins; where the state of its actuator is not known, as soon as it is.
//
// Pure: the time is an argument. Any thread, one at a time.

#include <optional>
#include <string>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/lifecycle/config/user_rules.hpp"
#include "musher/lifecycle/machine/machine.hpp"
#include "musher/lifecycle/machine/timed_rule_check.hpp"

namespace musher {

class RuleMonitor {
 public:
  static constexpr Duration kViolatedFor = Milliseconds(1000);

  struct Violation {
    std::string rule;    // as the file has it
    std::string states;  // "lamp is in Active, base is exited"
  };

  // `rules` name actuators of `config`, which must outlive it.
  RuleMonitor(const MachineConfig& config, UserRules rules);

  // The new violations. To be called after each step of the controller, and at next_check().
  std::vector<Violation> Check(const Machine& machine, Time now);
  // None: no rule waits for the time.
  std::optional<Time> next_check() const;
  // The rules that are violated now, as the file has them.
  std::vector<std::string> violated() const;

 private:
  struct Stable {
    StableRule rule;
    std::optional<Time> since = std::nullopt;  // it has not held in this stable state
    bool violated = false;                     // and that was reported
  };

  struct Timed {
    TimedRule rule;
    TimedRuleCheck check = {};
  };

  void CheckStable(const Machine& machine, Time now, std::vector<Violation>& found);
  void CheckTimed(const Machine& machine, Time now, std::vector<Violation>& found);
  // "lamp is in Active"; of none: the machine.
  std::string PlaceOf(std::optional<ActuatorIndex> subject, const Machine& machine) const;
  std::string StatesOf(const StableRule& rule, const Machine& machine) const;

  const MachineConfig& config_;
  std::vector<Stable> stable_;
  std::vector<Timed> timed_;
};

}  // namespace musher
