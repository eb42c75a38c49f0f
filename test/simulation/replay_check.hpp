#pragma once
// What a robot's controllers recorded leads to the very same decisions when it is replayed: as a
// whole, and from each snapshot on.

#include "musher/simulation/robot.hpp"

namespace musher::testing {

// Fails the test otherwise. All inputs go through their encoding.
void ExpectReplaysTheSame(const simulation::SimRobot& robot);

}  // namespace musher::testing
