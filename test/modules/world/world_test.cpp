// The world as a whole: obstacles, battery, events, and that it is the same from the same seed.

#include "musher/modules/world/simulation/world.hpp"

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include "musher/modules/world/scene/place.hpp"
#include "musher/test/modules/world/scenes.hpp"

namespace musher::world::world_test {

using Eigen::Vector2d;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Optional;

double EnergyJ(const Scene& scene, double percent) {
  return percent / 100 * scene.battery.capacity_wh * 3600;
}

TEST(World, StopsABodyAtAWallAndNotesTheBump) {
  Scene scene = EmptyYard();
  scene.boxes = {{"wall", {1, 0}, {0.05, 2}, 0}};
  World world(scene);
  Commander commander(world);
  commander.Walk({0.5, 0, 0}, Seconds(4));
  EXPECT_NEAR(world.body().pose().position_m.x(), 0.95 - scene.body.radius_m, 1e-9);
  EXPECT_NEAR(world.body().speed().x(), 0, 1e-9);
  EXPECT_EQ(world.track().bumps().size(), 1u);
}

TEST(World, LetsABodySlideAlongAWall) {
  Scene scene = EmptyYard();
  scene.boxes = {{"wall", {1, 0}, {0.05, 5}, 0}};
  scene.start.yaw_rad = M_PI / 4;
  World world(scene);
  Commander commander(world);
  commander.Walk({0.5, 0, 0}, Seconds(6));
  EXPECT_NEAR(world.body().pose().position_m.x(), 0.95 - scene.body.radius_m, 1e-9);
  EXPECT_NEAR(world.body().pose().position_m.y(), 0.5 * 5.8 * M_SQRT1_2, 0.02);
}

TEST(World, KeepsABodyInItsArea) {
  World world(EmptyYard());
  Commander commander(world);
  commander.Walk({1.6, 0, 0}, Seconds(10), 10);
  EXPECT_NEAR(world.body().pose().position_m.x(), 10 - world.scene().body.radius_m, 1e-9);
}

TEST(World, LogsOnceThatTheBodyBumpedIntoSomething) {
  World world(EmptyYard());
  ASSERT_EQ(world.PutDown({{9, 0}, 0}), std::nullopt);
  Commander commander(world);
  std::vector<std::string> lines;
  for (int i = 0; i < 300; ++i) {
    commander.Do(11, 27, {0.5, 0, 0});
    for (std::string& line : world.Step().log) lines.push_back(std::move(line));
  }
  EXPECT_THAT(lines, ElementsAre(HasSubstr("bumped")));
}

RC_GTEST_PROP(WorldProperty, NeverHasABodyInsideAnObstacle, ()) {
  World world(FullYard());
  Commander commander(world);
  const auto commands = *rc::gen::container<std::vector<std::tuple<int, int, int, int>>>(
      15, rc::gen::tuple(rc::gen::inRange(-160, 160), rc::gen::inRange(-55, 55),
                         rc::gen::inRange(-250, 250), rc::gen::inRange(0, 12)));
  for (const auto& [x, y, yaw, what] : commands) {
    if (what == 0) {
      commander.Do(12, 0);
      Pass(world, Seconds(0.5));
      commander.Do(16, 1);  // a jump ahead
      for (int i = 0; i < 100; ++i) {
        world.Step();
        RC_ASSERT(IsFree(world.scene(), world.body().pose().position_m));
      }
      commander.Do(12, 0);
      Pass(world, Seconds(0.5));
    }
    for (int i = 0; i < 50; ++i) {
      commander.Do(11, 10, {x / 100.0, y / 100.0, yaw / 100.0});
      world.Step();
      RC_ASSERT(IsFree(world.scene(), world.body().pose().position_m));
    }
  }
}

RC_GTEST_PROP(WorldProperty, KeepsItsBatteryWithinItsLimits, ()) {
  Scene scene = EmptyYard();
  scene.battery.capacity_wh = 0.05;  // a second of walking takes it all
  World world(scene);
  Commander commander(world);
  const auto actions = *rc::gen::container<std::vector<std::pair<int, int>>>(
      30, rc::gen::pair(rc::gen::inRange(0, 5), rc::gen::inRange(-50, 250)));
  for (const auto& [action, number] : actions) {
    if (action == 0) world.Plug(number > 100);
    if (action == 1) static_cast<void>(world.SetBattery(number));
    if (action == 2) commander.Do(12, 0);
    if (action == 3) commander.Walk({0.5, 0, 0.3}, Seconds(1));
    for (int i = 0; i < 50; ++i) {
      world.Step();
      RC_ASSERT(world.battery().percent() >= 0 && world.battery().percent() <= 100);
    }
  }
}

TEST(World, TakesFromTheBatteryWhatItsActivitiesDrain) {
  World world(EmptyYard());
  const BatterySpec& spec = world.scene().battery;
  Commander commander(world);
  Pass(world, Seconds(100));
  EXPECT_NEAR(EnergyJ(world.scene(), spec.start_percent - world.battery().percent()),
              100 * spec.standing_w, 1e-6);
  double moving_s = 0, other_j = 0;
  const double before = world.battery().percent();
  for (int i = 0; i < 3000; ++i) {
    if (i < 2000) commander.Do(11, 27, {0.3, 0, 1.0});
    if (i == 2500) commander.Do(7, 1);
    const Activity activity = world.body().activity();  // that the next step pays for
    world.Step();
    if (activity == Activity::kMoving) moving_s += 0.02;
    if (activity == Activity::kStanding) other_j += 0.02 * spec.standing_w;
    if (activity == Activity::kLying) other_j += 0.02 * spec.lying_w;
  }
  EXPECT_NEAR(moving_s, 41.5, 0.5);  // 40 s, the timeout of commands, and to come to a halt
  EXPECT_NEAR(EnergyJ(world.scene(), before - world.battery().percent()),
              moving_s * spec.moving_w + other_j, 1e-6);
}

TEST(World, ChargesByCableAndOnThePad) {
  Scene scene = EmptyYard();
  scene.start_standing = false;
  scene.pads = {{{5, 5}, 1.0}};
  World world(scene);
  const BatterySpec& spec = scene.battery;
  Pass(world, Seconds(1));
  EXPECT_FALSE(world.battery().charging());
  EXPECT_NEAR(world.battery().power_w(), -spec.lying_w, 1e-9);
  world.Plug(true);
  Pass(world, Seconds(1));
  EXPECT_TRUE(world.battery().charging());
  EXPECT_NEAR(world.battery().power_w(), spec.cable_w - spec.lying_w, 1e-9);
  world.Plug(false);
  ASSERT_EQ(world.PutDown({{5.4, 4.6}, 0}), std::nullopt);
  Pass(world, Seconds(1));
  EXPECT_NEAR(world.battery().power_w(), spec.pad_w - spec.lying_w, 1e-9);
}

TEST(World, LetsTheBodySinkWhenTheBatteryIsEmpty) {
  World world(EmptyYard());
  ASSERT_EQ(world.SetBattery(0), std::nullopt);
  EXPECT_THAT(world.Step().log, Contains(HasSubstr("empty")));
  Pass(world, Seconds(2));
  EXPECT_EQ(world.body().mode(), 0);
  EXPECT_EQ(world.body().status(), BoardStatus::kLowBattery);
  world.Plug(true);
  Pass(world, Seconds(10));
  EXPECT_EQ(world.body().status(), BoardStatus::kNormal);
}

TEST(World, RefusesAnImpossibleBatteryLevel) {
  World world(EmptyYard());
  EXPECT_THAT(world.SetBattery(100.5), Optional(HasSubstr("0 to 100")));
  EXPECT_THAT(world.SetBattery(-1), Optional(HasSubstr("0 to 100")));
  EXPECT_THAT(world.SetBattery(std::nan("")), Optional(HasSubstr("0 to 100")));
  EXPECT_EQ(world.battery().percent(), world.scene().battery.start_percent);
}

TEST(World, RefusesToPutABodyIntoAnObstacle) {
  World world(FullYard());
  EXPECT_THAT(world.PutDown({{2, -2}, 0}), Optional(HasSubstr("an obstacle is in the way")));
  EXPECT_THAT(world.PutDown({{99, 0}, 0}), Optional(HasSubstr("outside")));
  EXPECT_THAT(world.PutDown({{std::nan(""), 0}, 0}), Optional(HasSubstr("not a number")));
  EXPECT_EQ(world.body().pose().position_m, Vector2d(0, 0));
}

TEST(World, PlaysTheEventsOfItsScene) {
  Scene scene = EmptyYard();
  scene.events = {{Seconds(1), ChargeTo{15}},       {Seconds(1), Touch{3}},
                  {Seconds(2), Cable{true}},        {Seconds(3), FaultOn{"motor", 4}},
                  {Seconds(4), Carry{{{2, 2}, 1}}}, {Seconds(5), Speed{4}}};
  World world(scene);
  Pass(world, Milliseconds(980));
  EXPECT_GT(world.battery().percent(), 79);
  EXPECT_THAT(world.Step().touches, ElementsAre(3));
  EXPECT_NEAR(world.battery().percent(), 15, 0.01);
  Pass(world, Seconds(1));
  EXPECT_TRUE(world.battery().cable());
  Pass(world, Seconds(1));
  EXPECT_NE(world.body().motor_errors()[4], 0);
  Pass(world, Seconds(1));
  EXPECT_EQ(world.body().pose(), (Pose2{{2, 2}, 1}));
  Pass(world, Milliseconds(980));
  EXPECT_EQ(world.Step().speed, std::optional(4.0));
}

// What is compared: every number that moves.
std::vector<double> Numbers(const World& world) {
  const Body& body = world.body();
  return {body.pose().position_m.x(),     body.pose().position_m.y(), body.pose().yaw_rad,
          body.odometry().position_m.x(), body.speed().x(),           body.turn_rate().z(),
          world.battery().percent(),      body.motor_temperature_c(0)};
}

std::vector<std::vector<double>> Scenario(std::uint64_t seed) {
  Scene scene = FullYard();
  scene.seed = seed;
  World world(scene);
  Commander commander(world);
  std::vector<std::vector<double>> scenario;
  for (int i = 0; i < 20; ++i) {
    commander.Walk({0.4, 0.05, 0.3}, Seconds(1));
    scenario.push_back(Numbers(world));
  }
  return scenario;
}

TEST(World, IsTheSameFromTheSameSeed) {
  EXPECT_EQ(Scenario(7), Scenario(7));
  EXPECT_NE(Scenario(7), Scenario(8));
}

TEST(World, IsAValueThatContinuesFromACopy) {
  World world(FullYard());
  Commander(world).Walk({0.4, 0, 0.3}, Seconds(3));
  World copy = world;
  Pass(world, Seconds(2));
  Pass(copy, Seconds(1));
  Pass(copy, Seconds(1));
  EXPECT_EQ(Numbers(world), Numbers(copy));
}

TEST(World, RecordsThatABodyThatCouldWalkStands) {
  World world(EmptyYard());
  Commander(world).Walk({0.5, 0, 0}, Seconds(3));
  Pass(world, Seconds(4));
  std::vector<std::string> motions;
  for (const Sample& sample : world.track().samples()) {
    const std::string& motion = world.track().motions().at(sample.motion);
    if (motions.empty() || motions.back() != motion) motions.push_back(motion);
  }
  EXPECT_THAT(motions, ElementsAre("stand", "walk", "stand"));
}

TEST(Track, DoesNotGrowForEverAndKeepsItsEnds) {
  Track track;
  for (int i = 0; i < 500'000; ++i) {
    Sample sample;
    sample.at = Milliseconds(20) * i;
    if (track.IsDue(sample.at)) track.Add(sample, "Active", "stand");
  }
  EXPECT_LE(track.samples().size(), Track::kMost);
  EXPECT_GT(track.samples().size(), Track::kMost / 2);
  EXPECT_EQ(track.samples().front().at, Duration::zero());
  EXPECT_GT(track.samples().back().at, Seconds(9990));
}

}  // namespace musher::world::world_test
