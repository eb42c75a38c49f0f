// A ROS 2 node with a checkpoint in a machine with an actuator of each protocol.

#include <set>

#include "musher/test/protocols/mixed_robot.hpp"

namespace musher::testing::mixed_robot_health_test {

// Integration tests cover detection with real processes; here it is the decision code and monitor.
class AMixedRobotWithACheckpoint : public AMixedRobot {
 protected:
  static MachineConfig Checked(Duration checkpoint) {
    MachineConfig config = Config(false);
    config.actuators[2].checkpoint = checkpoint;
    config.actuators[2].restart.policy = RestartPolicy::kOnFailure;
    return config;
  }
  explicit AMixedRobotWithACheckpoint(Duration checkpoint = Milliseconds(400))
      : AMixedRobot(Checked(checkpoint)) {
    robot_.on_record = [this](const action::Record& record) { events_.insert(record.event); };
  }

  std::set<EventName> events_;  // of the records so far
};

class AMixedRobotWithAShortCheckpoint : public AMixedRobotWithACheckpoint {
 protected:
  AMixedRobotWithAShortCheckpoint() : AMixedRobotWithACheckpoint(Milliseconds(60)) {}
};

TEST_F(AMixedRobotWithAShortCheckpoint, DoesNotTakeALongTransitionForAHang) {
  BringUp();
  for (const char* callback : {"deactivate", "activate"}) {
    ros_->script[callback].takes = Milliseconds(95);  // its time is 100 ms
  }
  for (const BuiltInState state : {kLowPower, kActive}) {
    Set(state);
    robot_.RunFor(std::chrono::seconds(2));
    ExpectAllIn(state);
  }
  EXPECT_FALSE(events_.contains(EventName::kActuatorHung));
}

TEST_F(AMixedRobotWithACheckpoint, DetectsAFrozenNodeWithinItAndRestartsIt) {
  BringUp();
  const std::int32_t before = Pids()[2];
  ros_->frozen = true;
  ASSERT_TRUE(robot_.RunUntil([&] { return robot_.machine().actuators[2].health == Health::kHung; },
                              Milliseconds(450)));
  EXPECT_TRUE(events_.contains(EventName::kActuatorHung));
  robot_.RunFor(std::chrono::seconds(15));  // past the lease of the dead process
  ExpectAllIn("Active");
  EXPECT_NE(Pids()[2], before);
}

TEST_F(AMixedRobotWithACheckpoint, DoesNotTakeALongTransitionForAHang) {
  BringUp();
  ros_->script["deactivate"].takes = Milliseconds(450);
  ros_->script["activate"].takes = Milliseconds(450);
  Set("LowPower");
  robot_.RunFor(std::chrono::seconds(2));
  ExpectAllIn("LowPower");
  EXPECT_FALSE(events_.contains(EventName::kActuatorHung));
}

TEST_F(AMixedRobotWithACheckpoint, RestartsANodeThatHangsInATransitionLongAfterItsDeadline) {
  BringUp();
  ros_->script["deactivate"].takes = std::chrono::hours(1);
  EXPECT_EQ(Set("LowPower").outcome, SwitchOutcome::kDoneDegraded);
  robot_.RunFor(std::chrono::seconds(20));
  ExpectAllIn("LowPower");
}

// A critical node of another host, which a launch file there has started, with the checkpoint that
// such a node has by default: the process of another host has no exit that is seen, and the lease
// of a ROS 2 process is 10 s.
class AMixedRobotWithANodeOfAnotherHost : public AMixedRobot {
 protected:
  AMixedRobotWithANodeOfAnotherHost() : AMixedRobot(Far()) {
    robot_.network().SetLease(std::chrono::seconds(60));  // no other sign of its loss
  }
  static MachineConfig Far() {
    MachineConfig config = Config(false);
    ActuatorConfig& planner = config.actuators[2];
    planner.command.clear();
    planner.restart.policy = RestartPolicy::kNo;
    planner.critical = true;
    planner.on_lost = kProtected;
    planner.checkpoint = std::chrono::seconds(5);
    return config;
  }

  std::unique_ptr<transport::Node> pc_ = robot_.network().MakeNode("pc");
  RosManagedNode planner_{*pc_, "c"};
};

TEST_F(AMixedRobotWithANodeOfAnotherHost, KnowsWithinItsCheckpointThatTheHostIsOff) {
  BringUp();
  robot_.RunFor(std::chrono::seconds(20));
  ExpectAllIn("Active");
  const Time off = robot_.network().now();
  robot_.network().Crash(*pc_);
  ASSERT_TRUE(robot_.RunUntil([&] { return robot_.machine().state == "Protected"; },
                              std::chrono::seconds(10)));
  EXPECT_LE(robot_.network().now() - off, Milliseconds(5100));
  EXPECT_THAT(robot_.Degraded(), ::testing::ElementsAre("c"));
}

}  // namespace musher::testing::mixed_robot_health_test
