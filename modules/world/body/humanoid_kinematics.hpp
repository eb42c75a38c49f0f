#pragma once
// The positions of a humanoid's limbs from its joint angles: forward kinematics. Pure.
//
//   trunk's middle - hip (pitch, roll, yaw) - knee - ankle (pitch, roll), on either side
//                  - waist (yaw) - shoulder (pitch, roll, yaw) - elbow (pitch, yaw) - hand
//                                - neck (yaw)
//
// All values are in the body's frame: x ahead, y to the left, z up, from the middle of the trunk,
// in metres.

#include <Eigen/Geometry>
#include <array>

#include "musher/modules/world/scene/humanoid_specs.hpp"

namespace musher::world {

// Of a robot whose trunk's middle is 0.9 m over the ground when it stands upright. Arms and legs
// hang down when their angles are 0.
inline constexpr double kTrunkM = 0.9;
inline constexpr double kThighM = 0.38;
inline constexpr double kShankM = 0.38;
inline constexpr double kAnkleM = 0.06;  // over the sole
inline constexpr double kUpperArmM = 0.27;
inline constexpr double kForearmM = 0.30;  // from the elbow to the palm's middle

struct Arm {
  Eigen::Vector3d shoulder_m, elbow_m, hand_m;
  // Of the palm: -z from the elbow to it, x where the thumb is when the arm hangs down.
  Eigen::Matrix3d hand;
};
struct Leg {
  Eigen::Vector3d hip_m, knee_m, ankle_m;
  Eigen::Matrix3d foot;
};

struct Skeleton {
  Eigen::Matrix3d trunk;   // over the waist
  Eigen::Isometry3d head;  // its middle, on the neck's axis
  std::array<Arm, kSides> arms;
  std::array<Leg, kSides> legs;
};

Skeleton SkeletonOf(const Angles& angles);

}  // namespace musher::world
