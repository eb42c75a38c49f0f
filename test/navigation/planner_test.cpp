// The path over a map: clearance, length, refusals that name what is wrong, and large maps.

#include "musher/navigation/planner/planner.hpp"

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include <limits>

#include "musher/navigation/navigation_fault.hpp"
#include "musher/test/navigation/maps.hpp"

namespace musher::navigation::testing::planner_test {

using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

CellMap Wall() {
  return Drawn({"..........",  //
                "..........",  //
                ".....#....",  //
                ".....#....",  //
                ".....#....",  //
                ".....#...."},
               0.5);
}

// Its start room, a cell of the wall, and a closed room at the right.
CellMap ClosedRoom() {
  return Drawn({"..........",  //
                ".....#####",  //
                ".....#...#",  //
                ".....#...#",  //
                ".....#...#",  //
                ".....#####"},
               0.5);
}

Planner Made(CellMap map, double radius_m = 0.3) {
  PlannerRules rules;
  rules.radius_m = radius_m;
  return Planner::Make(std::move(map), rules).value();
}

Error RefusalOf(const Planner& planner, const Pose& start, const Pose& goal) {
  int asked = 0;
  const auto plan = planner.Find(start, goal, [&] { return ++asked > 0; });
  EXPECT_EQ(asked, 0) << "it is known without a search";
  EXPECT_FALSE(plan.ok());
  return plan.ok() ? Error{} : plan.error();
}

// The least room of a body along a path, looked at every centimetre.
double RoomAlong(const Path& path, const Clearance& clearance) {
  double room_m = 9;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const int steps = static_cast<int>(Distance(path[i - 1].at, path[i].at) / 0.01) + 1;
    for (int k = 0; k <= steps; ++k) {
      const Point place = Between(path[i - 1].at, path[i].at, double(k) / steps);
      room_m = std::min(room_m, clearance.At(place, 9));
    }
  }
  return room_m;
}

TEST(Planner, GoesAroundAWallWithRoomForTheBody) {
  const Planner planner = Made(Wall());
  const Plan plan = planner.Find({{1, 1, 0}, 0.2}, {{4.5, 1, 0}, -0.4}).value();
  EXPECT_EQ(plan.path.front(), (Pose{{1, 1, 0}, 0.2}));
  EXPECT_EQ(plan.path.back(), (Pose{{4.5, 1, 0}, -0.4}));
  EXPECT_GE(RoomAlong(plan.path, planner.clearance()), 0.3 - 1e-6);
  EXPECT_LT(plan.length_m, 4.7);
  EXPECT_LE(plan.length_m, plan.cell_length_m * 1.1);
}

TEST(Planner, IsSmooth) {
  const Plan plan = Made(Wall()).Find({{1, 1, 0}, 0}, {{4.5, 1, 0}, 0}).value();
  double sharpest_rad = 0;
  for (std::size_t i = 3; i + 2 < plan.path.size(); ++i) {
    sharpest_rad =
        std::max(sharpest_rad, std::abs(Wrapped(plan.path[i].yaw_rad - plan.path[i - 1].yaw_rad)));
  }
  EXPECT_GT(plan.path.size(), 20u);
  EXPECT_LT(sharpest_rad, 0.15);
}

TEST(Planner, TurnsToItsPathAndAtTheGoal) {
  const Path path = Made(Wall()).Find({{1, 2.7, 0}, 1}, {{4, 2.7, 0}, 2}).value().path;
  ASSERT_GE(path.size(), 4u);
  EXPECT_EQ(path[0].at, path[1].at);
  EXPECT_NEAR(path[1].yaw_rad, 0, 1e-6);
  EXPECT_EQ(path[path.size() - 2].at, path.back().at);
  EXPECT_NEAR(path[path.size() - 2].yaw_rad, 0, 1e-6);
  EXPECT_EQ(path.back().yaw_rad, 2);
}

TEST(Planner, TurnsWhereItIs) {
  const Path path = Made(Wall()).Find({{1, 1, 0}, 1}, {{1, 1, 0}, 2}).value().path;
  EXPECT_EQ(path.front(), (Pose{{1, 1, 0}, 1}));
  EXPECT_EQ(path.back(), (Pose{{1, 1, 0}, 2}));
  for (const Pose& pose : path) EXPECT_LT(Distance(pose.at, {1, 1, 0}), 0.6);
}

TEST(Planner, IsTheSameForTheSameSeed) {
  const auto path = [] { return Made(Wall()).Find({{1, 1, 0}, 0}, {{4.5, 1, 0}, 0}).value().path; };
  EXPECT_EQ(path(), path());
}

TEST(Planner, NamesAGoalInAnObstacleAtOnce) {
  const Error error = RefusalOf(Made(Wall()), {{1, 1, 0}, 0}, {{2.7, 0.7, 0}, 0});
  EXPECT_TRUE(Is(error, Fault::kGoalBlocked));
  EXPECT_EQ(error.message, "goal (2.70, 0.70) is in an obstacle");
}

TEST(Planner, NamesAGoalTooCloseToAnObstacle) {
  const Error error = RefusalOf(Made(Wall()), {{1, 1, 0}, 0}, {{2.4, 0.7, 0}, 0});
  EXPECT_TRUE(Is(error, Fault::kGoalBlocked));
  EXPECT_EQ(error.message, "goal (2.40, 0.70) is 0.10 m from an obstacle, the body needs 0.30 m");
}

TEST(Planner, NamesAGoalOutsideTheMap) {
  const Error error = RefusalOf(Made(Wall()), {{1, 1, 0}, 0}, {{12, 0.7, 0}, 0});
  EXPECT_TRUE(Is(error, Fault::kOutside));
  EXPECT_EQ(error.message,
            "goal (12.00, 0.70) is outside the map (x 0.00 to 5.00 m, y 0.00 to 3.00 m)");
}

TEST(Planner, NamesAGoalThatIsWalledIn) {
  const Error error = RefusalOf(Made(ClosedRoom()), {{1, 1, 0}, 0}, {{3.75, 1.25, 0}, 0});
  EXPECT_TRUE(Is(error, Fault::kWalledIn));
  EXPECT_THAT(error.message, HasSubstr("goal (3.75, 1.25) is walled in, within 0.25 m²"));
}

TEST(Planner, NamesAStartThatIsWalledIn) {
  const Error error = RefusalOf(Made(ClosedRoom()), {{3.75, 1.25, 0}, 0}, {{1, 1, 0}, 0});
  EXPECT_TRUE(Is(error, Fault::kWalledIn));
  EXPECT_THAT(error.message, HasSubstr("start (3.75, 1.25) is walled in"));
}

TEST(Planner, NamesAPassageTooNarrowForTheBody) {
  const CellMap map = Drawn({"....#....",  //
                             ".........",  //
                             ".........",  //
                             "....#...."},
                            0.5);
  EXPECT_TRUE(Made(map, 0.2).Find({{1, 1, 0}, 0}, {{4, 1, 0}, 0}).ok());
  EXPECT_TRUE(Is(RefusalOf(Made(map, 0.6), {{1, 1, 0}, 0}, {{3.7, 1, 0}, 0}), Fault::kWalledIn));
}

TEST(Planner, NamesAPlaceThatNoMapHasInASentence) {
  const auto planner = Planner::Make(Drawn({"....", "....", "...."}, 1, 10), {});
  ASSERT_TRUE(planner.ok());
  for (const double far : {1e308, -1e308, 1e19, 3e9}) {
    const auto plan = planner.value().Find({{1, 1, 0}, 0}, {{far, 1, 0}, 0});
    ASSERT_FALSE(plan.ok()) << far;
    EXPECT_TRUE(Is(plan.error(), Fault::kOutside)) << plan.error().message;
    EXPECT_LT(plan.error().message.size(), 150U) << plan.error().message;
  }
}

TEST(Planner, NamesNumbersThatAreNotFinite) {
  const Planner planner = Made(Wall());
  EXPECT_THAT(RefusalOf(planner, {{1, 1, 0}, 0}, {{kNan, 1, 0}, 0}).message,
              HasSubstr("goal: it has a number that is not finite"));
  EXPECT_THAT(RefusalOf(planner, {{1, 1, 0}, kNan}, {{1, 1, 0}, 0}).message, HasSubstr("start"));
  EXPECT_TRUE(Is(RefusalOf(planner, {{1, 1, 0}, 0}, {{1e300, 1, 0}, 0}), Fault::kOutside));
}

TEST(Planner, LetsABodyLeaveThatStandsALittleTooClose) {
  const Planner planner = Made(Wall());
  const Plan plan = planner.Find({{2.25, 1, 0}, 0}, {{1, 1, 0}, 0}).value();
  EXPECT_GE(RoomAlong(plan.path, planner.clearance()), 0.25 - 1e-6);
  EXPECT_TRUE(Is(RefusalOf(planner, {{2.4, 1, 0}, 0}, {{1, 1, 0}, 0}), Fault::kStartBlocked));
}

TEST(Planner, StopsWhenItsTimeIsUp) {
  CellMap map;
  map.resolution_m = 0.1;
  map.size_x = map.size_y = 300;
  map.blocked.resize(90'000);
  for (int y = 0; y < 295; ++y) map.blocked[map.IndexOf({150, y, 0})] = 1;
  const Planner planner = Made(map);
  const auto plan = planner.Find({{2, 2, 0}, 0}, {{28, 2, 0}, 0}, [] { return true; });
  ASSERT_FALSE(plan.ok());
  EXPECT_TRUE(Is(plan.error(), Fault::kTimeLimit));
}

TEST(Planner, StopsWhileItComputesTheDistancesOfAMap) {
  CellMap map;
  map.resolution_m = 0.1;
  map.size_x = map.size_y = 300;
  map.blocked.resize(90'000);
  int asked = 0;
  ASSERT_TRUE(Planner::Make(map, {}, [&] { return ++asked < 0; }).ok());
  ASSERT_GT(asked, 300) << "at least once for each row";
  for (const int until : {1, 2, 300, asked / 2, asked}) {
    int count = 0;
    const auto stopped = Planner::Make(map, {}, [&] { return ++count == until; });
    ASSERT_FALSE(stopped.ok()) << until;
    EXPECT_TRUE(Is(stopped.error(), Fault::kTimeLimit));
    EXPECT_EQ(count, until) << "it ends at once";
  }
}

TEST(Planner, RefusesAMapThatIsNone) {
  EXPECT_TRUE(Is(Planner::Make({}, {}).error(), Fault::kMap));
  CellMap wrong = Wall();
  wrong.blocked.pop_back();
  EXPECT_THAT(Planner::Make(wrong, {}).error().message, HasSubstr("59 cells, expected 10 x 6"));
  PlannerRules rules;
  rules.radius_m = kNan;
  EXPECT_TRUE(Is(Planner::Make(Wall(), rules).error(), Fault::kInput));
}

TEST(Planner, FliesOverAWall) {
  CellMap map;
  map.resolution_m = 0.25;
  map.size_x = 40;
  map.size_y = 12;
  map.size_z = 16;
  map.blocked.resize(std::size_t{40} * 12 * 16);
  for (int z = 0; z < 10; ++z) {
    for (int y = 0; y < 12; ++y) map.blocked[map.IndexOf({20, y, z})] = 1;
  }
  PlannerRules rules;
  rules.heading = Heading::kTurning;
  const Planner planner = Planner::Make(map, rules).value();
  const Plan plan = planner.Find({{1, 1.5, 1}, 0}, {{9, 1.5, 1}, 1}).value();
  EXPECT_GE(RoomAlong(plan.path, planner.clearance()), 0.3 - 1e-6);
  double highest_m = 0;
  for (const Pose& pose : plan.path) highest_m = std::max(highest_m, pose.at.z_m);
  EXPECT_GT(highest_m, 2.7);
  EXPECT_LT(highest_m, 3.3);
  EXPECT_LT(plan.length_m, 10);
  EXPECT_EQ(plan.path.back(), (Pose{{9, 1.5, 1}, 1}));
}

// On random maps: what the planner finds has room everywhere, and it finds a path where the
// cells have one.
RC_GTEST_PROP(Planner, KeepsRoomForTheBodyOnEveryMap, ()) {
  const auto seed = *rc::gen::inRange<std::uint64_t>(0, 1'000'000);
  PlannerRules rules;
  rules.radius_m = *rc::gen::element(0.0, 0.12, 0.3);
  const Planner planner =
      Planner::Make(RandomBoxes(seed, 8, 0.1, *rc::gen::element(0.05, 0.2, 0.4)), rules).value();
  std::mt19937_64 random(seed);
  const Pose start = {FreePlace(planner.clearance(), rules.radius_m, random), 0};
  const Pose goal = {FreePlace(planner.clearance(), rules.radius_m, random), 0};
  const auto plan = planner.Find(start, goal);
  if (!plan.ok()) {
    RC_ASSERT(!Is(plan.error(), Fault::kOutside) && !Is(plan.error(), Fault::kTimeLimit));
    return;
  }
  RC_ASSERT(plan.value().path.front() == start);
  RC_ASSERT(plan.value().path.back() == goal);
  RC_ASSERT(RoomAlong(plan.value().path, planner.clearance()) >= rules.radius_m - 0.011);
}

// Each cell as four.
CellMap Refined(const CellMap& map) {
  CellMap fine = map;
  fine.resolution_m /= 2;
  fine.size_x *= 2;
  fine.size_y *= 2;
  fine.blocked.resize(map.count() * 4);
  for (std::size_t i = 0; i < fine.count(); ++i) {
    const Cell cell = fine.CellAt(i);
    fine.blocked[i] = map.blocked[map.IndexOf({cell.x / 2, cell.y / 2, 0})];
  }
  return fine;
}

RC_GTEST_PROP(Planner, FindsEachPathThatIsWiderThanTheBodyByACell, ()) {
  const auto seed = *rc::gen::inRange<std::uint64_t>(0, 1'000'000);
  const CellMap map = RandomBoxes(seed, 6, 0.1, *rc::gen::element(0.2, 0.3, 0.4));
  PlannerRules rules;
  rules.radius_m = 0.2;
  const Planner planner = Planner::Make(map, rules).value();
  const auto fine = std::make_shared<Clearance>(Refined(map));
  const CellSearch wider(fine, rules.radius_m + map.resolution_m / 2);
  std::mt19937_64 random(seed);
  const Point start = FreePlace(*fine, 0.3, random), goal = FreePlace(*fine, 0.3, random);
  const Cell from = fine->map().CellOf(start), to = fine->map().CellOf(goal);
  RC_PRE(wider.RegionOf(from) == wider.RegionOf(to));
  RC_ASSERT(planner.Find({start, 0}, {goal, 0}).ok());
}

}  // namespace musher::navigation::testing::planner_test
