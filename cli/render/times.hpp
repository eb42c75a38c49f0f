#pragma once
// What `musher times` prints. Pure.

#include <string>
#include <vector>

#include "musher/cli/config/learned_times.hpp"

namespace musher::cli {

// A table, then for each actuator with another limit its line as it is and as it is proposed.
std::string TimesText(const std::vector<LearnedTime>& rows, const MachineConfig& config,
                      bool colour);
std::string TimesJson(const std::vector<LearnedTime>& rows);

}  // namespace musher::cli
