#pragma once
// Work that takes too long for the loop: one piece after the other, on another thread.

#include <functional>

namespace musher::navigation {

class Background {
 public:
  virtual ~Background() = default;

  // Runs `work` after all work before it; then, on the loop, the function that it returns. After
  // the destruction neither runs. Called on the loop.
  virtual void Do(std::function<std::function<void()>()> work) = 0;
};

}  // namespace musher::navigation
