#pragma once
// The looks of a humanoid from outside: white limbs, dark joints, a visor as face, drawn at its
// joints. Pure.

#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "musher/modules/world/body/humanoid_kinematics.hpp"
#include "musher/modules/world/render/scenery.hpp"

namespace musher::world {

// The stance of a humanoid.
struct HumanoidStance {
  Angles angles{};
  std::array<HandShape, kSides> hands{};
  double trunk_m = kTrunkM;  // its middle over the ground, upright
};

// Adds its parts. A camera on the robot itself may only see its arms, not the inside of its head.
void StandRobot(const HumanoidStance& stance, const Eigen::Isometry3d& body_in_place,
                bool arms_only, std::vector<Thing>& things);

}  // namespace musher::world
