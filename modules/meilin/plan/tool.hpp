#pragma once
// The command-line tools of plans, for the program musher-meilin.
//
//   musher-meilin check FILE…     errors of drawn plans (.toml), maps of boxes (.toml, .json) and
//                                 old plans (.json), each with its place
//   musher-meilin plan FILE       the plan of a drawn plan, or the best ones of a map of boxes, as
//                                 a table with the eight numbers of each step and a drawing

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/diagnostic.hpp"

namespace musher::meilin {

// The diagnostics of a file that is no plan, such as a tree; nothing if the caller does not know it
// either.
using FileCheck = std::function<std::optional<std::vector<Diagnostic>>(const std::string& path)>;

bool IsPlanTool(std::string_view command);  // "check", "plan"

// `argv[0]` is the command. What `others` does not know is a plan or a map. Returns the exit
// code: 0 no errors, 2 errors or usage. Prints the result on stdout, errors on stderr.
int RunPlanTool(int argc, const char* const* argv, const FileCheck& others = {});

// Of a plan, a map or an old plan, by the keys of the file.
std::vector<Diagnostic> CheckPlanFile(const std::string& path);

}  // namespace musher::meilin
