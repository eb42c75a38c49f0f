// What differs from run to run of a scene, and balls that appear. Errors are in scenes/bad.

#include <gmock/gmock.h>

#include <set>

#include "musher/modules/world/scene/place.hpp"
#include "musher/modules/world/scene/variation.hpp"
#include "musher/modules/world/scene_file/scene_toml.hpp"
#include "musher/modules/world/sensors/ranging.hpp"
#include "musher/test/modules/world/scenes.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::world::course_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

SceneReading ReadRun(const std::string& text, const SceneRun& run) {
  return ReadSceneText(text, "s.toml", run);
}

Scene Read(const std::string& text, const SceneRun& run = {}) {
  const SceneReading reading = ReadRun(text, run);
  for (const Diagnostic& diagnostic : reading.diagnostics) {
    ADD_FAILURE() << FormatDiagnostic(diagnostic);
  }
  return reading.scene.value_or(Scene());
}

constexpr const char* kBoards = R"(
[choices]
code = ["A-1", "A-2"]
arrow = ["left", "right"]
[follows.arrow]
lane = ["L1", "R1"]
[[board]]
x_m = 2
y_m = 0
qr = "$code"
[[board]]
x_m = 3
y_m = 0
arrow = "$arrow"
[[board]]
x_m = 4
y_m = 0
text = "$lane"
)";

TEST(Choices, ReplaceTheContentsOfBoardsAndWhatFollowsFromThem) {
  const Scene scene = Read(kBoards, {.seed = {}, .chosen = {{"code", "A-2"}, {"arrow", "right"}}});
  ASSERT_EQ(scene.boards.size(), 3U);
  EXPECT_EQ(scene.boards[0].sign.content, "A-2");
  EXPECT_EQ(scene.boards[1].sign.kind, Sign::Kind::kArrow);
  EXPECT_EQ(scene.boards[1].sign.content, "right");
  EXPECT_EQ(scene.boards[2].sign.content, "R1");
  EXPECT_EQ(SampledText(scene), "seed 1: code = A-2, arrow = right");
}

TEST(Choices, DependOnTheSeedAndTakeEveryValue) {
  std::set<std::string> seen;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const Scene scene = Read(kBoards, {.seed = seed, .chosen = {}});
    const Scene again = Read(kBoards, {.seed = seed, .chosen = {}});
    EXPECT_EQ(scene.seed, seed);
    EXPECT_EQ(SampledText(scene), SampledText(again));
    seen.insert(scene.boards[0].sign.content + scene.boards[1].sign.content);
  }
  EXPECT_EQ(seen.size(), 4U);
}

TEST(Choices, AreFixedByTheSceneAndByTheCallerBeforeIt) {
  const std::string fixed = std::string(kBoards) + "[chosen]\ncode = \"A-2\"\n";
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    EXPECT_EQ(Read(fixed, {.seed = seed, .chosen = {}}).boards[0].sign.content, "A-2");
  }
  const SceneRun other{.seed = {}, .chosen = {{"code", "A-1"}}};
  EXPECT_EQ(Read(fixed, other).boards[0].sign.content, "A-1");
}

TEST(Choices, OfTheCallerThatAreWrongAreReportedWithASuggestion) {
  const auto error = [](const SceneRun& run) {
    const SceneReading reading = ReadRun(kBoards, run);
    EXPECT_FALSE(reading.scene);
    return reading.diagnostics.empty() ? "" : FormatDiagnostic(reading.diagnostics[0]);
  };
  EXPECT_EQ(error({.seed = {}, .chosen = {{"cod", "A-1"}}}),
            "s.toml:1:1: error: --choose cod: unknown choice \"cod\"; expected one of code and "
            "arrow; did you mean \"code\"?");
  EXPECT_EQ(error({.seed = {}, .chosen = {{"arrow", "up"}}}),
            "s.toml:1:1: error: --choose arrow: expected one of left and right, found \"up\"");
}

TEST(Choices, LeaveATextWithADollarSignThatIsNoName) {
  EXPECT_EQ(Read("[[board]]\nx_m = 2\ny_m = 0\ntext = \"$ 5\"\n").boards[0].sign.content, "$ 5");
}

constexpr const char* kVaried = R"(
[vary]
start_m = 0.1
start_deg = 5
board_deg = 3
brightness = 0.2
temperature_k = 500
slip = 0.02
yaw_slip = 0.05
odometry_scale = 0.01
odometry_yaw_drift_deg_per_m = 1
camera_noise = 1
[body]
slip = 0.03
yaw_slip = 0.1
[[board]]
name = "sign"
x_m = 2
y_m = 0
)";

TEST(Variation, StaysWithinItsLimitsAndDiffersBySeed) {
  std::set<double> starts;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const Scene scene = Read(kVaried, {.seed = seed, .chosen = {}});
    EXPECT_LE(scene.start.position_m.cwiseAbs().maxCoeff(), 0.1);
    EXPECT_LE(std::abs(scene.start.yaw_rad), 5.001 * M_PI / 180);
    EXPECT_LE(std::abs(scene.boards[0].yaw_rad), 3.001 * M_PI / 180);
    EXPECT_NEAR(scene.light.brightness, 1, 0.2);
    EXPECT_NEAR(scene.light.temperature_k, 6500, 500);
    EXPECT_NEAR(scene.body.slip, 0.03, 0.02);
    EXPECT_NEAR(scene.body.yaw_slip.value(), 0.1, 0.05);
    EXPECT_NEAR(scene.body.odometry_scale, 1, 0.01);
    EXPECT_LE(std::abs(scene.body.odometry_yaw_drift_rad_per_m), 1.001 * M_PI / 180);
    EXPECT_NEAR(scene.cameras.cameras[0].noise, 1.5, 1);
    starts.insert(scene.start.position_m.x());
  }
  EXPECT_EQ(starts.size(), 200U);
  EXPECT_LT(*starts.begin(), -0.09);
  EXPECT_GT(*starts.rbegin(), 0.09);
}

TEST(Variation, OfOneValueDoesNotChangeTheOthers) {
  const Scene all = Read(kVaried);
  const Scene one = Read("[vary]\nslip = 0.02\n");
  EXPECT_EQ(one.body.slip, all.body.slip);
  EXPECT_FALSE(one.body.yaw_slip);
  EXPECT_EQ(one.light.brightness, 1);
}

TEST(Variation, IsNoneByDefaultAndIsNamedInTheReport) {
  EXPECT_EQ(SampledText(Read("seed = 3\n")), "seed 3");
  const std::string text = SampledText(Read(kVaried));
  EXPECT_THAT(text, HasSubstr("seed 1: start_x_m = "));
  EXPECT_THAT(text, HasSubstr("sign.yaw_deg = "));
  EXPECT_THAT(text, HasSubstr("camera.right.noise = "));
}

TEST(Variation, ThatPutsTheStartIntoAnObstacleIsReportedWithTheSeed) {
  int bad = 0;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const SceneReading reading =
        ReadRun("[vary]\nstart_m = 0.3\n[[circle]]\nx_m = 0.5\ny_m = 0\nradius_m = 0.2\n",
                {.seed = seed, .chosen = {}});
    if (reading.scene) continue;
    ++bad;
    EXPECT_THAT(FormatDiagnostic(reading.diagnostics[0]),
                HasSubstr("start, with seed " + std::to_string(seed) + ": the body"));
  }
  EXPECT_GT(bad, 0);
  EXPECT_LT(bad, 30);
}

Scene WithLamp() {
  Scene scene = EmptyYard();
  Ball lamp{{1, 0, 0.2}, 0.1};
  lamp.name = "lamp";
  lamp.shown = false;
  scene.balls = {lamp};
  return scene;
}

TEST(NamedBall, ThatIsHiddenIsNoObstacleAndStopsNoRay) {
  Scene scene = WithLamp();
  EXPECT_TRUE(IsFree(scene, {1, 0}));
  EXPECT_GT(DistanceAlong(scene, {0, 0, 0.2}, {1, 0, 0}, 5), 5);
  scene.balls[0].shown = true;
  EXPECT_FALSE(IsFree(scene, {1, 0}));
  EXPECT_NEAR(DistanceAlong(scene, {0, 0, 0.2}, {1, 0, 0}, 5), 0.9, 1e-9);
}

TEST(NamedBall, AppearsAndDisappearsByEventsAndOnRequest) {
  const Scene scene = Read(R"(
[[ball]]
name = "lamp"
x_m = 1
y_m = 0
shown = false
[[event]]
at_s = 1
show = "lamp"
[[event]]
at_s = 2
hide = "lamp"
)");
  World world(scene);
  EXPECT_FALSE(world.scene().balls[0].shown);
  Pass(world, Seconds(1));
  EXPECT_TRUE(world.scene().balls[0].shown);
  const World before = world;
  Pass(world, Seconds(1));
  EXPECT_FALSE(world.scene().balls[0].shown);
  EXPECT_TRUE(before.scene().balls[0].shown) << "a copy keeps its own state";
  EXPECT_FALSE(world.SetShown("lamp", true));
  EXPECT_TRUE(world.scene().balls[0].shown);
  EXPECT_THAT(world.SetShown("lmp", true).value_or(""), HasSubstr("no ball with the name \"lmp\""));
}

TEST(NamedBall, AppearsOnceWhenTheRobotComesNearAndDisappearsAfterItsTime) {
  Scene scene = WithLamp();
  scene.balls[0].center_m = {3, 0, 1};
  scene.balls[0].show_within_m = 2.5;
  scene.balls[0].show_for = Seconds(1.5);
  World world(scene);
  Commander commander(world);
  const auto shown = [&] { return world.scene().balls[0].shown; };
  commander.Walk({0.4, 0, 0}, Seconds(1));
  EXPECT_FALSE(shown());
  commander.Walk({0.4, 0, 0}, Seconds(1));
  EXPECT_TRUE(shown());
  commander.Walk({-0.4, 0, 0}, Seconds(3));
  EXPECT_FALSE(shown());
  commander.Walk({0.4, 0, 0}, Seconds(4));
  EXPECT_FALSE(shown());
}

TEST(Course, OfTheRepositoryIsValidForEverySeed) {
  std::set<std::string> orders;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const SceneReading reading =
        ReadSceneFile(SourceDir() + "/config/scenes/course.toml", {.seed = seed, .chosen = {}});
    ASSERT_THAT(reading.diagnostics, IsEmpty()) << seed;
    std::string order;
    for (const std::string& zone : reading.scene->referee.order) order += zone + " ";
    orders.insert(order);
  }
  EXPECT_EQ(orders.size(), 8U);
  EXPECT_THAT(orders, Contains("START QR_A A1 S1 S2 L1 QR_B B1 B2 R1 S2 S1 A2 START "));
}

}  // namespace musher::world::course_test
