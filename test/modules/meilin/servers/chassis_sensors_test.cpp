// The filters of the chassis' sensors, and their order by the direction of a climb.

#include "musher/modules/meilin/servers/chassis_sensors.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <set>

namespace musher::meilin::servers::chassis_sensors_test {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(DistanceFilter, IsTheMeanOfFive) {
  DistanceFilter filter;
  for (const double mm : {10, 20, 30, 40}) {
    filter.OnReading(mm);
    EXPECT_FALSE(filter.mm());
  }
  filter.OnReading(50);
  EXPECT_EQ(filter.mm(), 30);
  filter.OnReading(60);
  EXPECT_EQ(filter.mm(), 40);
}

TEST(DistanceFilter, ForgetsAtAReadingThatIsNone) {
  for (const double none : {kNan, 0.0, -1.0, std::numeric_limits<double>::infinity()}) {
    DistanceFilter filter;
    for (int i = 0; i < 5; ++i) filter.OnReading(100);
    filter.OnReading(none);
    EXPECT_FALSE(filter.mm()) << none;
    for (int i = 0; i < 4; ++i) filter.OnReading(100);
    EXPECT_FALSE(filter.mm());
    filter.OnReading(100);
    EXPECT_EQ(filter.mm(), 100);
  }
}

TEST(SwitchFilter, NeedsTwoEqualReadings) {
  SwitchFilter filter;
  filter.OnReading(true);
  EXPECT_FALSE(filter.on());
  filter.OnReading(true);
  EXPECT_EQ(filter.on(), true);
  filter.OnReading(false);
  filter.OnReading(true);
  filter.OnReading(false);
  EXPECT_EQ(filter.on(), true);
  filter.OnReading(false);
  EXPECT_EQ(filter.on(), false);
}

TEST(ClimbView, IsTheBodyTurned) {
  for (const ClimbDirection direction : {ClimbDirection::kForward, ClimbDirection::kLeft,
                                         ClimbDirection::kRight, ClimbDirection::kBackward}) {
    const ClimbView& view = ViewOf(direction);
    EXPECT_EQ(std::set(view.corners.begin(), view.corners.end()).size(), 4U);
    // The down sensors of two opposite sides, the ahead sensors beside them.
    EXPECT_EQ(view.distances[0] % 2, 0U);
    EXPECT_EQ(view.distances[1], view.distances[0] + 1);
    EXPECT_EQ(view.distances[3], (view.distances[0] + 4) % 8);
    EXPECT_EQ(view.distances[2], view.distances[3] + 1);
  }
}

}  // namespace musher::meilin::servers::chassis_sensors_test
