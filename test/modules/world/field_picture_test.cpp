// The picture of a run on a field.

#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "musher/modules/world/picture/picture.hpp"
#include "musher/modules/world/scene_file/scene_toml.hpp"
#include "musher/test/modules/world/climber.hpp"
#include "musher/test/modules/world/scenes.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::world::field_picture_test {

namespace fs = std::filesystem;

// Drives the world's robot to a point with its yaw held, for at most 10 s.
void DriveTo(World& world, const Eigen::Vector2d& to) {
  for (int i = 0; i < 500; ++i) {
    const LiftBody& robot = world.field()->robot();
    const Eigen::Vector2d way = to - robot.position_m();
    if (way.norm() < 0.01) return;
    const Eigen::Vector2d speed = way * std::min(4.0, 0.8 / way.norm());
    world.DriveLift({speed.x(), speed.y(), 0});
    world.Step();
  }
}

// The number of pixels of that colour.
int CountOf(const cv::Mat& picture, const Color& color) {
  int count = 0;
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      const auto pixel = picture.at<cv::Vec3b>(y, x);
      if (pixel[2] == color.red && pixel[1] == color.green && pixel[0] == color.blue) ++count;
    }
  }
  return count;
}

TEST(FieldPicture, HasThePlatformsTheWayAndWhatHappened) {
  Scene scene = ReadSceneFile(SourceDir() + "/config/scenes/meilin.toml").scene.value();
  World world(scene);
  ASSERT_FALSE(world.CommandSpear(3));
  Pass(world, std::chrono::seconds(6));
  DriveTo(world, {1.2, 2.4});
  ASSERT_FALSE(world.PutDown({{2.4, 2.4}, 0}));
  ASSERT_FALSE(world.Lift({230, 230, 230, 230}));
  DriveTo(world, {2.6, 2.4});
  ASSERT_FALSE(world.CommandArm(1));
  Pass(world, std::chrono::seconds(4));
  const char* kept = std::getenv("MUSHER_KEEP_PICTURE");
  const std::string path =
      kept != nullptr ? kept : (fs::temp_directory_path() / "field_picture_test.png").string();
  ASSERT_TRUE(Draw(world, path));
  const cv::Mat picture = cv::imread(path);
  ASSERT_FALSE(picture.empty());
  EXPECT_GT(CountOf(picture, {92, 128, 84}), 5000) << "platforms of 600 mm";
  EXPECT_GT(CountOf(picture, {24, 88, 190}), 500) << "the way";
  EXPECT_GT(CountOf(picture, {140, 40, 150}), 60) << "what was docked and taken";
  EXPECT_GT(CountOf(picture, {236, 196, 60}), 500) << "boxes that were not taken";
  if (kept == nullptr) fs::remove(path);
}

}  // namespace musher::world::field_picture_test
