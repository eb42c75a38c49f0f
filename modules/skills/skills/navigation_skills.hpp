#pragma once
// The moving skills of a robot: navigate_to, nav_2d, nav_3d, move, track, explore, follow_line and
// avoid_obstacle, and its recoveries leave_tight_start, clear, back_up and spin. Their headers
// explain their parameters, states and limits. Which of them a kind of robot has is a config
// (behavior/skill/toml/skills_toml.hpp).

#include "musher/base/result.hpp"
#include "musher/behavior/skill/registry.hpp"
#include "musher/modules/skills/robot/robot.hpp"

namespace musher::skills {

// `robot` has to outlive the registry and what is made from it. Fails for a name that is taken.
Result<> RegisterNavigationSkills(skill::Registry& registry, Robot& robot);

}  // namespace musher::skills
