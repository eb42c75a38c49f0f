// Maps of occupancy grids, of point clouds and of octrees, also bad, empty and large ones.

#include <gmock/gmock.h>

#include <limits>
#include <random>

#include "musher/navigation/navigation_fault.hpp"
#include "musher/navigation/planner/cell_map.hpp"
#include "musher/navigation/planner/octree_map.hpp"
#include "musher/navigation/planner/planner.hpp"

namespace musher::navigation::map_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

OccupancyGrid Grid() {
  return {0.5, {{1, 2, 0}, 0}, 3, 2, {0, 64, 65, 100, -1, 0}};
}

std::string MessageOf(const OccupancyGrid& grid) {
  const auto map = FromOccupancyGrid(grid, {});
  EXPECT_FALSE(map.ok());
  EXPECT_TRUE(map.ok() || Is(map.error(), Fault::kMap));
  return map.ok() ? "" : map.error().message;
}

TEST(CellMap, TakesTheOccupancyOfAGrid) {
  const CellMap map = FromOccupancyGrid(Grid(), {}).value();
  EXPECT_THAT(map.blocked, ElementsAre(0, 0, 1, 1, 1, 0)) << "unknown is blocked";
  EXPECT_EQ(map.CellOf({2.2, 2.7, 0}), (Cell{2, 1, 0}));
  EXPECT_EQ(map.CentreOf({2, 1, 0}), (Point{2.25, 2.75, 0}));
  OccupancyRules rules;
  rules.unknown_is_free = true;
  EXPECT_THAT(FromOccupancyGrid(Grid(), rules).value().blocked, ElementsAre(0, 0, 1, 1, 0, 0));
}

TEST(CellMap, IsTurnedWithItsOrigin) {
  OccupancyGrid grid = Grid();
  grid.origin.yaw_rad = M_PI / 2;
  const CellMap map = FromOccupancyGrid(grid, {}).value();
  EXPECT_EQ(map.CellOf({0.3, 3.2, 0}), (Cell{2, 1, 0}));
  EXPECT_NEAR(map.CentreOf({2, 1, 0}).x_m, 0.25, 1e-9);
  EXPECT_NEAR(map.CentreOf({2, 1, 0}).y_m, 3.25, 1e-9);
}

TEST(CellMap, RefusesABadGrid) {
  OccupancyGrid grid = Grid();
  grid.width = 4;
  EXPECT_EQ(MessageOf(grid), "occupancy grid: 6 cells, expected 4 x 2");
  grid = Grid();
  grid.width = 0;
  EXPECT_THAT(MessageOf(grid), HasSubstr("it is empty (0 x 2 cells)"));
  grid = Grid();
  grid.resolution_m = 0;
  EXPECT_THAT(MessageOf(grid), HasSubstr("resolution 0 m, expected a positive number"));
  grid.resolution_m = kNan;
  EXPECT_THAT(MessageOf(grid), HasSubstr("resolution nan m"));
  grid = Grid();
  grid.origin.at.y_m = kNan;
  EXPECT_THAT(MessageOf(grid), HasSubstr("origin"));
  grid = Grid();
  grid.data[4] = 101;
  EXPECT_EQ(MessageOf(grid), "occupancy grid: cell (1, 1) is 101, expected -1 to 100");
  grid = Grid();
  grid.width = grid.height = 4'000'000'000U;
  EXPECT_THAT(MessageOf(grid), HasSubstr("at most 33554432 in all"));
}

TEST(CellMap, TakesThePointsOfACloudBetweenFloorAndCeiling) {
  CloudRules rules;
  rules.resolution_m = 0.5;
  const CellMap map =
      FromPointCloud({{1, 1, 0.5}, {3, 2, 1}, {9, 9, 0}, {9, 9, 3}, {kNan, 1, 1}}, rules).value();
  EXPECT_EQ(std::count(map.blocked.begin(), map.blocked.end(), 1), 2);
  EXPECT_TRUE(map.blocked[map.IndexOf(map.CellOf({1, 1, 0}))]);
  EXPECT_TRUE(map.blocked[map.IndexOf(map.CellOf({3, 2, 0}))]);
  EXPECT_TRUE(map.Has(map.CellOf({0.1, 0.1, 0}))) << "with free space around";
  EXPECT_FALSE(map.Has(map.CellOf({9, 9, 0})));
}

TEST(CellMap, RefusesACloudThatIsNone) {
  const auto message_of = [](const std::vector<Point>& points) {
    const auto map = FromPointCloud(points, {});
    EXPECT_FALSE(map.ok());
    return map.ok() ? "" : map.error().message;
  };
  EXPECT_THAT(message_of({}), HasSubstr("none of its 0 points"));
  EXPECT_THAT(message_of({{kNan, 0, 1}}), HasSubstr("none of its 1 points"));
  EXPECT_THAT(message_of({{0, 0, 1}, {1e12, 1e12, 1}}), HasSubstr("coarser"));
}

TEST(CellMap, TakesAMillionPoints) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-30, 30);
  std::vector<Point> points;
  for (int i = 0; i < 1'000'000; ++i) points.push_back({place(random), 30, place(random)});
  const CellMap map = FromPointCloud(points, {}).value();
  EXPECT_GT(std::count(map.blocked.begin(), map.blocked.end(), 1), 1000);
}

TEST(CellMap, BlocksThePointsOfAScan) {
  CellMap map = FromOccupancyGrid(Grid(), {}).value();
  BlockPoints({{1.2, 2.2, 0}, {kNan, 2, 0}, {-1e300, 2, 0}, {50, 50, 0}}, map);
  EXPECT_THAT(map.blocked, ElementsAre(1, 0, 1, 1, 1, 0));
}

TEST(OctreeMap, HasThePointsOfACloud) {
  OctreeMap octree = OctreeMap::Make(0.2).value();
  EXPECT_EQ(octree.Block({{1, 1, 1}, {-1, 0, 2}, {kNan, 0, 0}, {1e9, 0, 0}}), 2u);
  const CellMap map = octree.Cells({}).value();
  EXPECT_FALSE(map.flat());
  EXPECT_EQ(std::count(map.blocked.begin(), map.blocked.end(), 1), 2);
  EXPECT_TRUE(map.blocked[map.IndexOf(map.CellOf({1.05, 1.05, 1.05}))]);
  EXPECT_TRUE(map.blocked[map.IndexOf(map.CellOf({-0.95, 0.05, 2.05}))]);
}

TEST(OctreeMap, KnowsWhatRaysHavePassed) {
  OctreeMap octree = OctreeMap::Make(0.2).value();
  octree.See({0.1, 0.1, 0.1}, {{3.1, 0.1, 0.1}}, 10);
  const CellMap map = octree.Cells({false, 0.4}).value();
  const auto blocked = [&](const Point& point) {
    return map.blocked[map.IndexOf(map.CellOf(point))] != 0;
  };
  EXPECT_FALSE(blocked({1.5, 0.1, 0.1})) << "on the ray";
  EXPECT_TRUE(blocked({3.1, 0.1, 0.1})) << "its end";
  EXPECT_TRUE(blocked({1.5, 0.4, 0.1})) << "not seen";
}

TEST(OctreeMap, IsTheSameAfterItWasWrittenAndRead) {
  OctreeMap octree = OctreeMap::Make(0.25).value();
  std::vector<Point> wall;
  for (int i = 0; i < 400; ++i) wall.push_back({1, i % 20 * 0.25, i / 20 * 0.25});
  octree.Block(wall);
  const OctreeMap read = OctreeMap::Read(octree.Binary()).value();
  EXPECT_EQ(read.resolution_m(), 0.25);
  EXPECT_EQ(read.Cells({}).value().blocked, octree.Cells({}).value().blocked);
}

TEST(OctreeMap, RefusesWhatIsNone) {
  EXPECT_TRUE(Is(OctreeMap::Make(0).error(), Fault::kMap));
  EXPECT_TRUE(Is(OctreeMap::Make(kNan).error(), Fault::kMap));
  EXPECT_THAT(OctreeMap::Make(0.1).value().Cells({}).error().message, HasSubstr("empty"));
  EXPECT_THAT(OctreeMap::Read("no map").error().message, HasSubstr("first line"));
  OctreeMap octree = OctreeMap::Make(0.05).value();
  octree.Block({{0, 0, 0}, {800, 800, 800}});
  EXPECT_THAT(octree.Cells({}).error().message, HasSubstr("use a coarser one"));
}

TEST(OctreeMap, TakesAMillionPointsForAFlight) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(0, 20), height(0, 3);
  std::vector<Point> points;
  for (int i = 0; i < 1'000'000; ++i) points.push_back({10, place(random), height(random)});
  OctreeMap octree = OctreeMap::Make(0.2).value();
  EXPECT_EQ(octree.Block(points), points.size());
  PlannerRules rules;
  const Planner planner = Planner::Make(octree.Cells({false, 2}).value(), rules).value();
  EXPECT_FALSE(planner.Find({{8.5, 10, 1}, 0}, {{11.5, 10, 1}, 0}).ok()) << "unknown is blocked";
  const Planner optimist = Planner::Make(octree.Cells({true, 2}).value(), rules).value();
  EXPECT_TRUE(optimist.Find({{8.5, 10, 1}, 0}, {{11.5, 10, 1}, 0}).ok()) << "over the wall";
}

}  // namespace musher::navigation::map_test
