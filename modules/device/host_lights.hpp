#pragma once
// LEDs of this computer as the kernel has them, by default under /sys/class/leds: a folder for each
// LED with a file for each of its values. The kernel blinks, so that a light goes on while this
// program is busy.
//
// Threads: the loop's. Writing blocks as long as the kernel's driver does.

#include <array>
#include <functional>
#include <optional>
#include <string>

#include "musher/modules/device/led_look.hpp"
#include "musher/modules/device/light_output.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::device {

inline constexpr const char* kLedFolder = "/sys/class/leds";

// The names of LEDs, in the order of the targets; empty: none.
using LedNames = std::array<std::string, kLedTargets.size()>;

// Shows it on the LED with that folder, one of a single colour (the brightest of the three) or of
// several. Fails with what the kernel says, and what to do.
Result<> ShowOnLed(const std::string& folder, const Look& look);

class HostLights : public LightOutput {
 public:
  static constexpr Duration kRetry = std::chrono::seconds(1);  // of lights that are not shown

  HostLights(transport::EventLoop& loop, const std::string& folder, const LedNames& names,
             std::function<void(const std::string&)> log);

  void Show(const Lights& lights) override;
  std::string FaultOf(std::uint8_t target) const override;

 private:
  struct Lamp {
    std::string folder;  // empty: none
    std::optional<Look> wanted;
    bool shown = false;  // `wanted`
    std::string fault;
  };
  void ShowAll();

  transport::EventLoop& loop_;
  const std::function<void(const std::string&)> log_;
  std::array<Lamp, kLedTargets.size()> lamps_;
  transport::LoopHandlePtr retry_;
};

}  // namespace musher::device
