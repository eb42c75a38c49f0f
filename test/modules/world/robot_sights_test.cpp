// A camera that stands in the place, and the humanoid that it sees.

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>

#include "musher/modules/world/render/shot.hpp"
#include "musher/modules/world/scene_file/scene_toml.hpp"
#include "musher/test/modules/world/scenes.hpp"
#include "musher/test/modules/world/shots.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::world::robot_sights_test {

using Eigen::Vector2i;
using Eigen::Vector3d;

constexpr std::size_t kFront = 0, kHall = 1;

Scene Wedding() {
  static const Scene scene =
      ReadSceneFile(SourceDir() + "/config/scenes/wedding.toml").scene.value();
  Scene quiet = scene;
  for (CameraSpec& camera : quiet.cameras.cameras) camera.noise = 0;
  quiet.ground.finest_per_m = 20;
  return quiet;
}

// In that pose for a while, with no other guest, before a wall that no part of it looks like.
World Posing(const std::string& pose, const Eigen::Vector2d& look = {0.5, 0.5}) {
  Scene scene = Wedding();
  scene.fence_color = {20, 180, 40};
  scene.guests.clear();
  World world(scene);
  EXPECT_EQ(world.SetPose(pose), std::nullopt);
  EXPECT_EQ(world.LookAt(look), std::nullopt);
  Pass(world, Seconds(8));
  return world;
}

// As from where a guest stands.
CameraSpec BeforeTheRobot() {
  CameraSpec spec;
  spec.on = CameraMount::kPlace;
  spec.position_m = {1.5, 0, 1.4};
  spec.yaw_rad = M_PI;
  spec.noise = spec.vignette = 0;
  return spec;
}

struct Shots {
  Image with, without;  // the robot
};
Shots BothWays(const World& world, const CameraSpec& spec) {
  const auto scenery = Scenery::Make(world.scene());
  EXPECT_TRUE(scenery);
  View view = ViewOf(world, kHall);
  const Camera camera(spec);
  Shots shots{camera.Shoot(*scenery.value(), view), {}};
  view.humanoid.reset();
  shots.without = camera.Shoot(*scenery.value(), view);
  return shots;
}

bool ShowsTheRobot(const Shots& shots, const Vector2i& pixel) {
  const std::uint8_t* with = shots.with.At(pixel.x(), pixel.y());
  const std::uint8_t* without = shots.without.At(pixel.x(), pixel.y());
  int differs = 0;
  for (int i = 0; i < 3; ++i) differs = std::max(differs, std::abs(with[i] - without[i]));
  return differs > 20;
}

Vector2i PixelOf(const CameraSpec& spec, const World& world, const Vector3d& on_body_m) {
  const Vector3d point = BodyInPlace(world.body().pose(), world.body().attitude()) * on_body_m;
  const auto pixel = Project(IntrinsicsOf(spec), CameraInPlace(spec, {}, {}).inverse() * point);
  EXPECT_TRUE(pixel);
  return pixel.value_or(Eigen::Vector2d(0, 0)).array().round().cast<int>();
}

RC_GTEST_PROP(PlaceCameraProperty, ShowsAPointWhereCameraInfoAndItsPlaceSayItIs, ()) {
  const auto within = [](int least, int most) { return *rc::gen::inRange(least, most) / 1000.0; };
  Scene scene = EmptyYard();
  scene.ground.finest_per_m = 10;
  scene.fence_height_m = 0;
  CameraSpec spec = Wedding().cameras.cameras[kHall];
  spec.vignette = 0;
  spec.position_m = {within(-3000, 3000), within(-3000, 3000), within(300, 3000)};
  spec.yaw_rad = within(-3000, 3000);
  spec.pitch_rad = within(-1000, 1000);
  spec.roll_rad = within(-1000, 1000);
  // Somewhere in the picture, and the robot anywhere.
  const Vector3d ahead(within(-700, 700), within(-500, 500), 2);
  View view;
  view.body = {{within(-9000, 9000), within(-9000, 9000)}, within(-3000, 3000)};
  view.attitude = {0.3, within(-300, 300), within(-300, 300)};
  view.gaze = {within(-2000, 2000), within(-300, 300)};
  const Eigen::Isometry3d camera = CameraInPlace(spec, view.body, view.attitude, view.gaze);
  RC_ASSERT((camera.translation() - spec.position_m).norm() < 1e-12);
  const Vector3d center_m = camera * ahead;
  RC_PRE(center_m.z() > 0.1);
  const auto middle = MiddleOfGlowingBall(scene, spec, view, center_m);
  RC_ASSERT(middle.has_value());
  RC_ASSERT((*middle - *Project(IntrinsicsOf(spec), ahead)).norm() < 1.0);
}

TEST(HallCamera, FilmsTheRobotAndTheGuestBeforeIt) {
  World world(Wedding());
  Pass(world, Seconds(10));  // the bride is here
  const CameraSpec& hall = world.scene().cameras.cameras[kHall];
  const auto is_in_picture = [&](const Vector3d& point) {
    const auto pixel = Project(IntrinsicsOf(hall), world.CameraPose(kHall).inverse() * point);
    return pixel && pixel->minCoeff() > 0 && pixel->x() < hall.width_px - 1 &&
           pixel->y() < hall.height_px - 1;
  };
  const Eigen::Isometry3d body = BodyInPlace(world.body().pose(), world.body().attitude());
  EXPECT_TRUE(is_in_picture(body * Vector3d(0, 0, 0.9))) << "raised hands";
  EXPECT_TRUE(is_in_picture(body * Vector3d(0, 0, -0.9))) << "feet";
  const Guest& bride = world.guests()[0];
  EXPECT_TRUE(is_in_picture(HeadOf(world.scene().guests[0], bride)));
  EXPECT_TRUE(is_in_picture({bride.position_m.x(), bride.position_m.y(), 0.05}));
}

TEST(HallCamera, StaysWhereItIsWhenTheRobotIsCarriedAway) {
  World world(Wedding());
  const Eigen::Isometry3d before = world.CameraPose(kHall);
  ASSERT_EQ(world.PutDown({{1, 2}, 1}), std::nullopt);
  ASSERT_EQ(world.LookAt({0, 0}), std::nullopt);
  Pass(world, Seconds(2));
  EXPECT_TRUE(world.CameraPose(kHall).isApprox(before));
}

TEST(RobotFigure, IsSeenWhereItsJointsAreInEveryPose) {
  for (const char* pose : {"neutral", "heart", "v_sign", "thumbs_up", "wave", "welcome"}) {
    const World world = Posing(pose);
    const CameraSpec spec = BeforeTheRobot();
    const Shots shots = BothWays(world, spec);
    const Skeleton skeleton = SkeletonOf(ViewOf(world, kHall).humanoid->angles);
    EXPECT_TRUE(ShowsTheRobot(shots, PixelOf(spec, world, skeleton.head.translation()))) << pose;
    for (const Arm& arm : skeleton.arms) {
      EXPECT_TRUE(ShowsTheRobot(shots, PixelOf(spec, world, arm.hand_m))) << pose;
      EXPECT_TRUE(ShowsTheRobot(shots, PixelOf(spec, world, arm.elbow_m))) << pose;
    }
    // Nothing is left where the arm was before.
    const Vector3d hung_m(0, -0.29, -0.16);
    if (skeleton.arms[1].hand_m.z() > 0.2) {
      EXPECT_FALSE(ShowsTheRobot(shots, PixelOf(spec, world, hung_m))) << pose;
    }
  }
}

TEST(RobotFigure, TurnsItsVisorToWhereItLooks) {
  const CameraSpec spec = BeforeTheRobot();
  const auto is_visor_at = [&](const World& world, double yaw_rad) {
    const Vector3d at(0.115 * std::cos(yaw_rad), 0.115 * std::sin(yaw_rad), 0.6);
    const Vector2i pixel = PixelOf(spec, world, at);
    const Shots shots = BothWays(world, spec);
    const std::uint8_t* bgr = shots.with.At(pixel.x(), pixel.y());
    return bgr[0] < 80 && bgr[1] < 80 && bgr[2] < 80;
  };
  EXPECT_TRUE(is_visor_at(Posing("neutral"), 0));
  const World looking = Posing("neutral", {0.25, 0.5});  // 60 degrees to the left
  EXPECT_TRUE(is_visor_at(looking, looking.gaze().yaw_rad));
  EXPECT_FALSE(is_visor_at(looking, 0));
}

// From the inside it would be all of the picture.
TEST(HeadCamera, SeesNothingOfItsOwnHeadAndTrunk) {
  for (const double x : {0.0, 0.3, 0.5, 1.0}) {
    const World world = Posing("neutral", {x, 0.5});
    const Shots shots = BothWays(world, world.scene().cameras.cameras[kFront]);
    EXPECT_EQ(shots.with.bgr, shots.without.bgr) << "looking at " << x;
  }
}

TEST(HeadCamera, SeesItsOwnRaisedHandWhenItLooksThere) {
  const World world = Posing("v_sign", {0.75, 0.5});
  const Shots shots = BothWays(world, world.scene().cameras.cameras[kFront]);
  EXPECT_NE(shots.with.bgr, shots.without.bgr);
}

TEST(RobotFigure, IsAsLargeAsInItsSceneAndStandsOnTheGround) {
  World world = Posing("neutral");
  View view = ViewOf(world, kHall);
  for (const double trunk_m : {0.6, 0.9}) {
    view.humanoid->trunk_m = view.attitude.height_m = trunk_m;
    std::vector<Thing> things;
    StandRobot(*view.humanoid, BodyInPlace({}, view.attitude), false, things);
    float lowest_m = 10, highest_m = 0;
    for (const Thing& thing : things) {
      // Along z its half is that of the unit ball's image.
      const float half_m = thing.to_unit.inverse().row(2).norm();
      lowest_m = std::min(lowest_m, thing.center_m.z() - half_m);
      highest_m = std::max(highest_m, thing.center_m.z() + half_m);
    }
    EXPECT_NEAR(lowest_m, 0, 1e-3) << trunk_m;
    EXPECT_NEAR(highest_m, trunk_m * 1.635 / 0.9, 1e-3) << trunk_m;
  }
}

}  // namespace musher::world::robot_sights_test
