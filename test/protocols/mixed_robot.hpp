#pragma once
// A whole machine in virtual time with one actuator of each protocol: "a" is Musher's own, "b" a
// CyberDog module, "c" a ROS 2 managed node.

#include <gmock/gmock.h>

#include "musher/simulation/robot.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"
#include "musher/test/protocols/cyberdog_module.hpp"
#include "musher/test/protocols/ros_managed_node.hpp"

namespace musher::testing {

class AMixedRobot : public ::testing::Test {
 protected:
  explicit AMixedRobot(bool critical = false) : AMixedRobot(Config(critical)) {}
  explicit AMixedRobot(const MachineConfig& config) : robot_(1, config) {
    robot_.UseProgram("b", [this](transport::Node& node) {
      auto module = std::make_shared<CyberdogModule>(node, "", "b", "b");
      module->script = module_script_;
      module_ = module.get();
      return module;
    });
    robot_.UseProgram("c", [this](transport::Node& node) {
      auto ros = std::make_shared<RosManagedNode>(node, "c");
      ros->script = node_script_;
      ros_ = ros.get();
      return ros;
    });
  }

  static MachineConfig Config(bool critical) {
    MachineConfig config = MachineOf(3);
    for (ActuatorConfig& actuator : config.actuators) actuator.command = {"run", actuator.name};
    config.actuators[1].protocol = Protocol::kCyberdog;
    config.actuators[1].heartbeat_name = "b";
    config.actuators[1].critical = critical;
    config.actuators[2].protocol = Protocol::kRos2Lifecycle;
    return config;
  }

  void BringUp() {
    robot_.StartController();
    ASSERT_TRUE(robot_.RunUntil([&] { return robot_.machine().phase == Phase::kRunning; }));
    ASSERT_EQ(robot_.machine().state, "Active");
    ASSERT_THAT(robot_.Degraded(), ::testing::IsEmpty());
    robot_.RunFor(std::chrono::seconds(1));  // the first heartbeats
  }
  std::vector<std::int32_t> Pids() {
    std::vector<std::int32_t> pids;
    for (const char* name : {"a", "b", "c"}) pids.push_back(robot_.processes().PidOf(name));
    return pids;
  }
  SwitchResult Set(const State& target) { return robot_.Set(target).value_or(SwitchResult{}); }
  void ExpectAllIn(const State& state) {
    EXPECT_EQ(robot_.machine().state, state);
    for (const KnownActuator& known : robot_.machine().actuators) {
      EXPECT_EQ(known.state(), state);
      EXPECT_EQ(known.presence, Presence::kPresent);
    }
    EXPECT_THAT(robot_.Degraded(), ::testing::IsEmpty());
  }

  struct Robot : simulation::SimRobot {
    using SimRobot::SimRobot;
    std::vector<std::string> Degraded() const { return musher::Degraded(config(), machine()); }
  };

  std::map<std::string, CyberdogModule::Callback> module_script_;
  std::map<std::string, RosManagedNode::Callback> node_script_;
  CyberdogModule* module_ = nullptr;
  RosManagedNode* ros_ = nullptr;
  Robot robot_;
};

}  // namespace musher::testing
