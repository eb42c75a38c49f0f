#pragma once
// A node of a simulated network whose loop reads sockets, too: once in a millisecond of virtual
// time. What another node of the same thread has sent by the loopback is there by then. How long it
// has waited is not known: that is the time of this computer, which may run something else
// meanwhile.

#include <poll.h>
#include <sys/socket.h>

#include <functional>
#include <memory>
#include <utility>

#include "musher/test/transport/wrapped_node.hpp"

namespace musher::transport {

class SocketLoop : public musher::testing::WrappedLoop {
 public:
  using WrappedLoop::WrappedLoop;

  LoopHandlePtr WhenReadable(int fd, std::function<void()> callback) override {
    const int off = 0;  // fails for what is no socket
    static_cast<void>(setsockopt(fd, SOL_SOCKET, SO_TIMESTAMPNS, &off, sizeof off));
    return Every(Milliseconds(1), [fd, callback = std::move(callback)] {
      pollfd readable{fd, POLLIN, 0};
      if (poll(&readable, 1, 0) > 0) callback();
    });
  }
};

class SocketNode : public musher::testing::WrappedNode {
 public:
  explicit SocketNode(std::unique_ptr<Node> node)
      : WrappedNode(std::move(node)), loop_(simulated().loop()) {}

  EventLoop& loop() override { return loop_; }

 private:
  SocketLoop loop_;
};

}  // namespace musher::transport
