// The room around a place, compared with a look at every cell.

#include "musher/navigation/planner/clearance.hpp"

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include <limits>

#include "musher/test/navigation/maps.hpp"

namespace musher::navigation::testing::clearance_test {

CellMap RandomCells() {
  CellMap map;
  map.resolution_m = 0.25;
  map.origin = {{-1, 2, 0.5}, *rc::gen::element(0.0, 0.7, -2.0)};
  map.size_x = *rc::gen::inRange(1, 12);
  map.size_y = *rc::gen::inRange(1, 12);
  map.size_z = *rc::gen::inRange(1, 5);
  const int of_ten = *rc::gen::inRange(0, 4);
  map.blocked.resize(static_cast<std::size_t>(map.size_x) * map.size_y * map.size_z);
  for (auto& cell : map.blocked) cell = *rc::gen::inRange(0, 10) < of_ten;
  return map;
}

// From a place to a box of the size of a cell.
double ToCell(const CellMap& map, const Point& place, const Cell& cell) {
  const Point at = map.InCells(place);
  const auto outside = [](double value, int begin) {
    return std::max({begin - value, value - begin - 1, 0.0});
  };
  return std::hypot(outside(at.x_m, cell.x), outside(at.y_m, cell.y),
                    map.flat() ? 0 : outside(at.z_m, cell.z)) *
         map.resolution_m;
}

double NearestOf(const CellMap& map, const std::function<double(const Cell&)>& distance) {
  double nearest_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < map.count(); ++i) {
    if (map.blocked[i]) nearest_m = std::min(nearest_m, distance(map.CellAt(i)));
  }
  return nearest_m;
}

Point RandomPlace(const CellMap& map) {
  const Cell cell = map.CellAt(*rc::gen::inRange<std::size_t>(0, map.count()));
  Point place = map.CentreOf(cell);
  const auto off = [] { return *rc::gen::inRange(-120, 121) / 1000.0; };
  return {place.x_m + off(), place.y_m + off(), place.z_m + off()};
}

RC_GTEST_PROP(Clearance, OfACellIsTheDistanceToTheNearestBlockedOne, ()) {
  const CellMap map = RandomCells();
  const Clearance clearance(map);
  for (std::size_t i = 0; i < map.count(); ++i) {
    const Point centre = map.CentreOf(map.CellAt(i));
    const double nearest_m =
        NearestOf(map, [&](const Cell& cell) { return Distance(map.CentreOf(cell), centre); });
    const double known_m = clearance.OfCell(i);
    const bool right =
        std::isinf(nearest_m) ? std::isinf(known_m) : std::abs(known_m - nearest_m) < 1e-5;
    RC_ASSERT(right);
  }
}

RC_GTEST_PROP(Clearance, FitsABodyExactlyWhereNoBlockedCellIsNearer, ()) {
  const CellMap map = RandomCells();
  const Clearance clearance(map);
  const Point place = RandomPlace(map);
  const double nearest_m =
      NearestOf(map, [&](const Cell& cell) { return ToCell(map, place, cell); });
  RC_PRE(map.Has(map.CellOf(place)));
  RC_ASSERT(clearance.Fits(place, 0) == (map.blocked[map.IndexOf(map.CellOf(place))] == 0));
  for (const double radius_m : {0.05, 0.2, 0.5, 1.0}) {
    if (std::abs(nearest_m - radius_m) < 1e-9) continue;
    RC_ASSERT(clearance.Fits(place, radius_m) == (nearest_m > radius_m));
  }
  RC_ASSERT(std::abs(clearance.At(place, 1) - std::min(nearest_m, 1.0)) < 1e-9);
}

RC_GTEST_PROP(Clearance, FitsAlongALineOnlyIfItDoesEverywhere, ()) {
  const CellMap map = RandomCells();
  const Clearance clearance(map);
  const Point from = RandomPlace(map), to = RandomPlace(map);
  const double radius_m = *rc::gen::element(0.05, 0.2, 0.4);
  bool fits = true, fits_with_slack = true;
  for (int i = 0; i <= 400; ++i) {
    const Point place = Between(from, to, i / 400.0);
    fits &= clearance.Fits(place, radius_m);
    fits_with_slack &= clearance.Fits(place, radius_m - 0.025);
  }
  if (fits) RC_ASSERT(clearance.FitsAlong(from, to, radius_m));
  if (clearance.FitsAlong(from, to, radius_m)) RC_ASSERT(fits_with_slack);
}

TEST(Clearance, IsInfiniteWithoutAnythingBlocked) {
  const Clearance clearance(Drawn({"...", "..."}, 1));
  EXPECT_TRUE(std::isinf(clearance.OfCell(4)));
  EXPECT_TRUE(clearance.Fits({1.5, 1.5, 0}, 100)) << "an edge of the map blocks nothing";
  EXPECT_FALSE(clearance.Fits({-0.1, 1.5, 0}, 0)) << "but the centre has to be on it";
}

TEST(Clearance, ExplainsThePointsOfAScanThatTheMapHas) {
  const Clearance clearance(Drawn({"....", "..#.", "...."}, 1));
  const std::vector<Point> unknown =
      NewPoints({{2, 1.5, 0}, {1.95, 1.5, 0}, {1.5, 1.5, 0}, {std::nan(""), 0, 0}}, clearance, 0.1);
  EXPECT_EQ(unknown, (std::vector<Point>{{1.5, 1.5, 0}}));
}

}  // namespace musher::navigation::testing::clearance_test
