#pragma once
// A node of a simulated network whose loop reads sockets, too: once in a millisecond of virtual
// time. What another node of the same thread has sent by the loopback is there by then.

#include <poll.h>

#include <functional>
#include <memory>
#include <utility>

#include "musher/test/transport/wrapped_node.hpp"

namespace musher::transport {

class SocketLoop : public musher::testing::WrappedLoop {
 public:
  using WrappedLoop::WrappedLoop;

  LoopHandlePtr WhenReadable(int fd, std::function<void()> callback) override {
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
