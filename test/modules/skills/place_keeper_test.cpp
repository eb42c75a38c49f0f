#include "musher/modules/skills/skills/place_keeper.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace musher::skills::place_keeper_test {

TEST(PlaceKeeper, CommandsNothingAtThePlace) {
  PlaceKeeper keeper;
  const navigation::Pose place{{1, 2, 3}, 0.5};
  EXPECT_EQ(keeper.Command(place, place, 0.1), navigation::Velocity{});
}

TEST(PlaceKeeper, CommandsInTheFrameOfTheBody) {
  PlaceKeeper keeper;
  const navigation::Velocity command =
      keeper.Command({{0, 0.1, 0}, M_PI / 2}, {{0, 0, 0}, M_PI / 2}, 0.1);
  EXPECT_GT(command.x_m_s, 0.1);  // the body looks along y
  EXPECT_NEAR(command.y_m_s, 0, 1e-9);
}

TEST(PlaceKeeper, IsNeverFasterThanItsLimits) {
  PlaceKeeper keeper;
  const navigation::Velocity command = keeper.Command({{30, -40, 50}, 3}, {}, 0.1);
  EXPECT_NEAR(std::hypot(command.x_m_s, command.y_m_s), PlaceKeeper::kSpeedMps, 1e-9);
  EXPECT_NEAR(command.z_m_s, PlaceKeeper::kSpeedMps, 1e-9);
  EXPECT_NEAR(command.yaw_rad_s, PlaceKeeper::kYawRateRadS, 1e-9);
}

TEST(PlaceKeeper, TurnsTheShortWay) {
  PlaceKeeper keeper;
  EXPECT_GT(keeper.Command({{}, -3.1}, {{}, 3.1}, 0.1).yaw_rad_s, 0);
}

TEST(PlaceKeeper, LearnsASteadyWindAndForgetsIt) {
  PlaceKeeper keeper;
  const navigation::Pose place{{0, 0, 1}, 0};
  for (int i = 0; i < 10; ++i) static_cast<void>(keeper.Command(place, {{0.1, 0, 1}, 0}, 0.1));
  EXPECT_LT(keeper.Command(place, place, 0.1).x_m_s, -0.05);
  keeper.Reset();
  EXPECT_EQ(keeper.Command(place, place, 0.1), navigation::Velocity{});
}

// While it is far from its place, an integral would make it fly past.
TEST(PlaceKeeper, LearnsNoWindFarFromItsPlace) {
  PlaceKeeper keeper;
  for (int i = 0; i < 100; ++i) static_cast<void>(keeper.Command({{9, 9, 9}, 0}, {}, 0.1));
  EXPECT_EQ(keeper.Command({}, {}, 0.1), navigation::Velocity{});
}

}  // namespace musher::skills::place_keeper_test
