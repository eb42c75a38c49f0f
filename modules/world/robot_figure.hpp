#pragma once
// What a humanoid looks like from outside: white limbs, dark joints, a visor for a face, drawn
// where its joints are. Pure.

#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "musher/modules/world/humanoid_kinematics.hpp"
#include "musher/modules/world/scenery.hpp"

namespace musher::world {

// How a humanoid stands at a moment.
struct HumanoidStance {
  Angles angles{};
  std::array<HandShape, kSides> hands{};
  double trunk_m = kTrunkM;  // its middle over the ground, upright
};

// Adds its parts. Those that a camera on the robot itself may have in view are its arms; the inside
// of its head is none of them.
void StandRobot(const HumanoidStance& stance, const Eigen::Isometry3d& body_in_place,
                bool arms_only, std::vector<Thing>& things);

}  // namespace musher::world
