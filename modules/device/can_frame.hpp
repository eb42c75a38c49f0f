#pragma once
// A data frame of a CAN bus (CAN 2.0), and how it travels. Plain values, no IO.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::device {

inline constexpr std::size_t kCanBytes = 8;  // of one frame at most

// An id of 11 bits and one of 29 bits with the same number are two ids.
struct CanId {
  std::uint32_t number = 0;
  bool extended = false;  // 29 bits

  friend bool operator==(const CanId&, const CanId&) = default;
  friend bool operator<(const CanId& a, const CanId& b) {
    return std::pair(a.extended, a.number) < std::pair(b.extended, b.number);
  }
};
std::string ToText(const CanId& id);  // "0x00834100", "0x1F2"

struct CanFrame {
  CanId id;
  std::uint8_t size = 0;  // bytes of `data` that were sent
  std::array<std::uint8_t, kCanBytes> data{};
  bool remote = false;  // a request for a frame, without data

  friend bool operator==(const CanFrame&, const CanFrame&) = default;
};

// A bus to which this computer is connected. Threads: the loop's.
class CanBus {
 public:
  // All run on the loop.
  struct Events {
    std::function<void(const CanFrame&)> on_frame;
    // The bus carries no frames, and why.
    std::function<void(const std::string& why)> on_fault;
    // It does again; a frame shows that, too.
    std::function<void()> on_recovered;
    // The interface is gone or down: this object receives nothing more. Open another one; this one
    // must not be destroyed in the call.
    std::function<void(const std::string& why)> on_lost;
  };
  using Open = std::function<Result<std::unique_ptr<CanBus>>(
      transport::EventLoop& loop, const std::string& network_interface, Events events)>;

  virtual ~CanBus() = default;

  // Hands it to the kernel, and returns at once: nothing shows that another device has received it.
  virtual Result<> Send(const CanFrame& frame) = 0;

  // Only frames of these ids are received from now on; empty: all.
  virtual void Filter(const std::vector<CanId>& ids) = 0;
};

}  // namespace musher::device
