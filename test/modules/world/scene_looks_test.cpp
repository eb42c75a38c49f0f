// The looks in a scene file: the values that are read. Errors are in scenes/bad.

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>

#include "musher/modules/world/scene/place.hpp"
#include "musher/modules/world/scene_file/scene_toml.hpp"
#include "musher/test/modules/world/shots.hpp"

namespace musher::world::scene_looks_test {

Scene Read(const std::string& text) {
  const SceneReading reading = ReadSceneText(text, "s.toml");
  for (const Diagnostic& diagnostic : reading.diagnostics) {
    ADD_FAILURE() << FormatDiagnostic(diagnostic);
  }
  return reading.scene.value_or(Scene());
}

TEST(SceneLooks, ReadsColoursByNameAndByNumber) {
  EXPECT_EQ(ParseColor("#12aBff"), (Color{0x12, 0xAB, 0xFF}));
  EXPECT_TRUE(ParseColor("yellow"));
  for (const char* wrong : {"", "#12345", "#1234567", "#12345g", "yelow", "#-12345"}) {
    EXPECT_FALSE(ParseColor(wrong)) << wrong;
  }
}

TEST(SceneLooks, TakesHeightsAndColoursOfThings) {
  const Scene scene = Read(R"(
[[box]]
x_m = 1
y_m = 2
length_m = 1
width_m = 1
height_m = 0.1
bottom_m = 0.4
color = "#010203"
[[ball]]
x_m = -1
y_m = 0
radius_m = 0.2
bottom_m = 1
glows = true
)");
  ASSERT_EQ(scene.boxes.size(), 1U);
  EXPECT_EQ(scene.boxes[0].height_m, 0.1);
  EXPECT_EQ(scene.boxes[0].bottom_m, 0.4);
  EXPECT_EQ(scene.boxes[0].color, (Color{1, 2, 3}));
  ASSERT_EQ(scene.balls.size(), 1U);
  EXPECT_NEAR(scene.balls[0].center_m.z(), 1.2, 1e-12);
  EXPECT_TRUE(scene.balls[0].glows);
}

TEST(SceneLooks, LetsTheBodyPassUnderWhatHangsOverIt) {
  Scene scene = Read("[[box]]\nx_m = 2\ny_m = 0\nlength_m = 1\nwidth_m = 1\nbottom_m = 0.5\n");
  EXPECT_TRUE(IsFree(scene, {2, 0}));
  scene.boxes[0].bottom_m = 0.2;
  EXPECT_FALSE(IsFree(scene, {2, 0}));
  scene = Read("[[board]]\nx_m = 2\ny_m = 0\n[[ball]]\nx_m = -2\ny_m = 0\n");
  EXPECT_FALSE(IsFree(scene, {2.2, 0}));
  EXPECT_FALSE(IsFree(scene, {-2.2, 0}));
}

TEST(SceneLooks, MakesALineOfAnArcAndClosesAClosedLine) {
  const Scene scene = Read(R"(
[[line]]
center_m = [1, 2]
radius_m = 0.5
from_deg = 0
to_deg = 90
[[line]]
points_m = [[0, 0], [1, 0], [1, 1]]
closed = true
)");
  ASSERT_EQ(scene.lines.size(), 2U);
  const auto& arc = scene.lines[0].points_m;
  EXPECT_LT((arc.front() - Eigen::Vector2d(1.5, 2)).norm(), 1e-9);
  EXPECT_LT((arc.back() - Eigen::Vector2d(1, 2.5)).norm(), 1e-9);
  for (const auto& point : arc) EXPECT_NEAR((point - Eigen::Vector2d(1, 2)).norm(), 0.5, 1e-9);
  EXPECT_EQ(scene.lines[1].points_m.size(), 4U);
  EXPECT_EQ(scene.lines[1].points_m.front(), scene.lines[1].points_m.back());
}

TEST(SceneLooks, FindsPicturesBesideTheScene) {
  const TempFolder folder;
  WriteQuarters(folder / "poster.png");
  const SceneReading reading = ReadSceneText(
      "[[board]]\nx_m = 1\ny_m = 1\npicture = \"poster.png\"\n"
      "[ground]\ntexture = \"picture\"\nfile = \"poster.png\"\n",
      folder / "scene.toml");
  ASSERT_TRUE(reading.scene);
  EXPECT_EQ(reading.scene->boards[0].sign.content, folder / "poster.png");
  EXPECT_EQ(reading.scene->ground.file, folder / "poster.png");
}

TEST(SceneLooks, ReportsWhyAPictureCannotBeShown) {
  const TempFolder folder;
  std::ofstream(folder / "notes.png") << "not a picture";
  const SceneReading reading = ReadSceneText(
      "[[board]]\nx_m = 1\ny_m = 1\npicture = \"notes.png\"\n"
      "[[board]]\nx_m = 1\ny_m = 1\npicture = \".\"\n",
      folder / "scene.toml");
  ASSERT_EQ(reading.diagnostics.size(), 2U);
  EXPECT_THAT(FormatDiagnostic(reading.diagnostics[0]),
              ::testing::EndsWith("scene.toml:4:11: error: board[1].picture: the picture "
                                  "\"notes.png\" cannot be shown: it is no picture that can be "
                                  "decoded"));
  EXPECT_THAT(FormatDiagnostic(reading.diagnostics[1]), ::testing::EndsWith("it is a folder"));
}

TEST(SceneLooks, ChangesOnlyTheGivenKeysOfACamera) {
  const Scene scene = Read(R"(
cameras.late = "wait"
[camera.front]
hfov_deg = 90
width_px = 320
noise = 0
[camera.left]
enabled = false
)");
  EXPECT_EQ(scene.cameras.late, CameraSet::Late::kWait);
  const auto& [front, left, right] = scene.cameras.cameras;
  EXPECT_NEAR(front.hfov_rad, M_PI / 2, 1e-12);
  EXPECT_EQ(front.width_px, 320);
  EXPECT_EQ(front.height_px, 480);
  EXPECT_FALSE(left.enabled);
  EXPECT_TRUE(right.enabled);
  EXPECT_EQ(right.model, CameraModel::kFisheye);
  EXPECT_NEAR(right.hfov_rad, M_PI, 1e-12);
}

}  // namespace musher::world::scene_looks_test
