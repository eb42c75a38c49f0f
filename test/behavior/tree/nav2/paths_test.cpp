// The nodes of nav2 that work on paths and goals.

#include <cmath>
#include <map>

#include "musher/test/behavior/tree/nav2/fake_robot.hpp"

namespace musher::tree::nav2::paths_test {

Pose AtX(double x_m) {
  return {.x_m = x_m};
}

struct Paths : Nav2Tree {
  template <class T>
  T Entry(const std::string& key) {
    return tree->board().Get<T>(key).value();
  }
};

TEST_F(Paths, TruncatePathEndsBeforeTheEndAndLooksAtIt) {
  Make("<TruncatePath distance=\"1.5\" input_path=\"{path}\" output_path=\"{path}\"/>");
  Put("path", Path{{AtX(0), AtX(1), AtX(2), {.x_m = 2, .y_m = 1}}});
  EXPECT_EQ(Next(), "S ");
  ASSERT_EQ(Entry<Path>("path").poses.size(), 2U);
  const Pose last = Entry<Path>("path").poses.back();
  EXPECT_NEAR(Distance(last, {.x_m = 2, .y_m = 1}), 1.5, 1e-9);
  EXPECT_EQ(last.y_m, 0);
  EXPECT_NEAR(last.yaw_rad, std::atan2(1, 2 - last.x_m), 1e-9);
  EXPECT_EQ(Next(), "S ");
  EXPECT_EQ(Entry<Path>("path").poses, std::vector{AtX(0)}) << "all of it is within 1.5 m";
  EXPECT_EQ(Next(), "S ") << "of one pose it stays";
  EXPECT_EQ(Entry<Path>("path").poses.size(), 1U);
  Put("path", Path{});
  EXPECT_EQ(Next(), "S ");
}
TEST_F(Paths, TruncatePathEndsBetweenTwoPosesThatAreFarApart) {
  Make("<TruncatePath distance=\"1\" input_path=\"{path}\" output_path=\"{path}\"/>");
  Put("path", Straight(8));
  EXPECT_EQ(Next(), "S ");
  EXPECT_EQ(Entry<Path>("path"), Straight(7));
}

TEST_F(Paths, TruncatePathLocalTakesWhatIsAroundTheRobot) {
  Make(
      "<TruncatePathLocal input_path=\"{path}\" output_path=\"{part}\" "
      "distance_forward=\"{forward}\" distance_backward=\"{backward}\"/>");
  Put("path", Path{{AtX(0), AtX(4), AtX(10)}});
  Put("forward", 3.0);
  Put("backward", 1.0);
  robot.at = {.x_m = 3, .y_m = 0.5};
  EXPECT_EQ(Next(), "S ");
  EXPECT_EQ(Entry<Path>("part").poses, (std::vector{AtX(2), AtX(4), AtX(6)}));
  Put("forward", -1.0);
  Put("backward", 0.0);
  EXPECT_EQ(Next(), "S ");
  EXPECT_EQ(Entry<Path>("part").poses, (std::vector{AtX(3), AtX(4), AtX(10)}));
  robot.at = AtX(12);
  EXPECT_EQ(Next(), "S ");
  EXPECT_EQ(Entry<Path>("part").poses, std::vector{AtX(10)});
  robot.at.reset();
  EXPECT_EQ(Next(), "F ");
  Put("forward", std::nan(""));
  robot.at = AtX(0);
  EXPECT_EQ(Next(), "! ");
}
TEST_F(Paths, TruncatePathLocalGoesOnWhereThePathCrossesItself) {
  Make(
      "<KeepRunningUntilFailure><TruncatePathLocal input_path=\"{path}\" output_path=\"{part}\" "
      "distance_forward=\"-1\" "
      "distance_backward=\"0\" max_robot_pose_search_dist=\"1.5\"/></KeepRunningUntilFailure>");
  Put("path", Path{{AtX(0), AtX(10), AtX(0)}});
  robot.at = AtX(1);
  EXPECT_EQ(Next(), "R ");
  EXPECT_EQ(LengthOf(Entry<Path>("part")), 19);
  for (const double x_m : {2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 9.0, 8.0}) {
    robot.at = AtX(x_m);
    EXPECT_EQ(Next(), "R ");
  }
  EXPECT_EQ(LengthOf(Entry<Path>("part")), 8) << "on the way back";
  ASSERT_TRUE(tree->Halt(At(now_ms)));
  EXPECT_EQ(Next(), "R ");
  EXPECT_EQ(LengthOf(Entry<Path>("part")), 18.5) << "a new run seeks it from the begin";
}
TEST_F(Paths, TruncatePathLocalFindsThePlaceWithTheDirectionOfAPose) {
  Make(
      "<TruncatePathLocal input_path=\"{path}\" output_path=\"{part}\" distance_forward=\"-1\" "
      "distance_backward=\"0\" pose=\"{pose}\" angular_distance_weight=\"1\"/>");
  Put("path", Path{{AtX(0), {.x_m = 10, .yaw_rad = M_PI}, AtX(0)}});
  Put("pose", Pose{.x_m = 4, .yaw_rad = -M_PI});
  EXPECT_EQ(Next(), "S ");
  EXPECT_EQ(LengthOf(Entry<Path>("part")), 4);
}

TEST_F(Paths, AGoalIsNearbyByTheLengthOfThePathThatIsLeft) {
  Make("<IsGoalNearby path=\"{path}\" proximity_threshold=\"4\"/>");
  EXPECT_EQ(Next(), "F ") << "there is no path";
  Put("path", Path{{AtX(0), AtX(8), {.x_m = 8, .y_m = 3}}});
  robot.at = {.x_m = 5, .y_m = 1};
  EXPECT_EQ(Next(), "F ") << "6 m are left, also where the next pose is nearer";
  robot.at = AtX(7.5);
  EXPECT_EQ(Next(), "S ");
  robot.at.reset();
  EXPECT_EQ(Next(), "F ");
}
TEST_F(Paths, AGoalIsNotNearbyWhereThePathPassesItBefore) {
  Make(
      "<IsGoalNearby path=\"{path}\" proximity_threshold=\"4\" "
      "max_robot_pose_search_dist=\"1.5\"/>");
  Put("path", Path{{AtX(0), AtX(10), AtX(0.1)}});
  robot.at = AtX(0.1);
  EXPECT_EQ(Next(), "F ");
}

TEST_F(Paths, AreJoinedAndReadByTheIndexOfAPose) {
  Make(
      "<Sequence><ConcatenatePaths input_path1=\"{a}\" input_path2=\"{b}\" output_path=\"{a}\"/>"
      "<GetPoseFromPath path=\"{a}\" index=\"{index}\" pose=\"{pose}\"/></Sequence>");
  EXPECT_EQ(Next(), "F ") << "both are empty";
  Put("a", Path{{AtX(1), AtX(2)}});
  Put("b", Path{{AtX(3)}});
  Put("index", -1);
  EXPECT_EQ(Next(), "S ");
  EXPECT_EQ(Entry<Pose>("pose"), AtX(3));
  EXPECT_EQ(Entry<Path>("a").poses.size(), 3U);
  Put("b", Path{});
  Put("index", 0);
  EXPECT_EQ(Next(), "S ");
  EXPECT_EQ(Entry<Pose>("pose"), AtX(1));
  for (const int outside : {3, -4}) {
    Put("index", outside);
    EXPECT_EQ(Next(), "F ") << outside;
  }
}

TEST_F(Paths, RemovePassedGoalsKeepsTheLastOne) {
  Make("<RemovePassedGoals input_goals=\"{goals}\" output_goals=\"{goals}\" radius=\"0.7\"/>");
  Put("goals", Goals{{AtX(0), AtX(0.6), AtX(2), AtX(0)}});
  EXPECT_EQ(Next(), "S ");
  EXPECT_EQ(Entry<Goals>("goals").poses, (std::vector{AtX(2), AtX(0)}));
  robot.at = AtX(2);
  EXPECT_EQ(Next(), "S ");
  robot.at = AtX(0);
  EXPECT_EQ(Next(), "S ");
  EXPECT_EQ(Entry<Goals>("goals").poses, std::vector{AtX(0)});
  robot.at.reset();
  EXPECT_EQ(Next(), "F ") << "it is not known where the robot is";
  Put("goals", Goals{});
  EXPECT_EQ(Next(), "S ");
}

TEST_F(Paths, TheNextFewGoalsAndAGoalBehindThem) {
  Make(
      "<Sequence>"
      "<AppendGoalPoseToGoals input_goals=\"{g}\" goal_pose=\"9;0;0\" output_goals=\"{g}\"/>"
      "<GetNextFewGoals input_goals=\"{g}\" num_goals=\"2\" output_goals=\"{few}\"/></Sequence>");
  EXPECT_EQ(Next(), "S ");
  EXPECT_EQ(Entry<Goals>("few").poses, std::vector{AtX(9)});
  Put("g", Goals{{AtX(1), AtX(2)}});
  EXPECT_EQ(Next(), "S ");
  EXPECT_EQ(Entry<Goals>("few").poses, (std::vector{AtX(1), AtX(2)}));
  EXPECT_EQ(Entry<Goals>("g").poses.size(), 3U);
}

TEST_F(Paths, GetCurrentPoseFailsWhereItIsNotKnown) {
  Make("<GetCurrentPose current_pose=\"{pose}\"/>");
  robot.at = AtX(4);
  EXPECT_EQ(Next(), "S ");
  EXPECT_EQ(Entry<Pose>("pose"), AtX(4));
  robot.at.reset();
  EXPECT_EQ(Next(), "F ");
}

TEST_F(Paths, APathThroughPlacesIsPlannedPartByPart) {
  Make(
      "<ComputePathThroughPoses goals=\"{goals}\" path=\"{path}\" planner_id=\"grid\" "
      "error_code_id=\"{code}\" error_msg=\"{why}\"/>");
  Put("goals", Goals{{AtX(2), AtX(5)}});
  EXPECT_EQ(Next(), "R ");
  EXPECT_EQ(robot.Take(), "plan to 2 by grid; ");
  robot.ends["plan"] = {.success = true, .path = {{AtX(2), AtX(2)}}};
  EXPECT_EQ(Next(), "S ");
  EXPECT_EQ(robot.Take(), "plan to 5 from 2 by grid; ");
  EXPECT_EQ(Entry<Path>("path").poses.size(), 3U) << "a part begins where the last one ends";
  EXPECT_EQ(Entry<int>("code"), 0);
  robot.ends["plan"] = {.error_code = kNoValidPath, .error = "walled in"};
  EXPECT_EQ(Next(), "F ");
  EXPECT_EQ(Entry<Path>("path"), Path{});
  EXPECT_EQ(Entry<int>("code"), 308);
  EXPECT_EQ(Entry<std::string>("why"), "place 1 of 2: walled in");
  Put("goals", Goals{});
  EXPECT_EQ(Next(), "F ");
  EXPECT_EQ(Entry<int>("code"), kNoPlacesGiven);
}

TEST_F(Paths, APathThroughPlacesIsCancelledInAHalt) {
  Make("<ComputePathThroughPoses goals=\"{goals}\" path=\"{path}\"/>");
  Put("goals", Goals{{AtX(2), AtX(5)}});
  EXPECT_EQ(Next(), "R ");
  ASSERT_TRUE(tree->Halt(At(now_ms)));
  EXPECT_EQ(robot.Take(), "plan to 2; plan! ");
}

TEST_F(Paths, APathIsValidWhereTheRobotSeesThatItIsFree) {
  for (const std::string name : {"IsPathValid", "ValidatePath"}) {
    Make("<" + name + " path=\"{path}\" max_lookahead_distance=\"{ahead}\"/>");
    Put("ahead", -1.0);
    EXPECT_EQ(Next(), "F ") << "there is none";
    Put("path", Straight(3));
    robot.sees_free = true;
    EXPECT_EQ(Next(), "S ");
    EXPECT_EQ(robot.seen_path, Straight(3));
    robot.sees_free = false;
    EXPECT_EQ(Next(), "F ");
    robot.at = AtX(1);
    Put("ahead", 0.5);
    EXPECT_EQ(Next(), "F ");
    EXPECT_EQ(robot.seen_path.poses, (std::vector{AtX(1), AtX(1.5)}));
  }
}
TEST_F(Paths, AFootprintForAPathIsWarnedOf) {
  EXPECT_THAT(
      Findings(Main("<IsPathValid path=\"{path}\" footprint=\"[[1,1],[1,-1],[-1,0]]\"/>"), factory),
      testing::HasSubstr("'footprint' has no effect: the radius of the robot counts"));
  EXPECT_EQ(Findings(Main("<IsPathValid path=\"{path}\" footprint=\"\"/>"), factory), "");
}

TEST_F(Paths, CancelControlFailsWhereThereIsNoController) {
  Make("<CancelControl/>");
  EXPECT_EQ(Next(), "S ");
  EXPECT_EQ(robot.Take(), "cancel drives; ");
  robot.has_tasks = false;
  EXPECT_EQ(Next(), "F ");
}

TEST_F(Paths, ARecoveryMayHelpAPlannerThatFailsOnItsWayThroughPlaces) {
  Make(
      "<Fallback><ComputePathThroughPoses goals=\"{goals}\" error_code_id=\"{code}\"/>"
      "<WouldAPlannerRecoveryHelp error_code=\"{code}\"/></Fallback>");
  Put("goals", Goals{{AtX(2)}});
  const std::map<std::uint16_t, std::string> expected = {
      {kNoError, "S "},      {kPlannerTimeout, "S "}, {kNoValidPath, "S "},
      {kGoalOccupied, "F "}, {kPlannerPose, "F "},    {kGoalOutside, "F "}};
  for (const auto& [code, letter] : expected) {
    robot.ends["plan"] = {.error_code = code};
    EXPECT_EQ(Next(), letter) << code;
  }
}

// As nav2's tree that checks the bounds of a drive.
struct TrackingBounds : Paths {
  TrackingBounds() {
    Make(
        "<ReactiveSequence><IsWithinPathTrackingBounds max_error_left=\"{left}\" "
        "max_error_right=\"{right}\" max_error_heading=\"{turn}\" tracking_feedback=\"{t}\"/>"
        "<FollowPath path=\"{path}\" tracking_feedback=\"{t}\"/></ReactiveSequence>");
    Put("left", 0.2);
    Put("right", 0.4);
    Put("turn", 1.0);
    Put("path", Path{{AtX(0), AtX(10), {.x_m = 10, .y_m = 10}}});
  }
  // Of the tick in which they are checked: that after the robot was there.
  std::string At(const Pose& pose) {
    robot.at = pose;
    Next();
    const std::string letter = Next();
    tree->Halt(tree::At(now_ms)).ok();
    return letter;
  }
};
TEST_F(TrackingBounds, HoldOnEachSideOfThePath) {
  EXPECT_EQ(At({.x_m = 4, .y_m = 0.19}), "R ");
  EXPECT_EQ(At({.x_m = 4, .y_m = 0.21}), "F ");
  EXPECT_EQ(At({.x_m = 4, .y_m = -0.39}), "R ");
  EXPECT_EQ(At({.x_m = 4, .y_m = -0.41}), "F ");
  EXPECT_EQ(At({.x_m = 9.7, .y_m = 4, .yaw_rad = 1.57}), "F ") << "to the left of the second line";
  EXPECT_EQ(At({.x_m = 10.3, .y_m = 4, .yaw_rad = 1.57}), "R ");
}
TEST_F(TrackingBounds, HoldForTheDirection) {
  EXPECT_EQ(At({.x_m = 4, .yaw_rad = 0.9}), "R ");
  EXPECT_EQ(At({.x_m = 4, .yaw_rad = -1.1}), "F ");
  EXPECT_EQ(At({.x_m = 10, .y_m = 4, .yaw_rad = M_PI / 2 + 2 * M_PI}), "R ");
}
TEST_F(TrackingBounds, BeginAgainWithTheNextDrive) {
  robot.at = {.x_m = 4, .y_m = 1};
  EXPECT_EQ(Next(), "R ") << "nothing is known before the drive";
  EXPECT_NEAR(Entry<Tracking>("t").off_m, 1, 1e-9);
  EXPECT_NEAR(Entry<Tracking>("t").left_m, 16, 1e-9);
  EXPECT_EQ(Next(), "F ");
  robot.at = AtX(5);
  EXPECT_EQ(Next(), "R ") << "what was known of the drive before counts no more";
  EXPECT_EQ(Next(), "R ");
}
TEST_F(TrackingBounds, AreThoseOfThePlaceOnAPathThatCrossesItself) {
  Put("path", Path{{AtX(0), AtX(10), {.x_m = 5, .y_m = 5}, {.x_m = 5, .y_m = -5}}});
  robot.at = AtX(4);
  EXPECT_EQ(Next(), "R ");
  robot.at = {.x_m = 5, .y_m = 0.3};
  EXPECT_EQ(Next(), "R ");
  EXPECT_NEAR(Entry<Tracking>("t").off_m, 0.3, 1e-9) << "not on the line that comes later";
  EXPECT_EQ(Next(), "F ");
}
TEST_F(TrackingBounds, RefuseWhatIsNoNumber) {
  Put("left", std::nan(""));
  EXPECT_EQ(Next(), "! ");
}

}  // namespace musher::tree::nav2::paths_test
