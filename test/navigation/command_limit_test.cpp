// The change from one command of a body to the next stays within its accelerations.

#include "musher/navigation/controller/command_limit.hpp"

#include <gtest/gtest.h>

namespace musher::navigation::command_limit_test {

constexpr Duration kStep = Milliseconds(50);

MotionLimits Limits() {
  MotionLimits limits;
  limits.acceleration_m_s2 = 1;
  limits.yaw_rad_s2 = 2;
  return limits;
}

class ACommandLimit : public ::testing::Test {
 protected:
  ACommandLimit() { limit_.Begin(now_); }
  // Wanted for a step, of which the gate lets this share pass.
  Velocity Send(const Velocity& wanted, double share) {
    now_ += kStep;
    const Velocity command = limit_.BeforeGate(wanted, 0, now_, false);
    return limit_.AfterGate({share * command.x_m_s, share * command.y_m_s, share * command.z_m_s,
                             share * command.yaw_rad_s},
                            0);
  }

  Time now_{};
  CommandLimit limit_{Limits(), true};
};

TEST_F(ACommandLimit, LetsABodyThatTheGateHasStoppedTurnOnWithinItsAcceleration) {
  for (int i = 0; i < 40; ++i) ASSERT_EQ(Send({0, 0, 0, 1}, 0).yaw_rad_s, 0);
  double last_rad_s = 0;
  for (int i = 0; i < 20; ++i) {
    const double sent_rad_s = Send({0, 0, 0, 1}, 1).yaw_rad_s;
    EXPECT_LE(sent_rad_s - last_rad_s, 0.1 + 1e-9);
    last_rad_s = sent_rad_s;
  }
  EXPECT_NEAR(last_rad_s, 1, 1e-9);
}

TEST_F(ACommandLimit, LetsABodyTurnOnTheOtherWayWithinItsAcceleration) {
  for (int i = 0; i < 40; ++i) Send({0, 0, 0, 0.4}, 1);
  for (int i = 0; i < 40; ++i) Send({0, 0, 0, -1}, 0);
  EXPECT_NEAR(Send({0, 0, 0, -1}, 1).yaw_rad_s, -0.1, 1e-9);
}

TEST_F(ACommandLimit, LetsTheGateStopATurnAtOnce) {
  for (int i = 0; i < 40; ++i) Send({0, 0, 0, 1}, 1);
  EXPECT_NEAR(Send({0, 0, 0, 1}, 0.2).yaw_rad_s, 0.2, 1e-9);
  EXPECT_EQ(Send({0, 0, 0, 1}, 0).yaw_rad_s, 0);
}

}  // namespace musher::navigation::command_limit_test
