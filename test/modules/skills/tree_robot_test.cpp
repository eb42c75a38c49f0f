// Trees of the shape of nav2's own, on a robot that moves in simulated time.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/behavior/tree/nav2/nodes.hpp"
#include "musher/modules/skills/nav2/tree_robot.hpp"
#include "musher/test/behavior/tree/trees.hpp"
#include "musher/test/modules/skills/moving_robot.hpp"

namespace musher::tree_robot_test {

using ::testing::HasSubstr;
using tree::nav2::Pose;

class ANav2Tree : public ::testing::Test {
 protected:
  ANav2Tree() { tree::nav2::AddNodes(factory, nav2); }

  void Make(const std::string& content) {
    tree = tree::MakeTree(tree::Main(content), factory);
    ASSERT_TRUE(tree);
  }
  // Ten ticks a second, until the tree has ended or for so long.
  char Run(double seconds) {
    char letter = 'R';
    for (int i = 0; i < static_cast<int>(std::lround(10 * seconds)) && letter == 'R'; ++i) {
      robot.Advance(Milliseconds(100));
      const auto result = tree->TickOnce(robot.Now());
      EXPECT_TRUE(result) << result.error().message;
      letter = tree::Letter(result);
    }
    return letter;
  }
  template <class T>
  T Entry(const std::string& key) {
    const Result<T> value = tree->board().Get<T>(key);
    EXPECT_TRUE(value) << value.error().message;
    return value ? value.value() : T{};
  }

  skills::testing::MovingRobot robot;
  skills::TreeRobot nav2{robot};
  tree::Factory factory;
  std::unique_ptr<tree::Tree> tree;
};

const std::string kNavigation =
    "<RecoveryNode number_of_retries=\"6\"><PipelineSequence>"
    "<ControllerSelector selected_controller=\"{c}\" default_controller=\"FollowPath\"/>"
    "<RateController hz=\"1\"><RecoveryNode number_of_retries=\"1\">"
    "<ComputePathToPose goal=\"{goal}\" path=\"{path}\" error_code_id=\"{plan_code}\" "
    "error_msg=\"{why}\"/>"
    "<ClearEntireCostmap service_name=\"global\"/></RecoveryNode></RateController>"
    "<RecoveryNode number_of_retries=\"1\">"
    "<FollowPath path=\"{path}\" controller_id=\"{c}\" error_code_id=\"{follow_code}\"/>"
    "<ClearEntireCostmap service_name=\"local\"/></RecoveryNode></PipelineSequence>"
    "<ReactiveFallback><GoalUpdated/><RoundRobin>"
    "<ClearEntireCostmap service_name=\"local\"/>"
    "<Spin spin_dist=\"1.57\"/><Wait wait_duration=\"5\"/>"
    "<BackUp backup_dist=\"0.3\" backup_speed=\"0.05\"/>"
    "</RoundRobin></ReactiveFallback></RecoveryNode>";

TEST_F(ANav2Tree, DrivesTheRobotToItsGoalAndPlansOnceASecond) {
  Make(kNavigation);
  ASSERT_TRUE(tree->board().Set("goal", Pose{.x_m = 6, .yaw_rad = 1}));
  EXPECT_EQ(Run(30), 'S');
  EXPECT_NEAR(robot.at.at.x_m, 6, 0.01);
  EXPECT_NEAR(robot.at.yaw_rad, 1, 0.01);
  EXPECT_GE(robot.plans, 4);
  EXPECT_LE(robot.plans, 7);
  EXPECT_LT(robot.travelled_m, 6.1) << "a new path does not lead back to where it was planned";
  EXPECT_EQ(Entry<int>("plan_code"), 0);
}
TEST_F(ANav2Tree, GoesToANewerGoalWithoutAStop) {
  Make(kNavigation);
  ASSERT_TRUE(tree->board().Set("goal", Pose{.x_m = 6}));
  EXPECT_EQ(Run(3), 'R');
  ASSERT_TRUE(tree->board().Set("goal", Pose{.x_m = 6, .y_m = 2}));
  EXPECT_EQ(Run(30), 'S');
  EXPECT_NEAR(robot.at.at.y_m, 2, 0.01);
}
TEST_F(ANav2Tree, RecoversFromAnObstacleUntilItIsGone) {
  bool blocked = true;
  robot.blocked = [&blocked](const navigation::Point& point) { return blocked && point.x_m > 3; };
  Make(kNavigation);
  ASSERT_TRUE(tree->board().Set("goal", Pose{.x_m = 6}));
  EXPECT_EQ(Run(12), 'R');
  EXPECT_EQ(Entry<int>("follow_code"), 104);
  EXPECT_GE(robot.cleared, 2);
  blocked = false;
  EXPECT_EQ(Run(60), 'S');
  EXPECT_NEAR(robot.at.at.x_m, 6, 0.01);
}
TEST_F(ANav2Tree, FailsWithTheCodeOfThePlannerWhereNoRecoveryHelps) {
  robot.plan = [](const auto&, const auto&) -> Result<navigation::Path> {
    return navigation::MakeError(navigation::Fault::kWalledIn, "it is walled in");
  };
  Make(kNavigation);
  ASSERT_TRUE(tree->board().Set("goal", Pose{.x_m = 6}));
  EXPECT_EQ(Run(120), 'F');
  EXPECT_EQ(Entry<int>("plan_code"), 208);
  EXPECT_EQ(Entry<std::string>("why"), "it is walled in");
}
TEST_F(ANav2Tree, SpinsAndMovesByTheAmountsOfItsPorts) {
  Make(
      "<Sequence><Spin spin_dist=\"-1.57\"/>"
      "<DriveOnHeading dist_to_travel=\"0.5\" speed=\"0.1\" time_allowance=\"20\"/></Sequence>");
  EXPECT_EQ(Run(40), 'S');
  EXPECT_NEAR(robot.at.yaw_rad, -1.57, 0.15);
  EXPECT_NEAR(robot.at.at.y_m, -0.5, 0.1);
  Make("<BackUp backup_dist=\"0.5\" backup_speed=\"0.1\"/>");
  EXPECT_EQ(Run(20), 'S');
  EXPECT_NEAR(robot.at.at.y_m, 0, 0.15);
}
TEST_F(ANav2Tree, DoesNotMoveToWhereNoScanSees) {
  robot.scan_covers_rad = 1;
  Make("<BackUp error_msg=\"{why}\"/>");
  EXPECT_EQ(Run(20), 'F');
  EXPECT_THAT(Entry<std::string>("why"), HasSubstr("no scan covers what is behind it"));
  EXPECT_EQ(robot.travelled_m, 0);
}
TEST_F(ANav2Tree, FailsAMotionAtItsTimeLimitAndStands) {
  Make("<Spin spin_dist=\"50\" time_allowance=\"2\"/>");
  EXPECT_EQ(Run(20), 'F');
  for (int i = 0; i < 10; ++i) robot.Advance(Milliseconds(100));
  EXPECT_TRUE(robot.Rests());
}
TEST_F(ANav2Tree, StandsWhenItIsHaltedInAMotionOrInADrive) {
  Make("<Spin spin_dist=\"50\" time_allowance=\"90\"/>");
  EXPECT_EQ(Run(2), 'R');
  EXPECT_FALSE(robot.Rests());
  ASSERT_TRUE(tree->Halt(robot.Now()));
  for (int i = 0; i < 20; ++i) robot.Advance(Milliseconds(100));
  EXPECT_TRUE(robot.Rests());
  Make(kNavigation);
  ASSERT_TRUE(tree->board().Set("goal", Pose{.x_m = 60}));
  EXPECT_EQ(Run(4), 'R');
  ASSERT_TRUE(tree->Halt(robot.Now()));
  for (int i = 0; i < 20; ++i) robot.Advance(Milliseconds(100));
  EXPECT_TRUE(robot.Rests());
}
TEST_F(ANav2Tree, FailsWithoutAPlannerAControllerAndAnAnswer) {
  robot.planner_up = robot.controller_up = false;
  Make("<ComputePathToPose goal=\"1;0;0\" error_msg=\"{why}\"/>");
  EXPECT_EQ(Run(1), 'F');
  EXPECT_EQ(Entry<std::string>("why"), "there is no planner");
  robot.planner_up = true;
  robot.answers = false;
  EXPECT_EQ(Run(20), 'F');
  EXPECT_EQ(Entry<std::string>("why"), "no answer");
  robot.clear_reply.reset();
  Make("<ClearEntireCostmap error_msg=\"{why}\"/>");
  EXPECT_EQ(Run(20), 'F');
  EXPECT_EQ(Entry<std::string>("why"), "no answer");
}
TEST_F(ANav2Tree, DoesNotMoveAFlyer) {
  robot.robot_kind = "cf2x";
  Make("<Spin error_msg=\"{why}\"/>");
  EXPECT_EQ(Run(2), 'F');
  EXPECT_THAT(Entry<std::string>("why"), HasSubstr("flies"));
}

}  // namespace musher::tree_robot_test
