#pragma once
// Rules of a test from JSON, as BehaviorTree.CPP 4 has them: which leaves are replaced, by a test
// node or by another node of the factory. Rules apply in their order.
//
//   { "TestNodeConfigs": {
//       "Blocked": {"return_status": "FAILURE", "async_delay": 500, "post_script": "n += 1"} },
//     "SubstitutionRules": { "*/there": "Blocked", "talk": "AlwaysSuccess" } }
//
// A test node has return_status (SUCCESS, the default, FAILURE or SKIPPED), async_delay in ms,
// success_script, failure_script and post_script. A rule has the name or the class of a leaf, or a
// path: of its subtrees (`arm/hand/close`, as in BehaviorTree.CPP), or of all nodes above it
// (`Main/Sequence/close`). `*` stands for any characters of a name or a path.
//
// Errors, all of them with their places: no JSON, an unknown field, a value of another kind, a rule
// with neither a test node nor a node of the factory. Warning: a test node that no rule uses.
//
// Threads: one at a time, like the factory.

#include <string>
#include <string_view>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/behavior/tree/factory.hpp"

namespace musher::tree {

// With an error the factory stays as it is. Add the robot's nodes before. `file`: for messages.
std::vector<Diagnostic> AddSubstitutions(Factory& factory, std::string_view json,
                                         const std::string& file);
std::vector<Diagnostic> AddSubstitutionsOfFile(Factory& factory, const std::string& path);

}  // namespace musher::tree
