#pragma once
// A line of a GPIO chip: a contact that is read, or an output that is switched. gpio_chip.hpp has
// those of Linux; a test has its own.
//
// "Active" is the meaning of the line, whatever its voltage: a contact that is closed to ground is
// active at 0 V (active_low).

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "musher/base/code.hpp"
#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::device {

enum class GpioBias : std::uint8_t { kAsIs, kPullUp, kPullDown, kNone };

struct GpioSpec {
  std::string line;                      // its name, or "gpiochip0:5"; empty: none
  bool active_low = false;               // active at 0 V
  GpioBias bias = GpioBias::kAsIs;       // of an input
  Duration debounce = Milliseconds(10);  // of an input, by the kernel; 0: none

  friend bool operator==(const GpioSpec&, const GpioSpec&) = default;
};

class GpioLine {
 public:
  enum class Direction : std::uint8_t { kInput, kOutput };

  // Of an input; all run on the loop, none in the call that opens the line. on_lost is the last
  // one, and does not destroy the line.
  struct Events {
    std::function<void(bool active)> on_level;  // it has changed
    // Changes are missing, or are too old: the kernel has dropped some, or the loop hung. on_level
    // follows with what is known now.
    std::function<void()> on_gap;
    std::function<void(const std::string& why)> on_lost;  // the chip is gone
  };
  // An output begins inactive. Fails with a sentence, and what to do. The loop outlives the line.
  using Open = std::function<Result<std::unique_ptr<GpioLine>>(transport::EventLoop&,
                                                               const GpioSpec&, Direction, Events)>;

  // Releases the line. An output is made inactive before.
  virtual ~GpioLine() = default;

  // Whether it is active now. Fails when the chip is gone.
  virtual Result<bool> IsActive() = 0;

  // Of an output.
  virtual Result<> Set(bool active) = 0;
};

}  // namespace musher::device
