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

// Pieces of one colour, 30 pixels wide, with gaps of the other one.
cv::Mat WithStripes(const cv::Scalar& color, const cv::Scalar& gaps, int slant_px) {
  cv::Mat bgr = WithBar({80, 200, 480, 40}, gaps);
  for (int x = 80; x + 30 + slant_px < 560; x += 60) {
    cv::fillConvexPoly(bgr,
                       std::vector<cv::Point>{
                           {x + slant_px, 200}, {x + 30 + slant_px, 200}, {x + 30, 239}, {x, 239}},
                       color);
  }
  return bgr;
}

TEST(Barrier, MayHaveStripes) {
  const cv::Scalar black(20, 20, 20);
  for (const int slant_px : {0, 20}) {
    for (const cv::Mat& bgr :
         {WithStripes(kRed, kWhite, slant_px), WithStripes(kYellow, black, slant_px)}) {
      const auto barrier = FindBarrier(bgr, {});
      ASSERT_TRUE(barrier) << slant_px;
      EXPECT_NEAR(barrier->height_px, 40, 3);
      EXPECT_NEAR(barrier->box.x + barrier->box.width / 2.0, 320, 50);
      BarrierParameters plain;
      plain.striped = false;
      EXPECT_FALSE(FindBarrier(bgr, plain));
    }
  }
  EXPECT_FALSE(FindBarrier(WithStripes(kYellow, kWhite, 0), {})) << "no warning colours";
}

TEST(Barrier, OfTiltedStripesIsNotNearerThanItIs) {
  const cv::Scalar black(20, 20, 20);
  for (const double degrees : {-20.0, -10.0, 10.0, 20.0}) {
    for (const cv::Mat& level : {WithStripes(kRed, kWhite, 0), WithStripes(kYellow, black, 0)}) {
      cv::Mat bgr;
      const cv::Mat turn = cv::getRotationMatrix2D({320, 220}, degrees, 1);
      cv::warpAffine(level, bgr, turn, level.size(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
      const auto barrier = FindBarrier(bgr, {});
      ASSERT_TRUE(barrier) << degrees;
      EXPECT_NEAR(barrier->height_px, 40, 4) << degrees;
    }
  }
}

TEST(Barrier, OfAGateCountsWithoutItsPosts) {
  cv::Mat bgr = WithBar({100, 150, 400, 40});
  bgr(cv::Rect(100, 150, 30, 300)).setTo(kRed);
  bgr(cv::Rect(470, 150, 30, 300)).setTo(kRed);
  const auto barrier = FindBarrier(bgr, {});
  ASSERT_TRUE(barrier);
  EXPECT_NEAR(barrier->height_px, 40, 5);
  EXPECT_LE(barrier->box.height, 48);
}

TEST(Barrier, IsNoRedShirtThatTheUpperEdgeCuts) {
  EXPECT_FALSE(FindBarrier(WithBar({200, 0, 220, 50}), {}));
  EXPECT_TRUE(FindBarrier(WithBar({40, 0, 560, 110}), {}));
  EXPECT_FALSE(FindBarrier(WithBar({40, 0, 560, 130}), {})) << "a quarter of the picture is high";
  EXPECT_FALSE(FindBarrier(WithBar({0, 0, 640, 200}), {})) << "nor a red wall";
}

TEST(Barrier, IsNoRowOfLampsUnderADarkCeiling) {
  cv::Mat bgr = GreyPicture();
  bgr(cv::Rect(0, 0, 640, 120)).setTo(cv::Scalar(30, 30, 30));
  for (const int y : {20, 60}) {
    for (int i = 0; i < 3; ++i) {
      cv::circle(bgr, {280 + 27 * i, y}, 5, {40, 190, 255}, cv::FILLED, cv::LINE_AA);
    }
  }
  EXPECT_FALSE(FindBarrier(bgr, {}));
}

TEST(Barrier, IsNoPanelOfSlats) {
  cv::Mat bgr = WithBar({100, 300, 400, 60}, {15, 15, 15});
  for (int x = 100; x + 14 <= 500; x += 20) {
    bgr(cv::Rect(x, 300, 14, 60)).setTo(cv::Scalar(70, 130, 180));
  }
  EXPECT_FALSE(FindBarrier(bgr, {}));
}

TEST(Barrier, IsNoRowOfRedChairsBeforeALightWall) {
  for (const double shade : {1.0, 0.9}) {
    cv::Mat bgr(480, 640, CV_8UC3, cv::Scalar(225, 230, 230));
    bgr(cv::Rect(120, 220, 400, 50)) *= shade;
    for (int i = 0; i < 4; ++i) bgr(cv::Rect(120 + 110 * i, 220, 60, 50)).setTo(kRed);
    EXPECT_FALSE(FindBarrier(bgr, {})) << shade;
  }
}

TEST(Barrier, IsNoStripeOfAFlag) {
  cv::Mat bgr = WithBar({200, 150, 270, 180});
  bgr(cv::Rect(200, 210, 270, 60)).setTo(kWhite);
  EXPECT_FALSE(FindBarrier(bgr, {}));
  bgr(cv::Rect(200, 270, 270, 60)).setTo(kWhite);
  EXPECT_TRUE(FindBarrier(bgr, {})) << "a bar over something white";
}

TEST(Barrier, IsNoWallOfBricks) {
  cv::Mat bgr = GreyPicture();
  bgr(cv::Rect(20, 150, 600, 120)).setTo(cv::Scalar(150, 160, 170));
  for (int row = 0; row < 8; ++row) {
    for (int x = 20 - (row % 2) * 20; x < 620; x += 40) {
      bgr(cv::Rect(x, 150 + 15 * row, 37, 12) & cv::Rect(20, 150, 600, 120))
          .setTo(cv::Scalar(50, 60, 160));
    }
  }
  EXPECT_FALSE(FindBarrier(bgr, {}));
  bgr(cv::Rect(0, 0, 640, 150)).setTo(cv::Scalar(50, 60, 160));
  EXPECT_FALSE(FindBarrier(bgr, {}));
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
      world::Scene scene = HallScene();
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
  world::Scene scene = HallScene();
  scene.boxes = {{"", {3, 0}, {0.025, 0.5}, 0, 0.1, 0.5, {200, 30, 30}}};
  const auto scenery = world::SceneryOf(scene);
  bool was_top = false;
  double top_m = 0;
  for (double x_m = testing::Nightly() ? 0 : 1.4; x_m < 2.6; x_m += 0.04) {
    const auto barrier = FindBarrier(SceneShot(*scenery, CourseCamera::kFront, {{x_m, 0}, 0}), {});
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
