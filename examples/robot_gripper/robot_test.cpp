// [robot]
// Tests the gripper in the whole robot: the world, motion and all other modules, over DDS.

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <future>
#include <memory>
#include <string>

#include "musher/controller/machine_controller.hpp"
#include "musher/cyberdog/extension.hpp"
#include "musher/messages/std_srvs/set_bool.hpp"
#include "musher/transport/service.hpp"

using musher::msg::SetBool;

class Robot : public testing::Test {
 protected:
  // A DDS domain of its own: another robot may run on this computer.
  Robot() {
    setenv("ROS_DOMAIN_ID", std::to_string(215 + getpid() % 8).c_str(), 1);
    node_ = musher::transport::NodeThread::Start().value();
  }
  void SetUp() override {
    ASSERT_TRUE(robot_.Init("robot.toml", node_));
    ASSERT_TRUE(robot_.AwaitSetUp());
    node_->RunOnLoop([&] {
      gripper_ = musher::transport::MakeClient<SetBool>(node_->node(), "gripper/close").value();
    });
  }
  ~Robot() override {
    node_->RunOnLoop([&] { gripper_.reset(); });
    robot_.Switch("TearDown");
  }
  void Go(const musher::State& state) {
    const musher::SwitchResult result = robot_.Switch(state);
    ASSERT_EQ(robot_.StateOf("gripper"), state) << result.reason;
  }
  SetBool::Response Close(bool close) {
    std::promise<SetBool::Response> promise;
    node_->RunOnLoop([&] {
      gripper_->Call({close}, std::chrono::seconds(10), [&](const auto& answer) {
        promise.set_value(answer ? answer.value()
                                 : SetBool::Response{false, answer.error().message});
      });
    });
    return promise.get_future().get();
  }

  std::shared_ptr<musher::transport::NodeThread> node_;
  std::unique_ptr<musher::transport::Client<SetBool>> gripper_;
  musher::MachineController robot_{{musher::cyberdog::Extension()}};
};
// [robot end]

// [tests]
TEST_F(Robot, GripsInActiveAndReleasesInProtected) {
  ASSERT_NO_FATAL_FAILURE(Go("SelfCheck"));
  ASSERT_NO_FATAL_FAILURE(Go("Active"));
  EXPECT_TRUE(Close(true).success);
  ASSERT_NO_FATAL_FAILURE(Go("Protected"));
  const SetBool::Response refused = Close(true);
  EXPECT_FALSE(refused.success);
  EXPECT_NE(refused.message.find("6113"), std::string::npos) << refused.message;
}
// [tests end]
