// navigate_to and move at an obstacle that stays: they wait, plan again, and fail in the end.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "musher/test/modules/skills/moving_robot.hpp"

namespace musher::blocked_way_test {

using skill::Status;
using skills::testing::SkillsOnARobot;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class BlockedWay : public ::testing::Test, public SkillsOnARobot {
 protected:
  void GoTo(const std::string& place) {
    const Result<> started = Start("navigate_to", {{"goal_pos", place}});
    ASSERT_TRUE(started) << started.error().message;
  }
  void ExpectFailure(double seconds, const std::string& message) {
    EXPECT_TRUE(RunToItsEnd(seconds)) << feedback().state;
    EXPECT_EQ(feedback().status, Status::kFailed);
    EXPECT_THAT(feedback().message, HasSubstr(message));
    for (int i = 0; i < 20; ++i) robot.Advance(Milliseconds(100));
    EXPECT_TRUE(robot.Rests());
  }
};

// A door that is closed, behind which the goal is: the planner's path leads through it.
TEST_F(BlockedWay, FailsAfterOneMinuteAtAnObstacleThatStays) {
  robot.blocked = [](const navigation::Point& at) { return at.x_m > 2; };
  GoTo("[4, 0]");
  RunFor(60);
  EXPECT_EQ(feedback().status, Status::kProcessing) << feedback().message;
  ExpectFailure(60, " s, 2.5 m from the goal, at (1.5");
  EXPECT_THAT(feedback().message, StartsWith("Blocked for 6"));
  EXPECT_THAT(feedback().message, HasSubstr("0.00): an obstacle stays in the way"));
  EXPECT_GE(run().replans(), 8);
}

// It stood before them until "Blocked for 62 s": a person who yields waits for the robot, and the
// robot for the person. On the robot's side of the door, at x = 2, the person steps aside.
TEST_F(BlockedWay, BacksUpSoThatAPersonWhoYieldsGetsRoom) {
  double person_m = 3;
  bool person_comes = false;
  std::set<std::string> texts;
  robot.blocked = [&](const navigation::Point& at) { return person_m > 2 && at.x_m > person_m; };
  EachStep([&] {
    constexpr double kYieldsM = 0.55;
    if (robot.at.at.x_m > 2.4) person_comes = true;
    if (person_comes) person_m = std::max(2.0, std::min(person_m, robot.at.at.x_m + kYieldsM));
    texts.insert(feedback().message);
  });
  GoTo("[6, 0]");
  EXPECT_TRUE(RunToItsEnd(90));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
  EXPECT_TRUE(texts.contains("Blocked: back_up"));
}

// A path around the person would be wrong before the robot has turned onto it.
TEST_F(BlockedWay, LetsAPersonPassBeforeItPlansAgain) {
  bool crosses = false;
  robot.blocked = [&](const navigation::Point& at) { return crosses && at.x_m > 2; };
  EachStep([&] {
    crosses = robot.at.at.x_m > 1 && robot.Now() < Time{} + std::chrono::seconds(8);
    robot.points.clear();
    if (crosses) robot.points = {{2.3, -0.1, 0}, {2.2, 0, 0}, {2.3, 0.1, 0}};
  });
  GoTo("[6, 0]");
  EXPECT_TRUE(RunToItsEnd(30));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
  EXPECT_EQ(robot.plans, 1);
  EXPECT_GE(robot.drives, 2);
}

TEST_F(BlockedWay, StandsWithoutRecoveriesAndWhereTheGateHoldsIt) {
  robot.blocked = [](const navigation::Point& at) { return at.x_m > 2; };
  for (const bool held : {false, true}) {
    robot.at = {};
    robot.held_by = held ? "an obstacle 0.22 m away, straight behind, stops it" : "";
    ASSERT_TRUE(
        Start("navigate_to", {{"goal_pos", "[4, 0]"}, {"recoveries", held ? "back_up" : ""}}));
    ASSERT_TRUE(RunToState("EXECUTING"));
    RunFor(5);
    const double before_m = robot.travelled_m;
    EXPECT_TRUE(RunToItsEnd(120));
    EXPECT_THAT(feedback().message, StartsWith("Blocked for 6"));
    EXPECT_NEAR(robot.travelled_m, before_m, 0.01);
  }
}

// A scanner that looks ahead sees no person behind the robot, and one may stand there.
TEST_F(BlockedWay, DoesNotBackUpWhereItsScanCoversNothing) {
  robot.blocked = [](const navigation::Point& at) { return at.x_m > 2; };
  robot.scan_covers_rad = M_PI / 2;
  std::set<std::string> texts;
  EachStep([&] { texts.insert(feedback().message); });
  GoTo("[4, 0]");
  RunFor(5);
  const double before_m = robot.travelled_m;
  ExpectFailure(120, " s, 2.5 m from the goal, at (1.5");
  EXPECT_NEAR(robot.travelled_m, before_m, 0.01);
  EXPECT_TRUE(
      texts.contains("back_up: it does not go backwards: no scan covers what is behind it"));
}

TEST_F(BlockedWay, DoesInTurnWhatItsParametersListAndFailsAfterTheirLimit) {
  robot.blocked = [](const navigation::Point& at) { return at.x_m > 2; };
  std::vector<std::string> order;
  std::optional<double> first_s;
  EachStep([&] {
    const std::string text = feedback().message;
    if (!text.starts_with("Blocked: ")) return;
    if (!first_s) first_s = ToSeconds(run().now());
    if (order.empty() || order.back() != text.substr(9)) order.push_back(text.substr(9));
  });
  ASSERT_TRUE(Start("navigate_to", {{"goal_pos", "[4, 0]"},
                                    {"at_obstacle", "clear, wait, back_up"},
                                    {"blocked_after", "3"},
                                    {"blocked_again", "2"},
                                    {"blocked_limit", "20"}}));
  ExpectFailure(120, "Blocked for 2");
  ASSERT_GE(order.size(), 4U);
  EXPECT_EQ(order[0], "clear");
  EXPECT_EQ(order[1], "wait");
  EXPECT_EQ(order[2], "back_up");
  EXPECT_EQ(order[3], "clear") << "and from the begin again";
  EXPECT_GT(robot.cleared, 0);
  EXPECT_LT(*first_s, 12);
}

// Its limit had not counted the waits: it stood there three times as long.
TEST_F(BlockedWay, CountsWhatItWaitsTowardsItsLimit) {
  robot.blocked = [](const navigation::Point& at) { return at.x_m > 2; };
  ASSERT_TRUE(Start("navigate_to", {{"goal_pos", "[4, 0]"},
                                    {"at_obstacle", "wait"},
                                    {"blocked_after", "1"},
                                    {"blocked_again", "1"},
                                    {"blocked_limit", "20"}}));
  ExpectFailure(35, "Blocked for 2");
}

TEST_F(BlockedWay, RefusesLimitsAndRecoveriesThatAreNone) {
  const auto why = [this](const std::string& name, const std::string& value) {
    EXPECT_TRUE(Start("navigate_to", {{"goal_pos", "[4, 0]"}, {name, value}}));
    Step();
    EXPECT_EQ(feedback().status, Status::kFailed);
    return feedback().message;
  };
  EXPECT_EQ(why("blocked_limit", "-1"), "blocked_limit is -1; expected 0 to 1000000 seconds");
  EXPECT_EQ(why("blocked_again", "1e9"), "blocked_again is 1e+09; expected 0 to 1000000 seconds");
  EXPECT_THAT(why("at_obstacle", "dance"), StartsWith("at_obstacle has 'dance'; expected "));
}

TEST_F(BlockedWay, GoesOnWhenAnObstacleLeavesInTime) {
  for (int door = 0; door < 3; ++door) {
    const double door_m = 2.0 + door;
    bool closed = true;
    robot.at = {};
    robot.blocked = [&](const navigation::Point& at) { return closed && at.x_m > door_m; };
    GoTo("[6, 0]");
    RunFor(50);
    EXPECT_EQ(feedback().status, Status::kProcessing) << feedback().message;
    closed = false;
    EXPECT_TRUE(RunToItsEnd(20));
    EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
  }
}

// Doors on the way, each closed for 50 s once the robot is there.
TEST_F(BlockedWay, WaitsAgainAtEachObstacle) {
  double door_m = 2;
  robot.blocked = [&](const navigation::Point& at) { return at.x_m > door_m; };
  GoTo("[8, 0]");
  for (; door_m < 8; door_m += 2) RunFor(50);
  EXPECT_TRUE(RunToItsEnd(20));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
}

// Between two closed doors the planner sends the robot from one to the other.
TEST_F(BlockedWay, FailsAlsoWhenItIsSentFromObstacleToObstacle) {
  const navigation::Point doors[] = {{3, 2, 0}, {3, -2, 0}};
  robot.blocked = [](const navigation::Point& at) { return at.x_m > 2.9; };
  robot.plan = [&](const auto& start, const auto& goal) -> Result<navigation::Path> {
    return navigation::Path{start, {doors[robot.plans % 2], 0}, goal};
  };
  GoTo("[6, 0]");
  ExpectFailure(300, "an obstacle stays in the way");
}

TEST_F(BlockedWay, EndsAMoveToo) {
  robot.blocked = [](const navigation::Point& at) { return at.x_m > 2; };
  ASSERT_TRUE(Start("move", {{"path", "[[1, 0], [4, 0]]"}, {"loops", "1"}}));
  EXPECT_TRUE(RunToItsEnd(120));
  EXPECT_EQ(feedback().status, Status::kFailed);
  EXPECT_THAT(feedback().message, StartsWith("Way-point 2 of 2: Blocked for 6"));
  EXPECT_TRUE(robot.Rests());
}

}  // namespace musher::blocked_way_test
