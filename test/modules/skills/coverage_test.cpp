// The path over a region: it keeps the radius, and it covers. Both are measured on a raster,
// without the functions that make the path.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "musher/modules/skills/coverage/coverage.hpp"
#include "musher/modules/skills/coverage/tour.hpp"

namespace musher::coverage::coverage_test {

using ::testing::HasSubstr;

Ring Box(double x, double y, double width, double height) {
  return {{x, y}, {x + width, y}, {x + width, y + height}, {x, y + height}};
}

Ring Circle(double x, double y, double radius, int corners) {
  Ring ring;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners;
    ring.push_back({x + radius * std::cos(angle), y + radius * std::sin(angle)});
  }
  return ring;
}

// What a path does, seen on a raster of 0.1 m.
struct Seen {
  double covered = 0;       // share of the free area within half a lane of the path
  double of_reachable = 0;  // the same of what is within half a lane of where the robot fits
  double nearest_m = 0;     // to an edge, where the path is nearest
  bool inside = true;       // all of the path
};

// A raster over a region, and which of its cells are marked.
class Raster {
 public:
  explicit Raster(const Region& region) {
    for (const GroundPoint& corner : region.boundary) {
      x0_ = std::min(x0_, corner.x_m);
      y0_ = std::min(y0_, corner.y_m);
      x1_ = std::max(x1_, corner.x_m);
      y1_ = std::max(y1_, corner.y_m);
    }
    columns_ = static_cast<int>((x1_ - x0_) / kCellM) + 1;
    rows_ = static_cast<int>((y1_ - y0_) / kCellM) + 1;
    marks_.resize(static_cast<std::size_t>(columns_ * rows_), false);
  }

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  GroundPoint At(int column, int row) const {
    return {x0_ + (column + 0.5) * kCellM, y0_ + (row + 0.5) * kCellM};
  }
  bool Has(int column, int row) const {
    return column >= 0 && row >= 0 && column < columns_ && row < rows_ &&
           marks_[Index(column, row)];
  }
  void Mark(int column, int row) { marks_[Index(column, row)] = true; }
  void MarkAround(const GroundPoint& point, double reach_m) {
    const auto cell = [](double m) { return static_cast<int>(std::floor(m / kCellM)); };
    const int last_row = std::min(cell(point.y_m + reach_m - y0_), rows_ - 1);
    const int last_column = std::min(cell(point.x_m + reach_m - x0_), columns_ - 1);
    for (int row = std::max(cell(point.y_m - reach_m - y0_), 0); row <= last_row; ++row) {
      for (int column = std::max(cell(point.x_m - reach_m - x0_), 0); column <= last_column;
           ++column) {
        if (Distance(At(column, row), point) <= reach_m) Mark(column, row);
      }
    }
  }

 private:
  static constexpr double kCellM = 0.1;

  std::size_t Index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(column);
  }

  double x0_ = 1e9, y0_ = 1e9, x1_ = -1e9, y1_ = -1e9;
  int columns_ = 0;
  int rows_ = 0;
  std::vector<bool> marks_;
};

// What is within half a lane of a place at which the robot fits.
Raster ReachableOf(const Region& region, const Options& options) {
  const std::vector<Edge> edges = EdgesOf(region);
  Raster fits(region);
  for (int row = 0; row < fits.rows(); ++row) {
    for (int column = 0; column < fits.columns(); ++column) {
      const GroundPoint at = fits.At(column, row);
      const bool clear = std::ranges::all_of(
          edges, [&](const Edge& edge) { return Distance(at, edge) >= options.robot_radius_m; });
      if (clear && Contains(edges, at)) fits.Mark(column, row);
    }
  }
  Raster reachable = fits;
  for (int row = 0; row < fits.rows(); ++row) {
    for (int column = 0; column < fits.columns(); ++column) {
      const bool inner = fits.Has(column - 1, row) && fits.Has(column + 1, row) &&
                         fits.Has(column, row - 1) && fits.Has(column, row + 1);
      if (!fits.Has(column, row) || inner) continue;
      reachable.MarkAround(fits.At(column, row), options.lane_width_m / 2);
    }
  }
  return reachable;
}

Seen Watch(const Region& region, const Plan& plan, const Options& options) {
  const std::vector<Edge> edges = EdgesOf(region);
  Seen seen{.nearest_m = 1e9};
  Raster covered(region);
  for (const GroundPoint& point : Interpolated(plan.corners, 0.05)) {
    seen.inside = seen.inside && Contains(edges, point);
    for (const Edge& edge : edges) seen.nearest_m = std::min(seen.nearest_m, Distance(point, edge));
    covered.MarkAround(point, options.lane_width_m / 2);
  }
  const Raster reachable = ReachableOf(region, options);
  double free = 0, both = 0, reached = 0, all = 0;
  for (int row = 0; row < covered.rows(); ++row) {
    for (int column = 0; column < covered.columns(); ++column) {
      if (!Contains(edges, covered.At(column, row))) continue;
      const bool is_covered = covered.Has(column, row), near = reachable.Has(column, row);
      ++free;
      both += is_covered ? 1 : 0;
      all += near ? 1 : 0;
      reached += near && is_covered ? 1 : 0;
    }
  }
  seen.covered = both / free;
  seen.of_reachable = reached / std::max(all, 1.0);
  return seen;
}

struct Case {
  const char* name;
  Region region;
  Options options{};
};

std::vector<Case> Cases() {
  const Ring l_shape{{0, 0}, {20, 0}, {20, 8}, {8, 8}, {8, 20}, {0, 20}};
  const Ring u_shape{{0, 0}, {20, 0}, {20, 20}, {14, 20}, {14, 6}, {6, 6}, {6, 20}, {0, 20}};
  const Ring triangle{{0, 0}, {30, 0}, {10, 25}};
  Region turned = Turned(Region{Box(0, 0, 30, 12), {Box(8, 4, 4, 3)}}, 0.4);
  Region columns{Box(0, 0, 30, 20), {}};
  for (int i = 0; i < 6; ++i) {
    columns.holes.push_back(Box(4 + 9 * (i % 3), 4 + 9 * static_cast<double>(i / 3), 2, 2));
  }
  Ring comb{{0, 0}, {21, 0}};
  for (int i = 3; i >= 0; --i) {
    comb.insert(comb.end(), {{6.0 * i + 3, 15}, {6.0 * i, 15}, {6.0 * i, 4}, {6.0 * i - 3, 4}});
  }
  comb.resize(comb.size() - 2);
  return {
      {"room", {Box(0, 0, 20, 20), {}}},
      {"room with a hole", {Box(0, 0, 20, 20), {Box(8, 8, 4, 4)}}},
      {"room with six columns", columns},
      {"L", {l_shape, {}}},
      {"U", {u_shape, {}}},
      {"comb", {comb, {}}},
      {"triangle", {triangle, {}}},
      {"turned room with a hole", turned},
      {"circle", {Circle(0, 0, 12, 40), {Circle(2, 1, 3, 24)}}},
      {"corridor", {Box(0, 0, 40, 1.4), {}}},
      {"small room, narrow lanes", {Box(0, 0, 6, 4), {Box(2, 1.5, 1, 1)}}, {0.5, 0.2}},
  };
}

TEST(Coverage, KeepsTheRadiusAndCoversAlmostAll) {
  for (const Case& tried : Cases()) {
    const auto plan = PlanCoverage(tried.region, tried.options, GroundPoint{1, 1});
    ASSERT_TRUE(plan) << tried.name << ": " << plan.error().message;
    const Seen seen = Watch(tried.region, plan.value(), tried.options);
    EXPECT_TRUE(seen.inside) << tried.name;
    EXPECT_GE(seen.nearest_m, tried.options.robot_radius_m - 1e-4) << tried.name;
    EXPECT_GE(seen.covered, 0.95) << tried.name;
    EXPECT_EQ(plan.value().cells_left_out, 0U) << tried.name;
  }
}

// One lane in the middle of them left a third of what the robot can come near to.
TEST(Coverage, CoversTheEndsOfThinTriangles) {
  const Options options{2, 0.3};
  for (const double width : {6.0, 12.0, 20.0, 30.0}) {
    for (const double top : {0.0, 0.3, 0.5}) {
      for (const double height : {1.8, 2.5, 3.5}) {
        const Region triangle{{{0, 0}, {width, 0}, {top * width, height}}, {}};
        const auto plan = PlanCoverage(triangle, options, GroundPoint{0, 0});
        ASSERT_TRUE(plan) << plan.error().message;
        const Seen seen = Watch(triangle, plan.value(), options);
        EXPECT_TRUE(seen.inside);
        EXPECT_GE(seen.nearest_m, options.robot_radius_m - 1e-4);
        EXPECT_GE(seen.of_reachable, 0.85) << width << " x " << height << ", " << top;
      }
    }
  }
}

TEST(Coverage, HasLanesInTheDirectionWithTheFewestTurns) {
  const auto plan = PlanCoverage(Turned(Region{Box(0, 0, 30, 8), {}}, 0.3), {}, {});
  ASSERT_TRUE(plan) << plan.error().message;
  EXPECT_NEAR(std::remainder(plan.value().direction_rad - 0.3, std::numbers::pi), 0, 1e-6);
  EXPECT_EQ(plan.value().lanes, 4U);
}

TEST(Coverage, HasShortWaysBetweenItsLanes) {
  for (const Case& tried : Cases()) {
    const auto plan = PlanCoverage(tried.region, tried.options, {});
    ASSERT_TRUE(plan) << tried.name << ": " << plan.error().message;
    const double lanes = static_cast<double>(plan.value().lanes);
    EXPECT_LE(plan.value().between_m, 1.7 * tried.options.lane_width_m * lanes) << tried.name;
  }
}

TEST(Coverage, BeginsNearTheRobot) {
  const Region room{Box(0, 0, 20, 20), {Box(8, 8, 4, 4)}};
  for (const GroundPoint start : {GroundPoint{1, 1}, {19, 1}, {1, 19}, {19, 19}, {30, 30}}) {
    const auto plan = PlanCoverage(room, {}, start);
    ASSERT_TRUE(plan) << plan.error().message;
    const GroundPoint corner{std::clamp(start.x_m, 1.0, 19.0), std::clamp(start.y_m, 1.0, 19.0)};
    EXPECT_LE(Distance(plan.value().corners.front(), corner), 3.0);
  }
}

// Two rooms, with a door that is too narrow for the robot.
TEST(Coverage, LeavesOutWhatTheRobotCannotReach) {
  Region rooms{{{0, 0},
                {10, 0},
                {10, 3},
                {11, 3},
                {11, 0},
                {15, 0},
                {15, 10},
                {11, 10},
                {11, 3.8},
                {10, 3.8},
                {10, 10},
                {0, 10}},
               {}};
  const auto plan = PlanCoverage(rooms, {}, {});
  ASSERT_TRUE(plan) << plan.error().message;
  EXPECT_GT(plan.value().cells_left_out, 0U);
  for (const GroundPoint& corner : plan.value().corners) EXPECT_LT(corner.x_m, 10);
  const auto small = PlanCoverage(rooms, {2, 0.3}, {});
  ASSERT_TRUE(small) << small.error().message;
  EXPECT_EQ(small.value().cells_left_out, 0U);
}

TEST(Coverage, RefusesWhatCannotBeCovered) {
  const auto why_not = [](const Region& region, const Options& options) {
    const auto plan = PlanCoverage(region, options, {});
    return plan ? "" : plan.error().message;
  };
  const Region room{Box(0, 0, 10, 10), {}};
  EXPECT_EQ(why_not(room, {0, 0.5}), "lane_width is 0 m; expected more than 0 m");
  EXPECT_EQ(why_not(room, {std::nan(""), 0.5}), "lane_width is nan m; expected more than 0 m");
  for (const double narrow : {1e-6, 1e-12, 1e-300}) {
    EXPECT_THAT(why_not(room, {narrow, 0.5}), HasSubstr("expected at most 2000")) << narrow;
  }
  EXPECT_EQ(why_not(room, {2, -0.5}), "robot_radius is -0.5 m; expected 0 m or more");
  EXPECT_EQ(why_not(room, {2, std::nan("")}), "robot_radius is nan m; expected 0 m or more");
  EXPECT_EQ(why_not(room, {2, 5.1}),
            "a robot with a radius of 5.1 m does not fit into the boundary");
  EXPECT_THAT(why_not({Box(0, 0, 9e4, 9e4), {}}, {}), HasSubstr("the region needs"));
  EXPECT_THAT(why_not({{{0, 0}, {1, 1}, {1, 0}, {0, 1}}, {}}, {}), HasSubstr("crosses or touches"));
}

TEST(Coverage, IsInterpolatedWithoutAGap) {
  const auto points = Interpolated({{0, 0}, {1, 0}, {1, 0}, {1, 0.33}}, 0.05);
  ASSERT_EQ(points.size(), 1U + 20 + 7);
  EXPECT_EQ(points.front(), (GroundPoint{0, 0}));
  EXPECT_EQ(points.back(), (GroundPoint{1, 0.33}));
  for (std::size_t i = 1; i < points.size(); ++i) {
    EXPECT_LE(Distance(points[i - 1], points[i]), 0.05 + 1e-9);
    EXPECT_GT(Distance(points[i - 1], points[i]), 0);
  }
}

// Found by the property below: from one lane to the next one of its cell there was no way that
// keeps the radius, and the path went straight, 7 cm nearer to the corner of the hole than the
// robot fits.
TEST(Coverage, LeavesOutALaneToWhichThereIsNoWay) {
  Region region;
  const std::array<std::pair<double, double>, 8> corners{
      {{0.43, 10.69}, {1.33, 7.98}, {2, 4}, {3, 4}, {4, 4}, {5, 4}, {6.38, 10.37}, {7.06, 5.46}}};
  for (const auto& [eighths, radius] : corners) {
    const double angle = eighths * std::numbers::pi / 4;
    region.boundary.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  }
  Region one{Box(0, 0, 0.51, 2.86), {}};
  one = Turned(one, 1.23);
  for (GroundPoint& corner : one.boundary) corner = {corner.x_m + 3.32, corner.y_m - 4.57};
  region.holes.push_back(one.boundary);
  const Options options{2, 0.38};
  const auto plan = PlanCoverage(region, options, GroundPoint{0, 0});
  ASSERT_TRUE(plan) << plan.error().message;
  const Seen seen = Watch(region, plan.value(), options);
  EXPECT_TRUE(seen.inside);
  EXPECT_GE(seen.nearest_m, options.robot_radius_m - 1e-4);
}

// Two rooms above each other, with a gap that is too narrow for the robot, and cells that reach
// over both: the lane at y = 1 m is isolated from the others.
TEST(Coverage, CoversTheRestOfACellWhoseFirstLaneIsIsolated) {
  const Region rooms{{{0, 0},
                      {10, 0},
                      {10, 2},
                      {5.3, 2},
                      {5.3, 3},
                      {10, 3},
                      {10, 10},
                      {0, 10},
                      {0, 3},
                      {4.7, 3},
                      {4.7, 2},
                      {0, 2}},
                     {}};
  const FreeSpace space(rooms, 0.5);
  const auto lane = [](double y_m, double from_m, double to_m) {
    return Lane{y_m, {from_m, to_m}};
  };
  const Cell low_left{{lane(1, 0.5, 4.5), lane(4, 0.5, 4.5)}};
  const Cell low_right{{lane(1, 5.5, 9.5), lane(4, 5.5, 9.5)}};
  const Cell high{{lane(6, 0.5, 9.5), lane(8, 0.5, 9.5)}};
  const Cell all{{lane(1, 0.5, 9.5), lane(4, 0.5, 9.5), lane(6, 0.5, 9.5), lane(8, 0.5, 9.5)}};
  struct Case {
    std::vector<Cell> cells;
    int lanes = 0;  // that are not isolated
  };
  for (const Case& one :
       {Case{{all}, 3}, Case{{low_left, low_right, high}, 4}, Case{{high, low_right}, 3}}) {
    for (const GroundPoint start : {GroundPoint{1, 1}, {9, 1}, {1, 8}, {9, 8}}) {
      Router router(space, rooms);
      const Tour tour = TourOf(one.cells, start, router);
      EXPECT_EQ(std::ranges::count(tour.on_lane, true), one.lanes);
      for (const GroundPoint& corner : tour.corners) EXPECT_GT(corner.y_m, 3);
      EXPECT_EQ(tour.cells + tour.cells_left_out, one.cells.size());
      EXPECT_GT(tour.cells_left_out, 0U);
    }
  }
}

// A star of random corners with random boxes as holes, as far as they are a region.
Region AnyRegion() {
  const auto number = [](int least, int most) { return *rc::gen::inRange(least, most) / 100.0; };
  Region region;
  const int corners = *rc::gen::inRange(3, 14);
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * (i + number(0, 80)) / corners;
    const double radius = number(400, 1600);
    region.boundary.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  }
  const int holes = *rc::gen::inRange(0, 5);
  for (int i = 0; i < holes; ++i) {
    Region one{Box(0, 0, number(30, 500), number(30, 500)), {}};
    one = Turned(one, number(0, 314));
    const double x = number(-1000, 1000), y = number(-1000, 1000);
    for (GroundPoint& corner : one.boundary) corner = {corner.x_m + x, corner.y_m + y};
    region.holes.push_back(one.boundary);
    if (!Checked(region)) region.holes.pop_back();
  }
  return region;
}

RC_GTEST_PROP(Coverage, KeepsTheRadiusInEachRegionAndCoversIt, ()) {
  const Region region = AnyRegion();
  const Options options{2, *rc::gen::inRange(5, 60) / 100.0};
  const auto plan = PlanCoverage(region, options, GroundPoint{0, 0});
  if (!plan) return;
  const Seen seen = Watch(region, plan.value(), options);
  RC_ASSERT(seen.inside);
  RC_ASSERT(seen.nearest_m >= options.robot_radius_m - 1e-4);
  // What the robot cannot come near to in narrow corners is not the path's.
  if (plan.value().cells_left_out == 0) RC_ASSERT(seen.of_reachable >= 0.85);
}

}  // namespace musher::coverage::coverage_test
