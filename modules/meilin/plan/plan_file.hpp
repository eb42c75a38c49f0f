#pragma once
// A plan that a person writes, a TOML file. Heights and, where they are missing, yaws come from the
// field:
//
//   side = "blue"       # or "red"; default "blue"
//   start = [0, 0]      # row and column before the first step; default [0, 0]
//   start_yaw_deg = 0
//
//   [[step]]
//   move = [1, 0]       # yaw_deg: by default the robot keeps its heading
//   [[step]]
//   fetch = [2, 0]      # yaw_deg: by default towards the box
//
// Pure but for ReadPlanFile(); functions never throw.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/modules/meilin/plan/action_sequence.hpp"

namespace musher::meilin {

struct DrawnPlan {
  Side side = Side::kBlue;
  PlanStart start;
  std::vector<PlanStep> steps;  // ToActionSequence() makes the message
};

struct DrawnPlanReading {
  std::optional<DrawnPlan> plan;        // present exactly when no diagnostic is an error
  std::vector<Diagnostic> diagnostics;  // by line; also what ReadActionSequence() refuses
};

// `rules` except for the side, which the text has. `path` is what diagnostics refer to.
DrawnPlanReading ReadPlanText(std::string_view text, const std::string& path,
                              const PlanRules& rules = {});
DrawnPlanReading ReadPlanFile(const std::string& path, const PlanRules& rules = {});

}  // namespace musher::meilin
