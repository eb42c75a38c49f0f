#pragma once
// A plan for several robots as a TOML file, for `musher skill plan`:
//
//   [[step]]                                           # all robots of a step start together
//   jetbot_0 = { skill = "nav_2d", goal_pos = [5.6, 1.5, 0] }
//   cf2x_0 = { skill = "take_off", altitude = 1.2 }
//
//   [[step]]                                           # begins once the step before is done
//   cf2x_0 = { skill = "land" }
//
// A step has a robot as a key, with the name of its skill and the parameters. Pure, apart from the
// file. All errors are reported at once, with line and column.

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/base/toml/document.hpp"
#include "musher/messages/musher_msgs/skill_feedback.hpp"
#include "musher/messages/plan_msgs/plan.hpp"

namespace musher::cli {

struct PlanFile {
  struct Parameter {
    std::string key;
    std::string value;  // as text: "2.0", "[10, 20, 0]", "car"
    config_toml::Position at;

    friend bool operator==(const Parameter& a, const Parameter& b) {
      return a.key == b.key && a.value == b.value;
    }
  };
  struct Member {
    std::string robot;
    std::string skill;
    config_toml::Position at;  // of the skill's name
    std::vector<Parameter> parameters;
  };
  std::vector<std::vector<Member>> steps;
};

struct PlanFileReading {
  std::optional<PlanFile> plan;  // present exactly when no diagnostic is an error
  std::vector<Diagnostic> diagnostics;
};

PlanFileReading ReadPlanFile(const std::string& path);
// The same for a text; `path` is what diagnostics refer to.
PlanFileReading ReadPlanText(std::string_view text, const std::string& path);

// Errors in the skills and the keys of parameters of those robots whose skills are offered:
// unknown ones, with the nearest, and a missing one that is required.
std::vector<Diagnostic> CheckPlanFile(const PlanFile& plan,
                                      const std::vector<msg::SkillOffers>& offers,
                                      const std::string& path);

// Its steps are numbered from 1.
msg::SkillPlan ToMessage(const PlanFile& plan);

}  // namespace musher::cli
