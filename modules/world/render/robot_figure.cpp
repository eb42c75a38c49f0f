#include "musher/modules/world/render/robot_figure.hpp"

#include "musher/modules/world/render/parts.hpp"

namespace musher::world {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

const Light3 kShell{230, 236, 246};
const Light3 kGrey{150, 155, 163};
const Light3 kDark{52, 56, 64};
const Light3 kVisor{18, 21, 28};
const Light3 kEyes{96, 214, 255};

// The palm's frame: -z away from the elbow, x to the thumb's side, y to the left when the arm hangs
// down. Palms look inwards.
void AddHand(HandShape shape, std::size_t side, const Arm& arm, Parts& parts) {
  const double inwards = side == 0 ? -1 : 1;
  const auto at = [&](double thumb_m, double in_m, double away_m) -> Vector3d {
    return arm.hand_m + arm.hand * Vector3d(thumb_m, inwards * in_m, -away_m);
  };
  const auto finger = [&](const Vector3d& from_m, const Vector3d& to_m) {
    parts.Limb(from_m, to_m, 0.014, kDark);
  };
  parts.Round(at(0, 0, 0), arm.hand, Vector3d(0.042, 0.024, 0.05), kDark);
  switch (shape) {
    case HandShape::kOpen:
      for (const double aside : {-0.03, -0.01, 0.01, 0.03}) {
        finger(at(aside, 0, 0.03), at(1.5 * aside, 0.015, 0.12));
      }
      finger(at(0.03, 0, 0), at(0.075, 0.015, 0.05));
      break;
    case HandShape::kFist:
      parts.Round(at(0, 0.015, 0.045), arm.hand, Vector3d(0.045, 0.036, 0.032), kDark);
      finger(at(0.035, 0.02, 0.01), at(0.02, 0.05, 0.05));
      break;
    case HandShape::kThumb:
      parts.Round(at(0, 0.015, 0.045), arm.hand, Vector3d(0.045, 0.036, 0.032), kDark);
      parts.Limb(at(0.03, 0, 0.02), at(0.125, 0, 0.02), 0.018, kDark);
      break;
    case HandShape::kV:
      parts.Round(at(0, 0.015, 0.045), arm.hand, Vector3d(0.045, 0.036, 0.032), kDark);
      for (const double way : {-1.0, 1.0}) {
        parts.Limb(at(0.018 * way, 0, 0.04), at(0.062 * way, 0, 0.165), 0.015, kDark);
      }
      break;
    case HandShape::kCurled:
      for (const double aside : {-0.03, -0.01, 0.01, 0.03}) {
        finger(at(aside, 0, 0.03), at(aside, 0.02, 0.09));
        finger(at(aside, 0.02, 0.09), at(aside, 0.085, 0.1));
      }
      finger(at(0.02, 0, -0.02), at(0.02, 0.135, -0.02));
      break;
  }
}

void AddArm(const Arm& arm, HandShape shape, std::size_t side, Parts& parts) {
  const Vector3d wrist_m = arm.hand_m + (arm.elbow_m - arm.hand_m).normalized() * 0.05;
  parts.Round(arm.shoulder_m, Vector3d::Constant(0.066), kDark);
  parts.Limb(arm.shoulder_m, arm.elbow_m, 0.052, kShell);
  parts.Round(arm.elbow_m, Vector3d::Constant(0.048), kDark);
  parts.Limb(arm.elbow_m, wrist_m, 0.044, kShell);
  AddHand(shape, side, arm, parts);
}

void AddLeg(const Leg& leg, Parts& parts) {
  parts.Round(leg.hip_m, Vector3d::Constant(0.078), kDark);
  parts.Limb(leg.hip_m, leg.knee_m, 0.076, kShell);
  parts.Round(leg.knee_m, Vector3d::Constant(0.06), kDark);
  parts.Limb(leg.knee_m, leg.ankle_m, 0.06, kShell);
  parts.Round(leg.ankle_m, Vector3d::Constant(0.045), kDark);
  parts.Round(leg.ankle_m + leg.foot * Vector3d(0.04, 0, -0.03), leg.foot,
              Vector3d(0.125, 0.055, 0.03), kGrey);
}

void AddTrunk(const Skeleton& skeleton, Parts& parts) {
  const auto round = [&](const Vector3d& at_m, const Vector3d& half_m, const Light3& color) {
    parts.Round(skeleton.trunk * at_m, skeleton.trunk, half_m, color);
  };
  parts.Round(Vector3d(0, 0, -0.03), Vector3d(0.105, 0.15, 0.1), kGrey);
  round({0, 0, 0.1}, {0.085, 0.1, 0.11}, kDark);  // the waist
  round({0, 0, 0.29}, {0.115, 0.175, 0.19}, kShell);
  round({0, 0, 0.4}, {0.085, 0.2, 0.07}, kShell);
  round({0.1, 0, 0.33}, {0.03, 0.06, 0.06}, kGrey);
  round({0, 0, 0.49}, {0.045, 0.045, 0.07}, kDark);  // the neck
}

void AddHead(const Skeleton& skeleton, Parts& parts) {
  const Matrix3d turned = skeleton.head.linear();
  const auto round = [&](const Vector3d& at_m, const Vector3d& half_m, const Light3& color) {
    parts.Round(skeleton.head * at_m, turned, half_m, color);
  };
  round({-0.005, 0, 0.005}, {0.11, 0.098, 0.13}, kShell);
  round({0.035, 0, 0.005}, {0.083, 0.085, 0.066}, kVisor);
  for (const int side : {-1, 1}) {
    round({-0.005, 0.095 * side, 0}, {0.035, 0.02, 0.045}, kGrey);
    round({0.107, 0.034 * side, 0.012}, {0.012, 0.015, 0.02}, kEyes);
  }
}

}  // namespace

void StandRobot(const HumanoidStance& stance, const Eigen::Isometry3d& body_in_place,
                bool arms_only, std::vector<Thing>& things) {
  const Skeleton skeleton = SkeletonOf(stance.angles);
  Parts parts(body_in_place, things, stance.trunk_m / kTrunkM);
  for (std::size_t side = 0; side < kSides; ++side) {
    AddArm(skeleton.arms[side], stance.hands[side], side, parts);
  }
  if (arms_only) return;
  for (const Leg& leg : skeleton.legs) AddLeg(leg, parts);
  AddTrunk(skeleton, parts);
  AddHead(skeleton, parts);
}

}  // namespace musher::world
