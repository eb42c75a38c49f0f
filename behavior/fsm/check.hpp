#pragma once
// Static check of a chart, before it runs. Machine::Build() calls it; the warnings are then in
// Machine::warnings().
//
// Errors, since the machine would get stuck:
//   a dead end      a normal state without a transition out
//   a trap          states that lead only to each other, never back to the start, to the safe state
//                   or to a final one
//   a final state that declares a transition
//   a state that declares both On() and Defer() of an event
// Warnings, since it may be intended:
//   unreachable     only Force() reaches it
//   a safe state without a transition out: only Force() or Reset() leaves it
//   a transition that is declared twice, with the same text
//   an event that a state defers, and that no state declares to handle
//
// Threads: any, while no other thread changes the chart.

#include <string>
#include <string_view>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/behavior/fsm/chart.hpp"

namespace musher::fsm {

struct Problem {
  Severity severity = Severity::kError;
  std::string where;  // "TRACKING"; "SHOW/PHOTO" of a machine inside
  std::string what;

  friend bool operator==(const Problem&, const Problem&) = default;
};

// Includes the problems of the machines inside. In the order of the states. The ids of `chart` are
// its own. `place`: the path of the state that holds the machine (Machine::Place()); "" of the
// outermost one.
std::vector<Problem> Check(const Chart& chart, std::string_view place = {});

}  // namespace musher::fsm
