#pragma once
// Rules of the user about the stable states of a machine, in which nothing is under way. A file has
// one in each line:
//
//   # The lamp is on only where the base carries it.
//   never lamp Active while base is not Active
//   never machine LowPower while lamp is Active
//   never lamp Error
//   never arm Active while base is exited
//
// "machine" is the state of the machine. An actuator whose process has exited is in no state, and
// "exited".

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/lifecycle/config/config.hpp"

namespace musher {

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

  // `state_of`: the state of an actuator, empty where it has exited; of none, the machine's.
  bool IsViolated(const std::function<State(std::optional<ActuatorIndex>)>& state_of) const;
};

struct StableRules {
  std::vector<StableRule> rules;
  std::vector<Diagnostic> diagnostics;  // of all lines; with one the rules are not complete
};

// `file`: its name, for the diagnostics.
StableRules ReadStableRules(const MachineConfig& config, const std::string& file,
                            std::string_view text);

}  // namespace musher
