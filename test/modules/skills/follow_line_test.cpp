// follow_line: straight, in a bend, lost and found.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/test/modules/skills/moving_robot.hpp"

namespace musher::follow_line_test {

using skill::Status;
using skills::Robot;
using skills::testing::SkillsOnARobot;
using ::testing::StartsWith;

using Texts = std::vector<std::pair<std::string, std::string>>;

// A circle around the origin, to the left; seen up to 0.6 m to the side.
constexpr double kRadiusM = 4;

std::optional<Robot::Line> Circle(const navigation::Pose& pose) {
  const double distance = std::hypot(pose.at.x_m, pose.at.y_m);
  const double along = std::atan2(pose.at.y_m, pose.at.x_m) + M_PI / 2;
  Robot::Line line;
  line.offset_m = distance - kRadiusM;
  line.heading_rad = navigation::Wrapped(along - pose.yaw_rad);
  if (std::abs(line.offset_m) > 0.6 || std::abs(line.heading_rad) > 1) return std::nullopt;
  return line;
}

class FollowLine : public ::testing::Test, public SkillsOnARobot {
 protected:
  FollowLine() {
    robot.at = {{kRadiusM, 0, 0}, M_PI / 2};
    robot.see_line = Circle;
  }
  void Go(const Texts& parameters = {}) {
    const Result<> started = Start("follow_line", parameters);
    ASSERT_TRUE(started) << started.error().message;
  }
  double OffLine() const {
    return std::abs(std::hypot(robot.at.at.x_m, robot.at.at.y_m) - kRadiusM);
  }
  std::string WhyRefused(const Texts& parameters) {
    Go(parameters);
    Step();
    EXPECT_EQ(feedback().status, Status::kFailed);
    return feedback().message;
  }
};

TEST_F(FollowLine, StaysOnTheLineForItsDistance) {
  double farthest = 0;
  double fastest = 0;
  Go({{"distance", "25"}});
  EachStep([&] {
    farthest = std::max(farthest, OffLine());
    fastest = std::max(fastest, navigation::Speed(robot.velocity()));
  });
  EXPECT_TRUE(RunToItsEnd(150));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
  EXPECT_THAT(feedback().message, StartsWith("Followed the line for 25."));
  EXPECT_LT(farthest, 0.1);
  EXPECT_LE(fastest, 0.31);
  EXPECT_NEAR(robot.travelled_m, 25, 0.2);
  EXPECT_TRUE(robot.Rests());
}

TEST_F(FollowLine, CountsNoJumpOfItsPoseAsWay) {
  for (const bool by_odometry : {false, true}) {
    robot.at = {{kRadiusM, 0, 0}, M_PI / 2};
    robot.corrected = {};
    robot.travelled_m = 0;
    Go({{"distance", "10"}});
    RunFor(5);
    const double turned_rad = by_odometry ? 1 : 0.2;  // along the circle, 4 m or 0.8 m
    const navigation::Pose was = robot.at;
    robot.at.at.x_m = std::cos(turned_rad) * was.at.x_m - std::sin(turned_rad) * was.at.y_m;
    robot.at.at.y_m = std::sin(turned_rad) * was.at.x_m + std::cos(turned_rad) * was.at.y_m;
    robot.at.yaw_rad = navigation::Wrapped(was.yaw_rad + turned_rad);
    if (!by_odometry) {
      robot.corrected = {robot.at.at.x_m - was.at.x_m, robot.at.at.y_m - was.at.y_m, 0};
    }
    EXPECT_TRUE(RunToItsEnd(150));
    EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
    EXPECT_NEAR(robot.travelled_m, 10, 0.3) << by_odometry;
  }
}

TEST_F(FollowLine, ComesToTheLineFromBesideIt) {
  for (const double offset_m : {-0.5, 0.5}) {
    robot.at = {{kRadiusM + offset_m, 0, 0}, M_PI / 2};
    Go({{"distance", "6"}, {"speed", "1"}});
    EXPECT_TRUE(RunToItsEnd(60));
    EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
    EXPECT_LT(OffLine(), 0.15);
  }
}

TEST_F(FollowLine, FindsALineThatIsLost) {
  Go();
  RunFor(5);
  robot.at.yaw_rad = navigation::Wrapped(robot.at.yaw_rad - 1.5);
  Step();
  EXPECT_EQ(feedback().state, "SEARCHING");
  RunFor(1);
  EXPECT_THAT(feedback().message, StartsWith("Line lost, searching... ("));
  EXPECT_LT(navigation::Speed(robot.velocity()), 0.01);
  RunFor(7);
  EXPECT_EQ(feedback().state, "EXECUTING");
  RunFor(20);
  EXPECT_LT(OffLine(), 0.1);
}

TEST_F(FollowLine, FailsWhenTheLineIsNotFound) {
  Go();
  RunFor(5);
  robot.see_line = [](const auto&) { return std::optional<Robot::Line>(); };
  RunFor(1);
  const auto stood_at = robot.at.at;
  EXPECT_TRUE(RunToItsEnd(9));
  EXPECT_EQ(feedback().status, Status::kFailed);
  EXPECT_EQ(feedback().message, "Line lost: not found by turning to both sides");
  EXPECT_LT(navigation::Distance(robot.at.at, stood_at), 0.01);
  for (int i = 0; i < 10; ++i) robot.Advance(Milliseconds(100));
  EXPECT_TRUE(robot.Rests());
}

TEST_F(FollowLine, FailsWithoutALineOrOdometry) {
  robot.see_line = [](const auto&) { return std::optional<Robot::Line>(); };
  Go();
  EXPECT_TRUE(RunToItsEnd(3));
  EXPECT_EQ(feedback().message, "No line in sight of robot_0");
  robot.see_line = Circle;
  Go();
  RunFor(3);
  robot.odometry_up = false;
  RunFor(1);
  EXPECT_TRUE(robot.Rests());
  EXPECT_TRUE(RunToItsEnd(3));
  EXPECT_EQ(feedback().message, "No odometry of robot_0");
}

TEST_F(FollowLine, StandsInAPauseAndWhenItIsCancelled) {
  Go();
  RunFor(5);
  Pause();
  RunFor(60);
  EXPECT_TRUE(robot.Rests());
  Resume();
  RunFor(5);
  EXPECT_EQ(feedback().state, "EXECUTING");
  EXPECT_FALSE(robot.Rests());
  ASSERT_TRUE(manager->Cancel("follow_line", "enough"));
  EXPECT_TRUE(RunToItsEnd(3));
  EXPECT_EQ(feedback().status, Status::kCancelled);
  EXPECT_TRUE(robot.Rests());
}

// The cancelled skill braked for 5 s, between the commands of the one that had the base.
TEST_F(FollowLine, IsNotBrakedByTheEndOfASkillThatIsPaused) {
  const std::vector<std::pair<std::string, Texts>> others = {
      {"navigate_to", {{"goal_pos", "[40, 0]"}}},
      {"avoid_obstacle", {{"goal_pos", "[40, 0]"}}},
      {"back_up", {}}};
  for (const auto& [other, parameters] : others) {
    for (const bool reset : {false, true}) {
      robot.at = {{kRadiusM, 0, 0}, M_PI / 2};
      ASSERT_TRUE(Start(other, parameters));
      RunFor(1);
      ASSERT_TRUE(manager->Pause(other, "by a request"));
      RunFor(2);
      robot.at = {{kRadiusM, 0, 0}, M_PI / 2};
      Go();
      RunFor(3);
      robot.stops = 0;
      ASSERT_TRUE(reset ? manager->Reset(other) : manager->Cancel(other, "a person"));
      RunFor(6);
      EXPECT_EQ(robot.stops, 0) << other;
      EXPECT_NEAR(navigation::Speed(robot.velocity()), 0.3, 0.05) << other;
      manager->ResetAll();
    }
  }
}

TEST_F(FollowLine, StandsBeforeABoxOnTheLineAndFailsWhenItStays) {
  for (int i = -10; i <= 10; ++i) {
    robot.points.push_back({2 + 0.02 * i, std::sqrt(kRadiusM * kRadiusM - 4), 0});
  }
  Go({{"speed", "1"}});
  EXPECT_TRUE(RunToItsEnd(60));
  EXPECT_EQ(feedback().status, Status::kFailed);
  EXPECT_THAT(feedback().message, StartsWith("Blocked for 10.0 s: an obstacle is on the line"));
  EXPECT_GT(robot.nearest_m, robot.radius_m());
  EXPECT_TRUE(robot.Rests());
}

TEST_F(FollowLine, GoesOnWhenTheBoxHasLeft) {
  robot.points = {{2, std::sqrt(kRadiusM * kRadiusM - 4), 0}};
  Go({{"distance", "8"}});
  RunFor(20);
  EXPECT_THAT(feedback().message, StartsWith("Blocked ("));
  robot.points.clear();
  EXPECT_TRUE(RunToItsEnd(60));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
}

TEST_F(FollowLine, RefusesParametersThatAreNone) {
  const std::string speed = "; expected more than 0 and at most 1 m/s";
  EXPECT_EQ(WhyRefused({{"speed", "0"}}), "speed is 0 m/s" + speed);
  EXPECT_EQ(WhyRefused({{"speed", "1.1"}}), "speed is 1.1 m/s" + speed);
  EXPECT_EQ(WhyRefused({{"distance", "-1"}}), "distance is -1 m; expected 0 m or more");
  robot.robot_kind = "drone_autel";
  EXPECT_EQ(WhyRefused({}), "robot_0 flies; follow_line is for robots on the ground");
}

}  // namespace musher::follow_line_test
