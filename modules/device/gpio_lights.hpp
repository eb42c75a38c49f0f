#pragma once
// Lamps on GPIO lines: each is on or off, and blinks by the loop. A line that cannot be switched is
// opened again once in a second. When the program ends by itself they are off.
//
// Threads: the loop's.

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "musher/modules/device/gpio_line.hpp"
#include "musher/modules/device/led_look.hpp"
#include "musher/modules/device/light_output.hpp"

namespace musher::device {

// In the order of the targets; without a line: none.
using LampLines = std::array<GpioSpec, kLedTargets.size()>;

class GpioLights : public LightOutput {
 public:
  static constexpr Duration kReopen = std::chrono::seconds(1);

  GpioLights(transport::EventLoop& loop, const GpioLine::Open& open, const LampLines& lines,
             const std::function<void(const std::string&)>& log);
  ~GpioLights() override;

  void Show(const Lights& lights) override;
  std::string FaultOf(std::uint8_t target) const override;

 private:
  class Lamp;

  std::array<std::unique_ptr<Lamp>, kLedTargets.size()> lamps_;  // null: none
};

}  // namespace musher::device
