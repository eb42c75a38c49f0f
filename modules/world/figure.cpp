#include "musher/modules/world/figure.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "musher/modules/world/face.hpp"

namespace musher::world {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;

// In slices across its longest axis: one ball round all of a limb would be as wide as it is long.
void Bound(const Matrix3d& turned, const Vector3d& half_m, Thing& thing) {
  constexpr int kMostSlices = 5;
  int longest = 0;
  const double along_m = half_m.maxCoeff(&longest);
  Vector3d rest_m = half_m;
  rest_m[longest] = 0;
  const double thick_m = rest_m.maxCoeff();
  const int slices = std::clamp(static_cast<int>(std::lround(along_m / thick_m)), 1, kMostSlices);
  const double half_slice_m = along_m / slices;
  for (int i = 0; i < slices; ++i) {
    const double middle_m = half_slice_m * (2 * i + 1 - slices);
    // It is thickest where it is nearest to its middle.
    const double inner = std::max(0.0, std::abs(middle_m) - half_slice_m) / along_m;
    const double radius_m = std::hypot(half_slice_m, thick_m * std::sqrt(1 - inner * inner));
    const Vector3d at_m = turned.col(longest) * middle_m;
    thing.bounds.push_back(
        {thing.center_m + at_m.cast<float>(), static_cast<float>(std::min(radius_m, along_m))});
  }
}

Thing Rounded(const Vector3d& center_m, const Matrix3d& turned, const Vector3d& half_m,
              const Light3& color) {
  Thing thing;
  thing.shape = Thing::Shape::kEllipsoid;
  thing.center_m = center_m.cast<float>();
  thing.half_m = half_m.cast<float>();
  const Matrix3d to_unit = half_m.cwiseInverse().asDiagonal() * turned.transpose();
  thing.to_unit = to_unit.cast<float>();
  thing.color = color;
  Bound(turned, half_m, thing);
  return thing;
}

// The parts of a body by how far ahead, to the left and up they are from the place it stands on.
class Parts {
 public:
  Parts(const Guest& guest, std::vector<Thing>& things)
      : turned_(AngleAxisd(guest.yaw_rad, Vector3d::UnitZ()).toRotationMatrix()),
        foot_m_(guest.position_m.x(), guest.position_m.y(), 0),
        things_(things) {}

  void Round(const Vector3d& at_m, const Vector3d& half_m, const Light3& color) {
    things_.push_back(Rounded(foot_m_ + turned_ * at_m, turned_, half_m, color));
  }
  // From a joint to the next.
  void Limb(const Vector3d& from_m, const Vector3d& to_m, double radius_m, const Light3& color) {
    const Vector3d along = to_m - from_m;
    const Matrix3d limb =
        turned_ * Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitX(), along).toRotationMatrix();
    things_.push_back(Rounded(foot_m_ + turned_ * (from_m + along / 2), limb,
                              {along.norm() / 2 + 0.6 * radius_m, radius_m, radius_m}, color));
  }

 private:
  const Matrix3d turned_;
  const Vector3d foot_m_;
  std::vector<Thing>& things_;
};

// Where the hands are for a sign, in heights of the guest; the other side is mirrored.
struct ArmPose {
  Vector3d elbow, hand;
};
ArmPose ArmOf(Gesture gesture, int side) {
  ArmPose down{{0.0, 0.145, 0.62}, {0.04, 0.145, 0.46}};
  if (gesture == Gesture::kHeart) return {{0.05, 0.165, 0.68}, {0.14, 0.022, 0.75}};
  // One hand is enough for the others.
  if (gesture == Gesture::kNone || side > 0) return down;
  return {{0.08, 0.17, 0.66}, {0.15, 0.15, 0.80}};
}

void AddArms(const GuestSpec& spec, Gesture gesture, const Light3& skin, const Light3& sleeves,
             Parts& parts) {
  const double tall = spec.height_m;
  for (const int side : {-1, 1}) {
    const Vector3d mirrored(tall, side * tall, tall);
    const ArmPose arm = ArmOf(gesture, side);
    const Vector3d shoulder = Vector3d(0, 0.115, 0.79).cwiseProduct(mirrored);
    const Vector3d elbow = arm.elbow.cwiseProduct(mirrored);
    const Vector3d hand = arm.hand.cwiseProduct(mirrored);
    parts.Limb(shoulder, elbow, 0.032 * tall, sleeves);
    parts.Limb(elbow, hand, 0.027 * tall, sleeves);
    parts.Round(hand, Vector3d(0.022, 0.024, 0.03) * tall, skin);
    if (gesture != Gesture::kV || side > 0) continue;
    for (const double lean : {-0.02, 0.02}) {
      parts.Limb(hand, hand + Vector3d(0, lean, 0.07) * tall, 0.006 * tall, skin);
    }
  }
}

}  // namespace

Figure::Figure(const GuestSpec& guest, Texture head)
    : spec_(guest), head_(std::make_shared<const Texture>(std::move(head))) {}

void Figure::Stand(const Guest& guest, std::vector<Thing>& things) const {
  const double tall = spec_.height_m;
  const Light3 skin = ToLight(SkinOf(spec_.face));
  const Light3 hair = ToLight(HairOf(spec_.face));
  const Light3 clothes = ToLight(spec_.color);
  const Light3 lower = spec_.gown ? clothes : Light3(clothes * 0.6F);
  Parts parts(guest, things);
  if (spec_.gown) {
    parts.Round(Vector3d(0, 0, 0.2) * tall, Vector3d(0.14, 0.15, 0.36) * tall, lower);
  } else {
    for (const int side : {-1, 1}) {
      parts.Limb(Vector3d(0, 0.05 * side, 0.52) * tall, Vector3d(0, 0.055 * side, 0.02) * tall,
                 0.055 * tall, lower);
    }
  }
  parts.Round(Vector3d(0, 0, 0.63) * tall, Vector3d(0.075, 0.1, 0.2) * tall, clothes);
  parts.Round(Vector3d(-0.005, 0, 0.785) * tall, Vector3d(0.06, 0.13, 0.045) * tall, clothes);
  const double head_m = HeadHeightM(spec_);
  const Vector3d middle = HeadOf(spec_, guest);
  parts.Round(Vector3d(0, 0, tall - head_m), Vector3d(0.05, 0.05, 0.09), skin * 0.92F);
  AddArms(spec_, guest.gesture, skin, clothes, parts);

  const Matrix3d turned = (AngleAxisd(guest.head_yaw_rad, Vector3d::UnitZ()) *
                           AngleAxisd(guest.head_pitch_rad, Vector3d::UnitY()))
                              .toRotationMatrix();
  const Vector3d half = Vector3d(0.42, 0.35, 0.5) * head_m;
  if (HasLongHair(spec_.face)) {
    things.push_back(Rounded(middle + turned * Vector3d(-0.22, 0, -0.25) * head_m, turned,
                             Vector3d(0.24, 0.4, 0.62) * head_m, hair));
  }
  Thing head = Rounded(middle, turned, half, hair);
  head.front = head_;
  things.push_back(std::move(head));
}

}  // namespace musher::world
