#pragma once
// The proposed limits of `musher times` as a change of the config's text. Pure.
//
// Only the numbers change that get another limit: comments, spaces and arrays over several lines
// stay as they are.

#include <string>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/cli/config/learned_times.hpp"

namespace musher::cli {

// A unified diff with three lines of context, as `patch` takes it; "": no limit changes.
// `text` is the text of this config, and `name` its file in the head of the diff. Error: a limit
// is not written as a decimal number.
Result<std::string> TimesDiff(std::string_view text, const MachineConfig& config,
                              const std::vector<LearnedTime>& learned, const std::string& name);

}  // namespace musher::cli
