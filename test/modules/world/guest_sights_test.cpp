// Guests and the camera on the head: what common detectors find, and that the picture turns with
// the head.

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/objdetect.hpp>

#include "musher/modules/world/render/shot.hpp"
#include "musher/modules/world/scene_file/scene_toml.hpp"
#include "musher/test/modules/world/scenes.hpp"
#include "musher/test/modules/world/shots.hpp"
#include "musher/test/support/nightly.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::world::guest_sights_test {

using Eigen::Vector3d;
using ::testing::SizeIs;

const Scene& Wedding() {
  static const Scene scene =
      ReadSceneFile(SourceDir() + "/config/scenes/wedding.toml").scene.value();
  return scene;
}

View Upright(const Scene& scene) {
  View view;
  view.body = scene.start;
  view.attitude.height_m = scene.body.stand_height_m;
  return view;
}

std::vector<cv::Rect> FacesIn(const Image& image) {
  static cv::CascadeClassifier cascade(
      "/usr/share/opencv4/haarcascades/haarcascade_frontalface_alt.xml");
  EXPECT_FALSE(cascade.empty()) << "from Debian's opencv-data";
  std::vector<cv::Rect> found;
  cascade.detectMultiScale(GreyOf(image), found, 1.1, 3, 0, {24, 24});
  return found;
}

// One of that face, so far before the camera, looking at it; the camera nods to it as far as it
// can.
Image ShotOfGuest(int face, double height_m, double far_m, double turned_rad) {
  Scene scene = Wedding();
  GuestSpec spec;
  spec.face = face;
  spec.height_m = height_m;
  scene.guests = {spec};
  View view = Upright(scene);
  Guest guest;
  guest.here = true;
  guest.position_m = scene.start.position_m + Eigen::Vector2d(0.1 + far_m, 0);
  guest.yaw_rad = M_PI;
  guest.head_yaw_rad = M_PI + turned_rad;
  guest.head_pitch_rad = std::atan2(HeadOf(spec, guest).z() - 1.5, far_m);
  const double most_rad = scene.humanoid->pitch_rad;
  view.gaze.pitch_rad = std::clamp(-guest.head_pitch_rad, -most_rad, most_rad);
  view.guests = {guest};
  return ShotOf(scene, scene.cameras.cameras[0], view);
}

TEST(GuestFace, IsFoundByAUsualDetectorFromSixtyCentimetresToThreeMetres) {
  int face = 0;
  for (const double far_m : {0.6, 1.0, 1.5, 2.0, 2.5, 3.0}) {
    for (const double height_m : {1.4, 1.8}) {
      for (const double turned_rad : {0.0, -0.25}) {
        face = (face + 1) % 12;
        EXPECT_THAT(FacesIn(ShotOfGuest(face, height_m, far_m, turned_rad)), SizeIs(1))
            << "face " << face << " of " << height_m << " m at " << far_m << " m";
      }
    }
  }
}

TEST(GuestFace, IsNotFoundOfAGuestWhoLooksAway) {
  for (const double turned_rad : {M_PI, M_PI / 2}) {
    EXPECT_THAT(FacesIn(ShotOfGuest(3, 1.7, 1.5, turned_rad)), SizeIs(0)) << turned_rad;
  }
}

TEST(GuestFace, IsNoneInAnEmptyHallWhereverTheHeadLooks) {
  const Scene& scene = Wedding();
  const auto scenery = Scenery::Make(scene);
  ASSERT_TRUE(scenery);
  const Camera camera(scene.cameras.cameras[0]);
  for (const double yaw_rad : {-2.0, -1.2, -0.5, 0.0, 0.4, 0.9, 1.6}) {
    View view = Upright(scene);
    view.gaze.yaw_rad = yaw_rad;
    EXPECT_THAT(FacesIn(camera.Shoot(*scenery.value(), view)), SizeIs(0)) << yaw_rad;
  }
}

TEST(GuestFace, IsNoneInItsOwnArmsWhateverPoseItTakes) {
  const Scene& scene = Wedding();
  const auto scenery = Scenery::Make(scene);
  ASSERT_TRUE(scenery);
  const Camera camera(scene.cameras.cameras[0]);
  int number = 0;
  for (const PoseSpec& pose : scene.humanoid->poses) {
    for (const double yaw_rad : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
      if (number++ % 3 != 0 && !musher::testing::Nightly()) continue;
      View view = Upright(scene);
      view.gaze = {yaw_rad, 0.3};
      view.humanoid = HumanoidStance{pose.angles, pose.hands, scene.body.stand_height_m};
      view.humanoid->angles[kHeadYaw] = yaw_rad;
      EXPECT_THAT(FacesIn(camera.Shoot(*scenery.value(), view)), SizeIs(0))
          << pose.names[0] << " " << yaw_rad;
    }
  }
}

// A ball in an empty hall, and a head that looks about: it is where CameraInfo and the head say.
RC_GTEST_PROP(HeadCameraProperty, ShowsAPointWhereCameraInfoAndTheHeadSayItIs, ()) {
  const auto within = [](int least, int most) { return *rc::gen::inRange(least, most) / 1000.0; };
  Scene scene = EmptyYard();
  scene.ground.finest_per_m = 10;
  scene.fence_height_m = 0;
  CameraSpec spec = Wedding().cameras.cameras[0];
  spec.noise = spec.vignette = 0;
  View view;
  view.body = {{within(-1000, 1000), within(-1000, 1000)}, within(-3000, 3000)};
  view.attitude.height_m = 0.9;
  view.gaze = {within(-2000, 2000), within(-350, 350)};
  // Somewhere in the picture.
  const Vector3d ahead(within(-900, 900), within(-600, 600), 2);
  const Eigen::Isometry3d camera = CameraInPlace(spec, view.body, view.attitude, view.gaze);
  const Vector3d center_m = camera * ahead;
  RC_PRE(center_m.z() > 0.1);
  const auto middle = MiddleOfGlowingBall(scene, spec, view, center_m);
  RC_ASSERT(middle.has_value());
  const auto pixel = Project(IntrinsicsOf(spec), ahead);
  RC_ASSERT((*middle - *pixel).norm() < 1.0);
}

TEST(HeadCamera, TurnsWithWaistAndHead) {
  CameraSpec spec = Wedding().cameras.cameras[0];
  spec.pitch_rad = 0;
  const Attitude standing{0.9, 0, 0};
  const Eigen::Isometry3d left = CameraInPlace(spec, {}, standing, {M_PI / 2, 0});
  EXPECT_NEAR((left.translation() - Vector3d(0, 0.1, 1.5)).norm(), 0, 1e-12);
  EXPECT_NEAR((left.linear() * Vector3d::UnitZ() - Vector3d::UnitY()).norm(), 0, 1e-12);
  const Eigen::Isometry3d down = CameraInPlace(spec, {}, standing, {0, 0.3});
  EXPECT_NEAR((down.linear() * Vector3d::UnitZ()).z(), -std::sin(0.3), 1e-12);
  spec.on = CameraMount::kBody;
  EXPECT_TRUE(CameraInPlace(spec, {}, standing, {1, 0.3})
                  .isApprox(CameraInPlace(spec, {}, standing), 1e-12));
}

TEST(HeadCamera, SeesInTheRunningWorldWhereTheHeadIsNow) {
  World world(Wedding());
  ASSERT_EQ(world.LookAt({0.3, 0.6}), std::nullopt);
  Pass(world, Seconds(1));  // on its way
  const View view = ViewOf(world, 0);
  EXPECT_EQ(view.gaze.yaw_rad, world.humanoid()->gaze().yaw_rad);
  EXPECT_GT(view.gaze.yaw_rad, 0.05);
  EXPECT_GT(view.gaze.pitch_rad, 0.01);
}

TEST(Guests, AreDrawnWhereTheyAreAndHideWhatIsBehindThem) {
  Scene scene = Wedding();
  scene.cameras.cameras[0].noise = 0;
  const auto scenery = Scenery::Make(scene);
  ASSERT_TRUE(scenery);
  const Camera camera(scene.cameras.cameras[0]);
  View view = Upright(scene);
  const Image empty = camera.Shoot(*scenery.value(), view);
  World world(scene);
  Pass(world, Seconds(10));  // the bride is here
  view = ViewOf(world, 0);
  const Image with_bride = camera.Shoot(*scenery.value(), view);
  const Vector3d head = HeadOf(scene.guests[0], world.guests()[0]);
  const auto pixel = Project(camera.intrinsics(), world.CameraPose(0).inverse() * head).value();
  const int x = static_cast<int>(std::lround(pixel.x())),
            y = static_cast<int>(std::lround(pixel.y()));
  EXPECT_NE(empty.At(x, y)[2], with_bride.At(x, y)[2]);
  const auto faces = FacesIn(with_bride);
  ASSERT_THAT(faces, SizeIs(1));
  const cv::Point middle = (faces[0].tl() + faces[0].br()) / 2;
  EXPECT_NEAR(middle.x, pixel.x(), 5);
  EXPECT_NEAR(middle.y, pixel.y(), 25);
}

}  // namespace musher::world::guest_sights_test
