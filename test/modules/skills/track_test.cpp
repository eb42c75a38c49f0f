// track: a target that walks, stands, disappears, comes near and cannot be reached.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/test/modules/skills/moving_robot.hpp"

namespace musher::track_test {

using skill::Status;
using skills::testing::SkillsOnARobot;
using ::testing::HasSubstr;
using ::testing::StartsWith;

using Texts = std::vector<std::pair<std::string, std::string>>;

class Track : public ::testing::Test, public SkillsOnARobot {
 protected:
  Track() {
    robot.targets["/target_0/odom"] = [this](Time time) -> std::optional<navigation::Pose> {
      if (!seen) return std::nullopt;
      const double walked_m = walks_m_s * ToSeconds(time.time_since_epoch());
      return navigation::Pose{{start.x_m + walked_m, start.y_m, 0}, 0};
    };
  }
  void Go(const Texts& parameters = {}) {
    const Result<> started = Start("track", parameters);
    ASSERT_TRUE(started) << started.error().message;
  }
  double Apart() const {
    const auto target = robot.targets.at("/target_0/odom")(robot.Now());
    return navigation::Distance(target->at, robot.at.at);
  }
  std::string WhyRefused(const std::string& name, const std::string& value) {
    Go({{name, value}});
    Step();
    EXPECT_EQ(feedback().status, Status::kFailed);
    return feedback().message;
  }

  bool seen = true;
  navigation::Point start{6, 0, 0};
  double walks_m_s = 0;
};

TEST_F(Track, KeepsItsDistanceFromATargetThatStands) {
  Go();
  RunFor(10);
  EXPECT_NEAR(Apart(), 1.5, 0.35);
  EXPECT_TRUE(robot.Rests());
  EXPECT_THAT(feedback().message, StartsWith("Tracking... (1."));
  EXPECT_EQ(feedback().status, Status::kProcessing);
  const int plans = robot.plans;
  RunFor(60);
  EXPECT_EQ(robot.plans, plans);
}

TEST_F(Track, FollowsATargetThatWalksWithoutStopping) {
  walks_m_s = 0.6;
  Go();
  RunFor(10);
  int stops = 0;
  EachStep([&] { stops += navigation::Speed(robot.velocity()) < 0.1 ? 1 : 0; });
  double farthest = 0;
  for (int i = 0; i < 600; ++i) {
    Step();
    farthest = std::max(farthest, Apart());
  }
  EXPECT_LE(farthest, 3.2);
  EXPECT_GT(robot.at.at.x_m, 30);
  EXPECT_LT(stops, 350);  // it is faster than the target, and waits for it
}

TEST_F(Track, PlansAfterSoManyPoses) {
  walks_m_s = 0.95;
  Go({{"track_period", "20"}});
  RunFor(60);
  EXPECT_NEAR(robot.plans, 60 / 2, 5);
}

TEST_F(Track, CountsThePosesOfTheTargetNotItsOwnSteps) {
  walks_m_s = 0.95;
  robot.target_hz = 50;
  Go({{"track_period", "100"}});
  RunFor(60);
  EXPECT_NEAR(robot.plans, 60 / 2, 5);
}

TEST_F(Track, BacksAwayFromATargetThatIsTooNear) {
  start = {0.3, 0, 0};
  Go();
  RunFor(10);
  EXPECT_NEAR(Apart(), 1.5, 0.2);
  EXPECT_NEAR(robot.at.yaw_rad, 0, 1e-6);
  start = robot.at.at;
  RunFor(10);
  EXPECT_NEAR(Apart(), 1.5, 0.2);
}

TEST_F(Track, SaysThatTheTargetIsLostAndFailsLater) {
  Go();
  RunFor(2);
  seen = false;
  RunFor(3);
  EXPECT_THAT(feedback().message, StartsWith("Target lost (3.0s)"));
  RunFor(6.5);
  EXPECT_EQ(feedback().status, Status::kProcessing);
  EXPECT_NEAR(robot.at.at.x_m, 4.5, 0.35);
  EXPECT_TRUE(RunToItsEnd(2));
  EXPECT_EQ(feedback().message, "Target lost: no pose on /target_0/odom for 10.0 s");
}

TEST_F(Track, GoesOnWhenTheTargetIsSeenAgain) {
  Go();
  RunFor(2);
  seen = false;
  RunFor(8);
  seen = true;
  start = {20, 0, 0};
  RunFor(20);
  EXPECT_NEAR(robot.at.at.x_m, 18.5, 0.35);
}

TEST_F(Track, FailsWithoutATargetOrAServer) {
  seen = false;
  Go();
  EXPECT_TRUE(RunToItsEnd(11));
  EXPECT_EQ(feedback().message, "Target not seen: no pose on /target_0/odom");
  Go({{"target_topic", "/target_7/odom"}});
  EXPECT_TRUE(RunToItsEnd(11));
  EXPECT_EQ(feedback().message, "Target not seen: no pose on /target_7/odom");
  robot.planner_up = false;
  Go();
  EXPECT_TRUE(RunToItsEnd(11));
  EXPECT_THAT(feedback().message, HasSubstr("Path planner server not available"));
}

TEST_F(Track, FailsWhenThereIsNoPathForALongTime) {
  robot.plan = [](const auto&, const auto&) -> Result<navigation::Path> {
    return Error{kCodeFailed, "walled in"};
  };
  Go();
  RunFor(5);
  EXPECT_THAT(feedback().message, HasSubstr("No path to the target ("));
  EXPECT_TRUE(RunToItsEnd(8));
  EXPECT_EQ(feedback().status, Status::kFailed);
  EXPECT_EQ(feedback().message, "No path to the target for 10.0 s: Planning failed: walled in");
}

// The planner's path leads through it.
TEST_F(Track, FailsAtAnObstacleThatStays) {
  robot.blocked = [](const navigation::Point& at) { return at.x_m > 2; };
  Go();
  RunFor(8);
  EXPECT_THAT(feedback().message, HasSubstr("s): an obstacle stays in the way"));
  EXPECT_TRUE(RunToItsEnd(8));
  EXPECT_EQ(feedback().status, Status::kFailed);
  EXPECT_EQ(feedback().message, "No path to the target for 10.0 s: an obstacle stays in the way");
  RunFor(1);
  EXPECT_TRUE(robot.Rests());
  robot.at = {};
  Go({{"track_period", "100"}});
  EXPECT_TRUE(RunToItsEnd(20));
  EXPECT_EQ(feedback().message, "No path to the target for 10.0 s: an obstacle stays in the way");
}

TEST_F(Track, FailsWhereItsDrivesDoNotMoveTheRobot) {
  Go();
  RunFor(2);
  robot.drive_speed_m_s = 0;
  RunFor(8);
  EXPECT_THAT(feedback().message,
              HasSubstr("s): the robot makes no progress along its path, as at an obstacle"));
  EXPECT_TRUE(RunToItsEnd(8));
  EXPECT_EQ(
      feedback().message,
      "No path to the target for 10.0 s: the robot makes no progress along its path, as at an "
      "obstacle");
}

TEST_F(Track, OutlivesAnObstacleAndARestartOfServers) {
  Go();
  RunFor(2);
  robot.FailDrive(MakeError(navigation::Fault::kObstacle, "a person"));
  RunFor(1);
  robot.KillController();
  robot.KillPlanner();
  RunFor(6);
  robot.planner_up = robot.controller_up = true;
  RunFor(10);
  EXPECT_EQ(feedback().status, Status::kProcessing) << feedback().message;
  EXPECT_NEAR(Apart(), 1.5, 0.35);
}

TEST_F(Track, SucceedsAfterItsDurationAtAStand) {
  walks_m_s = 0.5;
  Go({{"duration", "20"}});
  EXPECT_TRUE(RunToItsEnd(25));
  EXPECT_EQ(feedback().status, Status::kCompleted);
  EXPECT_EQ(feedback().message, "Tracked for 20.0 s");
  EXPECT_TRUE(robot.Rests());
}

TEST_F(Track, StandsWhenItIsCancelledAndInAPause) {
  Go();
  RunFor(2);
  Pause();
  RunFor(60);
  EXPECT_TRUE(robot.Rests());
  EXPECT_GT(Apart(), 3);
  Resume();
  RunFor(2);
  EXPECT_FALSE(robot.Rests());
  ASSERT_TRUE(manager->Cancel("track", "enough"));
  EXPECT_TRUE(RunToItsEnd(3));
  EXPECT_EQ(feedback().status, Status::kCancelled);
  EXPECT_TRUE(robot.Rests());
}

TEST_F(Track, KeepsTheHeightOfAFlyer) {
  robot.robot_kind = "cf2x";
  robot.at.at.z_m = 2;
  Go();
  RunFor(10);
  EXPECT_EQ(robot.at.at.z_m, 2);
  EXPECT_NEAR(robot.at.at.x_m, 4.5, 0.35);
}

TEST_F(Track, DoesNotGoOnWithAFlyerThatWasPutDownInAPause) {
  robot.robot_kind = "cf2x";
  robot.at.at.z_m = 2;
  Go();
  RunFor(3);
  Pause();
  RunFor(3);
  robot.at.at.z_m = 0;
  const int drives = robot.drives;
  Resume();
  EXPECT_TRUE(RunToItsEnd(10));
  EXPECT_EQ(feedback().status, Status::kFailed);
  EXPECT_EQ(robot.drives, drives);
}

TEST_F(Track, RefusesParametersThatAreNone) {
  EXPECT_EQ(WhyRefused("track_period", "0"), "track_period is 0; expected 1 or more");
  EXPECT_EQ(WhyRefused("target_topic", "\"\""), "target_topic is empty; expected a topic");
  EXPECT_EQ(WhyRefused("distance", "0"), "distance is 0; expected more than 0");
  EXPECT_EQ(WhyRefused("lost_limit", "-1"), "lost_limit is -1; expected more than 0");
  EXPECT_EQ(WhyRefused("duration", "-1"), "duration is -1; expected 0 or more seconds");
}

}  // namespace musher::track_test
