#pragma once
// All skills of the program musher-skills.

#include "musher/behavior/skill/registry.hpp"
#include "musher/modules/skills/robot/robot.hpp"

namespace musher::skills {

// The robot must outlive the registry and its skills.
Result<> RegisterSkills(skill::Registry& registry, Robot& robot);

}  // namespace musher::skills
