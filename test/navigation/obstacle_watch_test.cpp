// What counts as an obstacle in the way, and the points of a scan.

#include "musher/navigation/controller/obstacle_watch.hpp"

#include <gmock/gmock.h>

#include <limits>

namespace musher::navigation::obstacle_watch_test {

using ::testing::IsEmpty;
using ::testing::SizeIs;

const ObstacleRules kRules = {0.3, 0.1, 0.2, 0.2, 0.8, 2.0, 0.1, 0.5, 0.3};

Trajectory Straight() {
  return MakeTrajectory({{{0, 0, 0}, 0}, {{10, 0, 0}, 0}}, {}).value();
}

auto Look(Duration at, double ahead_m, const std::vector<Point>& obstacles, bool flat = true) {
  return FirstObstruction(Straight(), at, ahead_m, obstacles, flat, kRules);
}

TEST(ObstacleWatch, SeesAnObstacleWithinItsWayOnly) {
  EXPECT_TRUE(Look({}, 2, {{1.5, 0, 0}}));
  EXPECT_TRUE(Look({}, 2, {{1.5, 0.35, 0}})) << "the body would pass it too near";
  EXPECT_FALSE(Look({}, 2, {{1.5, 0.45, 0}})) << "beside its path";
  EXPECT_FALSE(Look({}, 1, {{1.5, 0, 0}})) << "farther ahead";
  EXPECT_FALSE(Look({}, 2, {}));
}

TEST(ObstacleWatch, SaysHowFarTheBodyCanGo) {
  const auto obstruction = Look({}, 2, {{1.9, 0, 0}, {1.5, 0, 0}});
  ASSERT_TRUE(obstruction);
  EXPECT_EQ(obstruction->at, (Point{1.5, 0, 0}));
  EXPECT_NEAR(obstruction->ahead_m, 1.1, 0.05);
}

TEST(ObstacleWatch, LetsABodyLeaveAnObstacleBehind) {
  const Duration at = std::chrono::seconds(4);
  const double x_m = Straight().At(at).pose.at.x_m;
  EXPECT_FALSE(Look(at, 2, {{x_m - 0.2, 0, 0}}));
  EXPECT_FALSE(Look(at, 2, {{x_m, 0.35, 0}})) << "beside it";
  EXPECT_TRUE(Look(at, 2, {{x_m + 0.3, 0.2, 0}}));
}

TEST(ObstacleWatch, ComparesHeightsInSpaceOnly) {
  EXPECT_TRUE(Look({}, 2, {{1.5, 0, 3}}, true));
  EXPECT_FALSE(Look({}, 2, {{1.5, 0, 3}}, false));
  EXPECT_TRUE(Look({}, 2, {{1.5, 0, 0.3}}, false));
}

TEST(ObstacleWatch, IgnoresPointsThatAreNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(Look({}, 2, {{nan, 0, 0}, {1, nan, 0}}));
}

TEST(ObstacleWatch, EndsAtTheEndOfTheTrajectory) {
  EXPECT_FALSE(Look(std::chrono::hours(1), 2, {{10.2, 0, 0}}));
  EXPECT_FALSE(Look({}, 20, {{10.5, 0, 0}}));
  EXPECT_TRUE(Look({}, 20, {{10.3, 0, 0}}));
}

TEST(BrakingDistance, IsThatOfAConstantDecelerationAfterAReaction) {
  EXPECT_DOUBLE_EQ(BrakingDistance(1.5, kRules), 0.15 + 1.5 * 1.5 / 1.6);
  EXPECT_EQ(BrakingDistance(0, kRules), 0);
}

TEST(Scan, GivesThePlacesOfItsRanges) {
  const float inf = std::numeric_limits<float>::infinity();
  const Scan scan{-M_PI / 2, M_PI / 2, 0.1, 5, {1, 2, 3, inf, NAN, 0.05F, 6}};
  const std::vector<Point> points = PointsOf(scan, {{10, 20, 0.4}, M_PI / 2});
  ASSERT_THAT(points, SizeIs(3));
  EXPECT_NEAR(points[0].x_m, 11, 1e-6);
  EXPECT_NEAR(points[1].y_m, 22, 1e-6);
  EXPECT_NEAR(points[2].x_m, 7, 1e-6);
  EXPECT_EQ(points[2].z_m, 0.4);
  EXPECT_THAT(PointsOf(scan, {{NAN, 0, 0}, 0}), IsEmpty());
}

}  // namespace musher::navigation::obstacle_watch_test
