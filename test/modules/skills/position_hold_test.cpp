#include "musher/modules/skills/robot/position_hold.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace musher::skills::position_hold_test {

TEST(PositionHold, CommandsNothingAtThePlace) {
  PositionHold hold;
  const navigation::Pose place{{1, 2, 3}, 0.5};
  EXPECT_EQ(hold.Command(place, place, 0.1), navigation::Velocity{});
}

TEST(PositionHold, CommandsInTheFrameOfTheBody) {
  PositionHold hold;
  const navigation::Velocity command =
      hold.Command({{0, 0.1, 0}, M_PI / 2}, {{0, 0, 0}, M_PI / 2}, 0.1);
  EXPECT_GT(command.x_m_s, 0.1);  // the body looks along y
  EXPECT_NEAR(command.y_m_s, 0, 1e-9);
}

TEST(PositionHold, IsNeverFasterThanItsLimits) {
  PositionHold hold;
  const navigation::Velocity command = hold.Command({{30, -40, 50}, 3}, {}, 0.1);
  EXPECT_NEAR(std::hypot(command.x_m_s, command.y_m_s), PositionHold::kSpeedMps, 1e-9);
  EXPECT_NEAR(command.z_m_s, PositionHold::kSpeedMps, 1e-9);
  EXPECT_NEAR(command.yaw_rad_s, PositionHold::kYawRateRadS, 1e-9);
}

TEST(PositionHold, TurnsTheShortWay) {
  PositionHold hold;
  EXPECT_GT(hold.Command({{}, -3.1}, {{}, 3.1}, 0.1).yaw_rad_s, 0);
}

TEST(PositionHold, LearnsASteadyWindAndForgetsIt) {
  PositionHold hold;
  const navigation::Pose place{{0, 0, 1}, 0};
  for (int i = 0; i < 10; ++i) static_cast<void>(hold.Command(place, {{0.1, 0, 1}, 0}, 0.1));
  EXPECT_LT(hold.Command(place, place, 0.1).x_m_s, -0.05);
  hold.Reset();
  EXPECT_EQ(hold.Command(place, place, 0.1), navigation::Velocity{});
}

// While it is far from its place, an integral would make it fly past.
TEST(PositionHold, LearnsNoWindFarFromItsPlace) {
  PositionHold hold;
  for (int i = 0; i < 100; ++i) static_cast<void>(hold.Command({{9, 9, 9}, 0}, {}, 0.1));
  EXPECT_EQ(hold.Command({}, {}, 0.1), navigation::Velocity{});
}

}  // namespace musher::skills::position_hold_test
