#pragma once
// An operator new that counts the allocations of the program, on any thread.

#include <cstddef>

namespace musher::testing {

struct Allocations {
  std::size_t times = 0;
  std::size_t bytes = 0;
};

// Since the program began.
Allocations AllocationsOfNew();

}  // namespace musher::testing
