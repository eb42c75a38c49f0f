// The drive to a pose, pure, with an ideal holonomic body in virtual time.

#include "musher/modules/meilin/servers/move_to_pose.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace musher::meilin::servers::move_to_pose_test {

using ::testing::HasSubstr;

constexpr double kPi = std::numbers::pi;

class MoveToPoseTest : public ::testing::Test {
 protected:
  // Updates and moves the body until the drive has ended, at most for `limit_s`.
  std::optional<MoveEnd> Drive(double limit_s = 60) {
    const Time until = now_ + FromSeconds(limit_s);
    while (now_ < until) {
      if (auto end = Tick()) return end;
    }
    return std::nullopt;
  }
  std::optional<MoveEnd> Tick() {
    const Duration period = core_.UpdatePeriod();
    now_ += period;
    const double dt = ToSeconds(period);
    Move(dt);
    if (!frozen_) seen_ = body_;
    seen_.x_m += jump_m_;
    if (!silent_) core_.OnPose(seen_, now_, now_.time_since_epoch() - late_);
    const auto step = core_.Update(now_);
    if (step.command) sent_.push_back(*step.command);
    if (step.command) velocity_ = *step.command;
    idle_ = step.idle;
    return step.end;
  }
  void Move(double dt) {
    if (stuck_) return;
    const double c = std::cos(body_.yaw_rad);
    const double s = std::sin(body_.yaw_rad);
    body_.x_m += grip_ * dt * (c * velocity_.x_m_s - s * velocity_.y_m_s);
    body_.y_m += grip_ * dt * (s * velocity_.x_m_s + c * velocity_.y_m_s);
    body_.yaw_rad += dt * (grip_ * velocity_.yaw_rad_s + drift_rad_s_);
  }
  void ExpectReached(const std::optional<MoveEnd>& end) {
    ASSERT_TRUE(end);
    EXPECT_TRUE(end->success) << end->message;
    EXPECT_EQ(end->message, "Goal reached");
  }
  void ExpectFailed(const std::optional<MoveEnd>& end, const std::string& message) {
    ASSERT_TRUE(end);
    EXPECT_FALSE(end->success);
    EXPECT_THAT(end->message, HasSubstr(message));
    EXPECT_EQ(velocity_, BodyVelocity{}) << "the body stands";
  }

  MoveSettings settings_;
  MoveToPose core_{settings_};
  Time now_{Milliseconds(1000)};
  FieldPose body_;
  BodyVelocity velocity_;
  std::vector<BodyVelocity> sent_;
  bool silent_ = false;
  bool stuck_ = false;
  double grip_ = 1;  // of the wheels
  bool idle_ = false;
  double drift_rad_s_ = 0;
  FieldPose seen_;
  bool frozen_ = false;  // the pose that is seen, with rising stamps
  double jump_m_ = 0;
  Duration late_{};
};

TEST_F(MoveToPoseTest, ReachesTheDistanceAndTheYaw) {
  for (const FieldPose target : {FieldPose{2, 1, kPi / 2}, {-1, -1, kPi}, {-1, -1, 0}}) {
    core_.Begin(target, now_);
    ExpectReached(Drive());
    EXPECT_LE(std::hypot(body_.x_m - target.x_m, body_.y_m - target.y_m), 0.015 + 1e-9);
    EXPECT_LE(std::abs(WrappedYaw(body_.yaw_rad - target.yaw_rad)), kPi / 180 + 1e-9);
  }
}

TEST_F(MoveToPoseTest, TurnsFirstAndThenDrives) {
  core_.Begin({1, 0, 1}, now_);
  while (core_.phase() != MovePhase::kXy) ASSERT_FALSE(Tick());
  EXPECT_EQ(body_.x_m, 0);
  EXPECT_NEAR(body_.yaw_rad, 1, 0.02);
}

TEST_F(MoveToPoseTest, TurnsTheShortWay) {
  body_.yaw_rad = 3;
  core_.Begin({0, 0, -3}, now_);
  Tick();
  Tick();
  EXPECT_GT(velocity_.yaw_rad_s, 0);
}

TEST_F(MoveToPoseTest, KeepsItsSpeedsWithinTheLimits) {
  core_.Begin({3, -2, 2}, now_);
  ExpectReached(Drive());
  for (const BodyVelocity& v : sent_) {
    const double speed = std::hypot(v.x_m_s, v.y_m_s);
    EXPECT_LE(speed, 1.5 + 1e-9);
    EXPECT_TRUE(speed < 1e-9 || speed >= 0.15 - 1e-9) << speed;
    EXPECT_LE(std::abs(v.yaw_rad_s), 1.5);
  }
}

TEST_F(MoveToPoseTest, IsNotReachedWhileTheYawIsWrong) {
  // The body turns while it drives: at the place the yaw is not there yet.
  settings_.max_xy_yaw_rad_s = 0;
  core_ = MoveToPose(settings_);
  drift_rad_s_ = 0.15;
  core_.Begin({1, 0, 0}, now_);
  ExpectReached(Drive());
  EXPECT_LE(std::abs(body_.yaw_rad), kPi / 180 + 0.15 * 0.4) << "and the time of the brake";
}

TEST_F(MoveToPoseTest, BrakesWithZerosFiftyTimesASecondBeforeTheResult) {
  core_.Begin({0.5, 0, 0}, now_);
  ExpectReached(Drive());
  ASSERT_GE(sent_.size(), 16U);
  for (std::size_t i = sent_.size() - 15; i < sent_.size(); ++i) {
    EXPECT_EQ(sent_[i], BodyVelocity{});
  }
  EXPECT_TRUE(idle_);
  const std::size_t sent = sent_.size();
  Tick();
  EXPECT_EQ(sent_.size(), sent) << "nothing is sent any more";
}

TEST_F(MoveToPoseTest, WaitsTwoSecondsForAPose) {
  silent_ = true;
  core_.Begin({1, 0, 0}, now_);
  const Time begin = now_;
  ExpectFailed(Drive(), "Timed out waiting for relocation pose");
  EXPECT_EQ(now_ - begin, Milliseconds(2000));
}

TEST_F(MoveToPoseTest, BeginsWhenThePoseComes) {
  silent_ = true;
  core_.Begin({1, 0, 0}, now_);
  Drive(1);
  silent_ = false;
  ExpectReached(Drive());
}

TEST_F(MoveToPoseTest, StopsWhenThePoseIsLost) {
  for (const FieldPose target : {FieldPose{0, 0, 3}, {3, 0, 0}}) {
    body_ = {};
    silent_ = false;
    core_.Begin(target, now_);
    Drive(0.5);
    silent_ = true;
    ExpectFailed(Drive(), "Pose lost: no pose for 0.6 s");
  }
}

TEST_F(MoveToPoseTest, IgnoresPosesThatAreNotFinite) {
  core_.OnPose({std::numeric_limits<double>::quiet_NaN(), 0, 0}, now_);
  EXPECT_EQ(core_.Blind(now_), "no pose yet");
  core_.OnPose({0, std::numeric_limits<double>::infinity(), 0}, now_);
  EXPECT_EQ(core_.Blind(now_), "no pose yet");
}

// It drove on with the velocity of that error, past the goal and off the platform.
TEST_F(MoveToPoseTest, StopsSoonWhereThePoseStandsWhileItDrives) {
  core_.Begin({2, 0, 0}, now_);
  while (body_.x_m < 1.2) ASSERT_FALSE(Tick());
  frozen_ = true;
  ExpectFailed(Drive(), "its odometry does not change at all");
  EXPECT_LT(body_.x_m, 2.2);
  frozen_ = false;
  core_.Begin({2, 0, 3}, now_);
  Drive(0.5);
  frozen_ = true;
  ExpectFailed(Drive(), "its odometry does not change at all");
}

TEST_F(MoveToPoseTest, StopsWhereThePoseJumps) {
  core_.Begin({2, 0, 0}, now_);
  ASSERT_FALSE(Drive(0.5));
  jump_m_ = -2;
  ExpectFailed(Drive(), "the pose has jumped by 1.9");
  core_.Begin({0, 1, 0}, now_);
  EXPECT_FALSE(Drive(0.2)) << "another drive begins from there";
}

TEST_F(MoveToPoseTest, StopsWherePosesComeEverLater) {
  core_.Begin({20, 0, 0}, now_);
  ASSERT_FALSE(Drive(0.5));
  late_ = Milliseconds(450);
  ASSERT_FALSE(Drive(0.5));
  late_ = Milliseconds(550);
  ExpectFailed(Drive(), "Pose lost: it comes 0.6 s late");
  core_.Begin({0, 1, 0}, now_);
  ExpectReached(Drive());  // the clocks of two computers may differ by as much
}

TEST_F(MoveToPoseTest, WaitsForItsWheelsAtTheStepOfAClimb) {
  core_.OnClimbing(true);
  core_.Begin({1, 0, 0}, now_);
  ASSERT_FALSE(Drive(0.5));
  stuck_ = true;
  EXPECT_FALSE(Drive(5));
  core_.OnClimbing(false);
  stuck_ = false;
  ExpectReached(Drive());
  core_.Begin({0, 0, 0}, now_);
  stuck_ = true;
  ExpectFailed(Drive(2), "it is stuck");
}

TEST_F(MoveToPoseTest, EndsThePhasesAtTheirLimits) {
  grip_ = 0.15;
  core_.Begin({0, 0, 1}, now_);
  ExpectFailed(Drive(), "Yaw phase timed out");
  core_.Begin({3, 0, body_.yaw_rad}, now_);
  const Time begin = now_;
  ExpectFailed(Drive(), "XY phase timed out");
  EXPECT_NEAR(ToSeconds(now_ - begin), 10, 0.2);
}

TEST_F(MoveToPoseTest, NamesThePhaseOfACancelledDrive) {
  silent_ = true;
  core_.Begin({1, 0, 1}, now_);
  EXPECT_EQ(core_.CancelText(), "Goal canceled while waiting for relocation pose");
  silent_ = false;
  Tick();
  EXPECT_EQ(core_.CancelText(), "Goal canceled during yaw phase");
  while (core_.phase() != MovePhase::kXy) ASSERT_FALSE(Tick());
  EXPECT_EQ(core_.CancelText(), "Goal canceled during xy phase");
  core_.Stop(now_);
  Tick();
  EXPECT_EQ(velocity_, BodyVelocity{});
  EXPECT_FALSE(Drive(1)) << "the caller has given the result";
}

TEST_F(MoveToPoseTest, DrivesSlowlyDuringAClimb) {
  settings_.climb_m_s = 0.3;
  core_ = MoveToPose(settings_);
  core_.OnClimbing(true);
  core_.Begin({2, 0, 0}, now_);
  Drive(1);
  EXPECT_NEAR(velocity_.x_m_s, 0.3, 1e-9);
  core_.OnClimbing(false);
  Drive(0.1);
  EXPECT_GT(velocity_.x_m_s, 1);
}

TEST_F(MoveToPoseTest, SlowsDownBeforeTheGoalByItsLimit) {
  settings_.brake_m_s2 = 1;
  core_ = MoveToPose(settings_);
  core_.Begin({2, 0, 0}, now_);
  while (!idle_) {
    const double left = 2 - body_.x_m;
    Tick();
    if (velocity_.x_m_s > 0.15) {
      EXPECT_LE(velocity_.x_m_s, std::sqrt(2 * left) + 1e-9);
    }
  }
}

TEST_F(MoveToPoseTest, GoesOnToANewTarget) {
  core_.Begin({3, 0, 0}, now_);
  Drive(1);
  core_.Begin({0, 1, 0}, now_);
  ExpectReached(Drive());
  EXPECT_NEAR(body_.y_m, 1, 0.02);
}

}  // namespace musher::meilin::servers::move_to_pose_test
