// The detector and its results on the camera pictures of the wedding scene, while the robot stands
// and looks ahead.

#include <gmock/gmock.h>

#include <cmath>

#include "musher/modules/vision/vision_config.hpp"
#include "musher/modules/world/render/shot.hpp"
#include "musher/modules/world/scene_file/scene_toml.hpp"
#include "musher/test/support/nightly.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::vision::wedding_scene_test {

class WeddingScene : public ::testing::Test {
 protected:
  // Advances to that time of the scene, and looks 5 times a second from `from_s` on.
  std::vector<Sight> Watch(double from_s, double to_s) {
    std::vector<Sight> sights;
    for (int step = 1; Seconds() < to_s; ++step) {
      world_.Step();
      if (Seconds() < from_s || step % 10 != 0) continue;
      world::Image image = camera_.Shoot(*scenery_.value(), ViewOf(world_, 0));
      msg::Image picture;
      picture.width = std::uint32_t(image.width);
      picture.height = std::uint32_t(image.height);
      picture.encoding = "bgr8";
      picture.step = picture.width * 3;
      picture.data = std::move(image.bgr);
      sights.push_back(
          watch_.OnPicture(world_.now().count(), detector_.value()->Detect(picture), lens_));
    }
    return sights;
  }
  double Seconds() const { return ToSeconds(world_.now()); }

  const world::SceneReading reading_ =
      world::ReadSceneFile(SourceDir() + "/config/scenes/wedding.toml");
  const VisionConfig config_ = *ReadVisionFile(SourceDir() + "/config/vision/faces.toml").config;
  world::World world_{*reading_.scene};
  const Result<std::unique_ptr<world::Scenery>> scenery_ = world::Scenery::Make(*reading_.scene);
  const world::Camera camera_{reading_.scene->cameras.cameras[0]};
  const Lens lens_ = PinholeOf(reading_.scene->cameras.cameras[0].hfov_rad, 640, 480);
  const Result<std::unique_ptr<Detector>> detector_ = MakeCascadeDetector(config_.cascade);
  FaceWatch watch_{config_.faces};
};

TEST_F(WeddingScene, TheBrideIsSeenWhereSheStands) {
  const std::vector<Sight> sights = Watch(9, testing::Nightly() ? 18 : 12);
  ASSERT_TRUE(sights.back().target);
  const int bride = sights.back().target->id;
  int seen = 0;
  for (const Sight& sight : sights) {
    EXPECT_NE(sight.too_close, true);
    if (sight.target) {
      EXPECT_EQ(sight.target->id, bride);
      ++seen;
    }
  }
  EXPECT_GE(seen, int(sights.size()) - 4);
  const auto head =
      world_.CameraPose(0).inverse() * HeadOf(world_.scene().guests[0], world_.guests()[0]);
  EXPECT_NEAR(*sights.back().target->distance_m, head.norm(), 0.15 * head.norm());
}

TEST_F(WeddingScene, TheChildComesTooCloseAndIsUntilItHasSteppedBack) {
  for (const Sight& sight : Watch(49, 54.5)) EXPECT_NE(sight.too_close, true);
  const std::vector<Sight> near = Watch(54.5, 59);
  EXPECT_EQ(near.back().too_close, true);
  for (std::size_t i = 1; i < near.size(); ++i) {
    EXPECT_TRUE(*near[i].too_close || !*near[i - 1].too_close) << "clear too early";
  }
  for (const Sight& sight : Watch(59, 59.6)) EXPECT_EQ(sight.too_close, true);
  EXPECT_EQ(Watch(59.6, 63).back().too_close, false);
}

TEST_F(WeddingScene, GuestsWhoPassWithoutLookingAreNoTarget) {
  int targets = 0;
  for (const Sight& sight : Watch(22, 29)) targets += sight.target ? 1 : 0;
  EXPECT_LE(targets, 1);
}

}  // namespace musher::vision::wedding_scene_test
