#pragma once
// Where the lights are: on a topic of the world, LEDs of this computer, boards on a CAN bus, or
// lamps on GPIO lines.
//
// Threads: the loop's.

#include <array>
#include <string>

#include "musher/modules/device/led.hpp"

namespace musher::device {

class LightOutput {
 public:
  using Lights = std::array<LedArbiter::Shown, kLedTargets.size()>;  // in the order of the targets

  virtual ~LightOutput() = default;

  // Shows the lights, now or once they work. Called again with those that have not changed.
  virtual void Show(const Lights& lights) = 0;

  // Why a light is not shown; "": it is, or there is none. `target` is one of kLedTargets.
  virtual std::string FaultOf(std::uint8_t target) const = 0;

  // Before the program exits: waits a moment until the last lights have been delivered.
  virtual void Flush() {}
};

}  // namespace musher::device
