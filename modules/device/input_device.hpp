#pragma once
// Keys of an input device of Linux (evdev): a file below /dev/input, or the device of a name. A
// device that is not there, is unplugged or lacks one of the keys is opened again once in a second.
//
// Threads: the loop's.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "musher/base/unique_fd.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::device {

// Either of both.
struct InputSource {
  std::string file;  // "/dev/input/event0"
  std::string name;  // as the kernel has it, in /proc/bus/input/devices

  friend bool operator==(const InputSource&, const InputSource&) = default;
};

class InputDevice {
 public:
  static constexpr Duration kReopen = std::chrono::seconds(1);
  static constexpr Duration kLate =
      Milliseconds(100);  // an event that has waited longer is missing

  // All run on the loop, and in the constructor.
  struct Events {
    std::function<void(std::uint16_t code, bool pressed)> on_key;
    // Events are missing: the device is lost, or the kernel has dropped some. on_key follows with
    // what is known of each key; those of a lost device are released.
    std::function<void()> on_gap;
    std::function<void(const std::string&)> log;
    // The device is opened, for the first time or again. on_key follows with the state of each key;
    // that of a pipe is not known: released.
    std::function<void()> on_open = [] {};
  };

  // Reads the keys `codes` (linux/input-event-codes.h). It opens the device at once. The loop
  // outlives it.
  InputDevice(transport::EventLoop& loop, InputSource source, std::vector<std::uint16_t> codes,
              Events events);

  // Why it cannot be read; "": it can.
  const std::string& fault() const { return fault_; }

 private:
  void Open();
  void Read();
  // What the kernel knows, after it has dropped events or while a key is pressed already.
  void Ask();
  void Lose(const std::string& why);
  const std::string& name() const { return source_.file.empty() ? source_.name : source_.file; }

  transport::EventLoop& loop_;
  const InputSource source_;
  const std::vector<std::uint16_t> codes_;
  const Events events_;
  std::string fault_;  // as logged: once, until it is another one
  UniqueFd fd_;
  transport::LoopHandlePtr reopen_;
  transport::LoopHandlePtr readable_;  // last: its callback uses the rest
};

}  // namespace musher::device
