#pragma once
// Checks that the recording of a robot's controllers replays to the same decisions: as a whole, and
// from each snapshot on.

#include "musher/simulation/robot.hpp"

namespace musher::testing {

// Fails the test at a difference. All inputs are encoded and decoded first.
void ExpectReplaysTheSame(const simulation::SimRobot& robot);

}  // namespace musher::testing
