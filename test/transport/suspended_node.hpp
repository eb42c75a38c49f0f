#pragma once
// A simulated node whose computer the test suspends.

#include <memory>
#include <utility>

#include "musher/test/transport/wrapped_node.hpp"

namespace musher::testing {

// Its time and its timers stand meanwhile, so nothing else happens. `each_look`: it was suspended
// for so long whenever its loop is asked.
class SuspendedLoop : public WrappedLoop {
 public:
  using WrappedLoop::WrappedLoop;

  Duration TimeSuspended() const override { return suspended += each_look; }

  mutable Duration suspended{};
  Duration each_look{};
};

class SuspendedNode : public WrappedNode {
 public:
  explicit SuspendedNode(std::unique_ptr<transport::Node> node)
      : WrappedNode(std::move(node)), loop_(simulated().loop()) {}

  SuspendedLoop& loop() override { return loop_; }

 private:
  SuspendedLoop loop_;
};

}  // namespace musher::testing
