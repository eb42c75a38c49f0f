#include "musher/modules/world/render/figure.hpp"

#include <Eigen/Geometry>
#include <utility>

#include "musher/modules/world/paint/face.hpp"
#include "musher/modules/world/render/parts.hpp"

namespace musher::world {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;

// Positions of the hands for a gesture, in heights of the guest; the other side is mirrored.
struct ArmPose {
  Vector3d elbow, hand;
};
ArmPose ArmOf(Gesture gesture, int side) {
  ArmPose down{{0.0, 0.145, 0.62}, {0.04, 0.145, 0.46}};
  if (gesture == Gesture::kHeart) return {{0.05, 0.165, 0.68}, {0.14, 0.022, 0.75}};
  // The other gestures need one hand.
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
  const Eigen::Translation3d foot_m(guest.position_m.x(), guest.position_m.y(), 0);
  Parts parts(foot_m * AngleAxisd(guest.yaw_rad, Vector3d::UnitZ()), things);
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
