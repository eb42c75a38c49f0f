#pragma once
// What is wrong with a chart, found before it runs. Machine::Build() asks it; warnings are then in
// Machine::warnings().
//
// Errors, since the machine would get stuck:
//   a dead end      a normal state from which no way leads on
//   a trap          states that lead only to each other, never back to the start, to the safe state
//                   or to a final one
//   a final state that declares a way
// Warnings, since it may be meant:
//   unreachable     only a force leads there
//   a safe state from which no way leads on: only a force or a reset does
//   a way that is declared twice, in the same words

#include <string>
#include <vector>

#include "musher/behavior/fsm/chart.hpp"
#include "musher/lifecycle/diagnostic.hpp"

namespace musher::fsm {

struct Problem {
  Severity severity = Severity::kError;
  std::string where;  // "TRACKING"; "SHOW/PHOTO" of a machine inside
  std::string what;

  friend bool operator==(const Problem&, const Problem&) = default;
};

// Those of a machine inside too. In the order of the states. The ids of `chart` are its own.
std::vector<Problem> Check(const Chart& chart);

}  // namespace musher::fsm
