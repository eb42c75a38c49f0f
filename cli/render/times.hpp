#pragma once
// What `musher times` prints. Pure.

#include <string>
#include <vector>

#include "musher/cli/config/learned_times.hpp"

namespace musher::cli {

// A table, then for each actuator with another limit its line as it is and as it is proposed.
std::string TimesText(const std::vector<LearnedTime>& rows, const MachineConfig& config,
                      bool colour);
// `diff`: of the config; empty: none was requested, or no limit changes.
std::string TimesJson(const std::vector<LearnedTime>& rows, const std::string& diff);

}  // namespace musher::cli
