#pragma once
// A contact on a GPIO line: a touch pad, a key, a bumper. A line that cannot be read - no such
// line, no permission, in use, its chip is gone - is opened again once in a second. While it can
// be, it is read once in a second, besides: a chip may be lost, or a change, without an event.
//
// Threads: the loop's.

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "musher/modules/device/gpio_line.hpp"

namespace musher::device {

class GpioInput {
 public:
  static constexpr Duration kReopen = std::chrono::seconds(1);
  static constexpr Duration kLook = std::chrono::seconds(1);

  // All run on the loop, and in the constructor.
  struct Events {
    // It is known for the first time, has changed, or is known again after a gap.
    std::function<void(bool active)> on_level;
    std::function<void()> on_gap;   // changes are missing
    std::function<void()> on_lost;  // nothing is known; after on_gap
    std::function<void(const std::string&)> log;
  };

  // Opens the line at once. The loop outlives it.
  GpioInput(transport::EventLoop& loop, const GpioLine::Open& open, GpioSpec spec, Events events);

  // Why it cannot be read; "": it can.
  const std::string& fault() const { return fault_; }

 private:
  void Open();
  void Look();
  void Report(bool active);
  void Miss();
  void Lose(const std::string& why);

  transport::EventLoop& loop_;
  const GpioLine::Open open_;
  const GpioSpec spec_;
  const Events events_;
  std::string fault_;               // as logged: once, until it is another one
  std::optional<bool> level_;       // as reported since the last gap
  bool known_ = false;              // whether a level was reported since it was opened
  transport::LoopHandlePtr next_;   // opens it again, or looks at it
  std::unique_ptr<GpioLine> line_;  // last: its callbacks use the rest
};

}  // namespace musher::device
