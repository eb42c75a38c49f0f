// The way off an edge: each place, with what the robot does there, or why it is not certain.

#include "musher/modules/meilin/nodes/edge.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace musher::meilin::edge_test {

using ::testing::HasSubstr;

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

Wheels Of(double mm) {
  return {{mm, mm, mm, mm}, {}};
}

// Beside the edge of (0, 1) and (1, 1), which is 200 mm higher: so far over the upper one.
PoseFix At(double offset_m, double z_m = kUnknown, double yaw_rad = 0, double y_m = 2.4) {
  return {1.8 + offset_m, y_m, yaw_rad, {}, z_m};
}

OffEdge Plan(const PoseFix& pose, const std::optional<Wheels>& wheels) {
  return PlanOffEdge({}, pose, wheels);
}

TEST(TheWayOffAnEdge, IsNoneOnLevelGround) {
  for (const double offset_m : {-0.6, 0.6}) {
    const OffEdge way = Plan(At(offset_m), Of(20));
    EXPECT_FALSE(way.on_edge);
    EXPECT_FALSE(way.next);
    EXPECT_EQ(way.unclear, "");
  }
  EXPECT_FALSE(Plan({-3, 2.4, 0}, Of(20)).on_edge) << "outside the grid";
}
TEST(TheWayOffAnEdge, LowersWheelsThatAreOutAtTheCentreOnLevelGround) {
  const OffEdge there = Plan(At(0.6), Of(400));
  ASSERT_TRUE(there.next);
  EXPECT_FALSE(there.next->drive);
  EXPECT_EQ(there.next->wheels_mm, Settings{}.normal_height_mm);
  const OffEdge beside = Plan(At(0.39), Of(400));
  ASSERT_TRUE(beside.next && beside.next->drive);
  EXPECT_DOUBLE_EQ(beside.next->drive->x_m, 2.4);
}
TEST(TheWayOffAnEdge, IsBackAndDownWhereTheHullIsNotOverTheUpperCell) {
  const OffEdge way = Plan(At(-0.25), Wheels{{205, 205, 100, 205}, {}});
  EXPECT_TRUE(way.on_edge);
  EXPECT_EQ(CellText(way.to), "(0, 1)");
  ASSERT_TRUE(way.next);
  EXPECT_FALSE(way.next->drive) << "all wheels down first";
  const OffEdge then = Plan(At(-0.25), Of(205));
  ASSERT_TRUE(then.next && then.next->drive);
  EXPECT_DOUBLE_EQ(then.next->drive->x_m, 1.2);
}
TEST(TheWayOffAnEdge, IsOnWhereTheHullRestsOnTheUpperCell) {
  const OffEdge way = Plan(At(0.2, 0.22), Of(20));
  EXPECT_EQ(CellText(way.to), "(1, 1)");
  ASSERT_TRUE(way.next && way.next->drive);
  EXPECT_DOUBLE_EQ(way.next->drive->x_m, 2.4);
}

struct Unclear {
  const char* name;
  PoseFix pose;
  std::optional<Wheels> wheels;
  const char* why;
};

class AnEdgeThatIsNotCertain : public ::testing::TestWithParam<Unclear> {};

TEST_P(AnEdgeThatIsNotCertain, MovesNothingAndSaysWhy) {
  const OffEdge way = Plan(GetParam().pose, GetParam().wheels);
  EXPECT_TRUE(way.on_edge);
  EXPECT_FALSE(way.next);
  EXPECT_THAT(way.unclear, HasSubstr(GetParam().why));
  EXPECT_THAT(way.unclear, HasSubstr("put it on a cell by hand"));
}
INSTANTIATE_TEST_SUITE_P(
    Places, AnEdgeThatIsNotCertain,
    ::testing::Values(
        Unclear{"NoWheels", At(0.1), std::nullopt, "the wheels do not report"},
        Unclear{"Across", At(0.1, kUnknown, 0.7), Of(20), "it looks across the edge, 0.70 rad"},
        Unclear{"Corner", At(0.1, kUnknown, 0, 1.8), Of(20), "at a corner or at the border"},
        Unclear{"LongAbove", At(0.1), Wheels{{205, 205, 20, 20}, {}},
                "the wheels of the upper side are long"},
        Unclear{"NothingBelow", At(-0.1), Of(20), "nothing holds the wheels of the lower side"},
        Unclear{"TooLow", At(0.2, 0.02), Of(20), "the body is at 20 mm"},
        Unclear{"TooHigh", At(-0.25, 0.7), Of(205), "the body is at 700 mm"}),
    [](const auto& each) { return each.param.name; });

}  // namespace musher::meilin::edge_test
