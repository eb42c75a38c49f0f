#pragma once
// What a test repeats with other numbers: a few times in the gate, often in the nightly run.

#include <cstdlib>
#include <vector>

namespace musher::testing {

// ctest sets it in a build with MUSHER_NIGHTLY.
inline bool Nightly() {
  return std::getenv("MUSHER_NIGHTLY") != nullptr;
}

// Of values in their order: all in the nightly run; in the gate the first and the last, where most
// breaks.
inline std::vector<double> Ends(std::vector<double> values) {
  if (!Nightly() && values.size() > 2) values = {values.front(), values.back()};
  return values;
}

}  // namespace musher::testing
