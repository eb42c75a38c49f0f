// The skill visual_servoing on a body with inertia.

#include <gmock/gmock.h>

#include "musher/test/modules/skills/moving_robot.hpp"

namespace musher::visual_servoing_test {

using skill::Status;
using skills::Look;
using skills::testing::SkillsOnARobot;
using ::testing::HasSubstr;
using ::testing::StartsWith;

using Texts = std::vector<std::pair<std::string, std::string>>;

class VisualServoing : public ::testing::Test, public SkillsOnARobot {
 protected:
  VisualServoing() {
    robot.look = [this](const std::string& target, Time at) -> std::optional<Look> {
      if (!detectors) return std::nullopt;
      Look look{at, {}};
      if (target == "dock") look.seen = InBody();
      return look;
    };
  }
  std::vector<navigation::Point> InBody() const {
    std::vector<navigation::Point> seen;
    const double c = std::cos(robot.at.yaw_rad), s = std::sin(robot.at.yaw_rad);
    for (const navigation::Point& dock : docks) {
      const double x = dock.x_m - robot.at.at.x_m, y = dock.y_m - robot.at.at.y_m;
      seen.push_back({c * x + s * y, c * y - s * x, 0});
    }
    return seen;
  }
  void Go(Texts parameters = {}) {
    parameters.emplace_back("target", "dock");
    const Result<> started = Start("visual_servoing", parameters);
    ASSERT_TRUE(started) << started.error().message;
  }
  std::string EndOf(double seconds = 100) {
    EXPECT_TRUE(RunToItsEnd(seconds)) << message();
    RunFor(0.5);
    EXPECT_TRUE(robot.Rests()) << message();
    return message();
  }
  double DistanceToDock() const {
    return std::hypot(docks[0].x_m - robot.at.at.x_m, docks[0].y_m - robot.at.at.y_m);
  }

  std::vector<navigation::Point> docks{{3, 0.5, 0}};
  bool detectors = true;
};

TEST_F(VisualServoing, StandsBeforeTheTarget) {
  Go({{"distance", "0.8"}, {"bearing", "0.5"}});
  EXPECT_EQ(EndOf(), "Reached dock");
  EXPECT_EQ(feedback().status, Status::kCompleted);
  EXPECT_NEAR(DistanceToDock(), 0.8, 0.06);
}

TEST_F(VisualServoing, FailsAtAStandWhenTheTargetIsLost) {
  Go();
  RunFor(3);
  EXPECT_FALSE(robot.Rests());
  docks.clear();
  RunFor(1);
  EXPECT_TRUE(robot.Rests());
  EXPECT_THAT(EndOf(3), StartsWith("dock is not seen for 2."));
}

TEST_F(VisualServoing, GoesOnWhenTheTargetIsSeenAgainInTime) {
  Go();
  RunFor(3);
  const auto there = std::exchange(docks, {});
  RunFor(1.5);
  docks = there;
  EXPECT_EQ(EndOf(), "Reached dock");
}

TEST_F(VisualServoing, FailsBeforeTwoTargetsAndOneThatJumps) {
  Go();
  RunFor(2);
  docks.push_back({2, -1, 0});
  EXPECT_THAT(EndOf(5), HasSubstr("2 things are dock"));
  docks.pop_back();
  Go();
  RunFor(2);
  docks[0].y_m -= 4;
  EXPECT_THAT(EndOf(5), StartsWith("dock has jumped by 4.0"));
}

TEST_F(VisualServoing, FailsWithTheNameOfWhatIsMissing) {
  detectors = false;
  Go();
  EXPECT_EQ(EndOf(5), "robot_0 has no detector");
  detectors = true;
  Go();
  RunFor(2);
  robot.scan_up = false;
  EXPECT_EQ(EndOf(5), "No scan of robot_0");
  robot.scan_up = true;
  Go();
  RunFor(2);
  robot.odometry_up = false;
  EXPECT_EQ(EndOf(5), "No odometry of robot_0");
}

TEST_F(VisualServoing, FailsAtWhatStopsItAndDoesNotBackUpBlindly) {
  Go();
  RunFor(2);
  robot.held_by = "an obstacle 0.10 m away";
  EXPECT_EQ(EndOf(15), "Blocked: an obstacle 0.10 m away");
  robot.held_by.clear();
  docks = {{robot.at.at.x_m + 0.5, robot.at.at.y_m, 0}};
  robot.at.yaw_rad = 0;
  robot.scan_covers_rad = 2;
  const double before_m = robot.at.at.x_m;
  Go();
  EXPECT_EQ(EndOf(15), "it is too near, and no scan covers what is behind it");
  EXPECT_NEAR(robot.at.at.x_m, before_m, 0.01);
}

TEST_F(VisualServoing, IsLateAfterOneMinute) {
  docks = {{9, 0, 0}};
  Go({{"speed", "0.05"}});
  EXPECT_THAT(EndOf(70), StartsWith("Timeout: dock is "));
}

TEST_F(VisualServoing, RefusesWhatItCannotDo) {
  const std::vector<std::pair<Texts, std::string>> cases{
      {{{"distance", "0.1"}}, "distance is 0.1 m; expected more than the radius"},
      {{{"distance", "1e300"}}, "distance is 1e+300 m; expected"},
      {{{"bearing", "2"}}, "bearing is 2 rad; expected -1 to 1"},
      {{{"speed", "0"}}, "speed is 0 m/s"},
      {{{"tolerance", "0"}}, "tolerance is 0; expected more than 0"},
      {{{"lost_limit", "-1"}}, "lost_limit is -1"}};
  for (const auto& [texts, why] : cases) {
    Go(texts);
    EXPECT_THAT(EndOf(5), StartsWith(why));
  }
  robot.robot_kind = "cf2x";
  Go();
  EXPECT_EQ(EndOf(5), "robot_0 flies; visual_servoing is for robots on the ground");
}

TEST_F(VisualServoing, StandsWhileItIsPausedAndWhenItIsCancelled) {
  Go();
  RunFor(3);
  Pause();
  RunFor(2);
  EXPECT_TRUE(robot.Rests());
  Resume();
  RunFor(2);
  EXPECT_FALSE(robot.Rests());
  ASSERT_TRUE(manager->Cancel("visual_servoing", "by the test"));
  EndOf(5);
  EXPECT_EQ(feedback().status, Status::kCancelled);
}

}  // namespace musher::visual_servoing_test
