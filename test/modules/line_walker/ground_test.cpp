// Pixels on the ground, against the world's camera model.

#include "musher/modules/line_walker/ground.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "musher/modules/line_walker/line_walker.hpp"
#include "musher/modules/world/scene_file/scene_toml.hpp"
#include "musher/test/modules/line_walker/s_lane.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::line_walker::ground_test {

constexpr double kHeight = 0.29;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// How far off the same point comes back, at most; of all points that the camera shows.
double WorstError(const MountedCamera& camera, int* shown) {
  const WorldCamera world(camera, Pose{}, kHeight);
  double worst = 0;
  for (double x = -1.5; x <= 1.5; x += 0.1) {
    for (double y = -1.5; y <= 1.5; y += 0.1) {
      const auto share = world.ShareOf({x, y});
      if (!share) continue;
      const auto back = OnGround(camera, kHeight, 4, (*share)[0], (*share)[1]);
      if (!back) {
        ADD_FAILURE() << x << " " << y << " is shown, but not found on the ground";
        continue;
      }
      ++*shown;
      worst = std::max(worst, std::hypot(back->x_m - x, back->y_m - y));
    }
  }
  return worst;
}

TEST(Ground, IsTheInverseOfTheWorldsCameras) {
  const CameraSet cameras;
  for (const MountedCamera* camera : {&cameras.left, &cameras.right, &cameras.front}) {
    int shown = 0;
    EXPECT_LT(WorstError(*camera, &shown), 1e-6);
    EXPECT_GT(shown, 40);
  }
}

TEST(Ground, IsTheInverseOfACameraWithARoll) {
  MountedCamera camera = CameraSet().left;
  camera.roll_rad = 0.2;
  camera.yaw_rad = 1.2;
  int shown = 0;
  EXPECT_LT(WorstError(camera, &shown), 1e-6);
  EXPECT_GT(shown, 40);
}

TEST(Ground, HasTheFisheyesOfTheYard) {
  const auto scene = world::ReadSceneFile(SourceDir() + "/config/scenes/yard.toml").scene;
  ASSERT_TRUE(scene);
  const CameraSet cameras;
  const auto same = [](const MountedCamera& ours, const world::CameraSpec& theirs) {
    const world::CameraSpec spec = SpecOf(ours);
    EXPECT_TRUE(spec.model == theirs.model);
    EXPECT_NEAR((spec.position_m - theirs.position_m).norm(), 0, 1e-9);
    EXPECT_NEAR(spec.yaw_rad, theirs.yaw_rad, 1e-9);
    EXPECT_NEAR(spec.pitch_rad, theirs.pitch_rad, 1e-9);
    EXPECT_NEAR(spec.hfov_rad, theirs.hfov_rad, 1e-9);
    EXPECT_EQ(spec.width_px, theirs.width_px);
    EXPECT_EQ(spec.height_px, theirs.height_px);
  };
  same(cameras.left, scene->cameras.cameras[1]);
  same(cameras.right, scene->cameras.cameras[2]);
}

TEST(Ground, ShowsWhatIsAheadAtTheRightOfTheLeftPicture) {
  const CameraSet cameras;
  const auto left = OnGround(cameras.left, kHeight, 2, 0.75, 0.6);
  const auto right = OnGround(cameras.right, kHeight, 2, 0.25, 0.6);
  ASSERT_TRUE(left && right);
  EXPECT_GT(left->x_m, 0.4);
  EXPECT_GT(left->y_m, 0.2);
  EXPECT_NEAR(right->x_m, left->x_m, 1e-9);
  EXPECT_NEAR(right->y_m, -left->y_m, 1e-9);
}

TEST(Ground, IsNotSeenAboveTheHorizonOutsideThePictureOrByNaN) {
  const CameraSet cameras;
  EXPECT_FALSE(OnGround(cameras.front, kHeight, 2, 0.5, 0.1)) << "the sky";
  EXPECT_FALSE(OnGround(cameras.front, kHeight, 2, 0.5, 0.42)) << "farther than 2 m";
  EXPECT_TRUE(OnGround(cameras.front, kHeight, 2, 0.5, 0.9));
  EXPECT_FALSE(OnGround(cameras.front, kHeight, 2, 1.1, 0.9));
  EXPECT_FALSE(OnGround(cameras.front, kHeight, 2, 0.5, -0.1));
  EXPECT_FALSE(OnGround(cameras.front, kHeight, 2, kNaN, 0.9));
  EXPECT_FALSE(OnGround(cameras.left, kHeight, 2, 0.5, kNaN));
  EXPECT_FALSE(OnGround(cameras.left, kHeight, 20, 0.01, 0.99)) << "outside the fisheye's circle";
}

TEST(Ground, TakesAnEvenChoiceOfTheEdgeAndLeavesOutItsNaN) {
  msg::YellowLines lines;
  for (int i = 0; i < 300; ++i) {
    lines.edge_x.push_back(0.2F + 0.002F * float(i));
    lines.edge_y.push_back(i % 3 == 0 ? std::numeric_limits<float>::quiet_NaN() : 0.7F);
  }
  lines.edge_x.push_back(0.5F);  // without its y
  const auto points = EdgeOnGround(CameraSet().left, kHeight, 2, lines, 50);
  ASSERT_EQ(points.size(), 50U);
  EXPECT_LT(points.front().x_m, 0);
  EXPECT_GT(points.back().x_m, 0.4);
  EXPECT_TRUE(EdgeOnGround(CameraSet().left, kHeight, 2, msg::YellowLines(), 50).empty());
}

}  // namespace musher::line_walker::ground_test
