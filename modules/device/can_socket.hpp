#pragma once
// A CAN bus by SocketCAN of Linux: a network interface such as "can0", or "vcan0" without hardware.
// Frames of CAN 2.0; the bit rate is set by the system (`ip link set can0 type can bitrate …`).
//
// Threads: the loop's. On a simulated loop, which has no sockets, nothing is received.

#include <string>

#include "musher/base/unique_fd.hpp"
#include "musher/modules/device/can_frame.hpp"

namespace musher::device {

class CanSocket : public CanBus {
 public:
  // Fails with NetError and what to type where this computer has no such interface, or it is
  // down.
  static Result<std::unique_ptr<CanBus>> Open(transport::EventLoop& loop,
                                              const std::string& network_interface, Events events);

  // The same of a socket that has frames as the kernel writes them, one in each message.
  CanSocket(transport::EventLoop& loop, std::string network_interface, UniqueFd fd, Events events);

  Result<> Send(const CanFrame& frame) override;
  void Filter(const std::vector<CanId>& ids) override;

 private:
  void Receive();
  void Lose(int error);

  const std::string name_;
  const Events events_;
  UniqueFd fd_;
  transport::LoopHandlePtr readable_;  // last: its callback uses the rest
};

}  // namespace musher::device
