#pragma once
// The fixed values of a match, a JSON file: where the robot stands to take and to dock the spear,
// where the rack is, and time limits. See config/meilin/match_blue.json.
//
//   {"match_side": "blue", "prepare": {"align": {"target_x": 1.0, ...}, ...}, "final": {...}}
//
// Each number becomes an entry of the blackboard: prepare_align_target_x. All sections and their
// values are required, other keys are errors. Lengths: m, angles: rad, speeds: m/s, limits: s,
// heights: mm. All errors are reported at once, each with the file and the path in the JSON.
// Pure; any thread.

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/modules/meilin/field/grid.hpp"

namespace musher::meilin {

struct MatchConfig {
  std::optional<Side> side;  // of match_side; it overrides meilin_side
  std::vector<std::pair<std::string, double>> entries;
};

struct MatchReading {
  std::optional<MatchConfig> config;
  std::vector<std::string> errors;  // "match.json: prepare.dock: missing; expected ..."
};

MatchReading ReadMatchText(std::string_view text, const std::string& file);
MatchReading ReadMatchFile(const std::string& path);

}  // namespace musher::meilin
