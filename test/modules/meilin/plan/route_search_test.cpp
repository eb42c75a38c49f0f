// Plans for a field whose boxes are known.

#include "musher/modules/meilin/plan/route_search.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <set>

namespace musher::meilin::route_search_test {
namespace {

BoxMap Map(std::array<std::array<int, kCols>, kRows> boxes, Side side = Side::kBlue,
           bool omni = false) {
  BoxMap map;
  map.side = side;
  map.omni = omni;
  for (std::size_t row = 0; row < kRows; ++row) {
    for (std::size_t col = 0; col < kCols; ++col) {
      map.boxes.at(row).at(col) = static_cast<Box>(boxes.at(row).at(col));
    }
  }
  return map;
}

// Whether a robot can do the plan and what it says is true of it.
void ExpectSound(const BoxMap& map, const Route& route, Cell entrance) {
  PlanRules rules;
  rules.grid.side = map.side;
  rules.boxes = map;  // as the mission has it
  const PlanReading reading =
      ReadActionSequence(ToActionSequence(route.steps), rules, {.cell = entrance});
  RC_ASSERT(reading.message() == "");
  std::set<std::pair<int, int>> taken;
  int kfs1 = 0;
  Cell here{-1, -1};
  for (const PlanStep& step : route.steps) {
    const std::pair at(step.cell.row, step.cell.col);
    if (step.fetch) {
      RC_ASSERT(map.At(step.cell) == Box::kKfs2);
      RC_ASSERT(taken.insert(at).second);
      continue;
    }
    RC_ASSERT(map.At(step.cell) != Box::kFake);
    RC_ASSERT(map.At(step.cell) != Box::kKfs2 || taken.count(at) == 1);
    kfs1 += here != step.cell && map.At(step.cell) == Box::kKfs1 ? 1 : 0;
    here = step.cell;
  }
  RC_ASSERT(here.row == kRows - 1);
  RC_ASSERT(static_cast<int>(taken.size()) == route.kfs2_count);
  RC_ASSERT(kfs1 == route.kfs1_affected);
}

RC_GTEST_PROP(RouteSearch, FindsOnlyPlansThatTheRobotAccepts, ()) {
  BoxMap map;
  map.side = *rc::gen::element(Side::kBlue, Side::kRed);
  map.omni = *rc::gen::arbitrary<bool>();
  // From a nearly empty field to one with a box on half of its cells.
  const int empty = *rc::gen::inRange(4, 20);
  for (auto& row : map.boxes) {
    for (Box& box : row) {
      const int kind = *rc::gen::inRange(0, empty);
      box = kind > 3 ? Box::kEmpty : static_cast<Box>(kind);
    }
  }
  RouteRules rules;
  rules.most_visits = 200'000;
  rules.entrance = {0, *rc::gen::inRange(0, kCols)};
  const RouteReport report = FindRoutes(map, rules);
  for (std::size_t count = 0; count < report.routes.size(); ++count) {
    const RouteBucket& bucket = report.routes.at(count);
    RC_ASSERT(bucket.routes.size() <= 10U);
    RC_ASSERT(bucket.routes.size() == std::min<std::uint64_t>(10, bucket.total));
    double last_s = 0;
    for (const Route& route : bucket.routes) {
      RC_ASSERT(route.kfs2_count == static_cast<int>(count));
      RC_ASSERT(route.cost_s >= last_s);
      last_s = route.cost_s;
      ExpectSound(map, route, rules.entrance);
    }
  }
}

TEST(RouteSearch, FindsEveryPathThroughAnEmptyField) {
  const RouteReport report = FindRoutes({});
  EXPECT_TRUE(report.complete);
  // From each cell of a row three paths lead to the next one: 3 starts, 5 rows.
  EXPECT_EQ(report.routes[0].total, 729U);
  EXPECT_EQ(report.routes[1].total, 0U);
  const Route& best = report.routes[0].routes.at(0);
  EXPECT_EQ(best.steps.size(), 6U);
  // Start, up 200, up 200, up 200, down 200 and down 400 in the middle.
  EXPECT_DOUBLE_EQ(best.cost_s, 1 + 2.5 + 2.5 + 2.5 + 3.5 + 5);
  EXPECT_EQ(best.steps.at(0).cell, (Cell{0, 1}));
}

TEST(RouteSearch, BeginsAtTheEntranceAndDrivesOverNoBoxOnTheWayToTheFirstCell) {
  for (const Box box : {Box::kKfs1, Box::kFake, Box::kKfs2}) {
    BoxMap map;
    map.boxes[0][1] = box;
    const auto first = [&map](int column) {
      std::set<int> columns;
      RouteRules rules;
      rules.entrance = {0, column};
      rules.most_routes = 1000;
      const RouteReport report = FindRoutes(map, rules);
      for (const RouteBucket& bucket : report.routes) {
        for (const Route& route : bucket.routes) columns.insert(route.steps.front().cell.col);
      }
      return columns;
    };
    EXPECT_EQ(first(0), std::set<int>{0}) << "the box is on the way to column 2";
    EXPECT_EQ(first(2), std::set<int>{2});
    EXPECT_EQ(first(1), (std::set<int>{0, 2})) << "the robot is already there";
  }
}

TEST(RouteSearch, AgreesWithTheMirroredField) {
  const auto blue = FindRoutes(Map({{{0, 0, 0}, {2, 0, 0}, {0, 0, 2}, {0, 3, 0}, {1, 0, 0}}}));
  const auto red =
      FindRoutes(Map({{{0, 0, 0}, {0, 0, 2}, {2, 0, 0}, {0, 3, 0}, {0, 0, 1}}}, Side::kRed));
  for (std::size_t count = 0; count < blue.routes.size(); ++count) {
    ASSERT_EQ(blue.routes.at(count).total, red.routes.at(count).total);
    for (std::size_t index = 0; index < blue.routes.at(count).routes.size(); ++index) {
      EXPECT_EQ(blue.routes.at(count).routes.at(index).cost_s,
                red.routes.at(count).routes.at(index).cost_s);
    }
  }
}

TEST(RouteSearch, TakesABoxThatIsInItsWay) {
  const auto report = FindRoutes(Map({{{3, 0, 3}, {3, 2, 3}, {3, 0, 3}, {3, 0, 3}, {3, 0, 3}}}));
  EXPECT_EQ(report.routes[0].total, 0U);
  EXPECT_EQ(report.routes[1].total, 1U);
}

TEST(RouteSearch, FindsNoPathBehindFakeBoxes) {
  for (const bool omni : {false, true}) {
    const auto report = FindRoutes(Map({{{0, 0, 0}, {3, 3, 3}}}, Side::kBlue, omni));
    EXPECT_EQ(BestRoute(report.routes), nullptr);
  }
}

TEST(RouteSearch, MovesBackToTheCentreBetweenTwoFetches) {
  // Only through the middle column, with boxes on both sides of (1, 1).
  const auto report =
      FindRoutes(Map({{{3, 0, 3}, {2, 0, 2}, {3, 0, 3}, {3, 0, 3}, {3, 0, 3}, {3, 0, 3}}}));
  const Route* best = BestRoute(report.routes);
  ASSERT_NE(best, nullptr);
  EXPECT_EQ(best->kfs2_count, 2);
  ASSERT_EQ(best->steps.size(), 9U);
  EXPECT_TRUE(best->steps[2].fetch);
  EXPECT_EQ(best->steps[3].cell, (Cell{1, 1}));
  EXPECT_FALSE(best->steps[3].fetch);
  EXPECT_TRUE(best->steps[4].fetch);
}

TEST(RouteSearch, KeepsTheYawOfTheLastFetchOnlyOneWay) {
  const std::array<std::array<int, kCols>, kRows> boxes = {
      {{3, 0, 3}, {2, 0, 3}, {3, 0, 3}, {3, 0, 3}, {3, 0, 3}, {3, 0, 3}}};
  const Route one_way = *BestRoute(FindRoutes(Map(boxes)).routes);
  const Route omni = *BestRoute(FindRoutes(Map(boxes, Side::kBlue, true)).routes);
  ASSERT_TRUE(one_way.steps.at(2).fetch);
  EXPECT_DOUBLE_EQ(one_way.steps.at(2).yaw_rad, -kPi / 2);
  EXPECT_DOUBLE_EQ(one_way.steps.at(3).yaw_rad, -kPi / 2);
  ASSERT_TRUE(omni.steps.at(2).fetch);
  EXPECT_DOUBLE_EQ(omni.steps.at(2).yaw_rad, -kPi / 2) << "a side fetch turns in both";
  EXPECT_DOUBLE_EQ(omni.steps.at(3).yaw_rad, 0);
}

TEST(RouteSearch, LeavesABoxThatIsTooLowForTheWheels) {
  // The only box lies 200 mm below the only path past it.
  const auto report =
      FindRoutes(Map({{{3, 0, 3}, {3, 0, 3}, {3, 0, 2}, {3, 0, 3}, {3, 0, 3}, {3, 0, 3}}}));
  EXPECT_EQ(report.routes[0].total, 1U);
  EXPECT_EQ(report.routes[1].total, 0U);
}

TEST(RouteSearch, EndsAtItsLimitOnAFieldFullOfBoxes) {
  std::array<std::array<int, kCols>, kRows> boxes{};
  for (auto& row : boxes) row = {2, 0, 2};
  RouteRules rules;
  rules.most_visits = 50;
  EXPECT_FALSE(FindRoutes(Map(boxes), rules).complete);
  EXPECT_TRUE(FindRoutes(Map(boxes)).complete);
}

TEST(RouteSearch, PrefersTwoBoxesThenThree) {
  Routes routes;
  EXPECT_EQ(BestRoute(routes), nullptr);
  routes[0].routes.push_back({{}, 1, 0, 0});
  EXPECT_EQ(BestRoute(routes)->kfs2_count, 0);
  routes[3].routes.push_back({{}, 9, 3, 0});
  EXPECT_EQ(BestRoute(routes)->kfs2_count, 3);
  routes[2].routes.push_back({{}, 9, 2, 0});
  EXPECT_EQ(BestRoute(routes)->kfs2_count, 2);
}

}  // namespace
}  // namespace musher::meilin::route_search_test
