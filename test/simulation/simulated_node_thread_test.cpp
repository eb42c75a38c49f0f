// A simulated node refuses what would wait for ever on a robot.

#include "musher/simulation/simulated_node_thread.hpp"

#include <gtest/gtest.h>

namespace musher::simulation::simulated_node_thread_test {

class SimulatedNodeThreads : public ::testing::Test {
 protected:
  // `call` is made by a timer of the node.
  void OnTheLoop(const std::function<void()>& call) {
    node_.RunOnLoop([&] { timer_ = node_.loop().At(node_.loop().Now(), call); });
    node_.WaitFor(Milliseconds(1));
  }

  transport::sim::Network network_{1};
  SimulatedNodeThread node_{network_, "robot"};
  transport::LoopHandlePtr timer_;
};

TEST_F(SimulatedNodeThreads, RunWorkAndLetTimePassForACallback) {
  bool ran = false;
  OnTheLoop([&] { ran = true; });
  EXPECT_TRUE(ran);
}

using SimulatedNodeThreadsDeathTest = SimulatedNodeThreads;

TEST_F(SimulatedNodeThreadsDeathTest, EndTheProgramWhenAHandlerWaitsForItsOwnLoop) {
  EXPECT_DEATH(OnTheLoop([&] { node_.RunOnLoop([] {}); }), "called on the loop itself");
  EXPECT_DEATH(OnTheLoop([&] { node_.WaitFor(Milliseconds(1)); }), "called on the loop itself");
}

}  // namespace musher::simulation::simulated_node_thread_test
