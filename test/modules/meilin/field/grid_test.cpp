// The field of the match: heights, cells, directions and where a robot stands to take a box.

#include "musher/modules/meilin/field/grid.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "musher/modules/meilin/field/costs.hpp"

namespace musher::meilin::grid_test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(Grid, HasTheHeightsOfTheBlueHalf) {
  const Grid grid;
  EXPECT_EQ(grid.HeightMm({1, 0}), 400);
  EXPECT_EQ(grid.HeightMm({1, 1}), 200);
  EXPECT_EQ(grid.HeightMm({2, 0}), 600);
  EXPECT_EQ(grid.HeightMm({2, 2}), 200);
  EXPECT_EQ(grid.HeightMm({3, 1}), 600);
  EXPECT_EQ(grid.HeightMm({4, 1}), 400);
  EXPECT_EQ(grid.HeightMm({0, 2}), 0);
  EXPECT_EQ(grid.HeightMm({5, 1}), 0);
}

TEST(Grid, MirrorsTheHeightsOfTheRedHalf) {
  Grid red;
  red.side = Side::kRed;
  EXPECT_EQ(red.HeightMm({2, 0}), 200);
  EXPECT_EQ(red.HeightMm({2, 1}), 400);
  EXPECT_EQ(red.HeightMm({2, 2}), 600);
  const Grid blue;
  for (int row = 0; row < kRows; ++row) {
    for (int col = 0; col < kCols; ++col) {
      EXPECT_EQ(red.HeightMm({row, col}), blue.HeightMm({row, kCols - 1 - col}));
    }
  }
}

TEST(Grid, IsOnTheGroundOutsideOfIt) {
  const Grid grid;
  for (const Cell cell : {Cell{-1, 0}, Cell{6, 1}, Cell{2, -1}, Cell{2, 3}}) {
    EXPECT_FALSE(IsInside(cell));
    EXPECT_EQ(grid.HeightMm(cell), 0);
  }
}

TEST(Grid, FindsEachCellAroundItsCentre) {
  Grid grid;
  grid.origin = {2.14, 0.49};
  for (int row = 0; row < kRows; ++row) {
    for (int col = 0; col < kCols; ++col) {
      const Point2 centre = grid.Centre({row, col});
      for (const double aside_m : {-0.59, 0.0, 0.59}) {
        const auto found = grid.CellAt({centre.x_m + aside_m, centre.y_m - aside_m});
        EXPECT_EQ(found, (Cell{row, col})) << aside_m;
      }
    }
  }
}

TEST(Grid, HasNoCellOutsideForNoNumberAndWithoutASize) {
  Grid grid;
  for (const Point2 at :
       {Point2{0.5, 1.2}, Point2{1.2, 4.3}, Point2{kNan, 1.2}, Point2{1.2, kNan},
        Point2{1e300, 1.2}, Point2{1.2, -std::numeric_limits<double>::infinity()}}) {
    EXPECT_EQ(grid.CellAt(at), std::nullopt) << at.x_m << " " << at.y_m;
  }
  for (const double size_m : {0.0, -1.2, kNan}) {
    grid.size_m = size_m;
    EXPECT_EQ(grid.CellAt({1.2, 1.2}), std::nullopt) << size_m;
  }
}

TEST(Grid, IsAtACentreWithinTheTolerance) {
  const Grid grid;
  EXPECT_TRUE(grid.IsAtCentre({2.4, 1.34}, {1, 0}));
  EXPECT_FALSE(grid.IsAtCentre({2.4, 1.36}, {1, 0}));
}

TEST(Grid, TakesABoxFromAMetreBeforeItsCentre) {
  const Grid grid;
  const Pose2 forward = grid.GraspPose({1, 1}, {2, 1}, 0.05);
  EXPECT_DOUBLE_EQ(forward.x_m, 2.6);
  EXPECT_DOUBLE_EQ(forward.y_m, 2.4);
  EXPECT_EQ(forward.yaw_rad, 0.05) << "the yaw of the plan, not that of the line";
  const Pose2 right = grid.GraspPose({1, 1}, {1, 0}, -kPi / 2);
  EXPECT_DOUBLE_EQ(right.x_m, 2.4);
  EXPECT_DOUBLE_EQ(right.y_m, 2.2);
  const Pose2 same = grid.GraspPose({1, 1}, {1, 1}, 0);
  EXPECT_DOUBLE_EQ(same.x_m, 2.4);
}

TEST(Direction, HasACodeAYawAndAName) {
  struct Case {
    Cell to;
    Direction direction;
    double yaw_rad;
    int code;
    const char* text;
  };
  for (const Case& one : {Case{{3, 1}, Direction::kForward, 0, 0, "forward"},
                          Case{{2, 2}, Direction::kLeft, kPi / 2, 1, "left"},
                          Case{{2, 0}, Direction::kRight, -kPi / 2, 2, "right"},
                          Case{{1, 1}, Direction::kBackward, kPi, 3, "backward"}}) {
    EXPECT_EQ(DirectionTo({2, 1}, one.to), one.direction);
    EXPECT_EQ(DirectionTo(one.to, {2, 1}), Opposite(one.direction));
    EXPECT_EQ(YawOf(one.direction), one.yaw_rad);
    EXPECT_EQ(CodeOf(one.direction), one.code);
    EXPECT_EQ(DirectionText(one.direction), one.text);
  }
}

TEST(Direction, IsNoneBetweenCellsThatShareNoEdge) {
  for (const Cell to : {Cell{2, 1}, Cell{3, 2}, Cell{4, 1}, Cell{0, 0}}) {
    EXPECT_EQ(DirectionTo({2, 1}, to), std::nullopt) << CellText(to);
    EXPECT_FALSE(AreNeighbours({2, 1}, to));
  }
}

TEST(Yaw, IsKeptInOneTurn) {
  EXPECT_DOUBLE_EQ(NormalizeYaw(3 * kPi / 2), -kPi / 2);
  EXPECT_DOUBLE_EQ(NormalizeYaw(kPi), kPi);
  EXPECT_NEAR(YawDistance(3.1, -3.1), 2 * kPi - 6.2, 1e-12);
  EXPECT_TRUE(std::isnan(YawDistance(kNan, 0)));
}

TEST(Yaw, SnapsToTheNearestDirection) {
  EXPECT_EQ(NearestDirection(0.7), Direction::kForward);
  EXPECT_EQ(NearestDirection(0.9), Direction::kLeft);
  EXPECT_EQ(NearestDirection(-1.5), Direction::kRight);
  EXPECT_EQ(NearestDirection(-3.0), Direction::kBackward);
  EXPECT_EQ(SnapYaw(-3.0), kPi);
  EXPECT_EQ(NearestDirection(kNan), Direction::kForward);
}

TEST(Side, IsBlueUnlessTheTextIsRed) {
  EXPECT_EQ(SideOf("red"), Side::kRed);
  EXPECT_EQ(SideOf("blue"), Side::kBlue);
  EXPECT_EQ(SideOf("Red"), Side::kBlue);
  EXPECT_EQ(SideText(Side::kRed), "red");
}

TEST(StepCosts, GrowWithTheStep) {
  const StepCosts costs;
  EXPECT_EQ(costs.Move(200, 200), 1.0);
  EXPECT_EQ(costs.Move(0, 200), 2.5);
  EXPECT_EQ(costs.Move(0, 400), 4.0);
  EXPECT_EQ(costs.Move(600, 400), 3.5);
  EXPECT_EQ(costs.Move(400, 0), 5.0);
  EXPECT_EQ(costs.Fetch(false), 4.0);
  EXPECT_EQ(costs.Fetch(true), 5.0);
}

}  // namespace
}  // namespace musher::meilin::grid_test
