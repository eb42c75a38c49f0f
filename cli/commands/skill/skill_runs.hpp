#pragma once
// What `musher skill pause`, `resume` and `cancel` have in common: they ask every actuator that
// offers a skill, of the machine that is meant, for something about its run.
//
// Threads: loop thread only.

#include <functional>
#include <optional>
#include <string>
#include <variant>

#include "musher/cli/machine/link.hpp"
#include "musher/cli/machine/skill_choice.hpp"

namespace musher::cli {

// True: the skill runs there, and the actuator was asked; false: it does not run.
using AskedRun = std::variant<bool, Failure>;

struct AskedRuns {
  bool any = false;                // an actuator runs the skill
  std::optional<Failure> failure;  // the last one; without `any` the command fails with it
};

// Asks the actuators of the machine that is meant which offer the skill, or the given one alone.
AskedRuns AskRunsOf(Link& link, const GlobalOptions& global, const std::string& skill,
                    const std::string& actuator,
                    const std::function<AskedRun(const OfferedSkill& skill)>& ask);

}  // namespace musher::cli
