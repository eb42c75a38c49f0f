#include "musher/navigation/trajectory/rounded_path.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "musher/navigation/navigation_fault.hpp"

namespace musher::navigation::rounded_path_test {

// Poses each 5 cm through these places, as a route has them.
Path Dense(const std::vector<Point>& places) {
  Path path;
  for (std::size_t i = 1; i < places.size(); ++i) {
    const Point &a = places[i - 1], &b = places[i];
    const double yaw_rad = std::atan2(b.y_m - a.y_m, b.x_m - a.x_m);
    const auto count = std::ceil(Distance(a, b) / 0.05);
    for (double j = 0; j < count; ++j) path.push_back({Between(a, b, j / count), yaw_rad});
    if (i + 1 == places.size()) path.push_back({b, yaw_rad});
  }
  return path;
}
double NearestTo(const Path& path, const Point& place) {
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const Pose& pose : path) nearest_m = std::min(nearest_m, Distance(pose.at, place));
  return nearest_m;
}

TEST(RoundedPath, LeavesACornerByNoMoreThanItsRuleAndTurnsInSmallSteps) {
  const Point corner{4, 0, 0};
  for (const double end_deg : {10.0, 45.0, 90.0, -90.0, 115.0}) {
    const double end_rad = end_deg * M_PI / 180;
    const Path path =
        Dense({{0, 0, 0}, corner, {4 + 3 * std::cos(end_rad), 3 * std::sin(end_rad), 0}});
    const auto rounded = RoundCorners(path, {.corner_m = 0.2, .step_m = 0.1});
    ASSERT_TRUE(rounded) << end_deg;
    const Path& result = rounded.value();
    EXPECT_EQ(result.front(), path.front()) << end_deg;
    EXPECT_EQ(result.back(), path.back()) << end_deg;
    const double off_m = NearestTo(result, corner);
    EXPECT_LE(off_m, 0.2 + 1e-9) << end_deg;
    EXPECT_GT(off_m, 0.05) << end_deg;
    for (std::size_t i = 1; i < result.size(); ++i) {
      EXPECT_LE(Distance(result[i - 1].at, result[i].at), 0.2) << end_deg;
      const double turn_rad = Wrapped(result[i].yaw_rad - result[i - 1].yaw_rad);
      EXPECT_LT(std::abs(turn_rad), 0.5) << end_deg << " pose " << i;
    }
  }
}

TEST(RoundedPath, KeepsTheMiddleOfALineBetweenTwoCornersThatAreNear) {
  const Path path = Dense({{0, 0, 0}, {2, 0, 0}, {2, 0.3, 0}, {4, 0.3, 0}});
  const auto rounded = RoundCorners(path, {.corner_m = 1, .step_m = 0.05});
  ASSERT_TRUE(rounded);
  EXPECT_LT(NearestTo(rounded.value(), {2, 0.15, 0}), 0.03);
}

TEST(RoundedPath, KeepsAReversal) {
  const auto rounded = RoundCorners(Dense({{0, 0, 0}, {3, 0, 0}, {1, 0, 0}}));
  ASSERT_TRUE(rounded);
  EXPECT_LT(NearestTo(rounded.value(), {3, 0, 0}), 1e-9);
}

TEST(RoundedPath, OfOnePlaceIsThatPlace) {
  const Path path{{{1, 2, 0}, 0.5}, {{1, 2, 0}, 0.5}};
  const auto rounded = RoundCorners(path);
  ASSERT_TRUE(rounded);
  EXPECT_EQ(rounded.value(), Path{path.front()});
}

TEST(RoundedPath, OfWhatIsNoPathIsRefused) {
  EXPECT_EQ(RoundCorners({}).error().message, "the path has no poses");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(Is(RoundCorners({{{0, 0, 0}, 0}, {{nan, 0, 0}, 0}}).error(), Fault::kInput));
  EXPECT_TRUE(Is(RoundCorners({{{0, 0, 0}, 0}, {{1e308, 0, 0}, 0}}).error(), Fault::kInput));
  EXPECT_TRUE(Is(RoundCorners({{{-1e308, 0, 0}, 0}, {{1e308, 0, 0}, 0}}).error(), Fault::kInput));
}

}  // namespace musher::navigation::rounded_path_test
