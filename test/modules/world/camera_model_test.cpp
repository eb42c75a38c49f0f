// The directions of pixels, against closed forms.

#include "musher/modules/world/body/camera_model.hpp"

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include <cmath>

#include "musher/modules/world/render/lens.hpp"

namespace musher::world::camera_model_test {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kDegree = M_PI / 180;

const CameraSpec& FrontSpec() {
  static const CameraSet set;
  return set.cameras[0];
}
const CameraSpec& FisheyeSpec() {
  static const CameraSet set;
  return set.cameras[1];
}

double Between(int least, int most) {
  return *rc::gen::inRange(least * 1000, most * 1000) / 1000.0;
}

TEST(CameraModel, HasAFocalLengthOfSixHundredPixelsAhead) {
  const Intrinsics front = IntrinsicsOf(FrontSpec());
  EXPECT_NEAR(front.focal_px, 600, 1e-9);
  EXPECT_EQ(front.center_px, Vector2d(319.5, 239.5));
  const auto pixel = Project(front, {0.1, -0.2, 1});
  ASSERT_TRUE(pixel);
  EXPECT_NEAR((*pixel - Vector2d(379.5, 119.5)).norm(), 0, 1e-9);
}

TEST(CameraModel, OfAFisheyeGrowsEvenlyWithTheAngle) {
  const Intrinsics fisheye = IntrinsicsOf(FisheyeSpec());
  for (const double degrees : {10.0, 45.0, 80.0, 90.0}) {
    const double angle = degrees * kDegree;
    const auto pixel = Project(fisheye, {std::sin(angle), 0, std::cos(angle)});
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(pixel->x() - 319.5, 320 * degrees / 90, 1e-9) << degrees;
    EXPECT_NEAR(pixel->y(), 239.5, 1e-9);
  }
  EXPECT_FALSE(Project(fisheye, {1, 0, -0.1})) << "beyond its circle";
}

TEST(CameraModel, OfAPinholeSeesNothingBehindIt) {
  EXPECT_FALSE(Project(IntrinsicsOf(FrontSpec()), {0, 0, -1}));
  EXPECT_FALSE(Project(IntrinsicsOf(FrontSpec()), {0, 0, 0}));
}

RC_GTEST_PROP(CameraModelProperty, ProjectsARayOntoThePixelItComesFrom, ()) {
  for (const CameraSpec& spec : {FrontSpec(), FisheyeSpec()}) {
    const Intrinsics intrinsics = IntrinsicsOf(spec);
    const Vector2d pixel(Between(40, 600), Between(40, 440));
    const Vector3d ray = RayOf(intrinsics, pixel);
    RC_ASSERT(std::abs(ray.norm() - 1) < 1e-12);
    const auto back = Project(intrinsics, ray * Between(1, 20));
    if (!back) RC_ASSERT(spec.model == CameraModel::kFisheye && ray.z() < 1e-9);
    if (back) RC_ASSERT((*back - pixel).norm() < 1e-6);
  }
}

// What pictures are drawn with is what CameraInfo says, for every pixel at once.
TEST(Lens, LooksInTheDirectionOfTheModel) {
  for (const CameraSpec& spec : {FrontSpec(), FisheyeSpec()}) {
    const Lens lens(spec);
    for (const int y : {0, 13, 240, 479}) {
      Places places;
      for (std::size_t i = 0; i < kBundle; ++i) {
        places.x[i] = 20.0F * static_cast<float>(i) + 0.25F;
        places.y[i] = static_cast<float>(y);
      }
      Rays rays;
      Each<float> gains;
      lens.Look(places, rays, gains);
      for (std::size_t i = 0; i < kBundle; ++i) {
        if (gains[i] <= 0) continue;
        const Vector3d expected = RayOf(lens.intrinsics(), {places.x[i], places.y[i]});
        EXPECT_LT((Vector3d(rays.x[i], rays.y[i], rays.z[i]) - expected).norm(), 2e-6);
      }
    }
  }
}

TEST(Lens, OfAFisheyeIsDarkBeyondItsCircle) {
  const Lens lens(FisheyeSpec());
  Places places;
  places.x.fill(2);
  places.y.fill(2);
  places.x[1] = 319.5F;
  places.y[1] = 239.5F;
  Rays rays;
  Each<float> gains;
  lens.Look(places, rays, gains);
  EXPECT_EQ(gains[0], 0);
  EXPECT_FLOAT_EQ(gains[1], 1);
  EXPECT_TRUE(lens.tiles().front().dark);
}

TEST(CameraInPlace, FollowsTheBodysPlaceHeightAndAttitude) {
  CameraSpec spec;
  spec.position_m = {0.3, 0, 0.1};
  // Standing level, turned to the left: what is ahead is along the place's y.
  const Eigen::Isometry3d level = CameraInPlace(spec, {{1, 2}, M_PI / 2}, {0.3, 0, 0});
  EXPECT_LT((level.translation() - Vector3d(1, 2.3, 0.4)).norm(), 1e-12);
  EXPECT_LT((level.linear().col(2) - Vector3d(0, 1, 0)).norm(), 1e-12) << "z ahead";
  EXPECT_LT((level.linear().col(0) - Vector3d(1, 0, 0)).norm(), 1e-12) << "x to the right";
  EXPECT_LT((level.linear().col(1) - Vector3d(0, 0, -1)).norm(), 1e-12) << "y down";
  // The nose down by 30 degrees: it looks and moves downwards.
  const Eigen::Isometry3d bowed = CameraInPlace(spec, {}, {0.3, 0, 30 * kDegree});
  EXPECT_NEAR(bowed.linear()(2, 2), -0.5, 1e-12);
  EXPECT_LT(bowed.translation().z(), 0.3);
}

}  // namespace musher::world::camera_model_test
