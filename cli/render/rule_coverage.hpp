#pragma once
// How often `musher prove` and `musher simulate` have reached what the user's rules name, as text
// and as JSON. A rule whose condition was never reached, or whose time never began, was not tested,
// and says nothing.

#include <cstdint>
#include <string>

#include "musher/cli/console/json_line.hpp"
#include "musher/lifecycle/config/user_rules.hpp"

namespace musher::cli {

enum class CheckedIn : std::uint8_t { kSearch, kSimulation };

// A line for each rule. `coverage`: of each of them, or of none.
std::string RuleCoverageText(const MachineConfig& config, const UserRules& rules,
                             const UserRulesCoverage& coverage, CheckedIn what, bool colour);
OrderedJson RuleCoverageJson(const UserRules& rules, const UserRulesCoverage& coverage);

}  // namespace musher::cli
