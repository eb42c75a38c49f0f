#pragma once
// One key of an input device of Linux (evdev), such as the power key of a computer: a file below
// /dev/input. A device that is not there, is unplugged or has no such key is opened again once in a
// second.
//
// Threads: the loop's.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "musher/base/result.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::device {

inline constexpr std::uint16_t kPowerKeyCode = 116;  // KEY_POWER of linux/input-event-codes.h

class InputKey {
 public:
  static constexpr Duration kReopen = std::chrono::seconds(1);

  using OnKey = std::function<void(bool pressed)>;
  using Log = std::function<void(const std::string&)>;

  // Calls `on_key` on the loop when the key is pressed or released, and with false when the device
  // is lost. It opens the device at once. The loop outlives it.
  InputKey(transport::EventLoop& loop, std::string device, std::uint16_t code, OnKey on_key,
           Log log);

 private:
  void Open();
  void Read();
  // What the kernel knows, after it has dropped events or while the key is pressed already.
  void Ask();
  void Lose(const std::string& why);

  transport::EventLoop& loop_;
  const std::string device_;
  const std::uint16_t code_;
  const OnKey on_key_;
  const Log log_;
  std::string fault_;  // as logged: once, until it is another one
  UniqueFd fd_;
  transport::LoopHandlePtr reopen_;
  transport::LoopHandlePtr readable_;  // last: its callback uses the rest
};

}  // namespace musher::device
