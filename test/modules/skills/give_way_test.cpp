// navigate_to where another robot comes the other way: who gives way, where to, for how long.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/test/modules/skills/moving_robot.hpp"

namespace musher::give_way_test {

using navigation::Point;
using skill::Status;
using skills::testing::SkillsOnARobot;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class GiveWay : public ::testing::Test, public SkillsOnARobot {
 protected:
  GiveWay() {
    robot.refuge = [this]() -> Result<navigation::Path> {
      return navigation::Path{robot.at, {{robot.at.at.x_m - 1, 1, 0}, 0}};
    };
  }
  void GoTo(const std::string& place) {
    const Result<> started = Start("navigate_to", {{"goal_pos", place}});
    ASSERT_TRUE(started) << started.error().message;
  }
  // A robot that comes from (x, 0) to the left.
  void Comes(const std::string& name, double x_m) {
    robot.known = {{.robot = name, .at = {x_m, 0, 0}, .path = {{-20, 0, 0}}}};
  }
};

TEST_F(GiveWay, DrivesAsideWaitsAndGoesOn) {
  GoTo("[10, 0]");
  RunFor(2);
  Comes("/a", 6);
  EXPECT_TRUE(RunToState("GIVING_WAY", 1));
  EXPECT_EQ(message(), "Gives way to /a");
  RunFor(8);
  EXPECT_EQ(message(), "Gives way to /a: waits");
  EXPECT_NEAR(robot.at.at.y_m, 1, 0.01);
  EXPECT_TRUE(robot.Rests());
  Comes("/a", -4);  // it has passed
  EXPECT_TRUE(RunToItsEnd(30));
  EXPECT_EQ(feedback().status, Status::kCompleted) << message();
}

TEST_F(GiveWay, IsForTheOtherOneWhereThisOneGoesFirst) {
  GoTo("[10, 0]");
  RunFor(2);
  Comes("/z", 6);
  for (int i = 0; i < 30; ++i) {
    Step();
    EXPECT_EQ(feedback().state, "EXECUTING");
  }
}

TEST_F(GiveWay, GoesOnWhenTheOtherIsForgotten) {
  GoTo("[10, 0]");
  RunFor(2);
  Comes("/a", 6);
  EXPECT_TRUE(RunToState("GIVING_WAY", 1));
  RunFor(5);
  robot.known.clear();
  EXPECT_TRUE(RunToItsEnd(30));
  EXPECT_EQ(feedback().status, Status::kCompleted) << message();
}

TEST_F(GiveWay, SaysThatItIsCorneredAndThenGoesFirst) {
  robot.refuge = [] { return Result<navigation::Path>(Error{kCodeFailed, "a dead end"}); };
  GoTo("[10, 0]");
  RunFor(2);
  Comes("/a", 6);
  EXPECT_TRUE(RunToState("GIVING_WAY", 1));
  RunFor(2);
  EXPECT_TRUE(robot.cornered);
  EXPECT_TRUE(RunToState("EXECUTING", 5));
  robot.known[0].cornered = true;  // the other one as well: its name decides
  EXPECT_TRUE(RunToState("GIVING_WAY", 5));
}

TEST_F(GiveWay, FailsWithTheNameOfTheRobotThatDoesNotLeaveTheWay) {
  GoTo("[10, 0]");
  RunFor(2);
  Comes("/a", 6);
  EXPECT_TRUE(RunToItsEnd(140));
  EXPECT_EQ(feedback().status, Status::kFailed);
  EXPECT_THAT(message(), HasSubstr("Gave way to /a for 120 s"));
  EXPECT_TRUE(robot.Rests());
}

TEST_F(GiveWay, EndsByACancellationAndLastsThroughAPause) {
  GoTo("[10, 0]");
  RunFor(2);
  Comes("/a", 6);
  EXPECT_TRUE(RunToState("GIVING_WAY", 1));
  RunFor(1);
  Pause();
  RunFor(2);
  EXPECT_TRUE(robot.Rests());
  Resume();
  RunFor(8);
  EXPECT_NEAR(robot.at.at.y_m, 1, 0.01) << message();
  EXPECT_TRUE(manager->Cancel("navigate_to", "by its client"));
  EXPECT_TRUE(RunToItsEnd(5));
  EXPECT_EQ(feedback().status, Status::kCancelled);
}

TEST_F(GiveWay, NamesTheRobotThatStandsInTheWay) {
  robot.blocked = [](const Point& at) { return at.x_m > 2; };
  robot.known = {{.robot = "/dog/jetbot_1", .at = {2.2, 0, 0}, .path = {}}};
  GoTo("[4, 0]");
  EXPECT_TRUE(RunToItsEnd(120));
  EXPECT_THAT(message(), StartsWith("Blocked for 6"));
  EXPECT_THAT(message(), HasSubstr("; /dog/jetbot_1 is 0.7 m away"));
}

}  // namespace musher::give_way_test
