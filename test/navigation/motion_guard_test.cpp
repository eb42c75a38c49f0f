// What a body is commanded beside what its odometry says.

#include "musher/navigation/gate/motion_guard.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "musher/navigation/navigation_fault.hpp"

namespace musher::navigation::motion_guard_test {

using ::testing::HasSubstr;

class Guard : public ::testing::Test {
 protected:
  // 50 poses and commands a second; until a fault, or for so long.
  std::optional<Error> RunFor(double seconds, const Velocity& command, const Velocity& moves) {
    for (int i = 0; i < 50 * seconds; ++i) {
      now_ += Milliseconds(20);
      pose_.yaw_rad = Wrapped(pose_.yaw_rad + moves.yaw_rad_s * 0.02);
      pose_.at.x_m += moves.x_m_s * std::cos(pose_.yaw_rad) * 0.02;
      pose_.at.y_m += moves.x_m_s * std::sin(pose_.yaw_rad) * 0.02;
      pose_.at.z_m += moves.z_m_s * 0.02;
      if (auto fault = guard_.OnPose(pose_, now_.time_since_epoch(), now_)) return fault;
      if (auto fault = guard_.OnCommand(command, now_)) return fault;
    }
    return std::nullopt;
  }

  MotionGuard guard_{GuardRules{}};
  Pose pose_;
  Time now_ = Time{} + std::chrono::seconds(50);
};

TEST_F(Guard, IsContentWithABodyThatMovesAsItIsCommanded) {
  EXPECT_FALSE(RunFor(20, {1.5, 0, 0, 0}, {1.5, 0, 0, 0}));
  EXPECT_FALSE(RunFor(20, {0.3, 0, 0, 1}, {0.3, 0, 0, 1})) << "on a small circle";
  EXPECT_FALSE(RunFor(20, {0, 0, 0, 0.3}, {0, 0, 0, 0.3}));
  EXPECT_FALSE(RunFor(20, {0.05, 0, 0, 0}, {0.05, 0, 0, 0})) << "slowly";
  EXPECT_FALSE(RunFor(20, {}, {}));
  EXPECT_FALSE(RunFor(20, {0, 0, 0.5, 0}, {0, 0, 0.5, 0})) << "upwards";
}

TEST_F(Guard, SaysThatAnOdometryStandsBesideCommands) {
  EXPECT_FALSE(RunFor(2, {1, 0, 0, 0}, {1, 0, 0, 0}));
  const Time begin = now_;
  const auto fault = RunFor(5, {1, 0, 0, 0}, {});
  ASSERT_TRUE(fault);
  EXPECT_TRUE(Is(*fault, Fault::kStuck));
  EXPECT_THAT(fault->message, HasSubstr("its odometry does not change at all"));
  EXPECT_LE(now_ - begin, Milliseconds(1100));
}

TEST_F(Guard, SaysThatAnOdometryStandsWhereverItHasStoppedToChange) {
  for (const int more : {1, 2, 3, 4}) {
    guard_.Restart();
    EXPECT_FALSE(RunFor(2 + 0.02 * more, {1, 0, 0, 0}, {1, 0, 0, 0}));
    const Time begin = now_;
    const auto fault = RunFor(5, {1, 0, 0, 0}, {});
    ASSERT_TRUE(fault);
    EXPECT_THAT(fault->message, HasSubstr("its odometry does not change at all"));
    EXPECT_LE(now_ - begin, Milliseconds(1100));
  }
}

TEST_F(Guard, SaysThatABodyIsStuckAlsoWhenItTrembles) {
  const Time begin = now_;
  std::optional<Error> fault;
  for (int i = 0; i < 200 && !fault; ++i) {
    fault = RunFor(0.04, {0.5, 0, 0, 0}, {i % 2 == 0 ? 0.2 : -0.2, 0, 0, 0});
  }
  ASSERT_TRUE(fault);
  EXPECT_THAT(fault->message, HasSubstr("shows no motion: it is stuck, its wheels slip"));
  EXPECT_NEAR(ToSeconds(now_ - begin), 3, 0.2);
}

TEST_F(Guard, LetsABodyStandAsLongAsTheGateHoldsIt) {
  EXPECT_FALSE(RunFor(60, {}, {}));
  EXPECT_FALSE(RunFor(10, {0.02, 0, 0, 0}, {})) << "0.2 m were commanded";
}

TEST_F(Guard, SaysThatThePoseHasJumped) {
  EXPECT_FALSE(RunFor(1, {1, 0, 0, 0}, {1, 0, 0, 0}));
  pose_.at.x_m += 0.3;
  EXPECT_FALSE(RunFor(1, {1, 0, 0, 0}, {1, 0, 0, 0})) << "a correction";
  pose_.at.y_m += 30;
  const auto fault = RunFor(0.02, {1, 0, 0, 0}, {1, 0, 0, 0});
  ASSERT_TRUE(fault);
  EXPECT_TRUE(Is(*fault, Fault::kJump));
  EXPECT_THAT(fault->message, HasSubstr("the pose has jumped by 30 m in 0.02 s"));
  EXPECT_FALSE(RunFor(1, {1, 0, 0, 0}, {1, 0, 0, 0})) << "it goes on from there";
  pose_.yaw_rad += 2;
  EXPECT_TRUE(RunFor(0.02, {}, {}));
}

TEST_F(Guard, SaysThatAPoseRunsAwayInSmallSteps) {
  EXPECT_FALSE(RunFor(1, {1, 0, 0, 0}, {1, 0, 0, 0}));
  const auto fault = RunFor(1, {1, 0, 0, 0}, {9, 0, 0, 0});
  ASSERT_TRUE(fault);
  EXPECT_TRUE(Is(*fault, Fault::kJump));
}

TEST_F(Guard, TakesMessagesThatWereHeldUpForNoJump) {
  EXPECT_FALSE(RunFor(1, {1, 0, 0, 0}, {1, 0, 0, 0}));
  now_ += Milliseconds(800);
  for (int i = 0; i < 40; ++i) {  // at once, with the stamps of 0.8 s
    pose_.at.x_m += 1.5 * 0.02;
    const Duration stamp = now_.time_since_epoch() - Milliseconds(800 - 20 * i);
    EXPECT_FALSE(guard_.OnPose(pose_, stamp, now_));
  }
}

// They counted as time, in which a body can move that far.
TEST_F(Guard, SaysThatThePoseHasJumpedAlsoWhereTheStampsLeapAhead) {
  for (const int ahead_s : {1, 8, 100}) {
    guard_.Forget();
    EXPECT_FALSE(RunFor(1, {1, 0, 0, 0}, {1, 0, 0, 0}));
    now_ += Milliseconds(20);
    pose_.at.x_m += 2;
    const Duration stamp = now_.time_since_epoch() + std::chrono::seconds(ahead_s);
    const auto fault = guard_.OnPose(pose_, stamp, now_);
    ASSERT_TRUE(fault) << ahead_s;
    EXPECT_THAT(fault->message, HasSubstr("the pose has jumped by 2 m in 0.02 s"));
  }
}

TEST_F(Guard, SaysThatAPoseRunsAwayAlsoWhereTheStampsRunFaster) {
  EXPECT_FALSE(RunFor(1, {1, 0, 0, 0}, {1, 0, 0, 0}));
  Duration stamp = now_.time_since_epoch();
  std::optional<Error> fault;
  for (int i = 0; i < 50 && !fault; ++i) {
    now_ += Milliseconds(20);
    stamp += Milliseconds(200);
    pose_.at.x_m += 0.2;
    fault = guard_.OnPose(pose_, stamp, now_);
  }
  EXPECT_TRUE(fault) << "10 m in a second";
}

TEST_F(Guard, SaysThatABodyIsCarried) {
  EXPECT_FALSE(RunFor(1, {1, 0, 0, 0}, {1, 0, 0, 0}));
  EXPECT_FALSE(RunFor(1, {}, {0.3, 0, 0, 0})) << "it rolls out";
  EXPECT_FALSE(RunFor(3, {}, {}));
  const auto fault = RunFor(3, {}, {0.5, 0, 0, 0});
  ASSERT_TRUE(fault);
  EXPECT_TRUE(Is(*fault, Fault::kPushed));
  EXPECT_THAT(fault->message, HasSubstr("without a command: it is pushed or carried"));
}

TEST_F(Guard, IgnoresPosesThatAreNotFinite) {
  EXPECT_FALSE(RunFor(1, {1, 0, 0, 0}, {1, 0, 0, 0}));
  const Pose bad{{std::nan(""), 1e308, 0}, 0};
  EXPECT_FALSE(guard_.OnPose(bad, Duration{}, now_));
  EXPECT_FALSE(RunFor(1, {1, 0, 0, 0}, {1, 0, 0, 0}));
  EXPECT_TRUE(guard_.OnPose({{1e308, 0, 0}, 0}, Duration{}, now_));
}

}  // namespace musher::navigation::motion_guard_test
