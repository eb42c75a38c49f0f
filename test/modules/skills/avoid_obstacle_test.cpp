// avoid_obstacle: past obstacles, never into one, and the end where there is no path.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include "musher/modules/skills/skills/vector_field.hpp"
#include "musher/test/modules/skills/moving_robot.hpp"

namespace musher::avoid_obstacle_test {

using skill::Status;
using skills::FieldRules;
using skills::FreeAhead;
using skills::FreeDirection;
using skills::testing::MovingRobot;
using skills::testing::SkillsOnARobot;
using ::testing::StartsWith;

using Texts = std::vector<std::pair<std::string, std::string>>;

void AddWall(MovingRobot& robot, double x0, double y0, double x1, double y1) {
  const int count = static_cast<int>(std::hypot(x1 - x0, y1 - y0) / 0.05) + 1;
  for (int i = 0; i <= count; ++i) {
    robot.points.push_back({x0 + (x1 - x0) * i / count, y0 + (y1 - y0) * i / count, 0});
  }
}

void AddPillar(MovingRobot& robot, double x, double y, double radius) {
  const int count = std::max(8, static_cast<int>(2 * M_PI * radius / 0.1));
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * M_PI * i / count;
    robot.points.push_back({x + radius * std::cos(angle), y + radius * std::sin(angle), 0});
  }
}

class AvoidObstacle : public ::testing::Test, public SkillsOnARobot {
 protected:
  void Go(const Texts& parameters = {}) {
    const Result<> started = Start("avoid_obstacle", parameters);
    ASSERT_TRUE(started) << started.error().message;
  }
  std::string WhyRefused(const Texts& parameters) {
    Go(parameters);
    Step();
    EXPECT_EQ(feedback().status, Status::kFailed);
    return feedback().message;
  }
};

TEST_F(AvoidObstacle, GoesStraightWhereNothingIs) {
  Go({{"heading", "1.5708"}, {"distance", "2"}});
  EXPECT_TRUE(RunToItsEnd(30));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
  EXPECT_EQ(feedback().message, "Reached goal");
  EXPECT_NEAR(robot.at.at.y_m, 2, 0.15);
  EXPECT_NEAR(robot.at.at.x_m, 0, 0.2);
  EXPECT_TRUE(robot.Rests());
}

TEST_F(AvoidObstacle, CountsNoJumpOfItsPoseAsWay) {
  for (const bool by_odometry : {false, true}) {
    robot.at = {};
    robot.corrected = {};
    robot.travelled_m = 0;
    Go({{"distance", "3"}});
    RunFor(3);
    const double jump_m = by_odometry ? 2.5 : 0.8;
    robot.at.at.x_m += jump_m;
    if (!by_odometry) robot.corrected = {jump_m, 0, 0};
    EXPECT_TRUE(RunToItsEnd(60));
    EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
    EXPECT_NEAR(robot.travelled_m, 3, 0.3) << by_odometry;
  }
}

TEST_F(AvoidObstacle, PassesAPillarOnItsWay) {
  AddPillar(robot, 2, 0.05, 0.3);
  Go({{"goal_pos", "[4, 0]"}});
  EXPECT_TRUE(RunToItsEnd(60));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
  EXPECT_LT(std::hypot(robot.at.at.x_m - 4, robot.at.at.y_m), 0.25);
  EXPECT_GT(robot.nearest_m, robot.radius_m());
}

TEST_F(AvoidObstacle, GoesThroughADoor) {
  AddWall(robot, 2, -3, 2, -0.1);
  AddWall(robot, 2, 0.9, 2, 3);
  Go({{"goal_pos", "[4, 0.4]"}});
  EXPECT_TRUE(RunToItsEnd(60));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
  EXPECT_GT(robot.nearest_m, robot.radius_m());
}

TEST_F(AvoidObstacle, StandsWhenItIsBlockedAndFailsLater) {
  AddPillar(robot, 0, 0, 0.4);
  Go();
  RunFor(5);
  EXPECT_TRUE(robot.Rests());
  EXPECT_THAT(feedback().message, StartsWith("Blocked ("));
  EXPECT_TRUE(RunToItsEnd(8));
  EXPECT_EQ(feedback().message, "Blocked: no free direction for 10.0 s");
  EXPECT_EQ(robot.travelled_m, 0);
}

TEST_F(AvoidObstacle, GoesOnWhenItIsFreeAgain) {
  AddPillar(robot, 0, 0, 0.4);
  Go();
  RunFor(8);
  robot.points.clear();
  EXPECT_TRUE(RunToItsEnd(30));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
}

TEST_F(AvoidObstacle, GivesUpInADeadEnd) {
  AddWall(robot, 2, -1, 2, 1);
  AddWall(robot, -0.5, 1, 2, 1);
  AddWall(robot, -0.5, -1, 2, -1);
  Go({{"goal_pos", "[4, 0]"}});
  EXPECT_TRUE(RunToItsEnd(130));
  EXPECT_EQ(feedback().status, Status::kFailed);
  EXPECT_THAT(feedback().message, StartsWith("Blocked: not nearer to the goal for 30.0 s"));
  EXPECT_GT(robot.nearest_m, robot.radius_m());
}

TEST_F(AvoidObstacle, FailsWithoutAScan) {
  robot.scan_up = false;
  Go();
  EXPECT_TRUE(RunToItsEnd(3));
  EXPECT_EQ(feedback().message, "No scan of robot_0");
  robot.scan_up = true;
  Go();
  RunFor(3);
  robot.scan_up = false;
  RunFor(1);
  EXPECT_TRUE(robot.Rests());
  EXPECT_TRUE(RunToItsEnd(3));
  EXPECT_EQ(feedback().message, "No scan of robot_0");
}

TEST_F(AvoidObstacle, HasALimitOfTime) {
  Go({{"goal_pos", "[100, 0]"}});
  EXPECT_TRUE(RunToItsEnd(130));
  EXPECT_THAT(feedback().message, StartsWith("Timeout: 6"));
}

TEST_F(AvoidObstacle, StandsInAPauseAndWhenItIsCancelled) {
  Go({{"goal_pos", "[9, 0]"}});
  RunFor(3);
  Pause();
  RunFor(60);
  EXPECT_TRUE(robot.Rests());
  Resume();
  RunFor(3);
  EXPECT_FALSE(robot.Rests());
  ASSERT_TRUE(manager->Cancel("avoid_obstacle", "enough"));
  EXPECT_TRUE(RunToItsEnd(3));
  EXPECT_EQ(feedback().status, Status::kCancelled);
  EXPECT_TRUE(robot.Rests());
}

TEST_F(AvoidObstacle, RefusesParametersThatAreNone) {
  EXPECT_EQ(WhyRefused({{"goal_pos", "[1]"}}),
            "goal_pos has 1 number; expected 2 or 3: x, y and z in the map");
  EXPECT_EQ(WhyRefused({{"speed", "2"}}), "speed is 2 m/s; expected more than 0 and at most 1 m/s");
  EXPECT_EQ(WhyRefused({{"distance", "0"}}), "distance is 0; expected more than 0");
  EXPECT_EQ(WhyRefused({{"blocked_limit", "-1"}}), "blocked_limit is -1; expected more than 0");
  robot.robot_kind = "cf2x";
  EXPECT_EQ(WhyRefused({}), "robot_0 flies; avoid_obstacle is for robots on the ground");
}

TEST(VectorField, TakesTheWantedDirectionWhereItIsFree) {
  EXPECT_EQ(FreeDirection({}, 0.3, 0, {}), 0.3);
  EXPECT_EQ(FreeDirection({{-1, 0, 0}}, 0.3, 0, {}), 0.3);
  EXPECT_EQ(FreeDirection({{5, 0, 0}}, 0, 0, {}), 0);
}

TEST(VectorField, TakesADirectionBesideAnObstacleWithRoom) {
  const FieldRules rules;
  const auto direction = FreeDirection({{1, 0.01, 0}}, 0, 0, rules);
  ASSERT_TRUE(direction);
  EXPECT_LT(*direction, 0);
  EXPECT_GE(std::sin(-*direction), rules.radius_m + rules.margin_m - 0.02);
  EXPECT_GT(FreeDirection({{1, 0.01, 0}}, 0, 0.5, rules), 0);  // it keeps to its side
}

TEST(VectorField, MeasuresTheWayAhead) {
  EXPECT_EQ(FreeAhead({}, 0.2, 0.05, 2), 2);
  EXPECT_NEAR(FreeAhead({{1, 0, 0}}, 0.2, 0.05, 2), 0.75, 1e-9);
  EXPECT_EQ(FreeAhead({{1, 0.3, 0}, {-1, 0, 0}}, 0.2, 0.05, 2), 2);
  EXPECT_EQ(FreeAhead({{0.1, 0, 0}}, 0.2, 0.05, 2), 0);
}

RC_GTEST_PROP(AvoidingRobots, NeverTouchAnObstacleThatStands, ()) {
  SkillsOnARobot skills;
  const int pillars = *rc::gen::inRange(1, 12);
  for (int i = 0; i < pillars; ++i) {
    const double x = *rc::gen::inRange(-100, 500) / 100.0;
    const double y = *rc::gen::inRange(-250, 250) / 100.0;
    const double radius = *rc::gen::inRange(5, 60) / 100.0;
    if (std::hypot(x, y) > radius + 0.3) AddPillar(skills.robot, x, y, radius);
  }
  skills.robot.at.yaw_rad = *rc::gen::inRange(-314, 314) / 100.0;
  const double speed = *rc::gen::inRange(10, 100) / 100.0;
  RC_ASSERT(
      skills.Start("avoid_obstacle", {{"goal_pos", "[4, 0]"}, {"speed", std::to_string(speed)}}));
  RC_ASSERT(skills.RunToItsEnd(150));
  RC_ASSERT(skills.robot.nearest_m > skills.robot.radius_m());
  for (int i = 0; i < 20; ++i) skills.robot.Advance(Milliseconds(100));
  RC_ASSERT(skills.robot.Rests());
  RC_TAG(skills.feedback().status == Status::kCompleted ? "arrived" : skills.message());
}

}  // namespace musher::avoid_obstacle_test
