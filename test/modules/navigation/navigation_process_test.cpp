// musher-planner and musher-controller as a controller and the robot's other programs use them: the
// real programs over DDS.

#include <csignal>
#include <memory>
#include <string>
#include <vector>

#include "musher/test/modules/module_process.hpp"
#include "musher/test/modules/navigation/simulated_robot.hpp"
#include "musher/test/navigation/maps.hpp"
#include "musher/transport/action.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::navigation::navigation_process_test {

using ::testing::AllOf;
using testing::At;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using transport::GoalEnd;

constexpr const char* kPlannerFile =
    "self_check_ms = 15000\nstale_ms = 5000\n[[robot]]\nname = \"jetbot_0\"\n";
// A drive does not end because a busy computer lets the robot's odometry wait.
constexpr const char* kControllerFile = R"(
self_check_ms = 15000
odometry_stale_ms = 5000
scan_stale_ms = 5000
[[robot]]
name = "jetbot_0"
)";

class NavigationProcess : public test::ModuleProcess {
 protected:
  NavigationProcess(const std::string& actuator, const std::string& program,
                    const std::string& file)
      : ModuleProcess(actuator, program), file_(file) {}

  void StartActive() {
    PublishMap();
    Start(file_);
    ExpectDone("SelfCheck");
    ExpectDone("Active");
  }
  void PublishMap() {
    map_ = Publisher<msg::OccupancyGrid>("map", transport::kLatchedQos);
    EXPECT_TRUE(map_->Publish(testing::GridOf(walls_.map())));
  }

  const std::string file_;
  Clearance walls_{testing::Drawn({"##########", "#........#", "#........#", "##########"}, 1, 10)};
  testing::SimulatedRobot robot_{peer_.node(), walls_, {"jetbot_0", {{2, 2, 0}, 0}}};
  std::unique_ptr<transport::Publisher<msg::OccupancyGrid>> map_;
};

class PlannerProcess : public NavigationProcess {
 protected:
  PlannerProcess() : NavigationProcess("planner_server", "musher-planner", kPlannerFile) {}
};

class ControllerProcess : public NavigationProcess {
 protected:
  ControllerProcess()
      : NavigationProcess("controller_server", "musher-controller", kControllerFile) {}

  // Drives ahead; the end comes to `end_`.
  void Drive() {
    if (!client_) {
      client_ = transport::MakeActionClient<msg::FollowPath>(peer_.node(), "jetbot_0/follow_path")
                    .value();
    }
    msg::FollowPath::Goal goal;
    const Pose& pose = robot_.pose();
    const double to_m = pose.at.x_m < 5 ? 8 : 2;
    goal.path.poses = {At(pose.at.x_m, pose.at.y_m), At(to_m, 2)};
    end_.reset();
    transport::GoalEvents<msg::FollowPath> events;
    events.on_end = [this](const auto& outcome) { end_ = outcome.end; };
    client_->SendGoal(goal, Milliseconds(120'000), std::move(events));
  }
  bool AwaitMotion() {
    return peer_.Until([&] { return robot_.speed_m_s() > 0.2; });
  }
  bool AwaitStand() {
    return peer_.Until([&] { return robot_.last_command() == msg::Twist{} && end_.has_value(); });
  }

  std::optional<GoalEnd> end_;
  std::unique_ptr<transport::ActionClient<msg::FollowPath>> client_;
};

TEST_F(PlannerProcess, PlansInActive) {
  StartActive();
  const auto client = transport::MakeActionClient<msg::ComputePathToPose>(
                          peer_.node(), "jetbot_0/compute_path_to_pose")
                          .value();
  std::optional<transport::GoalOutcome<msg::ComputePathToPose>> outcome;
  transport::GoalEvents<msg::ComputePathToPose> events;
  events.on_end = [&](const auto& end) { outcome = end; };
  client->SendGoal({.goal = At(8, 2)}, Milliseconds(120'000), std::move(events));
  ASSERT_TRUE(peer_.Until([&] { return outcome.has_value(); })) << peer_.Output();
  EXPECT_EQ(outcome->end, GoalEnd::kSucceeded) << outcome->reason << peer_.Output();
  EXPECT_GE(outcome->result.path.poses.size(), 2U);
  ExpectTornDown();
  EXPECT_THAT(peer_.Output(), HasSubstr("jetbot_0: a path of 6.00 m to (8.00, 2.00, 0.00)"));
}

TEST_F(PlannerProcess, FailsItsSelfCheckWithoutAMap) {
  Start("self_check_ms = 100\n[[robot]]\nname = \"jetbot_0\"\n");
  EXPECT_THAT(Failure(kSelfCheck),
              AllOf(StartsWith("5309 "), HasSubstr("jetbot_0: no map on map")));
}

TEST_F(ControllerProcess, DrivesInActiveAndStandsInTheOtherStates) {
  PublishMap();
  Start(file_);
  ExpectDone("SelfCheck");
  for (const BuiltInState state : {kDeActive, kProtected, kLowPower, kOta, kError}) {
    ExpectDone("Active");
    Drive();
    ASSERT_TRUE(AwaitMotion()) << state << peer_.Output();
    ExpectDone(state);
    EXPECT_TRUE(AwaitStand()) << state;
    EXPECT_EQ(end_, GoalEnd::kAborted) << state;
  }
  EXPECT_THAT(peer_.Output(), HasSubstr("jetbot_0: the drive has ended: it is in LowPower"));
}

// A SelfCheck in the run phase leaves the state as it is; it ended the drive, and every goal was
// rejected until Active was set again.
TEST_F(ControllerProcess, ASelfCheckOfAnActiveServerLeavesItsDriveAlone) {
  StartActive();
  Drive();
  ASSERT_TRUE(AwaitMotion()) << peer_.Output();
  ExpectDone("SelfCheck");
  ASSERT_TRUE(peer_.Until([&] { return end_.has_value(); })) << peer_.Output();
  EXPECT_EQ(end_, GoalEnd::kSucceeded) << peer_.Output();
  Drive();
  EXPECT_TRUE(AwaitMotion()) << "a goal after the check" << peer_.Output();
}

TEST_F(ControllerProcess, ThatIsKilledInADriveStandsUntilTheNextGoal) {
  StartActive();
  Drive();
  ASSERT_TRUE(AwaitMotion()) << peer_.Output();
  // So that the status of its successor is known from its own.
  ASSERT_TRUE(peer_.AwaitStatus([](const auto& report) { return report.state == "Active"; }));
  peer_.Signal(SIGKILL);
  ASSERT_EQ(peer_.AwaitExit(), -SIGKILL);
  ASSERT_TRUE(peer_.Until([&] { return end_.has_value() && robot_.speed_m_s() == 0; }));
  const int commands = robot_.commands();
  StartActive();
  int looks = 0;
  const auto look = peer_.node().loop().Every(Milliseconds(50), [&looks] { ++looks; });
  ASSERT_TRUE(peer_.Until([&looks] { return looks == 20; }));
  EXPECT_EQ(robot_.commands(), commands) << "the client has not sent another goal";
  Drive();
  EXPECT_TRUE(AwaitMotion()) << peer_.Output();
}

TEST_F(ControllerProcess, SendsAZeroVelocityWhenItIsTerminated) {
  StartActive();
  Drive();
  ASSERT_TRUE(AwaitMotion()) << peer_.Output();
  peer_.Signal(SIGTERM);
  EXPECT_TRUE(peer_.Until([&] { return robot_.zeros() == 1; })) << "a robot that gets nothing "
                                                                   "stops later, without a zero";
  EXPECT_EQ(peer_.AwaitExit(), -SIGTERM) << peer_.Output();
}

TEST_F(ControllerProcess, StandsAtAnEmergencyStop) {
  StartActive();
  Drive();
  ASSERT_TRUE(AwaitMotion()) << peer_.Output();
  const auto stop =
      Publisher<msg::EmergencyStop>(transport::EmergencyStopTopic(""), transport::kLatchedQos);
  msg::EmergencyStop engaged;
  engaged.id = 1;
  engaged.engaged = true;
  ASSERT_TRUE(stop->Publish(engaged));
  EXPECT_TRUE(AwaitStand());
  EXPECT_EQ(robot_.zeros(), 1);
  EXPECT_TRUE(AwaitOutput("the drive has ended: an emergency stop holds it")) << peer_.Output();
}

TEST_F(ControllerProcess, FailsItsSelfCheckWithoutOdometry) {
  robot_.odometry_silent = true;
  Start("self_check_ms = 100\n[[robot]]\nname = \"jetbot_0\"\n");
  EXPECT_THAT(Failure(kSelfCheck),
              AllOf(StartsWith("5309 "), HasSubstr("jetbot_0: no odometry on jetbot_0/odom yet")));
}

TEST_F(ControllerProcess, IsDegradedWithoutOneOfItsRobots) {
  PublishMap();
  std::string file = kControllerFile;
  file.replace(file.find("15000"), 5, "5000");
  Start(file + "[[robot]]\nname = \"g1_0\"\n");
  ExpectDone("SelfCheck");
  EXPECT_TRUE(peer_.AwaitStatus([](const ActuatorReport& report) {
    return report.degraded_reason == "g1_0: no odometry on g1_0/odom yet";
  })) << peer_.report().degraded_reason;
  ExpectDone("Active");
  Drive();
  EXPECT_TRUE(AwaitMotion()) << peer_.Output();
}

}  // namespace musher::navigation::navigation_process_test
