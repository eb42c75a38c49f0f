// The line across the lane's end, distinguished from the lines of the lane's sides.

#include "musher/modules/line_walker/end_line.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

namespace musher::line_walker::end_line_test {

// The two sides of a lane that begins to turn beside the body, as far as the front camera shows it.
GroundPoints Sides(double radius_m, double to_m) {
  GroundPoints points;
  for (double along = 0.65; along < to_m; along += 0.02) {
    for (const double left : {0.415, -0.415}) {
      const double turned = along / radius_m;
      points.push_back(
          {(radius_m - left) * std::sin(turned), radius_m - (radius_m - left) * std::cos(turned)});
    }
  }
  return points;
}

GroundPoints Across(double at_m, double turned_rad, double from_m = -0.4, double to_m = 0.4) {
  GroundPoints points;
  for (double left = from_m; left <= to_m; left += 0.02) {
    points.push_back({at_m - left * std::sin(turned_rad), left * std::cos(turned_rad)});
  }
  return points;
}

TEST(EndLine, IsFoundAheadWithTheLanesSides) {
  GroundPoints points = Sides(1e6, 1.0);
  for (const GroundPoint& point : Across(1.0, 0.1)) points.push_back(point);
  const auto end = FindEndLine(points, 0, {});
  ASSERT_TRUE(end);
  EXPECT_NEAR(end->middle.x_m, 1.0, 0.02);
  EXPECT_NEAR(end->middle.y_m, 0, 0.05);
  EXPECT_NEAR(end->heading_rad, 0.1, 0.03);
}

TEST(EndLine, IsFoundWhenTheBodyIsTurned) {
  const auto end = FindEndLine(Across(0.9, -0.4), -0.35, {});
  ASSERT_TRUE(end);
  EXPECT_NEAR(end->heading_rad, -0.4, 0.03);
}

TEST(EndLine, IsNoSideOfALaneThatCurves) {
  for (const double radius : {1.6, -1.6, 2.5, -2.5}) {
    for (const double heading : {-0.1, 0.0, 0.1}) {
      EXPECT_FALSE(FindEndLine(Sides(radius, 1.8), heading, {})) << radius << " " << heading;
    }
  }
}

TEST(EndLine, IsNeitherTooFarTooShortNorBroken) {
  EXPECT_FALSE(FindEndLine(Across(1.3, 0), 0, {}));
  EXPECT_FALSE(FindEndLine(Across(0.9, 0, -0.15, 0.15), 0, {}));
  GroundPoints broken = Across(0.9, 0, -0.4, -0.15);
  for (const GroundPoint& point : Across(0.9, 0, 0.15, 0.4)) broken.push_back(point);
  EXPECT_FALSE(FindEndLine(broken, 0, {}));
}

TEST(EndLine, IsNotMadeOfNothingOrNaN) {
  EXPECT_FALSE(FindEndLine({}, 0, {}));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  GroundPoints points(20, {nan, 1});
  EXPECT_FALSE(FindEndLine(points, 0, {}));
  for (const GroundPoint& point : Across(0.9, 0)) points.push_back(point);
  EXPECT_TRUE(FindEndLine(points, 0, {}));
}

}  // namespace musher::line_walker::end_line_test
