#pragma once
// Static check of a skill's table, before it runs. A run is refused with its errors; a test of your
// own skills calls it for each of them.
//
// Errors:
//   the table declares no state, a name twice, or a transition of an unknown state
//   a state from which no declared transitions lead to an end (SUCCEEDED, FAILED, CANCELLED)
//   an end that declares a transition, and a transition to IDLE
// Warnings, since it may be intended:
//   a state to which no transition leads
//   a skill that never succeeds: it only ends by a failure or a cancellation
//   a transition that is declared twice, with the same text

#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/behavior/fsm/check.hpp"
#include "musher/behavior/skill/table.hpp"

namespace musher::skill {

using fsm::Problem;

// In the order of the states; problems of the table itself, with an empty `where`, come first.
std::vector<Problem> Check(const Table& table);
// Its errors only, a line each, with the name of the skill before each.
Result<> CheckErrors(const std::string& skill, const Table& table);

}  // namespace musher::skill
