#pragma once
// The blackboards of a tree as one JSON text, so that a file can keep them while the process is
// replaced. By the path of the subtree, then by key:
//
//   {"Main": {"n": 3, "goal": {"x_m": 1, "y_m": 2}}, "Main/Sequence/Drive": {"speed": 0.5}}
//
// A number, a text, true and false are what they are; a type with JSON (json_fields.hpp) is its
// JSON; null is an entry without a value. An entry of another type is left out. A key that is
// remapped to the tree around, and the keys of a board around the main tree, stand in neither.
//
// Threads: as the tree.

#include <string>
#include <string_view>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/behavior/tree/tree.hpp"

namespace musher::tree {

std::string BoardsToJson(const Tree& tree);
// Each value counts as set; entries that the JSON does not have stay as they are. Errors, all of
// them with their places; then nothing has changed: no JSON, no such subtree, a value that is not
// of the type of its entry. `file`: for messages.
std::vector<Diagnostic> BoardsFromJson(Tree& tree, std::string_view json, const std::string& file);

}  // namespace musher::tree
