#pragma once
// The skills of a robot: all skills of the program, which of them this kind of robot has by the
// skill config, and their limits.

#include <functional>
#include <optional>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/behavior/skill/registry.hpp"
#include "musher/modules/skills/config/skills_config.hpp"
#include "musher/modules/skills/robot/robot.hpp"

namespace musher::skills {

using RegisterFunction = std::function<Result<>(skill::Registry&, Robot&)>;

struct LoadedSkills {
  std::optional<std::vector<skill::Entry>> entries;  // nothing where there are errors
  std::vector<Diagnostic> diagnostics;
};

// Without a skill config: all skills, as they declare themselves. The robot must outlive the
// entries.
LoadedSkills LoadSkills(const SkillsConfig& config, Robot& robot, const RegisterFunction& add);

}  // namespace musher::skills
