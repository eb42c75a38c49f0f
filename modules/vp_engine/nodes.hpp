#pragma once
// The nodes of programs, beside those of BehaviorTree.CPP 4:
//
//   Say           text                                       the robot speaks, to the end
//   MotionResult  motion_id, duration_ms, forwards_mps,      one motion of the body, to its end
//                 left_mps, turn_radps
//   Led           target, effect, red, green, blue           a light in a colour
//   LedRelease    target                                     the light is the robot's again
//   WaitSeconds   seconds
//
// The first four have the output `error`, a text: "" or why the robot has not done it. They fail
// then.

#include "musher/base/result.hpp"
#include "musher/behavior/tree/factory.hpp"
#include "musher/modules/vp_engine/robot.hpp"

namespace musher::vp_engine {

// The robot must outlive the trees.
Result<> AddNodes(tree::Factory& factory, Robot& robot);

}  // namespace musher::vp_engine
