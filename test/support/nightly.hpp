#pragma once
// What a test repeats with other random numbers: a few times in the gate, often in the nightly run.

#include <cstdlib>

namespace musher::testing {

// ctest sets it in a build with MUSHER_NIGHTLY.
inline bool Nightly() {
  return std::getenv("MUSHER_NIGHTLY") != nullptr;
}

}  // namespace musher::testing
