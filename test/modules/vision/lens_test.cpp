#include "musher/modules/vision/picture/lens.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "musher/test/modules/vision/faces.hpp"

namespace musher::vision::lens_test {

using ::testing::HasSubstr;

double DistanceOf(const Lens& lens, const FaceBox& box) {
  return DistanceM(lens, box, box.height, 0.2);
}

TEST(Lens, GivesTheDistanceFromTheSizeOfAFace) {
  for (const double distance_m : {0.3, 1.0, 4.0}) {
    const FaceBox box = FaceAt(0.5, 0.5, HeightAt(distance_m, 0.2));
    EXPECT_NEAR(DistanceOf(FrontLens(), box), distance_m, 1e-3);
  }
}

TEST(Lens, FitsAPictureInAnotherSize) {
  msg::CameraInfo half = FrontInfo();
  half.width = 320;
  half.height = 240;
  for (const std::size_t i : {0, 2, 4, 5}) half.k.at(i) /= 2;
  EXPECT_EQ(LensOf(half).value(), FrontLens());
}

TEST(Lens, MeasuresAlongTheLineOfSight) {
  // 1 m ahead and 0.4 m aside.
  const FaceBox box = FaceAt((319.5 + 0.4 * 600) / 640, 239.5 / 480, HeightAt(1, 0.2));
  EXPECT_NEAR(DistanceOf(FrontLens(), box), std::hypot(1, 0.4), 1e-6);
}

TEST(Lens, OfAFisheyeMeasuresByAngle) {
  msg::CameraInfo info = FrontInfo();
  info.distortion_model = msg::CameraInfo::kEquidistant;
  info.k[0] = info.k[4] = 200;  // pixels in a radian
  const double angle_rad = 2 * std::atan(0.1 / 0.5);
  const FaceBox box = FaceAt(0.5, 0.5, angle_rad * 200 / 480);
  EXPECT_NEAR(DistanceOf(LensOf(info).value(), box), 0.5, 1e-9);
}

TEST(Lens, MayBeGivenByItsAngle) {
  const Lens lens = PinholeOf(2 * std::atan(320.0 / 600), 640, 480);
  EXPECT_NEAR(lens.focal_x, FrontLens().focal_x, 1e-9);
  EXPECT_NEAR(lens.focal_y, FrontLens().focal_y, 1e-9);
}

TEST(Lens, IsNotMadeFromInvalidNumbers) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {0.0, -600.0, nan, std::numeric_limits<double>::infinity()}) {
    for (const std::size_t i : {0, 2, 4, 5}) {
      msg::CameraInfo info = FrontInfo();
      info.k.at(i) = bad;
      EXPECT_FALSE(LensOf(info)) << i << " " << bad;
    }
  }
  msg::CameraInfo info = FrontInfo();
  info.height = 0;
  const Result<Lens> lens = LensOf(info);
  ASSERT_FALSE(lens);
  EXPECT_EQ(lens.error().code, 5910);
  EXPECT_THAT(lens.error().message, HasSubstr("it is of no size"));
}

}  // namespace musher::vision::lens_test
