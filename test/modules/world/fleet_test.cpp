// Several robots in one world: collisions, hands and objects, movers, maps and scans.

#include "musher/modules/world/simulation/fleet.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "musher/modules/world/sensors/fleet_sensing.hpp"
#include "musher/modules/world/simulation/fleet_report.hpp"
#include "musher/test/modules/world/rooms.hpp"

namespace musher::world::fleet_test {

using Eigen::Vector2d;
using Eigen::Vector3d;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Vector3d At(const World& world, std::size_t robot) {
  return world.fleet().robots()[robot].body.position_m();
}
int CollisionsOf(const World& world, std::size_t robot) {
  return world.fleet().robots()[robot].collisions;
}

TEST(Fleet, MovesEachRobotByItsOwnCommands) {
  World world(RobotYard());
  DriveFor(world, 0, {{1, 0, 0}, 0}, Seconds(2));
  EXPECT_GT(At(world, 0).x(), 1.7);
  EXPECT_EQ(At(world, 1), Vector3d(0, 3, 0));
  EXPECT_EQ(At(world, 2), Vector3d(-3, 0, 0));
}

TEST(Fleet, CountsACollisionOnceUntilTheRobotMovesFreelyAgain) {
  Scene scene = RobotYard();
  scene.boxes = {{"shelf", {1.5, 0}, {0.5, 0.5}}};
  World world(scene);
  DriveFor(world, 0, {{1, 0, 0}, 0}, Seconds(3));
  EXPECT_EQ(CollisionsOf(world, 0), 1);
  EXPECT_NEAR(At(world, 0).x(), 0.8, 0.03);
  DriveFor(world, 0, {{-1, 0, 0}, 0}, Seconds(0.5));
  DriveFor(world, 0, {{1, 0, 0}, 0}, Seconds(2));
  EXPECT_EQ(CollisionsOf(world, 0), 2);
}

TEST(Fleet, NeverHasTwoRobotsOrARobotAndAWallInOnePlace) {
  Scene scene = RobotYard();
  scene.boxes = {{"wall", {2, 0}, {0.05, 3}}, {"wall", {0, -2}, {3, 0.05}, 0.3}};
  scene.movers = {MoverSpec{.name = "person_0", .points_m = {{-2, -4}, {-2, 4}}}};
  World world(scene);
  transport::sim::Random random(5);
  const auto any = [&] { return static_cast<double>(random.Next() % 401) / 100 - 2; };
  for (int i = 0; i < 3000; ++i) {
    for (std::size_t robot = 0; i % 25 == 0 && robot < 3; ++robot) {
      world.Drive(robot, {{any(), any(), any() / 2}, any()});
    }
    world.Step();
    for (std::size_t robot = 0; robot < 3; ++robot) {
      const BodyCylinder body = CylinderOf(world.scene().robots[robot], At(world, robot));
      ASSERT_TRUE(IsWithin(world.scene(), body)) << i;
      for (const Solid& solid : world.fleet().MovingSolids(world.scene(), robot)) {
        ASSERT_FALSE(Overlaps(solid, body)) << i << " " << solid.what;
      }
      for (const Solid& solid : SolidsOf(world.scene())) ASSERT_FALSE(Overlaps(solid, body)) << i;
    }
  }
  EXPECT_GT(CollisionsOf(world, 0) + CollisionsOf(world, 1), 0);
}

TEST(Fleet, FliesOverALowThingAndLandsOnIt) {
  Scene scene = RobotYard();
  scene.boxes = {{"table", {-3, 1.5}, {0.5, 0.5}, 0, 0.7}};
  World world(scene);
  DriveFor(world, 2, {{0, 0, 0.5}, 0}, Seconds(3));
  DriveFor(world, 2, {{0, 0.5, 0}, 0}, Seconds(3.2));
  EXPECT_EQ(CollisionsOf(world, 2), 0);
  DriveFor(world, 2, {{0, 0, -0.5}, 0}, Seconds(3));
  EXPECT_DOUBLE_EQ(At(world, 2).z(), 0.7);
  EXPECT_FALSE(world.fleet().robots()[2].body.airborne());
}

TEST(Fleet, IsStoppedByTheCeiling) {
  World world(RobotYard());
  DriveFor(world, 2, {{0, 0, 1}, 0}, Seconds(5));
  EXPECT_LE(At(world, 2).z(), 2.3 + 1e-6);
  EXPECT_GT(At(world, 2).z(), 2.2);
  EXPECT_EQ(CollisionsOf(world, 2), 1);
}

TEST(Fleet, DrainsABatteryFasterInTheAir) {
  Scene scene = RobotYard();
  scene.robots.push_back(FlyingRobot("cf2x_1", -3, 3));
  for (RobotSpec& robot : scene.robots) robot.battery.capacity_wh = 1;
  World world(scene);
  DriveFor(world, 2, {{0, 0, 0.3}, 0}, Seconds(4));
  const auto percent = [&](std::size_t i) { return world.fleet().robots()[i].battery.percent(); };
  EXPECT_LT(percent(2), percent(3) - 5);
  Pass(world, Seconds(60));
  EXPECT_EQ(percent(2), 0);
  EXPECT_EQ(At(world, 2).z(), 0);
}

TEST(Fleet, IsTheSameFromTheSameSeed) {
  const auto run = [](std::uint64_t seed) {
    Scene scene = RobotYard();
    scene.seed = seed;
    scene.robots[2].wind.drift_m_s = 0.1;
    scene.movers = {MoverSpec{.name = "p", .points_m = {{-2, -4}, {-2, 4}}, .wait_s = 3}};
    World world(scene);
    DriveFor(world, 2, {{0, 0, 0.2}, 0}, Seconds(20));
    return std::pair(At(world, 2), Vector2d(world.fleet().movers()[0].position_m()));
  };
  EXPECT_EQ(run(1), run(1));
  EXPECT_NE(run(1).first, run(2).first);
  EXPECT_NE(run(1).second, run(2).second);
}

TEST(Fleet, PutsARobotDownWhereItIsFreeAndRefusesOtherPlaces) {
  Scene scene = RobotYard();
  scene.boxes = {{"shelf", {2, 2}, {0.5, 0.5}}};
  World world(scene);
  EXPECT_EQ(world.PutDown(0, {{2, 2}, 0}),
            "jetbot_0 cannot be at (2.00 m, 2.00 m): it would be in box \"shelf\"");
  EXPECT_EQ(world.PutDown(0, {{0, 3.1}, 0}),
            "jetbot_0 cannot be at (0.00 m, 3.10 m): it would be in jetbot_1");
  EXPECT_EQ(world.PutDown(0, {{9, 0}, 0}),
            "jetbot_0 cannot be at (9.00 m, 0.00 m): it is outside the place");
  EXPECT_EQ(world.PutDown(0, {{kNan, 0}, 0}), "jetbot_0: a place that is not a number is refused");
  EXPECT_EQ(At(world, 0), Vector3d(0, 0, 0));
  EXPECT_FALSE(world.PutDown(0, {{3, -3}, 1}));
  Pass(world, Seconds(1));
  EXPECT_EQ(At(world, 0), Vector3d(3, -3, 0));
  EXPECT_TRUE(world.SetBattery(0, 101));
  EXPECT_TRUE(world.SetBattery(0, kNan));
  EXPECT_FALSE(world.SetBattery(0, 20));
  EXPECT_NEAR(world.fleet().robots()[0].battery.percent(), 20, 1e-9);
}

// Hands.

Scene WithBoxes() {
  Scene scene = RobotYard();
  scene.objects = {BoxOf("box_red", {0.8, 0, 0.075}), BoxOf("box_blue", {4, 4, 0.075})};
  scene.robots[1].hand.emplace();
  return scene;
}

TEST(Hand, ChecksTheDistanceAgainstTheThresholdAndItsReach) {
  World world(WithBoxes());
  const HandReply near = world.UseHand(0, {HandAction::kCheckDistance, "box_red", 2, {}});
  EXPECT_TRUE(near.success);
  EXPECT_EQ(near.message, "Within grasp distance");
  EXPECT_NEAR(near.distance_m, std::hypot(0.45, 0.325), 1e-9);
  const HandReply strict = world.UseHand(0, {HandAction::kCheckDistance, "box_red", 0.1, {}});
  EXPECT_FALSE(strict.success);
  EXPECT_EQ(strict.message, "Too far: 0.56m > 0.10m");
  const HandReply far = world.UseHand(0, {HandAction::kAttach, "box_blue", 20, {}});
  EXPECT_FALSE(far.success);
  EXPECT_THAT(far.message, AllOf(HasSubstr("Too far: "), HasSubstr("> 1.00m (the reach")));
  EXPECT_GT(far.distance_m, 4);
}

TEST(Hand, CarriesAnObjectWithoutCollisionAndReleasesItToTheFloor) {
  World world(WithBoxes());
  const HandReply taken = world.UseHand(0, {HandAction::kAttach, "box_red", 2, {}});
  ASSERT_TRUE(taken.success) << taken.message;
  EXPECT_EQ(taken.message, "Object attached");
  DriveFor(world, 0, {{1, 0, 0}, 0.5}, Seconds(3));
  EXPECT_EQ(CollisionsOf(world, 0), 0);
  const FleetObject& box = world.fleet().objects()[0];
  EXPECT_NEAR((box.middle_m - At(world, 0)).norm(), std::hypot(0.35, 0.4), 1e-9);
  EXPECT_EQ(box.held_by, std::optional<std::size_t>(0));
  const HandReply released = world.UseHand(0, {HandAction::kRelease, "", 0, {}});
  EXPECT_EQ(released.message, "Object released");
  EXPECT_NEAR(world.fleet().objects()[0].middle_m.z(), 0.075, 1e-9);
  EXPECT_FALSE(world.fleet().objects()[0].held_by);
}

TEST(Hand, ReleasesAnObjectOntoTheTableBelowIt) {
  Scene scene = WithBoxes();
  scene.boxes = {{"table", {2, 0}, {0.4, 1}, 0, 0.3}};
  World world(scene);
  ASSERT_TRUE(world.UseHand(0, {HandAction::kAttach, "box_red", 2, {}}).success);
  DriveFor(world, 0, {{1, 0, 0}, 0}, Seconds(3));
  ASSERT_TRUE(world.UseHand(0, {HandAction::kRelease, "box_red", 0, {}}).success);
  EXPECT_NEAR(world.fleet().objects()[0].middle_m.z(), 0.375, 1e-9);
}

TEST(Hand, PlacesAnObjectWhereItIsFreeAndWithinReach) {
  Scene scene = WithBoxes();
  scene.boxes = {{"shelf", {0.9, 0.6}, {0.2, 0.1}, 0, 1.5}};
  scene.objects.push_back(BoxOf("box_green", {0.6, -0.5, 0.075}));
  World world(scene);
  ASSERT_TRUE(world.UseHand(0, {HandAction::kAttach, "box_red", 2, {}}).success);
  const auto place = [&](const Vector3d& target) {
    return world.UseHand(0, {HandAction::kPlace, "box_red", 0, target});
  };
  EXPECT_THAT(place({3, 0, 0}).message, HasSubstr("Too far: "));
  EXPECT_EQ(place({0.9, 0.6, 0}).message, "the target is in box \"shelf\"");
  EXPECT_EQ(place({0.6, -0.5, 0}).message, "the target is in box_green");
  EXPECT_EQ(place({0, 0, 0}).message, "the target is in jetbot_0");
  EXPECT_THAT(place({kNan, 0, 0}).message, HasSubstr("not a number"));
  EXPECT_TRUE(world.fleet().robots()[0].holds);
  const HandReply placed = place({0.8, 0.1, 0});
  EXPECT_TRUE(placed.success);
  EXPECT_EQ(placed.message, "Object placed");
  EXPECT_TRUE(world.fleet().objects()[0].middle_m.isApprox(Vector3d(0.8, 0.1, 0.075)));
  EXPECT_FALSE(world.fleet().robots()[0].holds);
}

TEST(Hand, DoesNotReachThroughAWallButOverALowThing) {
  Scene scene = WithBoxes();
  scene.boxes = {{"wall", {0.6, 0}, {0.05, 1}, 0, 2}};
  World world(scene);
  for (const HandAction action : {HandAction::kCheckDistance, HandAction::kAttach}) {
    const HandReply through = world.UseHand(0, {action, "box_red", 2, {}});
    EXPECT_FALSE(through.success);
    EXPECT_EQ(through.message, "box \"wall\" is between the hand and box_red");
    EXPECT_NEAR(through.distance_m, std::hypot(0.45, 0.325), 1e-9);
  }
  scene.boxes = {{"wall", {0.28, 0}, {0.03, 1}, 0, 2}};
  EXPECT_FALSE(World(scene).UseHand(0, {HandAction::kAttach, "box_red", 2, {}}).success)
      << "the wall is between the robot and its hand";
  scene.boxes = {{"step", {0.6, 0}, {0.05, 1}, 0, 0.3}};
  EXPECT_TRUE(World(scene).UseHand(0, {HandAction::kAttach, "box_red", 2, {}}).success);
  scene.boxes = {{"wall", {0.6, -0.7}, {0.05, 0.4}, 0, 2}};
  World beside(scene);
  ASSERT_TRUE(beside.UseHand(0, {HandAction::kAttach, "box_red", 2, {}}).success);
  EXPECT_EQ(beside.UseHand(0, {HandAction::kPlace, "", 0, {0.9, -0.6, 0}}).message,
            "box \"wall\" is between the hand and the target");
}

TEST(Hand, HoldsOneObjectAndAnObjectHasOneHolder) {
  Scene scene = WithBoxes();
  scene.robots[1].start_m = {1.6, 0, 0};
  scene.robots[1].start_yaw_rad = M_PI;
  scene.objects[1].middle_m = {0.8, 0.3, 0.075};
  World world(scene);
  ASSERT_TRUE(world.UseHand(0, {HandAction::kAttach, "box_red", 2, {}}).success);
  EXPECT_TRUE(world.UseHand(0, {HandAction::kAttach, "box_red", 2, {}}).success);
  EXPECT_EQ(world.UseHand(0, {HandAction::kAttach, "box_blue", 2, {}}).message,
            "jetbot_0 already holds box_red");
  EXPECT_EQ(world.UseHand(1, {HandAction::kAttach, "box_red", 2, {}}).message,
            "box_red is held by jetbot_0");
  EXPECT_EQ(world.UseHand(1, {HandAction::kRelease, "box_red", 0, {}}).message,
            "jetbot_1 does not hold box_red");
  EXPECT_EQ(world.UseHand(1, {HandAction::kRelease, "", 0, {}}).message,
            "jetbot_1 holds no object");
}

TEST(Hand, RefusesWhatItDoesNotKnowWithTheNearestName) {
  World world(WithBoxes());
  EXPECT_EQ(world.UseHand(0, {HandAction::kAttach, "box_rde", 2, {}}).message,
            "there is no object \"box_rde\"; did you mean \"box_red\"?");
  EXPECT_EQ(world.UseHand(2, {HandAction::kAttach, "box_red", 2, {}}).message,
            "cf2x_0 has no hand");
  EXPECT_THAT(world.UseHand(0, {HandAction::kAttach, "", 2, {}}).message,
              HasSubstr("expected the name of an object"));
  EXPECT_THAT(world.UseHand(0, {HandAction::kCheckDistance, "box_red", kNan, {}}).message,
              HasSubstr("expected a distance threshold"));
  EXPECT_THAT(world.UseHand(0, {HandAction::kCheckDistance, "box_red", -1, {}}).message,
              HasSubstr("expected a distance threshold"));
}

TEST(Objects, FallWhenWhatTheyStandOnIsTaken) {
  Scene scene = WithBoxes();
  scene.objects[1].middle_m = {0.8, 0, 0.225};
  World world(scene);
  EXPECT_NEAR(world.fleet().objects()[1].middle_m.z(), 0.225, 1e-9);
  ASSERT_TRUE(world.UseHand(0, {HandAction::kAttach, "box_red", 2, {}}).success);
  EXPECT_NEAR(world.fleet().objects()[1].middle_m.z(), 0.075, 1e-9);
}

// Movers, scans and maps.

TEST(Movers, WaitForARobotInTheirWay) {
  Scene scene = RobotYard();
  scene.movers = {MoverSpec{.name = "p", .points_m = {{2, 0}, {-2, 0}}, .speed_vary = 0}};
  World world(scene);
  Pass(world, Seconds(10));
  EXPECT_NEAR(world.fleet().movers()[0].position_m().x(), 0.5, 0.02);
  EXPECT_EQ(world.fleet().movers()[0].speed_m_s(), 0);
  DriveFor(world, 0, {{0, -1, 0}, 0}, Seconds(2));
  Pass(world, Seconds(2));
  EXPECT_LT(world.fleet().movers()[0].position_m().x(), 0);
}

// Found in a demo: a robot waited for a mover that waited for the robot, both for ever.
TEST(Movers, TurnRoundWhenARobotStaysInTheirWay) {
  for (const bool round_trip : {false, true}) {
    Scene scene = RobotYard();
    scene.movers = {MoverSpec{
        .name = "p", .points_m = {{2, 0}, {-2, 0}}, .round_trip = round_trip, .speed_vary = 0}};
    World world(scene);
    Pass(world, Seconds(8));
    EXPECT_NEAR(world.fleet().movers()[0].position_m().x(), 0.5, 0.02);
    Pass(world, Seconds(7));
    EXPECT_GT(world.fleet().movers()[0].position_m().x(), 0.6) << "it goes back";
  }
}

TEST(Movers, GoToAndFroOrRound) {
  Scene scene = RobotYard();
  const std::vector<Vector2d> points = {{2, 1}, {4, 1}, {4, 3}};
  scene.movers = {MoverSpec{.name = "a", .points_m = points, .speed_m_s = 1, .speed_vary = 0},
                  MoverSpec{.name = "b",
                            .points_m = {{-4, 1}, {-2, 1}, {-2, 3}},
                            .round_trip = true,
                            .speed_m_s = 1,
                            .speed_vary = 0}};
  World world(scene);
  Pass(world, Seconds(4));
  EXPECT_TRUE(world.fleet().movers()[0].position_m().isApprox(Vector2d(4, 3), 0.02));
  Pass(world, Seconds(2));
  EXPECT_TRUE(world.fleet().movers()[0].position_m().isApprox(Vector2d(4, 1), 0.02));
  EXPECT_NEAR(world.fleet().movers()[1].yaw_rad(), -3 * M_PI / 4, 1e-6);
}

TEST(RobotScan, HasRobotsMoversAndObjectsAndNotItself) {
  Scene scene = RobotYard();
  scene.robots[1].start_m = {0, 2, 0};
  scene.objects = {BoxOf("box_red", {1, 0, 0.1})};
  scene.objects[0].size_m = {0.2, 0.2, 0.2};
  scene.movers = {MoverSpec{.name = "p", .points_m = {{-1.5, 0}, {-1.5, 0.01}}, .wait_s = 0}};
  const World world(scene);
  const msg::LaserScan scan = MeasureRobotScan(world, 0);
  ASSERT_EQ(scan.ranges.size(), 360u);
  EXPECT_EQ(scan.header.frame_id, "jetbot_0");
  const auto towards = [&](double rad) {
    return scan.ranges[static_cast<std::size_t>(
        std::lround((rad - scan.angle_min) / scan.angle_increment))];
  };
  EXPECT_NEAR(towards(0), 0.9, 0.01);
  EXPECT_NEAR(towards(M_PI / 2), 1.8, 0.01);
  EXPECT_NEAR(towards(-M_PI), 1.3, 0.01);
  EXPECT_NEAR(towards(-M_PI / 2), 5, 0.01);
}

// A flyer at a height above the middle of the yard.
Scene FlyerAbove(double height_m) {
  Scene scene = RobotYard();
  scene.robots[0].kind = RobotKind::kFlyer;
  scene.robots[0].start_m = {0, 0, height_m};
  scene.robots[0].range_down.emplace();
  scene.robots[1].start_m = {-4, -4, 0};
  scene.ceiling_m = 10;
  return scene;
}

TEST(RobotRange, IsToTheGroundWhereNothingIsBelow) {
  const msg::Range range = MeasureRobotRange(World(FlyerAbove(2.5)), 0);
  EXPECT_NEAR(range.range, 2.5, 0.05);
  EXPECT_EQ(range.header.frame_id, "jetbot_0/range_down");
  EXPECT_NEAR(range.field_of_view, M_PI / 6, 1e-6);
  EXPECT_NEAR(MeasureRobotRange(World(FlyerAbove(1)), 0).range, 1, 0.05);
}

TEST(RobotRange, IsToAHeadInTheConeAndNotToOneBesideIt) {
  for (const double aside_m : {0.0, 0.35, 1.0}) {
    Scene scene = FlyerAbove(2.5);
    scene.movers = {MoverSpec{.name = "p",
                              .points_m = {{aside_m, 0}, {aside_m, 0.001}},
                              .radius_m = 0.25,
                              .height_m = 1.6,
                              .speed_m_s = 0.01}};
    const double range_m = MeasureRobotRange(World(scene), 0).range;
    EXPECT_NEAR(range_m, aside_m < 0.5 ? 0.9 : 2.5, 0.06) << aside_m;
  }
}

TEST(RobotRange, IsInfiniteWhereNothingIsInReachAndNegativeWhereItIsTooNear) {
  EXPECT_EQ(MeasureRobotRange(World(FlyerAbove(6)), 0).range,
            std::numeric_limits<float>::infinity());
  EXPECT_EQ(MeasureRobotRange(World(FlyerAbove(0)), 0).range,
            -std::numeric_limits<float>::infinity());
}

TEST(Maps, HaveWallsAndNoneOfWhatMoves) {
  Scene scene = RobotYard();
  scene.boxes = {{"wall", {1, 0}, {0.1, 1}}, {"lamp", {-1, 0}, {0.2, 0.2}, 0, 0.2, 2.0}};
  scene.objects = {BoxOf("box_red", {2, 2, 0.1})};
  const msg::OccupancyGrid map = MapOfGround(scene, TallestOnGround(scene));
  ASSERT_EQ(map.info.width, 200u);
  ASSERT_EQ(map.info.height, 200u);
  const auto at = [&](double x, double y) {
    const auto column = static_cast<std::size_t>((x + 5) / 0.05);
    return int{map.data[static_cast<std::size_t>((y + 5) / 0.05) * 200 + column]};
  };
  EXPECT_EQ(at(1, 0), 100);
  EXPECT_EQ(at(1.08, 0.98), 100);
  EXPECT_EQ(at(1.13, 0), 0);
  EXPECT_EQ(at(-1, 0), 0) << "it hangs above the robots";
  EXPECT_EQ(at(2, 2), 0);
  EXPECT_EQ(at(0, 0), 0);
  EXPECT_EQ(at(-4.99, 0), 100);
  const msg::PointCloud2 cloud = CloudOfSurfaces(scene);
  EXPECT_EQ(cloud.data.size(), cloud.width * 12u);
  EXPECT_GT(cloud.width, 10'000u);
}

TEST(FleetReport, HasPoseBatteryLoadAndCollisions) {
  World world(WithBoxes());
  ASSERT_TRUE(world.UseHand(0, {HandAction::kAttach, "box_red", 2, {}}).success);
  EXPECT_THAT(FleetText(world), AllOf(HasSubstr("jetbot_0"), HasSubstr("box_red")));
  EXPECT_THAT(FleetJson(world),
              AllOf(HasSubstr(R"({"name":"jetbot_0","kind":"ground","x_m":0.000)"),
                    HasSubstr(R"("holds":"box_red")"), HasSubstr(R"("holds":null)"),
                    HasSubstr(R"("collisions":0)")));
}

}  // namespace musher::world::fleet_test
