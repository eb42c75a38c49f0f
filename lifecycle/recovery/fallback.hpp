#pragma once
// on_lost: the machine goes down when a critical actuator is unavailable (StepPart::FallBack()
// notes it), as soon as no switch is under way.

#include "musher/lifecycle/switch/switching.hpp"

namespace musher {

class Fallback : StepPart {
 public:
  Fallback(StepContext& step, PolicyMemory& memory, Switching& switching)
      : StepPart(step), memory_(memory), switching_(switching) {}

  // Returns whether a switch was begun.
  bool Begin();

 private:
  PolicyMemory& memory_;
  Switching& switching_;
};

}  // namespace musher
