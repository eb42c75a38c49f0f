#pragma once
// on_lost: the machine goes down when a critical actuator is unavailable (StepPart::FallBack()
// notes it), as soon as no switch is under way.

#include "musher/lifecycle/switch/switches.hpp"

namespace musher {

class Fallback : StepPart {
 public:
  Fallback(StepContext& step, PolicyMemory& memory, Switches& switches)
      : StepPart(step), memory_(memory), switches_(switches) {}

  // Returns whether a switch was begun.
  bool Begin();

 private:
  PolicyMemory& memory_;
  Switches& switches_;
};

}  // namespace musher
