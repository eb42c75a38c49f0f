// The line beside the body, through points with noise and with points of other lines.

#include "musher/modules/line_walker/line_fit.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <random>

namespace musher::line_walker::line_fit_test {

// Of an arc whose nearest point to the origin is `distance_m` to the left (negative: to the right).
GroundPoints ArcPoints(double distance_m, double heading_rad, double curvature_per_m,
                       double from_m = -0.5, double to_m = 1.0, int count = 40,
                       double noise_m = 0.005) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, noise_m);
  const double foot_x = -distance_m * std::sin(heading_rad);
  const double foot_y = distance_m * std::cos(heading_rad);
  GroundPoints points;
  for (int i = 0; i < count; ++i) {
    const double along = from_m + (to_m - from_m) * i / (count - 1);
    const double turned = heading_rad + curvature_per_m * along / 2;
    points.push_back({foot_x + along * std::cos(turned) + noise(random),
                      foot_y + along * std::sin(turned) + noise(random)});
  }
  return points;
}

TEST(SideLine, IsFoundBesideTheBody) {
  const auto line = FitSideLine(ArcPoints(0.415, 0, 0), Side::kLeft, {});
  ASSERT_TRUE(line);
  EXPECT_NEAR(line->distance_m, 0.415, 0.005);
  EXPECT_NEAR(line->heading_rad, 0, 0.02);
  EXPECT_NEAR(line->curvature_per_m, 0, 0.06);
  EXPECT_GT(line->quality, 0.8);
}

TEST(SideLine, HasTheDirectionAndTheCurvatureOfAnArcOnBothSides) {
  for (const double side : {1.0, -1.0}) {
    for (const double heading : {-0.3, 0.0, 0.3}) {
      for (const double curvature : {-0.625, 0.0, 0.625}) {
        const auto line = FitSideLine(ArcPoints(side * 0.35, heading, curvature),
                                      side > 0 ? Side::kLeft : Side::kRight, {});
        ASSERT_TRUE(line) << side << " " << heading << " " << curvature;
        EXPECT_NEAR(line->distance_m, 0.35, 0.01) << heading << " " << curvature;
        EXPECT_NEAR(line->heading_rad, heading, 0.05) << side << " " << curvature;
        EXPECT_NEAR(line->curvature_per_m, curvature, 0.25) << side << " " << heading;
      }
    }
  }
}

TEST(SideLine, IsTheNearerOneOfTwo) {
  GroundPoints points = ArcPoints(0.75, 0, 0, -0.5, 1.0, 55);
  for (const GroundPoint& point : ArcPoints(0.4, 0.05, 0.2)) points.push_back(point);
  const auto line = FitSideLine(points, Side::kLeft, {});
  ASSERT_TRUE(line);
  EXPECT_NEAR(line->distance_m, 0.4, 0.01);
}

TEST(SideLine, IgnoresALineThatCrossesItAndStrayPoints) {
  GroundPoints points = ArcPoints(-0.4, 0, 0.3);
  for (double y = -0.9; y < -0.1; y += 0.04) points.push_back({0.5, y});
  points.push_back({0.1, -0.1});
  points.push_back({-0.2, -0.15});
  const auto line = FitSideLine(points, Side::kRight, {});
  ASSERT_TRUE(line);
  EXPECT_NEAR(line->distance_m, 0.4, 0.015);
  EXPECT_NEAR(line->heading_rad, 0, 0.05);
}

TEST(SideLine, HasTheAssumedCurvatureWhereItIsTooShortToShowOne) {
  const auto points = ArcPoints(0.4, 0, 0.6, 0.0, 0.3, 12, 0.003);
  const auto line = FitSideLine(points, Side::kLeft, {}, 0.6);
  ASSERT_TRUE(line);
  EXPECT_NEAR(line->curvature_per_m, 0.6, 0.25);
  EXPECT_LT(line->quality, 0.4);
}

TEST(SideLine, IsNotMadeOfTooFewPointsNaNOrPointsOfTheOtherSide) {
  EXPECT_FALSE(FitSideLine({}, Side::kLeft, {}));
  EXPECT_FALSE(FitSideLine(ArcPoints(0.4, 0, 0, -0.5, 1, 5), Side::kLeft, {}));
  EXPECT_FALSE(FitSideLine(ArcPoints(0.4, 0, 0), Side::kRight, {}));
  EXPECT_FALSE(FitSideLine(GroundPoints(30, {0.3, 0.4}), Side::kLeft, {})) << "one place";
  const double nan = std::numeric_limits<double>::quiet_NaN();
  GroundPoints points(30, {nan, nan});
  EXPECT_FALSE(FitSideLine(points, Side::kLeft, {}));
  for (const GroundPoint& point : ArcPoints(0.4, 0, 0)) points.push_back(point);
  EXPECT_TRUE(FitSideLine(points, Side::kLeft, {}));
}

TEST(SideLine, IsNoLineAcrossTheWay) {
  GroundPoints points;
  for (double y = 0.1; y < 0.9; y += 0.02) points.push_back({0.4 + 0.05 * y, y});
  EXPECT_FALSE(FitSideLine(points, Side::kLeft, {}));
}

}  // namespace musher::line_walker::line_fit_test
