#pragma once
// One key of an input device of Linux, such as the power key of a computer.
//
// Threads: the loop's.

#include <cstdint>
#include <functional>
#include <string>

#include "musher/modules/device/input_device.hpp"

namespace musher::device {

inline constexpr std::uint16_t kPowerKeyCode = 116;  // KEY_POWER of linux/input-event-codes.h

class InputKey {
 public:
  using OnKey = std::function<void(bool pressed)>;
  using Log = std::function<void(const std::string&)>;

  // Calls `on_key` on the loop when the key is pressed or released, and with false when the device
  // is lost. It opens the device at once. The loop outlives it.
  InputKey(transport::EventLoop& loop, const std::string& device, std::uint16_t code,
           const OnKey& on_key, const Log& log)
      : device_(loop, {device, ""}, {code},
                {[on_key](std::uint16_t, bool pressed) { on_key(pressed); }, [] {},
                 [log](const std::string& line) { log("power key: " + line); }}) {}

 private:
  InputDevice device_;
};

}  // namespace musher::device
