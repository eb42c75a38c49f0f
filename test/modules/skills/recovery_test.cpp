// Recoveries: as skills, and as steps of navigate_to after a plan that has failed.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "musher/test/modules/skills/moving_robot.hpp"

namespace musher::recovery_test {

using navigation::Fault;
using skill::Status;
using skills::testing::SkillsOnARobot;
using ::testing::HasSubstr;

class ARecovery : public ::testing::Test, public SkillsOnARobot {
 protected:
  // A wall along y, so far behind the middle of the robot, which looks along x.
  void StandBefore(double wall_m) {
    for (int i = -20; i <= 20; ++i) robot.points.push_back({-wall_m, 0.05 * i, 0});
  }
  void Run(const std::string& name) {
    const Result<> started = Start(name);
    ASSERT_TRUE(started) << started.error().message;
    EXPECT_TRUE(RunToItsEnd(30));
    for (int i = 0; i < 20; ++i) robot.Advance(Milliseconds(100));
    EXPECT_TRUE(robot.Rests()) << name;
  }
  // For so long, and then to a stand.
  void MoveBy(const navigation::Velocity& command, double seconds) {
    robot.SetVelocity(command);
    for (double at_s = 0; at_s < seconds; at_s += 0.1) robot.Advance(Milliseconds(100));
    robot.StopMotion();
    for (int i = 0; i < 10; ++i) robot.Advance(Milliseconds(100));
  }
  void ExpectBacksUpStraight() {
    const navigation::Pose begin = robot.at;
    Run("back_up");
    EXPECT_EQ(feedback().message, "Recovered: back_up");
    const double x_m = robot.at.at.x_m - begin.at.x_m, y_m = robot.at.at.y_m - begin.at.y_m;
    const double c = std::cos(begin.yaw_rad), s = std::sin(begin.yaw_rad);
    EXPECT_NEAR(c * x_m + s * y_m, -0.42, 0.06);
    EXPECT_NEAR(c * y_m - s * x_m, 0, 0.01);
  }
  void ExpectFailure(const std::string& name, const std::string& why) {
    Run(name);
    EXPECT_EQ(feedback().status, Status::kFailed) << name;
    EXPECT_THAT(feedback().message, HasSubstr(why));
  }
  static Result<navigation::Path> Fails(Fault fault) {
    return navigation::MakeError(fault, "it has no path");
  }
};

TEST_F(ARecovery, LeavesATightStartAwayFromTheWall) {
  for (const double room_m : {0.01, 0.04}) {
    for (const double yaw_rad : {0.0, 1.2, 3.1, -2.0}) {
      robot.at = {{0, 0, 0}, yaw_rad};
      robot.points.clear();
      StandBefore(robot.radius_m() + room_m);
      robot.nearest_m = 1;
      Run("leave_tight_start");
      EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
      EXPECT_GT(robot.at.at.x_m, 0.25) << yaw_rad;
      EXPECT_GT(robot.nearest_m, robot.radius_m()) << yaw_rad;
    }
  }
}

TEST_F(ARecovery, IsSlow) {
  StandBefore(0.22);
  for (const char* name : {"leave_tight_start", "back_up", "spin"}) {
    ASSERT_TRUE(Start(name));
    double fastest_m_s = 0;
    EachStep([&] {
      fastest_m_s = std::max(fastest_m_s, navigation::Speed(robot.velocity()));
      EXPECT_LE(std::abs(robot.velocity().yaw_rad_s), 0.61) << name;
    });
    EXPECT_TRUE(RunToItsEnd(30));
    EXPECT_LE(fastest_m_s, 0.151) << name;
    EXPECT_EQ(feedback().status, Status::kCompleted) << name << ": " << feedback().message;
  }
}

TEST_F(ARecovery, BacksUpByWhatItSaysAndSpinsOnce) {
  Run("back_up");
  EXPECT_EQ(feedback().message, "Recovered: back_up");
  EXPECT_NEAR(robot.at.at.x_m, -0.42, 0.05);
  robot.at = {};
  Run("spin");
  EXPECT_EQ(feedback().message, "Recovered: spin");
  EXPECT_NEAR(robot.travelled_m, 0.42, 0.05) << "it stays where it is";
}

// It went straight back, where it had never been.
TEST_F(ARecovery, BacksUpAlongTheBendThatItHasCome) {
  MoveBy({.x_m_s = 0.5, .yaw_rad_s = 1}, 1.5);
  const navigation::Pose begin = robot.at;
  double off_path_m = 0;
  EachStep([&] {
    const double from_middle_m = std::hypot(robot.at.at.x_m, robot.at.at.y_m - 0.5);
    off_path_m = std::max(off_path_m, std::abs(from_middle_m - 0.5));
  });
  Run("back_up");
  EXPECT_EQ(feedback().message, "Recovered: back_up");
  EXPECT_LT(off_path_m, 0.06) << "straight back it is 0.14 m";
  EXPECT_NEAR(navigation::Distance(robot.at.at, begin.at), 0.4, 0.06);
}

TEST_F(ARecovery, BacksUpNoFartherThanTheCornerThatItHasTurned) {
  MoveBy({.x_m_s = 0.5}, 1);
  MoveBy({.yaw_rad_s = 1}, M_PI / 2);
  const double corner_m = robot.at.at.y_m;
  MoveBy({.x_m_s = 0.5}, 0.6);
  Run("back_up");
  EXPECT_EQ(feedback().message, "Recovered: back_up");
  EXPECT_NEAR(robot.at.at.y_m, corner_m, 0.06);
}

TEST_F(ARecovery, BacksUpOnceMoreFromWhereItHasBackedUpTo) {
  MoveBy({.x_m_s = 0.5}, 3);
  const double begin_m = robot.at.at.x_m;
  Run("back_up");
  Run("back_up");
  EXPECT_EQ(feedback().message, "Recovered: back_up");
  EXPECT_NEAR(robot.at.at.x_m, begin_m - 0.8, 0.1) << "and not to and fro";
}

// It drove ahead, towards the person for whom it made room.
TEST_F(ARecovery, BacksUpStraightWhereItsPathLeadsAheadOrAside) {
  for (const double turned_rad : {M_PI, M_PI / 2}) {
    MoveBy({.x_m_s = 0.5}, 2);
    MoveBy({.yaw_rad_s = 1}, turned_rad);
    ExpectBacksUpStraight();
  }
  MoveBy({.x_m_s = -0.5}, 2);
  ExpectBacksUpStraight();
}

TEST_F(ARecovery, DoesNotGoBackOnAPathThatNoScanCovers) {
  MoveBy({.x_m_s = 0.5, .yaw_rad_s = 1}, 1.5);
  robot.scan_covers_rad = M_PI / 2;
  const navigation::Point begin = robot.at.at;
  ExpectFailure("back_up", "it does not go backwards: no scan covers what is behind it");
  EXPECT_LT(navigation::Distance(robot.at.at, begin), 0.01);
}

TEST_F(ARecovery, TakesNoiseOfItsHeadingForNoTurn) {
  double noise_rad = 0.1, turned_rad = 0;
  EachStep([&] {
    turned_rad += 0.1 * robot.velocity().yaw_rad_s;
    robot.at.yaw_rad = navigation::Wrapped(robot.at.yaw_rad + noise_rad);
    noise_rad = -noise_rad;
  });
  Run("spin");
  EXPECT_EQ(feedback().status, Status::kCompleted);
  EXPECT_NEAR(turned_rad, 2 * M_PI, 0.4);
}

TEST_F(ARecovery, BacksUpAlongItsHeadingAlsoWhereItDriftsToASide) {
  robot.at.yaw_rad = 1;
  const navigation::Pose begin = robot.at;
  EachStep([&] {
    robot.at.at.x_m -= 0.02 * std::sin(1);
    robot.at.at.y_m += 0.02 * std::cos(1);
  });
  ASSERT_TRUE(Start("back_up"));
  EXPECT_TRUE(RunToItsEnd(30));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
  const double x_m = robot.at.at.x_m - begin.at.x_m, y_m = robot.at.at.y_m - begin.at.y_m;
  EXPECT_LT(x_m * std::cos(1) + y_m * std::sin(1), -0.38);
}

TEST_F(ARecovery, FailsWithTheReasonOfTheGate) {
  StandBefore(0.22);
  robot.held_by = "an obstacle 0.22 m away, straight behind, stops it";
  ExpectFailure("back_up", "back_up: an obstacle 0.22 m away");
  ExpectFailure("leave_tight_start", "stops it");
  EXPECT_EQ(robot.travelled_m, 0);
}

TEST_F(ARecovery, MovesNothingWithoutScanOrOdometry) {
  StandBefore(0.22);
  robot.scan_up = false;
  for (const char* name : {"leave_tight_start", "back_up", "spin"}) {
    ExpectFailure(name, "it does not move without a scan");
  }
  robot.scan_up = true;
  robot.odometry_up = false;
  for (const char* name : {"leave_tight_start", "back_up", "spin"}) {
    ExpectFailure(name, "No odometry of robot_0");
  }
  EXPECT_EQ(robot.travelled_m, 0);
}

// It went backwards into a person whom a scanner that looks ahead cannot see.
TEST_F(ARecovery, GoesNowhereThatItsScanDoesNotCover) {
  const std::string behind = "back_up: it does not go backwards: no scan covers what is behind it";
  for (const double covered_rad : {M_PI / 2, 2.36, 3.0}) {
    robot.scan_covers_rad = covered_rad;
    ExpectFailure("back_up", behind);
  }
  StandBefore(0.22);
  robot.scan_covers_rad = 0.2;
  ExpectFailure("leave_tight_start", "it does not go ahead: no scan covers what is ahead of it");
  EXPECT_EQ(robot.travelled_m, 0);
  robot.scan_covers_rad = M_PI / 2;
  Run("leave_tight_start");
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
  robot.at = {};
  robot.points.clear();
  robot.scan_covers_rad = M_PI;
  ASSERT_TRUE(Start("back_up"));
  RunFor(1);
  robot.scan_covers_rad = M_PI / 2;
  EXPECT_TRUE(RunToItsEnd(2));
  EXPECT_EQ(feedback().message, behind) << "also on its way";
}

TEST_F(ARecovery, TakesAJumpOfThePoseForNoMotion) {
  for (const char* name : {"back_up", "spin"}) {
    robot.at = {};
    ASSERT_TRUE(Start(name));
    RunFor(0.5);
    robot.at.at.x_m -= 3;
    EXPECT_TRUE(RunToItsEnd(30));
    EXPECT_EQ(feedback().status, Status::kFailed) << name;
    EXPECT_THAT(feedback().message, HasSubstr("its pose has jumped"));
  }
}

TEST_F(ARecovery, LeavesNoPlaceWhereItsScanSeesNothing) {
  ExpectFailure("leave_tight_start", "its scan sees nothing near");
}

TEST_F(ARecovery, ClearsTheMemoryOrSaysWhyNot) {
  Run("clear");
  EXPECT_EQ(feedback().message, "Recovered: clear");
  EXPECT_EQ(robot.cleared, 1);
  robot.clear_reply = Error{kCodeNetError, "no server of r/clear_planner_memory"};
  ExpectFailure("clear", "clear: no server of r/clear_planner_memory");
  robot.clear_reply.reset();
  ExpectFailure("clear", "have not answered");
}

TEST_F(ARecovery, OfAFlyerMovesNothing) {
  robot.robot_kind = "cf2x";
  robot.at.at.z_m = 1;
  for (const char* name : {"leave_tight_start", "back_up", "spin"}) ExpectFailure(name, "flies");
  Run("clear");
  EXPECT_EQ(feedback().status, Status::kCompleted);
}

// There is no path until the memory is cleared, for example of a person who has left.
TEST_F(ARecovery, MakesAFailedPlanGoOn) {
  const auto plans = robot.plan;
  for (const Fault fault : {Fault::kWalledIn, Fault::kTimeLimit}) {
    robot.at = {};
    robot.cleared = 0;
    robot.plan = [&](const auto& start, const auto& goal) -> Result<navigation::Path> {
      return robot.cleared > 0 ? plans(start, goal) : Fails(fault);
    };
    ASSERT_TRUE(Start("navigate_to", {{"goal_pos", "[4, 0, 0]"}}));
    EXPECT_TRUE(RunToState("RECOVERING", 5));
    Step();
    EXPECT_EQ(feedback().message, "No path: clear");
    EXPECT_TRUE(RunToItsEnd(30));
    EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
  }
}

TEST_F(ARecovery, DoesNotMoveARobotForWhichThereIsNoPath) {
  robot.plan = [](const auto&, const auto&) { return Fails(Fault::kWalledIn); };
  ASSERT_TRUE(Start("navigate_to", {{"goal_pos", "[4, 0, 0]"}}));
  EXPECT_TRUE(RunToItsEnd(30));
  EXPECT_EQ(feedback().message, "Planning failed: it has no path");
  EXPECT_EQ(robot.plans, 3) << "the first one, after clear, after wait";
  EXPECT_EQ(robot.travelled_m, 0);
}

TEST_F(ARecovery, IsTakenInTheOrderAndNumberOfTheParameter) {
  robot.plan = [](const auto&, const auto&) { return Fails(Fault::kStartBlocked); };
  std::vector<std::string> texts;
  EachStep([&] {
    const std::string text = feedback().message;
    if (text.starts_with("No room") && (texts.empty() || texts.back() != text)) {
      texts.push_back(text);
    }
  });
  ASSERT_TRUE(
      Start("navigate_to", {{"goal_pos", "[4, 0]"}, {"recoveries", "spin, back_up,wait, spin"}}));
  EXPECT_TRUE(RunToItsEnd(90));
  EXPECT_THAT(texts, ::testing::ElementsAre("No room to start: spin", "No room to start: back_up",
                                            "No room to start: wait", "No room to start: spin"));
  ASSERT_TRUE(Start("navigate_to", {{"goal_pos", "[4, 0]"}, {"recoveries", "leave, dance"}}));
  EXPECT_TRUE(RunToItsEnd(5));
  EXPECT_THAT(feedback().message,
              HasSubstr("recoveries has 'leave'; expected leave_tight_start, clear, wait"));
}

TEST_F(ARecovery, WaitsAsLongAsItIsAskedTo) {
  ASSERT_TRUE(Start("wait", {{"duration", "12"}}));
  RunFor(11.5);
  EXPECT_TRUE(run().running());
  EXPECT_TRUE(RunToItsEnd(1));
  EXPECT_EQ(feedback().message, "Recovered: wait");
  Run("wait");
  EXPECT_NEAR(ToSeconds(run().now()), 3, 0.2);
  ASSERT_TRUE(Start("wait", {{"duration", "-1"}}));
  Step();
  EXPECT_EQ(feedback().message, "Invalid duration: it is negative");
}

}  // namespace musher::recovery_test
