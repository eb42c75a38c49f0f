#pragma once
// The config of the planner, a TOML file; config/meilin/planner.toml explains its keys.

#include <string>
#include <string_view>

#include "musher/base/time.hpp"
#include "musher/base/toml/parsed.hpp"
#include "musher/modules/meilin/plan/route_search.hpp"

namespace musher::meilin {

// Relative names are in the machine's namespace.
struct PlannerTopics {
  std::string map = "mf_r2_data";
  std::string paths = "planning/paths_for_web";
  std::string plan = "mf_action_seq";
  std::string command = "planning/command";
  std::string last_error = "planning/last_error";
  std::string buffer_status = "mf_buffer_status";
  std::string buffer_service = "get_action_seq";
};

struct PlannerConfig {
  PlannerTopics topics;
  RouteRules rules;
  Duration auto_send{};  // after a map; 0: only on command
};

// Never throws; an unreadable file is a diagnostic.
Parsed<PlannerConfig> ReadPlannerFile(const std::string& path);
// The same for a text; `path` is what diagnostics refer to.
Parsed<PlannerConfig> ReadPlannerText(std::string_view text, const std::string& path);

}  // namespace musher::meilin
