#include "musher/modules/world/sensors/ranging.hpp"

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "musher/modules/world/scene/place.hpp"
#include "musher/test/modules/world/scenes.hpp"

namespace musher::world::ranging_test {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kMost = 30;

Vector3d Heading(double yaw, double down = 0) {
  return {std::cos(down) * std::cos(yaw), std::cos(down) * std::sin(yaw), -std::sin(down)};
}

Box MakeBox(const Vector2d& center, const Vector2d& half, double yaw = 0) {
  Box box;
  box.center_m = center;
  box.half_m = half;
  box.yaw_rad = yaw;
  return box;
}

TEST(Ranging, MeetsAWallAtTheDistanceThatItsAngleGives) {
  Scene scene = EmptyYard();
  scene.boxes = {MakeBox({3, 0}, {0.5, 4})};
  EXPECT_DOUBLE_EQ(DistanceAlong(scene, {0, 0, 0.3}, Heading(0), kMost), 2.5);
  EXPECT_NEAR(DistanceAlong(scene, {0, 0, 0.3}, Heading(0.5), kMost), 2.5 / std::cos(0.5), 1e-12);
  EXPECT_NEAR(DistanceAlong(scene, {0, 0, 0.3}, Heading(0, -0.05), kMost), 2.5 / std::cos(0.05),
              1e-12);
}

TEST(Ranging, MeetsATurnedBoxAtItsNearestCorner) {
  Scene scene = EmptyYard();
  scene.boxes = {MakeBox({4, 0}, {1, 1}, M_PI / 4)};
  EXPECT_NEAR(DistanceAlong(scene, {0, 0, 0.3}, Heading(0), kMost), 4 - std::sqrt(2), 1e-12);
}

TEST(Ranging, MeetsACylinderAndABallAtTheirRadius) {
  Scene scene = EmptyYard();
  scene.circles = {Circle{"", {0, 3}, 0.75}};
  scene.balls = {Ball{{-2, 0, 0.3}, 0.25, {}, false}};
  EXPECT_DOUBLE_EQ(DistanceAlong(scene, {0, 0, 0.3}, Heading(M_PI / 2), kMost), 2.25);
  EXPECT_DOUBLE_EQ(DistanceAlong(scene, {0, 0, 0.3}, Heading(M_PI), kMost), 1.75);
  // Past its side.
  EXPECT_NEAR(DistanceAlong(scene, {0.76, 0, 0.3}, Heading(M_PI / 2), kMost), 10, 1e-9);
}

TEST(Ranging, MeetsABoardFromEitherSideAndNotFromItsEdge) {
  Scene scene = EmptyYard();
  Board board;
  board.center_m = {2, 0};
  board.yaw_rad = M_PI;
  scene.boards = {board};
  EXPECT_DOUBLE_EQ(DistanceAlong(scene, {0, 0, 0.3}, Heading(0), kMost), 2);
  EXPECT_DOUBLE_EQ(DistanceAlong(scene, {3, 0, 0.3}, Heading(M_PI), kMost), 1);
  EXPECT_NEAR(DistanceAlong(scene, {2.01, -2, 0.3}, Heading(M_PI / 2), kMost), 12, 1e-9);
}

TEST(Ranging, PassesARoundBoardOutsideOfItsDisc) {
  Scene scene = EmptyYard();
  Board board{"", {2, 0}, M_PI, 0.4, 0.4, 0.1};
  board.round = true;
  scene.boards = {board};
  EXPECT_DOUBLE_EQ(DistanceAlong(scene, {0, 0.19, 0.3}, Heading(0), kMost), 2);
  EXPECT_DOUBLE_EQ(DistanceAlong(scene, {0, 0.13, 0.43}, Heading(0), kMost), 2);
  EXPECT_GT(DistanceAlong(scene, {0, 0.16, 0.46}, Heading(0), kMost), 9);
}

TEST(Ranging, LooksOverWhatIsLowAndUnderWhatHangs) {
  Scene scene = EmptyYard();
  scene.boxes = {MakeBox({2, 0}, {0.5, 0.5}), MakeBox({-2, 0}, {0.5, 0.5})};
  scene.boxes[0].height_m = 0.2;
  scene.boxes[1].bottom_m = 0.4;
  EXPECT_DOUBLE_EQ(DistanceAlong(scene, {0, 0, 0.1}, Heading(0), kMost), 1.5);
  EXPECT_DOUBLE_EQ(DistanceAlong(scene, {0, 0, 0.3}, Heading(0), kMost), 10) << "the fence";
  EXPECT_DOUBLE_EQ(DistanceAlong(scene, {0, 0, 0.3}, Heading(M_PI), kMost), 10);
  EXPECT_NEAR(DistanceAlong(scene, {0, 0, 0.5}, Heading(M_PI), kMost), 1.5, 1e-12);
  // From above onto its top.
  EXPECT_NEAR(DistanceAlong(scene, {2, 0, 1}, {0, 0, -1}, kMost), 0.8, 1e-12);
}

TEST(Ranging, MeetsTheGroundBelowAndTheSkyAboveTheFence) {
  const Scene scene = EmptyYard();
  EXPECT_NEAR(DistanceAlong(scene, {0, 0, 0.3}, Heading(1, 0.4), kMost), 0.3 / std::sin(0.4),
              1e-12);
  EXPECT_EQ(DistanceAlong(scene, {0, 0, 0.3}, Heading(0, -0.5), kMost), kNothing);
  EXPECT_EQ(DistanceAlong(scene, {0, 0, 0.3}, {0, 0, 1}, kMost), kNothing);
  EXPECT_NEAR(DistanceAlong(scene, {0, 0, 0.3}, Heading(0), kMost), 10, 1e-12);
}

TEST(Ranging, IsInfiniteBeyondItsReachAndZeroInsideAThing) {
  Scene scene = EmptyYard();
  scene.boxes = {MakeBox({3, 0}, {0.5, 4})};
  EXPECT_EQ(DistanceAlong(scene, {0, 0, 0.3}, Heading(0), 2.4), kNothing);
  EXPECT_EQ(DistanceAlong(scene, {3, 0, 0.3}, Heading(0), 2.4), 0);
  EXPECT_EQ(DistanceAlong(scene, {0, 0, -0.1}, Heading(0), 2.4), 0);
}

// Over one side, it comes down to the height of the fence beyond the corner.
TEST(Ranging, MeetsNoFenceBeyondItsCorner) {
  Scene scene = EmptyYard();
  scene.fence_height_m = 0.54;
  EXPECT_EQ(DistanceAlong(scene, {1.549, -7.787, 0.766}, Heading(-2.885, 0.019), kMost), kNothing);
}

// A number in steps of a thousandth.
rc::Gen<double> Between(double least, double most) {
  return rc::gen::map(
      rc::gen::inRange(static_cast<int>(least * 1000), static_cast<int>(most * 1000) + 1),
      [](int thousandths) { return thousandths / 1000.0; });
}

Scene DrawScene() {
  Scene scene = EmptyYard();
  const int boxes = *rc::gen::inRange(0, 5);
  for (int i = 0; i < boxes; ++i) {
    Box box = MakeBox({*Between(-8, 8), *Between(-8, 8)}, {*Between(0.05, 2), *Between(0.05, 2)},
                      *Between(-3.2, 3.2));
    box.height_m = *Between(0.05, 2);
    box.bottom_m = *Between(0, 0.5);
    scene.boxes.push_back(box);
  }
  const int circles = *rc::gen::inRange(0, 4);
  for (int i = 0; i < circles; ++i) {
    Circle circle{"", {*Between(-8, 8), *Between(-8, 8)}, *Between(0.05, 1.5)};
    circle.height_m = *Between(0.05, 2);
    scene.circles.push_back(circle);
  }
  return scene;
}

// How deep a point is inside of anything that stands there; negative outside.
double DepthIn(const Scene& scene, const Vector3d& point) {
  double deepest = -kNothing;
  const auto into = [&](const auto& thing) {
    const double across = -From(thing, point.head<2>()).distance_m;
    const double up =
        std::min(point.z() - thing.bottom_m, thing.bottom_m + thing.height_m - point.z());
    deepest = std::max(deepest, std::min(across, up));
  };
  for (const Box& box : scene.boxes) into(box);
  for (const Circle& circle : scene.circles) into(circle);
  return deepest;
}

RC_GTEST_PROP(RangingProperty, NeverPassesThroughAThingAndEndsOnTheSurfaceOfOne, ()) {
  const Scene scene = DrawScene();
  const Vector3d from(*Between(-9, 9), *Between(-9, 9), *Between(0.01, 1));
  const Vector3d along = Heading(*Between(-3.2, 3.2), *Between(-1.5, 1.5));
  const double distance = DistanceAlong(scene, from, along, kMost);
  if (DepthIn(scene, from) > 1e-9) {
    RC_ASSERT(distance == 0);
    return;
  }
  constexpr int kSteps = 300;
  for (int i = 0; i < kSteps; ++i) {
    const Vector3d point = from + along * (std::min(distance, kMost) * i / kSteps);
    RC_ASSERT(DepthIn(scene, point) < 1e-6);
    RC_ASSERT(point.z() > -1e-6);
  }
  if (distance == kNothing) return;
  const Vector3d end = from + along * distance;
  const Vector2d margin = (scene.most_m - end.head<2>()).cwiseMin(end.head<2>() - scene.least_m);
  const bool at_fence = std::abs(margin.minCoeff()) < 1e-6;
  RC_ASSERT(at_fence || end.z() < 1e-6 || std::abs(DepthIn(scene, end)) < 1e-6);
}

RC_GTEST_PROP(RangingProperty, IsTheSameWithAnyReachThatIsLongEnough, ()) {
  const Scene scene = DrawScene();
  const Vector3d from(*Between(-9, 9), *Between(-9, 9), *Between(0.01, 1));
  const Vector3d along = Heading(*Between(-3.2, 3.2), *Between(-0.5, 1.5));
  const double reach = *Between(0.1, 10);
  const double whole = DistanceAlong(scene, from, along, kMost);
  RC_ASSERT(DistanceAlong(scene, from, along, reach) == (whole <= reach ? whole : kNothing));
}

}  // namespace musher::world::ranging_test
