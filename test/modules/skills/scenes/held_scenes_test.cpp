// Held scenes with the whole chain: no robot touches anything, and each drive ends at a stand.

#include <gmock/gmock.h>

#include <algorithm>
#include <set>

#include "musher/test/modules/skills/scenes/random_scene.hpp"
#include "musher/test/modules/skills/scenes/scene_run.hpp"
#include "musher/test/modules/skills/scenes/scene_world.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::skills::testing {

std::vector<Scene> HeldScenes() {
  auto scenes = ReadScenes(SourceDir() + "/test/modules/skills/scenes/scenes.toml");
  EXPECT_TRUE(scenes) << scenes.error().message;
  return scenes ? std::move(scenes).value() : std::vector<Scene>();
}

void ExpectRight(const Scene& scene) {
  const SceneOutcome outcome = RunScene(scene, true, 1);
  for (const RobotOutcome& robot : outcome.robots) {
    const std::string what = scene.name + ": " + robot.message;
    EXPECT_EQ(robot.contacts, 0) << what;
    EXPECT_NE(robot.end, RobotOutcome::End::kOpen) << what;
    EXPECT_TRUE(robot.stands) << what;
    const bool jumps = std::ranges::any_of(scene.events, [](const SceneEvent& event) {
      return event.kind == SceneEvent::Kind::kJump;
    });
    if (robot.end == RobotOutcome::End::kArrived && !jumps) {
      EXPECT_LT(robot.off_goal_m, 0.5) << what;
    }
    if (scene.expects == Scene::Expects::kArrives) {
      EXPECT_EQ(robot.end, RobotOutcome::End::kArrived) << what;
      EXPECT_LT(robot.off_goal_m, 0.3) << what;
    }
    if (scene.expects == Scene::Expects::kRefuses) {
      EXPECT_EQ(robot.end, RobotOutcome::End::kRefused) << what;
    }
  }
}

TEST(HeldScenes, AreManyWithNamesOfTheirOwnAndBeginInFreePlaces) {
  const std::vector<Scene> scenes = HeldScenes();
  EXPECT_GE(scenes.size(), 40U);
  std::set<std::string> names;
  for (const Scene& scene : scenes) {
    EXPECT_TRUE(names.insert(scene.name).second) << scene.name;
    SceneWorld world(scene, 1);
    world.Step(0.01);
    for (std::size_t i = 0; i < scene.robots.size(); ++i) {
      EXPECT_GT(world.least_room_m(i), 0) << scene.name;
    }
  }
}

// A flyer drove on at half a metre a second, round a corner, for half a second without a scan.
TEST(RandomScenes, ASeedThatOnceHadAContactHasNone) {
  const SceneOutcome outcome = RunScene(RandomScene(50017), true, 50017);
  EXPECT_EQ(outcome.contacts(), 0);
  EXPECT_EQ(outcome.Count(RobotOutcome::End::kOpen), 0);
}

TEST(HeldScenes, EndWithoutContact) {
  const std::set<std::string> few = {"U trap, shallow",
                                     "door of 0.7 m",
                                     "door of 0.5 m",
                                     "person waits in the door for 8 s",
                                     "person who yields comes through the door",
                                     "map that contains the obstacle comes on the way",
                                     "map that is there only after the goal",
                                     "localisation jumps by 1 m for 3 s",
                                     "person who goes to and fro before the robot 1",
                                     "person who goes to and fro before the robot 2",
                                     "person comes the other way",
                                     "flyer passes a person"};
  std::size_t found = 0;
  for (const Scene& scene : HeldScenes()) {
    if (!few.contains(scene.name)) continue;
    ++found;
    ExpectRight(scene);
  }
  EXPECT_EQ(found, few.size());
}

// A room of 5 m x 1 m, with a mover at 'm'.
Scene Corridor(bool with_mover) {
  Scene scene;
  scene.cell_m = 1;
  scene.map = {"#######", "#S...m#", "#######"};
  scene.robots = {{{{1.5, 1.5, 0}, 0}, {}, 0}};
  if (with_mover) scene.movers.push_back({.path = {{5.5, 1.5, 0}}});
  return scene;
}

void Drive(SceneWorld& world, double speed_m_s, double seconds) {
  world.Command(0, {.x_m_s = speed_m_s});
  for (double at_s = 0; at_s < seconds; at_s += 0.01) world.Step(0.01);
}

// The world counts what a body touches that no gate stops.
TEST(ASceneWorld, StopsABodyAtAWallAndCountsEachContactOnce) {
  const Scene scene = Corridor(false);
  SceneWorld world(scene, 1);
  Drive(world, 1, 8);
  EXPECT_EQ(world.contacts(0), 1);
  EXPECT_NEAR(world.pose(0).at.x_m, 6 - kSceneBodyM, 0.02);
  Drive(world, -1, 2);
  EXPECT_EQ(world.contacts(0), 1);
  Drive(world, 1, 4);
  EXPECT_EQ(world.contacts(0), 2);
}

TEST(ASceneWorld, StopsABodyAtAMoverToo) {
  const Scene scene = Corridor(true);
  SceneWorld world(scene, 1);
  Drive(world, 1, 8);
  EXPECT_EQ(world.contacts(0), 1);
  EXPECT_EQ(world.hits_of_movers(), 0);
  EXPECT_NEAR(world.pose(0).at.x_m, 5.5 - 0.25 - kSceneBodyM, 0.02);
}

TEST(ASceneWorld, ShowsWallsAndMoversWhereTheyAre) {
  const Scene empty = Corridor(false), with_mover = Corridor(true);
  SceneWorld world(empty, 1), crowded(with_mover, 1);
  world.Step(0.01);
  const std::vector<float> ranges = world.Look(0, 8);
  ASSERT_EQ(ranges.size(), 360U);
  EXPECT_NEAR(ranges[0], 4.5, 0.01);
  EXPECT_NEAR(ranges[90], 0.5, 0.01);
  EXPECT_NEAR(ranges[180], 0.5, 0.01);
  EXPECT_NEAR(crowded.Look(0, 8)[0], 5.5 - 0.25 - 1.5, 0.01);
}

TEST(HeldScenesNightly, EndWithoutContact) {
  for (const Scene& scene : HeldScenes()) ExpectRight(scene);
}

TEST(RandomScenes, BeginInFreePlacesAndAreTheSameForASeed) {
  std::set<std::string> names;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    const Scene scene = RandomScene(seed);
    EXPECT_EQ(scene.map, RandomScene(seed).map) << seed;
    names.insert(scene.name);
    SceneWorld world(scene, 1);
    world.Step(0.01);
    for (std::size_t i = 0; i < scene.robots.size(); ++i) {
      EXPECT_GT(world.least_room_m(i), 0) << seed << ": " << scene.name;
    }
  }
  EXPECT_GT(names.size(), 100U);
}

void ExpectRandomScenesToEnd(std::uint64_t first, std::uint64_t count) {
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    Scene scene = RandomScene(seed);
    scene.name = "seed " + std::to_string(seed) + ", " + scene.name;
    ExpectRight(scene);
  }
}

TEST(RandomScenes, EndWithoutContact) {
  ExpectRandomScenesToEnd(1, 8);
}

TEST(RandomScenesNightly, EndWithoutContact) {
  ExpectRandomScenesToEnd(1000, 200);
}

// --- Flyers that land among persons ---

// How often they sink onto one.
int SunkIn(std::uint64_t seed, bool looks_down, bool only_heads = false) {
  Scene scene = LandingScene(seed);
  scene.looks_down = looks_down;
  scene.only_heads = only_heads;
  int sunk = 0;
  for (const RobotOutcome& robot : RunScene(scene, true, seed).robots) {
    EXPECT_EQ(robot.contacts, 0) << "seed " << seed;
    EXPECT_TRUE(robot.landed || !robot.landing.empty()) << "seed " << seed;
    sunk += robot.from_above;
  }
  return sunk;
}

TEST(LandingScenes, HaveFlyersThatSinkOntoPersonsWithoutASensorBelow) {
  EXPECT_GT(SunkIn(70305, false), 0);
  EXPECT_GT(SunkIn(70831, false), 0);
}

TEST(LandingScenes, HaveNoneThatSinksOntoAPersonWithOne) {
  for (const std::uint64_t seed : {70305, 70831, 70937}) {
    EXPECT_EQ(SunkIn(seed, true), 0) << "seed " << seed;
  }
}

// It came from the side, and was not in the cone before the flyer had sunk onto the head.
TEST(LandingScenes, HaveNoneThatSinksOntoAPersonOfWhomItsSensorSeesOnlyTheHead) {
  for (const std::uint64_t seed : {70882, 95023}) {
    EXPECT_EQ(SunkIn(seed, true, true), 0) << "seed " << seed;
  }
}

TEST(RandomScenes, HaveNoFlyerThatDescendsOntoAPersonWhoComesFromTheSide) {
  Scene scene = RandomScene(72099);
  scene.looks_down = scene.only_heads = true;
  const SceneOutcome outcome = RunScene(scene, true, 72099);
  EXPECT_EQ(outcome.contacts() + outcome.robots[0].from_above, 0);
  EXPECT_EQ(outcome.robots[0].end, RobotOutcome::End::kArrived);
}

// They descended on their way, onto persons who came into the cone of their sensor too late.
TEST(RandomScenes, HaveNoFlyerThatDescendsOntoAPersonOnItsWay) {
  for (const std::uint64_t seed : {74543, 74808, 76728}) {
    Scene scene = RandomScene(seed);
    scene.looks_down = true;
    const SceneOutcome outcome = RunScene(scene, true, seed);
    EXPECT_EQ(outcome.contacts() + outcome.robots[0].from_above, 0) << "seed " << seed;
    EXPECT_EQ(outcome.Count(RobotOutcome::End::kOpen), 0) << "seed " << seed;
  }
}

// They hovered above a person who stayed, until their skill failed.
TEST(LandingScenes, HaveFlyersThatLandAsideWhereAPersonStaysBelow) {
  Scene scene;
  scene.name = "a person below";
  scene.map.assign(24, "#" + std::string(22, '.') + "#");
  scene.map.front() = scene.map.back() = std::string(24, '#');
  scene.flies = scene.looks_down = scene.lands = true;
  scene.robots.push_back({{{1, 3, 2}, 0}, {{4, 3, 2}, 0}, 0});
  scene.movers.push_back({.path = {{4, 3, 0}}});
  scene.movers.back().height_m = 1.5;
  const SceneOutcome waits = RunScene(scene, true, 1);
  EXPECT_FALSE(waits.robots[0].landed);
  EXPECT_THAT(waits.robots[0].landing, ::testing::HasSubstr("it does not descend"));
  scene.aside_m = 2;
  const SceneOutcome aside = RunScene(scene, true, 1);
  EXPECT_TRUE(aside.robots[0].landed) << aside.robots[0].landing;
  EXPECT_THAT(aside.robots[0].landing, ::testing::StartsWith("Landed 0.7 m aside"));
  EXPECT_EQ(aside.contacts() + aside.robots[0].from_above, 0);
}

}  // namespace musher::skills::testing
