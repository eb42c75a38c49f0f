#pragma once
// Commands of `musher` that are programs of their own: `musher view` runs musher-view. The program
// replaces this process and receives every argument after the command, --help too.

#include <string>
#include <vector>

#include "musher/base/result.hpp"

namespace musher::cli {

// The path of a program that stands beside this one, else in PATH; an Error names the package that
// has it.
Result<std::string> FindExternal(const std::string& folder, const std::string& program);

// Replaces this process by the program. Returns only if that fails, with the reason.
Error RunExternal(const std::string& program, const std::vector<std::string>& arguments);

}  // namespace musher::cli
