// Maps and requests of planner_server, without a network.

#include "musher/modules/navigation/planner_server/planner_work.hpp"

#include <gmock/gmock.h>

#include <cstring>

#include "musher/navigation/navigation_fault.hpp"
#include "musher/test/modules/navigation/simulated_robot.hpp"
#include "musher/test/navigation/maps.hpp"

namespace musher::navigation::planner_work_test {

using ::testing::HasSubstr;

PlannerRobot Ground() {
  PlannerRobot robot;
  robot.name = "jetbot_0";
  return robot;
}

PlannerRobot Flyer() {
  PlannerRobot robot;
  robot.name = "cf2x_0";
  robot.flies = true;
  robot.radius_m = 0.15;
  return robot;
}

msg::PointCloud2 CloudOf(const std::vector<Point>& points) {
  msg::PointCloud2 cloud;
  cloud.width = static_cast<std::uint32_t>(points.size());
  cloud.height = 1;
  cloud.point_step = 12;
  cloud.row_step = cloud.width * 12;
  for (std::uint32_t i = 0; i < 3; ++i) {
    cloud.fields.push_back({std::string(1, char('x' + i)), 4 * i, msg::PointField::kFloat32, 1});
  }
  cloud.data.resize(cloud.row_step);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float values[3] = {float(points[i].x_m), float(points[i].y_m), float(points[i].z_m)};
    std::memcpy(cloud.data.data() + 12 * i, values, sizeof values);
  }
  return cloud;
}

// A wall across x = 2, from the ground to a height of 1 m, between y = -3 and 3.
std::vector<Point> WallOfOneMetre() {
  std::vector<Point> points;
  for (int y = -60; y <= 60; ++y) {
    for (int z = 0; z <= 20; ++z) points.push_back({2, y * 0.05, z * 0.05});
  }
  return points;
}

// A hall of 8 m with a wall across, which has a door at its upper end.
CellMap Hall() {
  return testing::Drawn({"####################", "#..................#", "#..................#",
                         "#........#.........#", "#........#.........#", "#........#.........#",
                         "#........#.........#", "####################"},
                        0.4, 4);
}

PathReply Find(const Planner& planner, const Pose& start, const Pose& goal,
               const PlannerRobot& robot = Ground(), const std::vector<Point>& seen = {}) {
  return FindPath(planner, {start, goal, seen}, {}, robot, {});
}

TEST(PlannerWork, GivesEachFailureItsCodeOfNav2) {
  const auto planner = MakePlanner(testing::GridOf(Hall()), {}, Ground());
  ASSERT_TRUE(planner) << planner.error().message;
  const auto code = [&](const Pose& start, const Pose& goal) {
    return Find(planner.value(), start, goal).error_code;
  };
  const Pose here{{1, 1, 0}, 0}, there{{6, 1, 0}, 0};
  EXPECT_EQ(code(here, there), 0);
  EXPECT_EQ(code({{-5, 1, 0}, 0}, there), 203);
  EXPECT_EQ(code(here, {{50, 1, 0}, 0}), 204);
  EXPECT_EQ(code({{0.1, 0.1, 0}, 0}, there), 205);
  EXPECT_EQ(code(here, {{3.7, 1, 0}, 0}), 206);
  const auto stopped =
      FindPath(planner.value(), {here, there, {}}, {}, Ground(), [] { return true; });
  EXPECT_EQ(stopped.error_code, 207);
}

TEST(PlannerWork, SaysThatThereIsNoPath) {
  const CellMap map = testing::Drawn({"#########", "#...#...#", "#...#...#", "#########"}, 1, 10);
  const auto planner = MakePlanner(testing::GridOf(map), {}, Ground());
  const PathReply reply = Find(planner.value(), {{2, 2, 0}, 0}, {{6, 2, 0}, 0});
  EXPECT_EQ(reply.error_code, 208);
  EXPECT_THAT(reply.plan.error().message, HasSubstr("walled in"));
}

TEST(PlannerWork, GoesAroundWhatTheScanSees) {
  const auto planner = MakePlanner(testing::GridOf(Hall()), {}, Ground());
  const Pose start{{5, 1.2, 0}, 0}, goal{{7, 1.2, 0}, 0};
  const std::vector<Point> box = {{6, 1.1, 0}, {6, 1.2, 0}, {6, 1.3, 0}};
  const PathReply reply = Find(planner.value(), start, goal, Ground(), box);
  ASSERT_TRUE(reply.plan) << reply.plan.error().message;
  EXPECT_TRUE(reply.around_seen);
  for (const Pose& pose : reply.plan.value().path) {
    for (const Point& point : box) EXPECT_GT(Distance(pose.at, point), 0.29);
  }
}

// 130 m by 130 m, 6.8 million cells.
TEST(PlannerWork, GoesAroundWhatTheScanSeesAlsoOnALargeMap) {
  CellMap map;
  map.resolution_m = 0.05;
  map.size_x = map.size_y = 2600;
  map.blocked.assign(std::size_t{2600} * 2600, 0);
  const auto planner = MakePlanner(testing::GridOf(map), {}, Ground());
  ASSERT_TRUE(planner) << planner.error().message;
  std::vector<Point> box;
  for (int i = -10; i <= 10; ++i) box.push_back({62, 60 + 0.05 * i, 0});
  for (const Point& to : {Point{66, 60, 0}, Point{120, 60, 0}, Point{125, 125, 0}}) {
    const Pose start{{60, 60, 0}, 0};
    std::vector<Point> in_the_way = box;
    if (to.y_m > 100) in_the_way = {{61.5, 61.5, 0}, {61.6, 61.4, 0}, {61.4, 61.6, 0}};
    const PathReply reply = Find(planner.value(), start, {to, 0}, Ground(), in_the_way);
    ASSERT_TRUE(reply.plan) << reply.plan.error().message;
    EXPECT_TRUE(reply.around_seen) << to.x_m;
    EXPECT_LT(Distance(reply.plan.value().path.back().at, to), 0.01);
    for (const Pose& pose : reply.plan.value().path) {
      for (const Point& point : in_the_way) EXPECT_GT(Distance(pose.at, point), 0.29);
    }
  }
}

// So a new path is there within milliseconds, on maps of any size.
TEST(PlannerWork, GoesOnWithTheLastPathAndPlansAroundWhatIsSeenNearTheRobot) {
  const auto planner = MakePlanner(testing::GridOf(Hall()), {}, Ground());
  PathRequest request{{{1, 1, 0}, 0}, {{7, 1, 0}, 0}, {}, {}};
  const PathReply first = FindPath(planner.value(), request, {}, Ground(), {});
  ASSERT_TRUE(first.plan);
  request.before = first.plan.value().path;
  request.start = request.before[request.before.size() / 2];
  const PathReply goes_on = FindPath(planner.value(), request, {}, Ground(), {});
  ASSERT_TRUE(goes_on.plan);
  EXPECT_EQ(goes_on.plan.value().path.front().at, request.start.at);
  EXPECT_LT(goes_on.plan.value().length_m, first.plan.value().length_m);
  EXPECT_EQ(goes_on.plan.value().path.back(), request.goal);
  request.start = {{0.8, 2.2, 0}, 0};  // it has left the path
  const PathReply again = FindPath(planner.value(), request, {}, Ground(), {});
  ASSERT_TRUE(again.plan);
  EXPECT_EQ(again.plan.value().path.front().at, request.start.at);
}

// Of the path only what is near the robot changes: the rest is not planned again, and the robot
// does not turn elsewhere for a thing on its way.
TEST(PlannerWork, ChangesThePathOnlyNearWhatIsSeen) {
  const CellMap map = testing::Carved(40, 12, 0.05, {{0.2, 0.2, 39.8, 11.8}});
  const auto planner = MakePlanner(testing::GridOf(map), {}, Ground());
  ASSERT_TRUE(planner);
  PathRequest request{{{1, 6, 0}, 0}, {{39, 6, 0}, 0}, {}, {}};
  const std::vector<Point> corners = {{1, 6, 0}, {20, 6, 0}, {25, 10, 0}, {30, 6, 0}, {39, 6, 0}};
  for (std::size_t i = 1; i < corners.size(); ++i) {
    for (int part = 0; part < 40; ++part) {
      request.before.push_back({Between(corners[i - 1], corners[i], part / 40.0), 0});
    }
  }
  request.before.push_back(request.goal);
  for (int i = -6; i <= 6; ++i) request.seen.push_back({3.5, 6 + 0.05 * i, 0});
  const PathReply reply = FindPath(planner.value(), request, {}, Ground(), {});
  ASSERT_TRUE(reply.plan) << reply.plan.error().message;
  EXPECT_TRUE(reply.around_seen);
  double corner_m = 100, seen_m = 100;
  for (const Pose& pose : reply.plan.value().path) {
    corner_m = std::min(corner_m, Distance(pose.at, corners[2]));
    for (const Point& point : request.seen) seen_m = std::min(seen_m, Distance(pose.at, point));
  }
  EXPECT_LT(corner_m, 0.01) << "its far part stays";
  EXPECT_GT(seen_m, 0.25);
}

// memory_m may be 50: what is seen 15 m ahead was forgotten when the path was planned.
TEST(PlannerWork, GoesAroundAllThatIsRemembered) {
  const CellMap map = testing::Carved(40, 12, 0.05, {{0.2, 0.2, 39.8, 11.8}});
  const auto planner = MakePlanner(testing::GridOf(map), {}, Ground());
  ASSERT_TRUE(planner);
  std::vector<Point> box;
  for (int i = -6; i <= 6; ++i) box.push_back({20, 6 + 0.05 * i, 0});
  const PathReply reply = Find(planner.value(), {{5, 6, 0}, 0}, {{35, 6, 0}, 0}, Ground(), box);
  ASSERT_TRUE(reply.plan);
  EXPECT_TRUE(reply.around_seen);
  for (const Pose& pose : reply.plan.value().path) {
    for (const Point& point : box) EXPECT_GT(Distance(pose.at, point), 0.29);
  }
}

// It was led straight into what stood ahead, and waited there as long as the person behind it did.
TEST(PlannerWork, GoesAroundWhatIsAheadAlsoWhereAPersonStandsRightBehindTheRobot) {
  const CellMap map = testing::Carved(20, 12, 0.05, {{0.2, 0.2, 19.8, 11.8}});
  const auto planner = MakePlanner(testing::GridOf(map), {}, Ground());
  ASSERT_TRUE(planner);
  std::vector<Point> box, seen;
  for (int i = -4; i <= 4; ++i) {
    seen.push_back({4.85, 6 + 0.03 * i, 0});
    box.push_back({6, 6 + 0.03 * i, 0});
  }
  seen.insert(seen.end(), box.begin(), box.end());
  const PathReply reply = Find(planner.value(), {{5, 6, 0}, 0}, {{10, 6, 0}, 0}, Ground(), seen);
  ASSERT_TRUE(reply.plan);
  EXPECT_TRUE(reply.around_seen);
  for (const Pose& pose : reply.plan.value().path) {
    for (const Point& point : box) EXPECT_GT(Distance(pose.at, point), 0.29);
  }
}

// It had driven into the box: a door that was seen closed took the detour away.
TEST(PlannerWork, GoesAroundWhatIsNearAlsoWhereTheWayIsClosedFartherOff) {
  const CellMap map = testing::Carved(40, 12, 0.05, {{0.2, 0.2, 39.8, 11.8}});
  const auto planner = MakePlanner(testing::GridOf(map), {}, Ground());
  ASSERT_TRUE(planner);
  std::vector<Point> box, seen;
  for (int i = -6; i <= 6; ++i) box.push_back({8, 6 + 0.05 * i, 0});
  for (int i = 4; i < 237; ++i) seen.push_back({26, 0.05 * i, 0});
  const Pose start{{5, 6, 0}, 0}, goal{{35, 6, 0}, 0};
  const PathReply closed = Find(planner.value(), start, goal, Ground(), seen);
  ASSERT_TRUE(closed.plan);
  EXPECT_FALSE(closed.around_seen);
  seen.insert(seen.end(), box.begin(), box.end());
  const PathReply reply = Find(planner.value(), start, goal, Ground(), seen);
  ASSERT_TRUE(reply.plan);
  EXPECT_TRUE(reply.around_seen);
  EXPECT_EQ(reply.plan.value().path.back().at, goal.at);
  for (const Pose& pose : reply.plan.value().path) {
    for (const Point& point : box) EXPECT_GT(Distance(pose.at, point), 0.29);
  }
}

TEST(PlannerWork, PlansOnTheWholeMapWhereNothingLeadsAroundNearTheRobot) {
  CellMap map = testing::Carved(
      40, 8, 0.05,
      {{0.2, 0.2, 39.8, 1.6}, {0.2, 6.4, 39.8, 7.8}, {0.2, 0.2, 1.6, 7.8}, {38.4, 0.2, 39.8, 7.8}});
  const auto planner = MakePlanner(testing::GridOf(map), {}, Ground());
  ASSERT_TRUE(planner);
  PathRequest request{{{10, 0.9, 0}, 0}, {{39, 1, 0}, 0}, {}, {}};
  request.before = FindPath(planner.value(), request, {}, Ground(), {}).plan.value().path;
  for (int i = 0; i <= 40; ++i) request.seen.push_back({13, 0.2 + 0.04 * i, 0});
  const PathReply around = FindPath(planner.value(), request, {}, Ground(), {});
  ASSERT_TRUE(around.plan);
  EXPECT_TRUE(around.around_seen);
  EXPECT_GT(around.plan.value().length_m, 45) << "by the other corridor";
}

TEST(PlannerWork, TakesAThingThatAFlyerSeesForAsHighAsTheRoom) {
  const auto planner = MakePlanner(CloudOf({{0, 0, 0}, {6, 3, 0}, {0, 3, 3}}), {}, Flyer());
  ASSERT_TRUE(planner) << planner.error().message;
  const std::vector<Point> person = {{3, 1.5, 0.8}, {3, 1.4, 0.8}, {3, 1.6, 0.8}};
  const PathReply reply =
      Find(planner.value(), {{1, 1.5, 0.8}, 0}, {{5, 1.5, 0.8}, 0}, Flyer(), person);
  ASSERT_TRUE(reply.plan) << reply.plan.error().message;
  EXPECT_TRUE(reply.around_seen);
  for (const Pose& pose : reply.plan.value().path) {
    for (const Point& point : person) {
      EXPECT_GT(std::hypot(pose.at.x_m - point.x_m, pose.at.y_m - point.y_m), 0.2)
          << "neither above nor below it";
    }
  }
}

TEST(PlannerWork, IgnoresAScanOfTheWallsOfTheMap) {
  const auto planner = MakePlanner(testing::GridOf(Hall()), {}, Ground());
  const std::vector<Point> wall = {{3.62, 1, 0}, {3.61, 1.2, 0}, {0.42, 1, 0}};
  const PathReply reply = Find(planner.value(), {{2, 1, 0}, 0}, {{2, 2, 0}, 0}, Ground(), wall);
  ASSERT_TRUE(reply.plan);
  EXPECT_FALSE(reply.around_seen);
}

TEST(PlannerWork, PlansByTheMapWhereNothingThatIsSeenIsOnTheWay) {
  const auto planner = MakePlanner(testing::GridOf(Hall()), {}, Ground());
  const PathReply reply =
      Find(planner.value(), {{5, 1.2, 0}, 0}, {{7, 1.2, 0}, 0}, Ground(), {{6, 2.2, 0}});
  ASSERT_TRUE(reply.plan);
  EXPECT_FALSE(reply.around_seen);
}

TEST(PlannerWork, PlansByTheMapWhereNothingLeadsAroundWhatIsSeen) {
  const auto planner = MakePlanner(testing::GridOf(Hall()), {}, Ground());
  std::vector<Point> in_the_door;
  for (int i = 0; i < 8; ++i) in_the_door.push_back({3.8, 1.6 + 0.15 * i, 0});
  const PathReply reply =
      Find(planner.value(), {{2.6, 2.2, 0}, 0}, {{5, 2.2, 0}, 0}, Ground(), in_the_door);
  ASSERT_TRUE(reply.plan) << reply.plan.error().message;
  EXPECT_FALSE(reply.around_seen);
}

class Refuge : public ::testing::Test {
 protected:
  static constexpr double kBayM = 5;

  Result<Plan> Find(const Pose& start, const std::vector<RobotIntent>& others,
                    const std::vector<Point>& seen = {}) {
    return FindRefuge(planner_.value(), {start, seen, others}, Ground(), {});
  }
  // That drives through the corridor from its other end.
  static RobotIntent Other(double x_m) {
    return {.robot = "/b", .at = {x_m, 1.4, 0}, .path = {{2, 1.4, 0}, {1, 1.4, 0}}};
  }

  const Result<Planner> planner_ =
      MakePlanner(testing::GridOf(testing::CorridorWithABay(kBayM)), {}, Ground());
};

TEST_F(Refuge, IsTheLastWidePlaceBehindTheRobot) {
  const auto plan = Find({{7, 1.4, 0}, 0}, {Other(9)});
  ASSERT_TRUE(plan) << plan.error().message;
  const Pose& place = plan.value().path.back();
  EXPECT_NEAR(place.at.x_m, kBayM, 0.3);
  EXPECT_GT(place.at.y_m, 1.4 + 0.55);
  EXPECT_LT(plan.value().length_m, 4);
}

TEST_F(Refuge, IsNotBeyondTheBodyOfTheOtherRobot) {
  RobotIntent other = Other(5.8);
  other.path = {{9, 1.4, 0}, {13, 1.4, 0}};
  const auto plan = Find({{6.8, 1.4, 0}, M_PI}, {other});
  ASSERT_TRUE(plan) << plan.error().message;
  EXPECT_GT(plan.value().path.back().at.x_m, 11.2) << "the room behind it";
}

TEST_F(Refuge, IsWhereTheRobotStandsIfItIsOffAllPaths) {
  const auto plan = Find({{kBayM, 2.4, 0}, 0}, {Other(9)});
  ASSERT_TRUE(plan) << plan.error().message;
  EXPECT_LT(plan.value().length_m, 0.2);
}

TEST_F(Refuge, IsNoneInADeadEnd) {
  // The end of the corridor behind it is closed by what the scan sees.
  std::vector<Point> seen;
  for (int i = 0; i <= 20; ++i) seen.push_back({6, 0.9 + 0.05 * i, 0});
  const auto plan = Find({{7, 1.4, 0}, 0}, {Other(9)}, seen);
  ASSERT_FALSE(plan);
  EXPECT_TRUE(Is(plan.error(), Fault::kWalledIn)) << plan.error().message;
}

TEST_F(Refuge, IsFoundAlsoForAPathThatEndsFarAway) {
  RobotIntent other = Other(9);
  other.path.push_back({1e12, 1e12, 0});
  EXPECT_TRUE(Find({{7, 1.4, 0}, 0}, {other}));
}

TEST(PlannerWork, FliesOverAWall) {
  const auto planner = MakePlanner(CloudOf(WallOfOneMetre()), {}, Flyer());
  ASSERT_TRUE(planner) << planner.error().message;
  const PathReply reply = Find(planner.value(), {{1.3, 0, 0.5}, 0}, {{2.8, 0, 0.5}, 0}, Flyer());
  ASSERT_TRUE(reply.plan) << reply.plan.error().message;
  double highest_m = 0;
  for (const Pose& pose : reply.plan.value().path) {
    highest_m = std::max(highest_m, pose.at.z_m);
    EXPECT_GT(pose.at.z_m, 0.2);
  }
  EXPECT_GT(highest_m, 1.2);
  EXPECT_LT(highest_m, 3);
}

TEST(PlannerWork, RefusesAnAltitudeBelowTheGroundOrAboveTheCeiling) {
  const auto planner = MakePlanner(CloudOf(WallOfOneMetre()), {}, Flyer());
  ASSERT_TRUE(planner);
  const Pose start{{1.3, 0, 0.5}, 0};
  for (const double z_m : {-0.5, 0.0, 3.1}) {
    const PathReply reply = Find(planner.value(), start, {{1.3, 1, z_m}, 0}, Flyer());
    EXPECT_EQ(reply.error_code, 204) << z_m;
    EXPECT_THAT(reply.plan.error().message, HasSubstr("at most 3.00 m"));
  }
  EXPECT_EQ(Find(planner.value(), start, {{1.3, 1, 2.6}, 0}, Flyer()).error_code, 0)
      << "above the points, below the ceiling";
}

TEST(PlannerWork, TakesACloudOfAMillionPoints) {
  std::vector<Point> points;
  points.reserve(1'000'000);
  for (int i = 0; i < 1'000'000; ++i) {
    points.push_back({(i % 1000) * 0.01, (i / 1000) * 0.01, 0});
  }
  const auto planner = MakePlanner(CloudOf(points), {}, Flyer());
  ASSERT_TRUE(planner) << planner.error().message;
  EXPECT_LT(planner.value().clearance().map().count(), 500'000U);
}

TEST(PlannerWork, RefusesACloudOfTooManyCells) {
  const auto planner = MakePlanner(CloudOf({{0, 0, 1}, {3000, 3000, 1}}), {}, Flyer());
  ASSERT_FALSE(planner);
  EXPECT_TRUE(Is(planner.error(), Fault::kMap));
}

}  // namespace musher::navigation::planner_work_test
