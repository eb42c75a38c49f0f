// Trees of the shape of nav2's own, on a robot that moves in simulated time.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "musher/behavior/tree/nav2/nodes.hpp"
#include "musher/modules/skills/nav2/tree_robot.hpp"
#include "musher/modules/skills/skills/travel.hpp"
#include "musher/navigation/planner/cell_map.hpp"
#include "musher/test/behavior/tree/trees.hpp"
#include "musher/test/modules/skills/moving_robot.hpp"

namespace musher::tree_robot_test {

using ::testing::HasSubstr;
using tree::nav2::Pose;

// Ticks all children until each has ended. Nothing is known of it when the tree is built.
class Both : public tree::Control {
  tree::Status OnTick(tree::Tick& tick) override {
    bool all_ended = true;
    for (tree::Node* child : children()) {
      if (!tree::IsCompleted(child->status())) child->Execute(tick);
      all_ended = all_ended && tree::IsCompleted(child->status());
    }
    if (!all_ended) return tree::Status::kRunning;
    const bool all_well = std::ranges::all_of(children(), [](const tree::Node* child) {
      return child->status() == tree::Status::kSuccess;
    });
    ResetChildren(tick);
    return all_well ? tree::Status::kSuccess : tree::Status::kFailure;
  }
};

class ANav2Tree : public ::testing::Test {
 protected:
  ANav2Tree() {
    tree::nav2::AddNodes(factory, nav2);
    EXPECT_TRUE(factory.Add<Both>("Both"));
    EXPECT_TRUE(factory.AddCondition("WayIsFree", [this](const tree::Tick&) {
      return way_is_free ? tree::Status::kSuccess : tree::Status::kFailure;
    }));
  }

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

  // The entry `path`.
  void SetPath(const std::vector<std::pair<double, double>>& places) {
    tree::nav2::Path path;
    for (const auto& [x_m, y_m] : places) path.poses.push_back(Pose{.x_m = x_m, .y_m = y_m});
    ASSERT_TRUE(tree->board().Set("path", path));
  }

  bool way_is_free = true;
  skills::testing::MovingRobot robot;
  skills::TreeRobot nav2{robot};
  tree::Factory factory;
  std::unique_ptr<tree::Tree> tree;
};

const std::string kNavigation =
    "<RecoveryNode number_of_retries=\"6\"><Sequence><PipelineSequence>"
    "<ControllerSelector selected_controller=\"{c}\" default_controller=\"FollowPath\"/>"
    "<RateController hz=\"1\"><RecoveryNode number_of_retries=\"1\">"
    "<ComputePathToPose goal=\"{goal}\" path=\"{path}\" error_code_id=\"{plan_code}\" "
    "error_msg=\"{why}\"/>"
    "<ClearEntireCostmap service_name=\"global\"/></RecoveryNode></RateController>"
    "<RecoveryNode number_of_retries=\"1\">"
    "<FollowPath path=\"{path}\" controller_id=\"{c}\" error_code_id=\"{follow_code}\"/>"
    "<ClearEntireCostmap service_name=\"local\"/></RecoveryNode></PipelineSequence>"
    "<GoalReached goal=\"{goal}\"/></Sequence>"
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
// Plans where the path is no longer free, or the goal has changed.
const std::string kPlansIfInvalid =
    "<PipelineSequence><RateController hz=\"2\"><Fallback>"
    "<ReactiveSequence><Inverter><GlobalUpdatedGoal/></Inverter><IsPathValid path=\"{path}\"/>"
    "</ReactiveSequence>"
    "<ComputePathToPose goal=\"{goal}\" path=\"{path}\"/></Fallback></RateController>"
    "<FollowPath path=\"{path}\"/></PipelineSequence>";

TEST_F(ANav2Tree, PlansAgainOnlyWhereItSeesSomethingOnTheRestOfItsPath) {
  Make(kPlansIfInvalid);
  ASSERT_TRUE(tree->board().Set("goal", Pose{.x_m = 8}));
  robot.points = {{-0.5, 0, 0}, {3, 1, 0}};  // behind it, beside the path
  EXPECT_EQ(Run(3), 'R');
  EXPECT_EQ(robot.plans, 1);
  robot.points = {{6, 0.05, 0}};
  EXPECT_EQ(Run(1), 'R');
  EXPECT_GE(robot.plans, 2);
  robot.points = {};
  const int before = robot.plans;
  EXPECT_EQ(Run(30), 'S');
  EXPECT_EQ(robot.plans, before);
}
TEST_F(ANav2Tree, PlansAgainWhereItDoesNotSee) {
  Make(kPlansIfInvalid);
  ASSERT_TRUE(tree->board().Set("goal", Pose{.x_m = 8}));
  EXPECT_EQ(Run(2), 'R');
  robot.scan_up = false;
  EXPECT_EQ(Run(2), 'R');
  EXPECT_GE(robot.plans, 3);
}

TEST_F(ANav2Tree, SeesNothingInItsWayThatIsBesideItOrThatItHasPassed) {
  tree::nav2::Path path{{Pose{}, Pose{.x_m = 4}, Pose{.x_m = 4, .y_m = 4}}};
  robot.at.at.x_m = 3;
  const std::map<std::string, std::pair<navigation::Point, bool>> places = {
      {"behind it", {{2, 0, 0}, true}},
      {"beside the path", {{3.5, 0.35, 0}, true}},
      {"within the margin of the controller", {{3.5, 0.25, 0}, false}},
      {"before it", {{3.5, 0.15, 0}, false}},
      {"behind the turn", {{4.1, 3, 0}, false}},
      {"beside the robot, which moves away from it", {{2.99, 0.1, 0}, true}}};
  for (const auto& [name, place] : places) {
    robot.points = {place.first};
    EXPECT_EQ(nav2.IsFree(path), place.second) << name;
  }
  path = {{Pose{.x_m = 4, .y_m = 4}}};
  robot.points = {{3.5, 2, 0}};
  EXPECT_FALSE(nav2.IsFree(path)) << "on the way to a path of one pose";
  robot.points = {};
  EXPECT_TRUE(nav2.IsFree(path));
  robot.odometry_up = false;
  EXPECT_FALSE(nav2.IsFree(path));
}

// As nav2's follow_point: keeps 1 m away from what GoalUpdater passes on.
TEST_F(ANav2Tree, FollowsAPointAtADistance) {
  Make(
      "<PipelineSequence><RateController hz=\"1\"><Sequence>"
      "<GoalUpdater input_goal=\"{goal}\" output_goal=\"{point}\">"
      "<ComputePathToPose goal=\"{point}\" path=\"{all}\"/></GoalUpdater>"
      "<TruncatePath distance=\"1\" input_path=\"{all}\" output_path=\"{path}\"/>"
      "</Sequence></RateController>"
      "<KeepRunningUntilFailure><FollowPath path=\"{path}\"/></KeepRunningUntilFailure>"
      "</PipelineSequence>");
  ASSERT_TRUE(tree->board().Set("goal", Pose{.x_m = 5, .stamp = robot.Now()}));
  EXPECT_EQ(Run(15), 'R');
  EXPECT_NEAR(robot.at.at.x_m, 4, 0.01);
  EXPECT_LT(robot.travelled_m, 4.1) << "it drives no path again from its begin";
  nav2.SetGoalUpdate(Pose{.x_m = 8, .stamp = robot.Now()});
  EXPECT_EQ(Run(15), 'R');
  EXPECT_NEAR(robot.at.at.x_m, 7, 0.01);
  nav2.SetGoalUpdate(Pose{.x_m = 7.3, .stamp = robot.Now()});  // comes to the robot
  EXPECT_EQ(Run(5), 'R');
  EXPECT_NEAR(robot.at.at.x_m, 7, 0.01);
  EXPECT_LT(robot.travelled_m, 7.2);
}

// As the newer of nav2's default trees: near the goal it plans again only where it has to.
TEST_F(ANav2Tree, KeepsItsPathNearTheGoalAsLongAsItIsFree) {
  Make(
      "<PipelineSequence><RateController hz=\"1\"><Fallback><ReactiveSequence>"
      "<Inverter><GlobalUpdatedGoal/></Inverter>"
      "<IsGoalNearby path=\"{path}\" proximity_threshold=\"4\" max_robot_pose_search_dist=\"1.5\"/>"
      "<TruncatePathLocal input_path=\"{path}\" output_path=\"{rest}\" distance_forward=\"-1\" "
      "distance_backward=\"0\"/><ValidatePath path=\"{rest}\"/></ReactiveSequence>"
      "<ComputePathToPose goal=\"{goal}\" path=\"{path}\"/></Fallback></RateController>"
      "<FollowPath path=\"{path}\"/></PipelineSequence>");
  robot.drive_speed_m_s = 0.5;
  ASSERT_TRUE(tree->board().Set("goal", Pose{.x_m = 10}));
  EXPECT_EQ(Run(11), 'R');
  const int far = robot.plans;
  EXPECT_GE(far, 8);
  EXPECT_EQ(Run(4), 'R');
  EXPECT_GT(robot.at.at.x_m, 6.5);
  const int near = robot.plans;
  EXPECT_LE(near, far + 2);
  robot.points = {{9, 0.1, 0}};
  EXPECT_EQ(Run(2), 'R');
  EXPECT_GE(robot.plans, near + 1);
  robot.points = {};
  ASSERT_TRUE(tree->board().Set("goal", Pose{.x_m = 10, .y_m = 1}));
  EXPECT_EQ(Run(30), 'S');
  EXPECT_NEAR(robot.at.at.y_m, 1, 0.01);
}

// As nav2's trees through poses.
TEST_F(ANav2Tree, TravelsThroughPlacesAndForgetsThoseItHasPassed) {
  Make(
      "<PipelineSequence><RateController hz=\"1\"><ReactiveSequence>"
      "<RemovePassedGoals input_goals=\"{goals}\" output_goals=\"{goals}\" radius=\"0.7\"/>"
      "<ComputePathThroughPoses goals=\"{goals}\" path=\"{path}\"/></ReactiveSequence>"
      "</RateController><FollowPath path=\"{path}\"/></PipelineSequence>");
  robot.drive_speed_m_s = 0.5;
  ASSERT_TRUE(tree->board().Set(
      "goals", tree::nav2::Goals{{Pose{.x_m = 3}, Pose{.x_m = 3, .y_m = 3}, Pose{.y_m = 3}}}));
  double nearest_m[2] = {1e9, 1e9};
  char letter = 'R';
  for (int i = 0; i < 600 && letter == 'R'; ++i) {
    letter = Run(0.1);
    nearest_m[0] = std::min(nearest_m[0], navigation::Distance(robot.at.at, {3, 0, 0}));
    nearest_m[1] = std::min(nearest_m[1], navigation::Distance(robot.at.at, {3, 3, 0}));
  }
  EXPECT_EQ(letter, 'S');
  EXPECT_LT(nearest_m[0], 0.71);
  EXPECT_LT(nearest_m[1], 0.71);
  EXPECT_NEAR(navigation::Distance(robot.at.at, {0, 3, 0}), 0, 0.01);
  EXPECT_LT(robot.travelled_m, 9.1) << "it does not go back to a place that it has passed";
  EXPECT_EQ(Entry<tree::nav2::Goals>("goals").poses.size(), 1U);
}

// As nav2's tree that waits near the goal (goal_patience): it waits before a way round that is much
// longer.
TEST_F(ANav2Tree, WaitsBeforeAWayThatIsMuchLongerNearTheGoal) {
  bool way_round = false;
  robot.plan = [&](const auto& start, const auto& goal) -> Result<navigation::Path> {
    if (!way_round) return navigation::Path{start, goal};
    return navigation::Path{start, {{start.at.x_m, 9, 0}, 0}, {{goal.at.x_m, 9, 0}, 0}, goal};
  };
  Make(
      "<PipelineSequence><RateController hz=\"1\">"
      "<ComputePathToPose goal=\"{goal}\" path=\"{path}\"/></RateController>"
      "<ReactiveSequence><PathLongerOnApproach path=\"{path}\" prox_len=\"3\" "
      "length_factor=\"2\"><RetryUntilSuccessful num_attempts=\"1\"><SequenceWithMemory>"
      "<CancelControl/><Wait wait_duration=\"5\"/></SequenceWithMemory></RetryUntilSuccessful>"
      "</PathLongerOnApproach><FollowPath path=\"{path}\"/></ReactiveSequence></PipelineSequence>");
  ASSERT_TRUE(tree->board().Set("goal", Pose{.x_m = 6}));
  robot.drive_speed_m_s = 0.5;
  for (int i = 0; i < 200 && robot.at.at.x_m < 4; ++i) Run(0.1);
  way_round = true;
  EXPECT_EQ(Run(2), 'R');
  const navigation::Point stood = robot.at.at;
  EXPECT_EQ(Run(2), 'R');
  EXPECT_TRUE(robot.Rests());
  EXPECT_EQ(robot.at.at.x_m, stood.x_m);
  way_round = false;
  EXPECT_EQ(Run(30), 'S');
  EXPECT_NEAR(robot.at.at.x_m, 6, 0.01);
  EXPECT_NEAR(robot.travelled_m, 6, 0.5);
}

TEST_F(ANav2Tree, GoesOnToAGoalThatComesJustBeforeTheEndAtTheOneBefore) {
  Make(kNavigation);
  ASSERT_TRUE(tree->board().Set("goal", Pose{.x_m = 3}));
  for (int i = 0; i < 100 && robot.at.at.x_m < 2.85; ++i) Run(0.1);
  ASSERT_TRUE(tree->board().Set("goal", Pose{.x_m = 3, .y_m = 2}));
  char letter = 'R';
  for (int i = 0; i < 10 && robot.driving(); ++i) letter = Run(0.1);
  EXPECT_EQ(letter, 'R');
  EXPECT_EQ(robot.at.at.x_m, 3);
  EXPECT_EQ(robot.at.at.y_m, 0) << "the drive has ended before the next plan";
  EXPECT_EQ(Run(30), 'S');
  EXPECT_NEAR(robot.at.at.y_m, 2, 0.01);
}
TEST_F(ANav2Tree, GoesOnToAGoalThatMovesLessThanTheToleranceJustBeforeTheEnd) {
  Make(kNavigation);
  ASSERT_TRUE(tree->board().Set("goal", Pose{.x_m = 3}));
  for (int i = 0; i < 100 && robot.at.at.x_m < 2.85; ++i) Run(0.1);
  ASSERT_TRUE(tree->board().Set("goal", Pose{.x_m = 3, .y_m = 0.4}));
  EXPECT_EQ(Run(30), 'S');
  EXPECT_NEAR(robot.at.at.y_m, 0.4, 0.01) << "it has arrived at the goal before, not at this one";
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
TEST_F(ANav2Tree, KeepsItsDriveAtTheEndOfItsPathWhereAPlanHasTheSameEnd) {
  const auto path = [](std::vector<Pose> poses) { return tree::nav2::Path{std::move(poses)}; };
  const Pose end{.x_m = 4};
  const tree::nav2::Path driven = path({Pose{}, end});
  robot.at.at.x_m = 4.05;
  const Pose here{.x_m = 4.05};
  EXPECT_TRUE(nav2.IsSameDrive(driven, path({here, end})));
  EXPECT_FALSE(nav2.IsSameDrive(driven, path({here, Pose{.x_m = 4, .yaw_rad = 1}})));
  EXPECT_FALSE(nav2.IsSameDrive(driven, path({here, Pose{.x_m = 4, .y_m = 1}, end}))) << "a detour";
  EXPECT_FALSE(nav2.IsSameDrive(path({here, Pose{.y_m = 2}, Pose{}, end}), path({here, end})))
      << "the begin of a loop";
  robot.at.at.x_m = 3.7;
  EXPECT_TRUE(nav2.IsSameDrive(driven, driven));
  EXPECT_FALSE(nav2.IsSameDrive(driven, path({Pose{.x_m = 3.7}, end})));
  robot.at.at.x_m = 4.05;
  robot.odometry_up = false;
  EXPECT_FALSE(nav2.IsSameDrive(driven, path({here, end})));
}
// The controller gives up after 2 s before an obstacle, and no drive is so old.
TEST_F(ANav2Tree, FailsADriveThatStandsAlsoWhereEachPlanIsAnotherPath) {
  int plans = 0;
  robot.plan = [&plans](const auto& start, const auto& goal) -> Result<navigation::Path> {
    return navigation::Path{{{start.at.x_m, 1e-9 * ++plans, 0}, 0}, goal};
  };
  robot.blocked = [](const navigation::Point& point) { return point.x_m > 3; };
  Make(
      "<PipelineSequence><RateController hz=\"2\">"
      "<ComputePathToPose goal=\"6;0;0\" path=\"{path}\"/></RateController>"
      "<FollowPath path=\"{path}\" error_code_id=\"{code}\" error_msg=\"{why}\"/>"
      "</PipelineSequence>");
  EXPECT_EQ(Run(20), 'F');
  EXPECT_EQ(Entry<int>("code"), 104);
  for (int i = 0; i < 20; ++i) robot.Advance(Milliseconds(100));
  EXPECT_TRUE(robot.Rests());
  EXPECT_FALSE(robot.driving()) << "what does not move is cancelled";
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
// Drives 20 m ahead; after so long it gives that up, and does what follows.
std::string DriveThen(const std::string& time_ms, const std::string& then) {
  return "<Fallback><Timeout msec=\"" + time_ms +
         "\"><Sequence><ComputePathToPose goal=\"20;0;0\" path=\"{path}\"/>"
         "<FollowPath path=\"{path}\"/></Sequence></Timeout>" +
         then + "</Fallback>";
}
TEST_F(ANav2Tree, BeginsAMotionOnceTheHaltedDriveHasEndedAndTheRobotStands) {
  robot.drive_speed_m_s = 1.5;  // it rolls on for more than half a metre
  Make(DriveThen("3000", "<BackUp backup_dist=\"0.3\" backup_speed=\"0.1\"/>"));
  double farthest_m = 0;
  char letter = 'R';
  for (int i = 0; i < 150 && letter == 'R'; ++i) {
    letter = Run(0.1);
    farthest_m = std::max(farthest_m, robot.at.at.x_m);
  }
  EXPECT_EQ(letter, 'S');
  EXPECT_NEAR(farthest_m - robot.at.at.x_m, 0.3, 0.05);
  EXPECT_EQ(robot.commands_in_drives, 0);
}
TEST_F(ANav2Tree, BeginsNoMotionWhileAHaltedDriveGoesOn) {
  robot.drives_brake = false;
  Make(DriveThen("3000", "<BackUp time_allowance=\"2\" error_msg=\"{why}\"/>"));
  EXPECT_EQ(Run(8), 'F');
  EXPECT_EQ(robot.commands_in_drives, 0);
  EXPECT_THAT(Entry<std::string>("why"), HasSubstr("a drive has not ended"));
}
TEST_F(ANav2Tree, BeginsAMotionWhereTheControllerOfTheHaltedDriveIsLost) {
  robot.drives_brake = false;
  Make(DriveThen("3000", "<BackUp backup_dist=\"0.3\" backup_speed=\"0.1\"/>"));
  EXPECT_EQ(Run(4), 'R');
  robot.KillController();
  EXPECT_EQ(Run(10), 'S');
}
TEST_F(ANav2Tree, BeginsNoMotionBeforeTheHaltedDriveOfALostControllerCountsAsEnded) {
  robot.drives_brake = false;
  Make(DriveThen("3000",
                 "<BackUp backup_dist=\"0.3\" backup_speed=\"0.1\" "
                 "time_allowance=\"30\"/>"));
  EXPECT_EQ(Run(4), 'R');
  robot.controller_up = false;
  EXPECT_EQ(Run(0.2), 'R');
  robot.controller_up = true;
  EXPECT_EQ(Run(1), 'R');
  robot.controller_up = false;
  EXPECT_EQ(Run(4.5), 'R');
  EXPECT_TRUE(robot.driving());
  EXPECT_EQ(Run(20), 'S');
  EXPECT_EQ(robot.commands_in_drives, 0);
}
// A reactive control starts the child that runs now before it halts the one behind it.
TEST_F(ANav2Tree, BeginsAMotionInAReactiveControlOnceTheDriveBehindItHasEnded) {
  Make(
      "<ReactiveSequence><Fallback><WayIsFree/><BackUp backup_dist=\"0.5\" backup_speed=\"0.1\"/>"
      "</Fallback><FollowPath path=\"{path}\"/></ReactiveSequence>");
  SetPath({{0, 0}, {9, 0}});
  EXPECT_EQ(Run(4), 'R');
  way_is_free = false;
  EXPECT_EQ(Run(1), 'R');
  const double farthest_m = robot.at.at.x_m;
  EXPECT_EQ(Run(4), 'R');
  EXPECT_LT(robot.at.at.x_m, farthest_m - 0.2);
  way_is_free = true;
  EXPECT_EQ(Run(20), 'S');
  EXPECT_NEAR(robot.at.at.x_m, 9, 0.01);
  EXPECT_EQ(robot.commands_in_drives, 0);
  EXPECT_EQ(robot.drives_from_a_motion, 0);
}
TEST_F(ANav2Tree, BeginsNoMotionBesideTheDriveOfAPipeline) {
  Make(
      "<PipelineSequence><Fallback><WayIsFree/><BackUp time_allowance=\"2\" error_msg=\"{why}\"/>"
      "</Fallback><FollowPath path=\"{path}\"/></PipelineSequence>");
  SetPath({{0, 0}, {50, 0}});
  EXPECT_EQ(Run(2), 'R');
  way_is_free = false;
  EXPECT_EQ(Run(5), 'F');
  EXPECT_EQ(robot.commands_in_drives, 0);
  EXPECT_THAT(Entry<std::string>("why"), HasSubstr("a drive has not ended"));
}
TEST_F(ANav2Tree, FailsADriveThatWaitsForTheBaseAlsoWhereItIsPlannedAgainEachSecond) {
  Make(
      "<Both><Spin spin_dist=\"50\" time_allowance=\"90\"/><PipelineSequence>"
      "<RateController hz=\"1\"><ComputePathToPose goal=\"9;0;0\" path=\"{path}\"/>"
      "</RateController><FollowPath path=\"{path}\" "
      "error_msg=\"{why}\"/></PipelineSequence></Both>");
  EXPECT_EQ(Run(9), 'R');
  EXPECT_FALSE(tree->board().Get<std::string>("why"));
  EXPECT_EQ(Run(3), 'R');
  EXPECT_GE(robot.plans, 8);
  EXPECT_EQ(Entry<std::string>("why"), "a motion has not ended");
  EXPECT_EQ(robot.drives, 0);
}
TEST_F(ANav2Tree, RunsTwoTasksOfTheBaseOneAfterTheOther) {
  const std::string back = "<BackUp backup_dist=\"0.3\" backup_speed=\"0.1\"/>";
  const std::string follow = "<FollowPath path=\"{path}\"/>";
  Make("<Both>" + back + "<Spin spin_dist=\"1.57\"/></Both>");
  EXPECT_EQ(Run(20), 'S');
  EXPECT_NEAR(robot.at.at.x_m, -0.3, 0.05);
  EXPECT_NEAR(robot.at.yaw_rad, 1.57, 0.15);
  for (const std::string& two : {back + follow, follow + back}) {
    robot.at = {};
    Make("<Both>" + two + "</Both>");
    SetPath({{0, 0}, {3, 0}});
    EXPECT_EQ(Run(20), 'S') << two;
  }
  EXPECT_EQ(robot.commands_in_drives, 0);
  EXPECT_EQ(robot.drives_from_a_motion, 0);
}
TEST_F(ANav2Tree, FailsWhatWaitsForTheBaseAtItsLimit) {
  Make(
      "<Both><Spin spin_dist=\"50\" time_allowance=\"15\"/><FollowPath path=\"{path}\" "
      "error_msg=\"{why}\"/><BackUp time_allowance=\"2\" error_msg=\"{also}\"/></Both>");
  SetPath({{0, 0}, {3, 0}});
  EXPECT_EQ(Run(20), 'F');
  EXPECT_EQ(Entry<std::string>("why"), "a motion has not ended");
  EXPECT_EQ(Entry<std::string>("also"), "a motion has not ended");
  EXPECT_EQ(robot.drives, 0);
}
TEST_F(ANav2Tree, FailsAMotionWhereAnotherClientBeginsADrive) {
  Make("<Spin spin_dist=\"50\" time_allowance=\"90\" error_msg=\"{why}\"/>");
  EXPECT_EQ(Run(2), 'R');
  const auto other = robot.FollowPath({{{0, 0, 0}, 0}, {{9, 0, 0}, 0}});
  EXPECT_EQ(Run(0.2), 'F');
  EXPECT_EQ(Entry<std::string>("why"), "a drive has begun");
  EXPECT_EQ(robot.commands_in_drives, 0);
}
TEST_F(ANav2Tree, CancelsTheDriveThatAProcessBeforeItHasLeftBehind) {
  for (const bool reachable : {true, false}) {
    robot.at = {};
    const auto left_behind = robot.FollowPath({{{0, 0, 0}, 0}, {{50, 0, 0}, 0}});
    robot.controller_up = reachable;
    skills::TreeRobot restarted(robot);
    robot.controller_up = true;
    tree::Factory nodes;
    tree::nav2::AddNodes(nodes, restarted);
    tree = tree::MakeTree(tree::Main("<Spin/>"), nodes);
    EXPECT_EQ(Run(9), 'S') << reachable;
    EXPECT_EQ(robot.commands_in_drives, 0);
    tree.reset();
  }
}
TEST_F(ANav2Tree, CancelsNoDriveOfItsOwnWhereTheControllerComesLate) {
  robot.controller_up = false;
  skills::TreeRobot restarted(robot);
  robot.controller_up = true;
  tree::Factory nodes;
  tree::nav2::AddNodes(nodes, restarted);
  ASSERT_TRUE(nodes.Add<Both>("Both"));
  tree = tree::MakeTree(tree::Main("<Both><FollowPath path=\"{path}\"/><ComputePathToPose "
                                   "goal=\"1;0;0\"/></Both>"),
                        nodes);
  SetPath({{0, 0}, {3, 0}});
  EXPECT_EQ(Run(9), 'S');
  tree.reset();
}
TEST_F(ANav2Tree, CancelsNoDriveThatHasBegunAfterItWhereTheControllerComesLate) {
  robot.controller_up = false;
  skills::TreeRobot restarted(robot);
  robot.controller_up = true;
  const auto of_another_client = robot.FollowPath({{{0, 0, 0}, 0}, {{3, 0, 0}, 0}});
  tree::Factory nodes;
  tree::nav2::AddNodes(nodes, restarted);
  tree = tree::MakeTree(tree::Main("<ComputePathToPose goal=\"1;0;0\"/>"), nodes);
  EXPECT_EQ(Run(9), 'S');
  for (int i = 0; i < 50; ++i) robot.Advance(Milliseconds(100));
  EXPECT_NEAR(robot.at.at.x_m, 3, 0.01);
  tree.reset();
}
const std::string kFollowTwice =
    "<RetryUntilSuccessful num_attempts=\"2\"><FollowPath path=\"{path}\"/>"
    "</RetryUntilSuccessful>";
TEST_F(ANav2Tree, DrivesOnToTheFarEndOfAWayOutAndBackAfterAFailure) {
  Make(kFollowTwice);
  SetPath({{0, 0}, {10, 0}, {0, 0}});
  for (int i = 0; i < 100 && robot.at.at.x_m < 5; ++i) Run(0.1);
  robot.at.at.y_m = 0.02;
  robot.FailDrive(navigation::MakeError(navigation::Fault::kObstacle, ""));
  double farthest_m = 0;
  char letter = 'R';
  for (int i = 0; i < 300 && letter == 'R'; ++i) {
    letter = Run(0.1);
    farthest_m = std::max(farthest_m, robot.at.at.x_m);
  }
  EXPECT_EQ(letter, 'S');
  EXPECT_EQ(robot.drives, 2);
  EXPECT_NEAR(farthest_m, 10, 0.2);
  EXPECT_NEAR(robot.at.at.x_m, 0, 0.01);
}
TEST_F(ANav2Tree, DrivesAPathFromItsBeginInANewRunAndFromAnotherPlace) {
  const navigation::Path path{{{0, 0, 0}, 0}, {{4, 0, 0}, 0}, {{4, 4, 0}, 0}};
  Make(
      "<Fallback><FollowPath path=\"{path}\"/><Sequence><Wait/><FollowPath path=\"{path}\"/>"
      "</Sequence></Fallback>");
  SetPath({{0, 0}, {4, 0}, {4, 4}});
  EXPECT_EQ(Run(3), 'R');
  ASSERT_TRUE(tree->Halt(robot.Now()));
  for (int i = 0; i < 20; ++i) robot.Advance(Milliseconds(100));
  ASSERT_TRUE(robot.Rests());
  robot.at.at = {4, 4, 0};  // by other means
  EXPECT_EQ(Run(0.1), 'R');
  EXPECT_EQ(robot.driven_paths.back(), path) << "in a new run";
  EXPECT_EQ(Run(2), 'R');
  robot.FailDrive(navigation::MakeError(navigation::Fault::kObstacle, ""));
  EXPECT_EQ(Run(0.5), 'R');
  robot.at.at.x_m += 1.5;  // near to the path
  EXPECT_EQ(Run(1), 'R');
  EXPECT_EQ(robot.drives, 3);
  EXPECT_EQ(robot.driven_paths.back(), path) << "from another place";
}
TEST_F(ANav2Tree, LeavesNothingOfAPathOutThatItIsFarFrom) {
  const navigation::Path path{{{0, 0, 0}, 0}, {{4, 0, 0}, 0}, {{4, 4, 0}, 0}};
  robot.at.at = {2, 0.5, 0};
  EXPECT_EQ(skills::RestOf(robot, path),
            (navigation::Path{{{2, 0.5, 0}, 0}, {{2, 0, 0}, 0}, path[1], path[2]}));
  robot.at.at = {2, -2.5, 0};
  EXPECT_EQ(skills::RestOf(robot, path), path);
}
TEST_F(ANav2Tree, ReachesAGoalWhereItsDriveHasArrivedNearIt) {
  robot.plan = [](const auto& start, const auto& goal) -> Result<navigation::Path> {
    return navigation::Path{start, {{goal.at.x_m - 0.4, goal.at.y_m, 0}, goal.yaw_rad}};
  };
  Make(kNavigation);
  ASSERT_TRUE(tree->board().Set("goal", Pose{.x_m = 3}));
  EXPECT_EQ(Run(30), 'S');
}
TEST_F(ANav2Tree, GoesOnAlongTheRestOfItsPathAfterAFailure) {
  Make(
      "<RetryUntilSuccessful num_attempts=\"2\"><FollowPath path=\"{path}\" "
      "controller_id=\"{c}\"/></RetryUntilSuccessful>");
  SetPath({{0, 0}, {4, 0}, {4, 1}, {0, 1}});
  EXPECT_EQ(Run(6.5), 'R');
  robot.FailDrive(navigation::MakeError(navigation::Fault::kObstacle, ""));
  EXPECT_EQ(Run(0.5), 'R');
  ASSERT_TRUE(tree->board().Set("c", std::string("another")));
  EXPECT_EQ(Run(20), 'S');
  EXPECT_EQ(robot.drives, 2) << "there is one controller";
  EXPECT_NEAR(robot.travelled_m, 9, 0.3);
}
TEST_F(ANav2Tree, DrivesALoopToItsEndAndAgainFromItsBegin) {
  Make(
      "<Repeat num_cycles=\"2\"><RetryUntilSuccessful num_attempts=\"2\"><FollowPath "
      "path=\"{path}\"/></RetryUntilSuccessful></Repeat>");
  SetPath({{0, 0}, {2, 0}, {2, 2}, {0, 2}, {0, 0}});
  robot.at.at = {0.05, -0.05, 0};
  EXPECT_EQ(Run(0.5), 'R');
  robot.FailDrive(navigation::MakeError(navigation::Fault::kObstacle, ""));
  EXPECT_EQ(Run(40), 'S');
  EXPECT_NEAR(robot.travelled_m, 16, 0.5);
}
TEST_F(ANav2Tree, BeginsADriveOnceTheRobotStandsAfterAHaltedMotion) {
  Make(
      "<Fallback><Timeout msec=\"2000\"><Spin spin_dist=\"50\" time_allowance=\"90\"/></Timeout>"
      "<FollowPath path=\"{path}\"/></Fallback>");
  ASSERT_TRUE(tree->board().Set("path", tree::nav2::Path{{Pose{}, Pose{.x_m = 2}}}));
  EXPECT_EQ(Run(10), 'S');
  EXPECT_EQ(robot.drives_from_a_motion, 0);
  EXPECT_NEAR(robot.at.at.x_m, 2, 0.01);
}
TEST_F(ANav2Tree, FailsWithACodeThatAsksForNoRecoveryWhereNoneHelps) {
  using navigation::Fault;
  using navigation::MakeError;
  const auto planned = [this](const Result<navigation::Path>& path) {
    robot.plan = [path](const auto&, const auto&) { return path; };
    Make("<ComputePathToPose goal=\"6;0;0\" error_code_id=\"{code}\"/>");
    EXPECT_EQ(Run(5), 'F');
    return Entry<int>("code");
  };
  EXPECT_EQ(planned(MakeError(Fault::kIdentifier, "")), 201);
  EXPECT_EQ(planned(MakeError(Fault::kFrame, "")), 202);
  EXPECT_EQ(planned(Error{kCodeNetError, "lost"}), 207);
  const auto driven = [this](const Error& error) {
    Make("<FollowPath path=\"{path}\" error_code_id=\"{code}\"/>");
    EXPECT_TRUE(tree->board().Set("path", tree::nav2::Path{{Pose{}, Pose{.x_m = 50}}}));
    EXPECT_EQ(Run(1), 'R');
    robot.FailDrive(error);
    EXPECT_EQ(Run(1), 'F');
    return Entry<int>("code");
  };
  EXPECT_EQ(driven(MakeError(Fault::kIdentifier, "")), 101);
  EXPECT_EQ(driven(MakeError(Fault::kOdometry, "")), 102);
  EXPECT_EQ(driven(MakeError(Fault::kInput, "")), 103);
  EXPECT_EQ(driven(MakeError(Fault::kLate, "")), 105);
  EXPECT_EQ(driven(MakeError(Fault::kScan, "")), 106);
  EXPECT_EQ(driven(MakeError(Fault::kTimeLimit, "")), 107);
  EXPECT_EQ(driven(Error{kCodeNetError, "lost"}), 107);
  EXPECT_EQ(driven(Error{kCodeStateInvalid, "rejected"}), 100);
  Make("<FollowPath path=\"{path}\" error_code_id=\"{code}\"/>");
  ASSERT_TRUE(tree->board().Set("path", tree::nav2::Path{}));
  EXPECT_EQ(Run(1), 'F');
  EXPECT_EQ(Entry<int>("code"), 103) << "an empty path";
  ASSERT_TRUE(tree->board().Set("path", tree::nav2::Path{{Pose{.x_m = NAN}}}));
  EXPECT_EQ(Run(1), 'F');
  EXPECT_EQ(Entry<int>("code"), 103) << "a path that is not finite";
  robot.controller_up = false;
  ASSERT_TRUE(tree->board().Set("path", tree::nav2::Path{{Pose{}, Pose{.x_m = 5}}}));
  EXPECT_EQ(Run(1), 'F');
  EXPECT_EQ(Entry<int>("code"), 101) << "no controller";
}
TEST_F(ANav2Tree, DoesNotSucceedWithoutAPathToItsGoal) {
  const auto code = [this](const navigation::Path& path) {
    robot.plan = [path](const auto&, const auto&) -> Result<navigation::Path> { return path; };
    Make("<ComputePathToPose goal=\"6;0;0\" error_code_id=\"{code}\" error_msg=\"{why}\"/>");
    return Run(5) == 'F' ? Entry<int>("code") : 0;
  };
  EXPECT_EQ(code({}), 208);
  EXPECT_EQ(code({{{0, 0, 0}, 0}, {{5.4, 0, 0}, 0}}), 208);
  EXPECT_EQ(Entry<std::string>("why"), "the path ends 0.6 m from the goal");
  EXPECT_EQ(code({{{NAN, 0, 0}, 0}, {{6, 0, 0}, 0}}), 208);
  EXPECT_EQ(code({{{0, 0, 0}, 0}, {{5.6, 0, 2}, 0}}), 0) << "on the ground the height is ignored";
}
TEST_F(ANav2Tree, DoesNotSucceedWhereTheDriveEndsBeforeItsGoal) {
  Make("<FollowPath path=\"{path}\" error_code_id=\"{code}\" error_msg=\"{why}\"/>");
  ASSERT_TRUE(tree->board().Set("path", tree::nav2::Path{{Pose{}, Pose{.x_m = 50}}}));
  EXPECT_EQ(Run(1), 'R');
  robot.EndDrive();
  EXPECT_EQ(Run(1), 'F');
  EXPECT_EQ(Entry<int>("code"), 105);
  EXPECT_THAT(Entry<std::string>("why"), HasSubstr("m from the goal"));
}
TEST_F(ANav2Tree, DoesNotSucceedWhereItsPoseIsUnknownWhenTheDriveEnds) {
  Make("<FollowPath path=\"{path}\" error_code_id=\"{code}\" error_msg=\"{why}\"/>");
  SetPath({{0, 0}, {50, 0}});
  EXPECT_EQ(Run(1), 'R');
  robot.odometry_up = false;
  robot.EndDrive();
  EXPECT_EQ(Run(1), 'F');
  EXPECT_EQ(Entry<int>("code"), 102);
  EXPECT_EQ(Entry<std::string>("why"), "No odometry of robot_0");
}
TEST_F(ANav2Tree, ReachesItsGoalAtTheHeightOfItsBodyUnlessItFlies) {
  robot.pelvis_m = 0.7;
  Make("<GoalReached goal=\"0;0;0\"/>");
  EXPECT_EQ(Run(0.1), 'S');
  robot.robot_kind = "cf2x";
  EXPECT_EQ(Run(0.1), 'F');
}
TEST_F(ANav2Tree, FailsWhereAnotherClientCancelsItsDrive) {
  Make("<FollowPath path=\"{path}\" error_code_id=\"{code}\"/>");
  ASSERT_TRUE(tree->board().Set("path", tree::nav2::Path{{Pose{}, Pose{.x_m = 50}}}));
  EXPECT_EQ(Run(1), 'R');
  robot.CancelDrive();
  EXPECT_EQ(Run(1), 'F');
  EXPECT_EQ(Entry<int>("code"), 150) << "no recovery is asked for";
}
TEST_F(ANav2Tree, FailsAMotionWithTheCodeOfItsReason) {
  const auto code = [this](const std::string& node) {
    Make("<" + node + " error_code_id=\"{code}\"/>");
    EXPECT_EQ(Run(5), 'F') << node;
    return Entry<int>("code");
  };
  EXPECT_EQ(code("Spin spin_dist=\"50\" time_allowance=\"2\""), 701);
  EXPECT_EQ(code("BackUp backup_dist=\"50\" time_allowance=\"2\""), 711);
  EXPECT_EQ(code("DriveOnHeading dist_to_travel=\"50\" time_allowance=\"2\""), 721);
  robot.held_by = "an obstacle";
  EXPECT_EQ(code("Spin"), 703);
  EXPECT_EQ(code("BackUp"), 714);
  EXPECT_EQ(code("DriveOnHeading"), 723);
  robot.held_by.clear();
  robot.odometry_up = false;
  EXPECT_EQ(code("Spin"), 702);
  EXPECT_EQ(code("BackUp"), 712);
  EXPECT_EQ(code("DriveOnHeading"), 722);
  robot.odometry_up = true;
  robot.scan_up = false;
  EXPECT_EQ(code("Spin"), 700);
  EXPECT_EQ(code("BackUp"), 710);
  EXPECT_EQ(code("DriveOnHeading"), 720);
}
TEST_F(ANav2Tree, FailsAMotionThatLeavesItsWayAndOneWhosePoseJumps) {
  Make(
      "<BackUp backup_dist=\"0.5\" backup_speed=\"0.05\" time_allowance=\"30\" "
      "error_code_id=\"{code}\" error_msg=\"{why}\"/>");
  char letter = 'R';
  for (int i = 0; i < 50 && letter == 'R'; ++i) {
    robot.at.at.y_m += 0.05;
    letter = Run(0.1);
  }
  EXPECT_EQ(letter, 'F');
  EXPECT_EQ(Entry<int>("code"), 710);
  EXPECT_EQ(Entry<std::string>("why"),
            "it has left its way: it is 1.0 m from its begin, 1.0 m to the side");
  robot.at = {};
  Make(
      "<DriveOnHeading dist_to_travel=\"5\" speed=\"0.1\" time_allowance=\"90\" "
      "error_code_id=\"{code}\" error_msg=\"{why}\"/>");
  EXPECT_EQ(Run(1), 'R');
  robot.at.at.x_m += 2;
  EXPECT_EQ(Run(0.2), 'F');
  EXPECT_EQ(Entry<int>("code"), 722);
  EXPECT_EQ(Entry<std::string>("why"), "its pose has jumped");
}
TEST_F(ANav2Tree, MovesWithoutALimitWhereItsTimeIs0) {
  Make("<Spin spin_dist=\"12\" time_allowance=\"0\"/>");
  EXPECT_EQ(Run(30), 'S');
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

TEST_F(ANav2Tree, NavigatesToAPose) {
  Make("<NavigateToPose goal=\"{goal}\" error_code_id=\"{code}\" error_msg=\"{why}\"/>");
  ASSERT_TRUE(tree->board().Set("goal", Pose{.x_m = 4, .y_m = 1, .yaw_rad = 1}));
  EXPECT_EQ(Run(30), 'S');
  EXPECT_NEAR(robot.at.at.x_m, 4, 0.01);
  EXPECT_NEAR(robot.at.at.y_m, 1, 0.01);
  EXPECT_NEAR(robot.at.yaw_rad, 1, 0.01);
  EXPECT_TRUE(robot.Rests());
  robot.plan = [](const auto&, const auto&) -> Result<navigation::Path> {
    return navigation::MakeError(navigation::Fault::kGoalBlocked, "a wall is there");
  };
  EXPECT_EQ(Run(120), 'F');
  EXPECT_EQ(Entry<int>("code"), 9000);
  EXPECT_THAT(Entry<std::string>("why"), HasSubstr("a wall is there"));
}
// The tree gives one node; the plans around an obstacle and the recoveries are those of the skill.
TEST_F(ANav2Tree, NavigatesToAPoseOnceAnObstacleIsGone) {
  Make("<NavigateToPose goal=\"6;0;0\"/>");
  bool stands_in_the_way = true;
  robot.blocked = [&](const navigation::Point& at) {
    return stands_in_the_way && std::abs(at.x_m - 3) < 0.2;
  };
  EXPECT_EQ(Run(10), 'R');
  EXPECT_LT(robot.at.at.x_m, 2.9);
  stands_in_the_way = false;
  EXPECT_EQ(Run(60), 'S');
  EXPECT_GE(robot.plans, 2);
}
TEST_F(ANav2Tree, NavigatesThroughPosesAndNamesTheOneThatItDoesNotReach) {
  Make("<NavigateThroughPoses goals=\"{goals}\" error_code_id=\"{code}\" error_msg=\"{why}\"/>");
  ASSERT_TRUE(tree->board().Set(
      "goals", tree::nav2::Goals{{Pose{.x_m = 2}, Pose{.x_m = 2, .y_m = 2}, Pose{.y_m = 2}}}));
  EXPECT_EQ(Run(60), 'S');
  EXPECT_EQ(robot.drives, 3);
  EXPECT_NEAR(robot.at.at.x_m, 0, 0.01);
  EXPECT_NEAR(robot.at.at.y_m, 2, 0.01);
  robot.plan = [](const auto& start, const auto& goal) -> Result<navigation::Path> {
    if (goal.at.y_m < 2) return navigation::MakeError(navigation::Fault::kGoalBlocked, "a wall");
    return navigation::Path{start, goal};
  };
  ASSERT_TRUE(
      tree->board().Set("goals", tree::nav2::Goals{{Pose{.x_m = 1, .y_m = 2}, Pose{.x_m = 1}}}));
  EXPECT_EQ(Run(200), 'F');
  EXPECT_EQ(Entry<int>("code"), 9100);
  EXPECT_THAT(Entry<std::string>("why"), HasSubstr("place 2: "));
}
TEST_F(ANav2Tree, StandsWhenItIsHaltedWhileItNavigates) {
  Make("<NavigateToPose goal=\"9;0;0\"/>");
  EXPECT_EQ(Run(3), 'R');
  EXPECT_TRUE(robot.driving());
  ASSERT_TRUE(tree->Halt(robot.Now()));
  for (int i = 0; i < 20; ++i) robot.Advance(Milliseconds(100));
  EXPECT_TRUE(robot.Rests());
  EXPECT_LT(robot.at.at.x_m, 5);
}
TEST_F(ANav2Tree, NavigatesOnceTheBaseIsFreeAndLeavesItToNoOtherTask) {
  Make(
      "<Both><Spin spin_dist=\"1\"/><NavigateToPose goal=\"2;0;0\"/>"
      "<FollowPath path=\"{path}\"/></Both>");
  SetPath({{2, 0}, {2, 1}});
  EXPECT_EQ(Run(60), 'S');
  EXPECT_EQ(robot.drives_from_a_motion, 0);
  EXPECT_EQ(robot.commands_in_drives, 0);
}
TEST_F(ANav2Tree, DoesNotNavigateWhileAnotherClientDrivesIt) {
  Make("<NavigateToPose goal=\"2;0;0\" error_msg=\"{why}\"/>");
  const auto other = robot.FollowPath({{{0, 0, 0}, 0}, {{50, 0, 0}, 0}});
  EXPECT_EQ(Run(9), 'R');
  EXPECT_EQ(robot.plans, 0);
  EXPECT_EQ(Run(2), 'F');
  EXPECT_EQ(Entry<std::string>("why"), "a drive has not ended");
}
TEST_F(ANav2Tree, FollowsAnObjectForItsTimeOrUntilItIsCancelled) {
  robot.targets["/person"] = [](Time now) {
    return navigation::Pose{{3 + 0.5 * ToSeconds(now.time_since_epoch()), 0, 0}, 0};
  };
  Make("<FollowObject pose_topic=\"/person\" max_duration=\"6\" error_msg=\"{why}\"/>");
  EXPECT_EQ(Run(5), 'R');
  EXPECT_GT(robot.at.at.x_m, 1);
  EXPECT_EQ(Run(10), 'S');
  EXPECT_TRUE(robot.Rests());
  Make("<FollowObject pose_topic=\"/person\" error_msg=\"{why}\"/>");
  EXPECT_EQ(Run(10), 'R');
  nav2.CancelNodes(tree::nav2::Cancellable::kFollowObject);
  EXPECT_EQ(Run(0.1), 'F');
  Make("<FollowObject pose_topic=\"/nothing\" error_msg=\"{why}\"/>");
  EXPECT_EQ(Run(20), 'F');
  EXPECT_THAT(Entry<std::string>("why"), HasSubstr("no pose on /nothing"));
}
TEST_F(ANav2Tree, LeavesItsBaseToAPersonAndToNothingElse) {
  Make("<AssistedTeleop error_code_id=\"{code}\" error_msg=\"{why}\"/>");
  EXPECT_EQ(Run(1), 'F');
  EXPECT_EQ(Entry<int>("code"), 730);
  EXPECT_EQ(Entry<std::string>("why"), "robot_0 has no topic for a person");
  robot.has_teleop = true;
  robot.stops = 0;
  EXPECT_EQ(Run(9), 'R');
  EXPECT_EQ(robot.stops, 0) << "it commands nothing";
  EXPECT_EQ(Run(2), 'F');
  EXPECT_EQ(Entry<int>("code"), 731);
  Make("<Both><AssistedTeleop time_allowance=\"5\"/><FollowPath path=\"{path}\"/></Both>");
  SetPath({{0, 0}, {2, 0}});
  EXPECT_EQ(Run(4), 'R');
  EXPECT_EQ(robot.drives, 0);
}
TEST_F(ANav2Tree, StandsWhereATreeCancelsItsMotion) {
  Make(
      "<Both><Spin spin_dist=\"50\" time_allowance=\"90\" error_code_id=\"{code}\"/>"
      "<Sequence><Wait wait_duration=\"2\"/><CancelSpin/></Sequence></Both>");
  EXPECT_EQ(Run(2.5), 'F');
  EXPECT_EQ(Entry<int>("code"), 700);
  for (int i = 0; i < 10; ++i) robot.Advance(Milliseconds(100));
  EXPECT_TRUE(robot.Rests());
}
TEST_F(ANav2Tree, KnowsThatItIsStuckAndWhenItHasStopped) {
  Make("<ReactiveFallback><IsStuck/><FollowPath path=\"{path}\"/></ReactiveFallback>");
  SetPath({{0, 0}, {9, 0}});
  robot.drive_speed_m_s = 0.5;
  EXPECT_EQ(Run(5), 'R');
  robot.drive_speed_m_s = 0;
  EXPECT_EQ(Run(4), 'S');
  EXPECT_NEAR(robot.at.at.x_m, 2.5, 0.5);
  robot.drive_speed_m_s = 1;
  for (int i = 0; i < 20; ++i) robot.Advance(Milliseconds(100));
  Make(
      "<Sequence><Timeout msec=\"1000\"><Spin spin_dist=\"9\" time_allowance=\"90\"/></Timeout>"
      "</Sequence>");
  EXPECT_EQ(Run(2), 'F');
  Make("<IsStopped duration_stopped=\"500\"/>");
  EXPECT_EQ(Run(0.1), 'F') << "it turns";
  for (int i = 0; i < 10; ++i) robot.Advance(Milliseconds(100));
  EXPECT_EQ(Run(0.4), 'R');
  EXPECT_EQ(Run(0.3), 'S');
  robot.odometry_up = false;
  EXPECT_EQ(Run(0.1), 'F');
}
TEST_F(ANav2Tree, KnowsItsBatteryItsFramesAndTheCallsThatItsProgramNotes) {
  Make("<IsBatteryLow min_battery=\"0.2\" battery_topic=\"/battery_status\"/>");
  EXPECT_EQ(Run(0.1), 'F');
  robot.level = skills::BatteryLevel{.share = 0.15};
  EXPECT_EQ(Run(0.1), 'S');
  Make("<IsBatteryLow min_battery=\"24\" is_voltage=\"true\"/>");
  EXPECT_EQ(Run(0.1), 'F');
  robot.level = skills::BatteryLevel{.share = 0.15, .voltage_v = 23.5, .charges = true};
  EXPECT_EQ(Run(0.1), 'S');
  Make("<IsBatteryCharging/>");
  EXPECT_EQ(Run(0.1), 'S');
  Make("<TransformAvailable child=\"base_link\" parent=\"map\"/>");
  EXPECT_EQ(Run(0.1), 'S');
  Make(
      "<PauseResumeController pause_service_name=\"/pause\" resume_service_name=\"/resume\">"
      "<FollowPath path=\"{path}\"/></PauseResumeController>");
  SetPath({{0, 0}, {4, 0}});
  EXPECT_EQ(Run(1), 'R');
  nav2.NoteCall("/pause");
  EXPECT_EQ(Run(10), 'R');
  EXPECT_TRUE(robot.Rests());
  nav2.NoteCall("/resume");
  EXPECT_EQ(Run(10), 'S');
  EXPECT_NEAR(robot.at.at.x_m, 4, 0.01);
}

class ACheckOfPlaces : public ANav2Tree {
 protected:
  // 10 x 10 m, with a wall of 0.5 m from x = 5 m on; not known from x = 8 m on.
  ACheckOfPlaces() {
    auto map = std::make_shared<navigation::CellMap>();
    map->resolution_m = 0.1;
    map->size_x = map->size_y = 100;
    map->blocked.assign(10000, 0);
    for (int y = 0; y < 100; ++y) {
      for (int x = 50; x < 55; ++x) map->blocked[map->IndexOf({x, y, 0})] = 1;
    }
    auto known = std::make_shared<navigation::CellMap>(*map);
    for (int y = 0; y < 100; ++y) {
      for (int x = 80; x < 100; ++x) known->blocked[map->IndexOf({x, y, 0})] = 1;
    }
    robot.ground_map = {false, map, true, known};
  }
  // 'S': it is occupied.
  char Check(const std::string& pose, const std::string& ports = "") {
    Make("<CheckPoseOccupancy pose=\"" + pose + "\" error_msg=\"{why}\" " + ports + "/>");
    return Run(0.1);
  }
};
TEST_F(ACheckOfPlaces, GoesByTheMapForTheRadiusOfTheBody) {
  EXPECT_EQ(Check("4.79;5;0"), 'F');
  EXPECT_EQ(Check("4.81;5;0"), 'S') << "0.2 m from the wall";
  EXPECT_EQ(Check("4.95;5;0", "use_footprint=\"false\""), 'F');
  EXPECT_EQ(Check("5.05;5;0", "use_footprint=\"false\""), 'S');
  EXPECT_EQ(Check("4.9;5;0", "use_footprint=\"false\" cost_threshold=\"253\""), 'S');
}
TEST_F(ACheckOfPlaces, GoesByWhatTheScanSeesNow) {
  EXPECT_EQ(Check("2;2;0"), 'F');
  robot.points = {{2.15, 2, 0}};
  EXPECT_EQ(Check("2;2;0"), 'S');
  EXPECT_EQ(Check("2;2;0", "use_footprint=\"false\""), 'F');
  robot.ground_map = {};
  EXPECT_EQ(Check("2;2;0"), 'S');
  EXPECT_EQ(Check("4;2;0"), 'F');
}
TEST_F(ACheckOfPlaces, CountsWhatIsNotKnownWhereTheTreeSaysSo) {
  const std::string unknown = "consider_unknown_as_obstacle=\"true\"";
  EXPECT_EQ(Check("9;5;0"), 'F');
  EXPECT_EQ(Check("9;5;0", unknown), 'S');
  EXPECT_EQ(Check("12;5;0"), 'F') << "outside the map";
  EXPECT_EQ(Check("12;5;0", unknown), 'S');
}
TEST_F(ACheckOfPlaces, WaitsForItsMapAndTakesPlacesForOccupiedWithoutOne) {
  robot.ground_map = {true, nullptr, true};
  EXPECT_EQ(Check("2;2;0"), 'R');
  robot.ground_map = {false, nullptr, true};
  EXPECT_EQ(Run(0.1), 'S');
  EXPECT_EQ(Entry<std::string>("why"), "no map has come");
  robot.ground_map = {};
  robot.scan_up = false;
  EXPECT_EQ(Check("2;2;0"), 'S');
  EXPECT_EQ(Entry<std::string>("why"), "there is no map, and no scan of robot_0");
  robot.robot_kind = "cf2x";
  EXPECT_EQ(Check("2;2;0"), 'S');
}
TEST_F(ACheckOfPlaces, LeavesGoalsOutThatAreOccupied) {
  Make("<RemoveInCollisionGoals input_goals=\"{goals}\" output_goals=\"{free}\"/>");
  ASSERT_TRUE(tree->board().Set(
      "goals", tree::nav2::Goals{{Pose{.x_m = 1, .y_m = 1}, Pose{.x_m = 5.2, .y_m = 1}}}));
  EXPECT_EQ(Run(0.1), 'S');
  EXPECT_EQ(Entry<tree::nav2::Goals>("free"), (tree::nav2::Goals{{Pose{.x_m = 1, .y_m = 1}}}));
}

}  // namespace musher::tree_robot_test
