#pragma once
// Rules of the user. A file has one in each line:
//
//   # The lamp is on only where the base carries it.
//   never lamp Active while base is not Active
//   never machine LowPower while lamp is Active
//   never lamp Error
//   never arm Active while base is exited
//   within 5 s of Error arm in DeActive or exited
//
// "never" is about the stable states of a machine, in which nothing is under way, "within" about
// the time after a state is requested (machine/timed_rule_check.hpp). "machine" is the state of the
// machine. An actuator whose process has exited is in no state, and "exited".

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/base/time.hpp"
#include "musher/lifecycle/config/config.hpp"

namespace musher {

// In how many stable states a rule was checked, and in how many of them what it names was reached.
struct RuleCoverage {
  std::uint64_t states = 0;
  std::uint64_t condition = 0;  // its condition holds; without one: all
  std::uint64_t forbidden = 0;  // the subject of "never" is in that state, whatever the condition

  RuleCoverage& operator+=(const RuleCoverage& other);
};

struct StableRule {
  // That an actuator, or the machine, is in a state.
  struct Place {
    std::optional<ActuatorIndex> actuator;  // none: the machine
    State state;                            // empty: its process has exited
  };

  std::string text;  // as the file has it
  Place never;
  std::optional<Place> condition;  // the rule counts only then; none: always
  bool condition_negated = false;  // … only where that does not hold

  // The state of an actuator, empty where it has exited; of none, the machine's.
  using StateOf = std::function<State(std::optional<ActuatorIndex>)>;

  bool IsViolated(const StateOf& state_of) const;
  // The same; counts this state in `coverage`.
  bool IsViolated(const StateOf& state_of, RuleCoverage& coverage) const;

 private:
  bool IsForbidden(const StateOf& state_of) const;
  bool HasCondition(const StateOf& state_of) const;
};

// Within a time after the machine begins to go to a state, the subject is in one of these.
struct TimedRule {
  std::string text;  // as the file has it
  int line = 0;      // of the file
  Duration within{};
  State of;                              // of the machine
  std::optional<ActuatorIndex> subject;  // none: the machine
  std::vector<State> states;             // an empty one: its process has exited

  bool IsMetIn(const State& state) const;
};

// How often the time of such a rule has begun, and how often the subject was there in time.
struct TimedRuleCoverage {
  std::uint64_t begun = 0;
  std::uint64_t met = 0;

  TimedRuleCoverage& operator+=(const TimedRuleCoverage& other);
};

struct UserRules {
  std::vector<StableRule> stable;
  std::vector<TimedRule> timed;

  std::size_t size() const { return stable.size() + timed.size(); }
  bool empty() const { return size() == 0; }
};

// The coverage of each rule, in the order of UserRules.
struct UserRulesCoverage {
  std::vector<RuleCoverage> stable;
  std::vector<TimedRuleCoverage> timed;

  UserRulesCoverage& operator+=(const UserRulesCoverage& other);
};

struct UserRulesReading {
  UserRules rules;
  std::vector<Diagnostic> diagnostics;  // of all lines; with one the rules are not complete
};

// `file`: its name, for the diagnostics.
UserRulesReading ReadUserRules(const MachineConfig& config, const std::string& file,
                               std::string_view text);

}  // namespace musher
