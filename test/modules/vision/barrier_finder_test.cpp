// A red bar: drawn, and over the lane of the simulated world.

#include "musher/modules/vision/course/barrier_finder.hpp"

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include "musher/test/modules/vision/course_pictures.hpp"
#include "musher/test/support/nightly.hpp"

namespace musher::vision::barrier_finder_test {

cv::Mat WithBar(const cv::Rect& box, const cv::Scalar& color = kRed) {
  cv::Mat bgr = GreyPicture();
  bgr(box).setTo(color);
  return bgr;
}

TEST(Barrier, IsALongLevelRedBar) {
  const auto barrier = FindBarrier(WithBar({100, 200, 400, 60}), {});
  ASSERT_TRUE(barrier);
  EXPECT_EQ(barrier->box, cv::Rect(100, 200, 400, 60));
  EXPECT_NEAR(barrier->height_px, 60, 1);
  EXPECT_FALSE(barrier->top || barrier->cut);
}

TEST(Barrier, IsAtTheTopWhenItsUpperEdgeIsInTheUppermostTenth) {
  EXPECT_FALSE(FindBarrier(WithBar({100, 48, 400, 60}), {})->top);
  EXPECT_TRUE(FindBarrier(WithBar({100, 47, 400, 60}), {})->top);
  const auto cut = FindBarrier(WithBar({0, 0, 640, 60}), {});
  EXPECT_TRUE(cut->top && cut->cut);
}

TEST(Barrier, IsNeitherShortNorSteepNorOfAnotherColour) {
  EXPECT_FALSE(FindBarrier(WithBar({100, 200, 150, 60}), {}));
  EXPECT_FALSE(FindBarrier(WithBar({100, 50, 40, 300}), {}));
  EXPECT_FALSE(FindBarrier(WithBar({100, 200, 400, 60}, kYellow), {}));
  EXPECT_FALSE(FindBarrier(WithBar({100, 200, 400, 60}, kGreen), {}));
  EXPECT_FALSE(FindBarrier(WithBar({100, 200, 30, 3}), {})) << "smaller than the least area";
  for (const double degrees : {-20.0, 20.0, -35.0, 35.0}) {
    cv::Mat bgr = WithBar({150, 220, 300, 40});
    const cv::Mat turn = cv::getRotationMatrix2D({300, 240}, degrees, 1);
    cv::warpAffine(bgr, bgr, turn, bgr.size(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    const auto barrier = FindBarrier(bgr, {});
    EXPECT_EQ(barrier.has_value(), std::abs(degrees) < 25) << degrees;
    if (barrier) {
      EXPECT_NEAR(barrier->height_px, 40, 2);
    }
  }
}

TEST(Barrier, IsTheLargestOfSeveral) {
  cv::Mat bgr = WithBar({100, 100, 200, 30});
  bgr(cv::Rect(50, 300, 500, 60)).setTo(kRed);
  EXPECT_EQ(FindBarrier(bgr, {})->box.y, 300);
}

RC_GTEST_PROP(BarrierProperty, OfAMirroredPictureIsInTheMirroredPlace, ()) {
  const cv::Rect box(*rc::gen::inRange(0, 300), *rc::gen::inRange(0, 400),
                     *rc::gen::inRange(60, 300), *rc::gen::inRange(5, 60));
  const cv::Mat bgr = WithBar(box);
  const auto barrier = FindBarrier(bgr, {}), mirrored = FindBarrier(Mirrored(bgr), {});
  RC_ASSERT(barrier.has_value() == mirrored.has_value());
  if (barrier) RC_ASSERT(640 - barrier->box.br().x == mirrored->box.x);
}

// A bar 0.1 m high, half a metre over the ground, across the lane.
TEST(BarrierOverALane, HasItsDistanceUntilItReachesTheTop) {
  const Lens lens = PinholeOf(world::CameraSet().cameras[0].hfov_rad, 640, 480);
  BarrierParameters parameters;
  parameters.height_m = 0.1;
  for (const double far_m : testing::Ends({0.8, 1.0, 1.5, 2.0, 3.0})) {
    for (const double yaw_deg : testing::Ends({-15.0, 0.0, 15.0})) {
      world::Scene scene = Hall();
      scene.boxes = {{"", {kEyeM + far_m, 0}, {0.025, 0.5}, 0, 0.1, 0.5, {200, 30, 30}}};
      const cv::Mat bgr = SceneShot(scene, CourseCamera::kFront, {{0, 0}, yaw_deg * M_PI / 180});
      const auto barrier = FindBarrier(bgr, parameters);
      ASSERT_TRUE(barrier) << far_m << " m " << yaw_deg;
      const double distance_m = DistanceBySizeM(lens, bgr.size(), barrier->height_px, 0.1, 600);
      EXPECT_NEAR(distance_m, far_m, 0.15 * far_m) << yaw_deg;
    }
  }
}

TEST(BarrierOverALane, ReachesTheTopBeforeItLeavesThePicture) {
  world::Scene scene = Hall();
  scene.boxes = {{"", {3, 0}, {0.025, 0.5}, 0, 0.1, 0.5, {200, 30, 30}}};
  bool was_top = false;
  double top_m = 0;
  for (double x_m = testing::Nightly() ? 0 : 1.4; x_m < 2.6; x_m += 0.04) {
    const auto barrier = FindBarrier(SceneShot(scene, CourseCamera::kFront, {{x_m, 0}, 0}), {});
    if (barrier && barrier->top && !was_top) top_m = 3 - kEyeM - x_m;
    EXPECT_FALSE(was_top && barrier && !barrier->top) << x_m;
    was_top = was_top || (barrier && barrier->top);
  }
  EXPECT_NEAR(top_m, 0.25 * 600 / 192, 0.06);
}

TEST(Barrier, IsNotFoundInNoise) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    EXPECT_FALSE(FindBarrier(NoisePicture(seed), {})) << seed;
  }
}

}  // namespace musher::vision::barrier_finder_test
