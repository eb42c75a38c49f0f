#pragma once
// Drives a robot a short path towards a point that is out of its reach by little: it turns on the
// spot, then drives forward slowly, without a plan. It needs a scan, and stops for an obstacle
// ahead.
//
// Metres; in the frame of the map.

#include "musher/base/result.hpp"
#include "musher/modules/skills/robot/robot.hpp"

namespace musher::skills {

// Sends the command of this step. Fails, with the motion stopped, when the robot must not go on:
// no odometry, no scan, an obstacle ahead, at the point, or `most_m` away from `start`. Points
// within 0.3 m of the target belong to what stands there.
Result<> NudgeTowards(Robot& robot, const navigation::Point& target, const navigation::Point& start,
                      double most_m);

}  // namespace musher::skills
