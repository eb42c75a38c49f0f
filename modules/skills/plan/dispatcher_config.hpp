#pragma once
// The config of musher-plan-dispatcher, a TOML file; every key is explained in
// config/skills/plan_dispatcher.toml. All errors are reported at once, with line and column.

#include <string>
#include <string_view>

#include "musher/base/toml/parsed.hpp"
#include "musher/modules/skills/plan/plan_run.hpp"

namespace musher::skills {

struct DispatcherConfig {
  std::string action = "plan_execution";         // that it serves
  std::string robot_action = "skill_execution";  // below the robot's name
  PlanRules rules;
};

// Never throws; an unreadable file is a diagnostic.
Parsed<DispatcherConfig> ReadDispatcherFile(const std::string& path);
// The same for a text; `path` is what diagnostics refer to.
Parsed<DispatcherConfig> ReadDispatcherText(std::string_view text, const std::string& path);

}  // namespace musher::skills
