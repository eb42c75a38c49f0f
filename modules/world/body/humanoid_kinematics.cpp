#include "musher/modules/world/body/humanoid_kinematics.hpp"

namespace musher::world {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::size_t kFirstOfArm[kSides] = {13,
                                             18};  // shoulder pitch, roll, yaw, elbow pitch, yaw
constexpr std::size_t kFirstOfLeg[kSides] = {0,
                                             6};  // hip pitch, roll, yaw, knee, ankle pitch, roll

Matrix3d Roll(double angle_rad) {
  return AngleAxisd(angle_rad, Vector3d::UnitX()).toRotationMatrix();
}
Matrix3d Pitch(double angle_rad) {
  return AngleAxisd(angle_rad, Vector3d::UnitY()).toRotationMatrix();
}
Matrix3d Yaw(double angle_rad) {
  return AngleAxisd(angle_rad, Vector3d::UnitZ()).toRotationMatrix();
}

// Mirrors angles of the left side to their own side.
Vector3d OnSide(std::size_t side, const Vector3d& left_m) {
  return side == 0 ? left_m : Vector3d(left_m.x(), -left_m.y(), left_m.z());
}

Vector3d Down(double length_m) {
  return {0, 0, -length_m};
}

Arm ArmOf(const double* joints, const Vector3d& shoulder_m, const Matrix3d& trunk) {
  Arm arm;
  arm.shoulder_m = trunk * shoulder_m;
  const Matrix3d upper = trunk * Pitch(joints[0]) * Roll(joints[1]) * Yaw(joints[2]);
  arm.elbow_m = arm.shoulder_m + upper * Down(kUpperArmM);
  arm.hand = upper * Pitch(joints[3]) * Yaw(joints[4]);
  arm.hand_m = arm.elbow_m + arm.hand * Down(kForearmM);
  return arm;
}

Leg LegOf(const double* joints, const Vector3d& hip_m) {
  Leg leg;
  leg.hip_m = hip_m;
  const Matrix3d thigh = Pitch(joints[0]) * Roll(joints[1]) * Yaw(joints[2]);
  leg.knee_m = leg.hip_m + thigh * Down(kThighM);
  const Matrix3d shank = thigh * Pitch(joints[3]);
  leg.ankle_m = leg.knee_m + shank * Down(kShankM);
  leg.foot = shank * Pitch(joints[4]) * Roll(joints[5]);
  return leg;
}

}  // namespace

Skeleton SkeletonOf(const Angles& angles) {
  // Of the left side.
  const Vector3d hip_m(0, 0.09, kThighM + kShankM + kAnkleM - kTrunkM);
  const Vector3d shoulder_m(0, 0.21, 0.4);
  const Vector3d head_m(0, 0, 0.6);
  Skeleton skeleton;
  skeleton.trunk = Yaw(angles[kWaistYaw]);
  skeleton.head = Isometry3d::Identity();
  skeleton.head.linear() = skeleton.trunk * Yaw(angles[kHeadYaw]);
  skeleton.head.translation() = skeleton.trunk * head_m;
  for (std::size_t side = 0; side < kSides; ++side) {
    skeleton.arms[side] =
        ArmOf(&angles[kFirstOfArm[side]], OnSide(side, shoulder_m), skeleton.trunk);
    skeleton.legs[side] = LegOf(&angles[kFirstOfLeg[side]], OnSide(side, hip_m));
  }
  return skeleton;
}

}  // namespace musher::world
