#pragma once
// What the detectors of one hall have in common: its colours, its light, the measures of its lanes
// and lines, and where the cameras are on the body. The tables [hall] and [[mounts]] of the config;
// each detector may still have a colour and a region of its own.

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/table_reader.hpp"
#include "musher/modules/vision/course/color_mask.hpp"
#include "musher/modules/vision/course/line_pieces.hpp"
#include "musher/modules/vision/course/white_balance.hpp"

namespace musher::vision {

struct Hall {
  std::optional<HsvRange> yellow;         // of lines, markers and lights
  std::optional<HsvRange> green;          // of arrows
  std::optional<HsvRange> red;            // of bars
  std::optional<WhiteBalance> balance;    // of all cameras
  std::map<std::string, Region> regions;  // by the kind that searches there, see RegionKeyOf()
  double lane_m = 0.88;                   // between the middles of a lane's two lines
  double least_line_m = 0.02;             // the width of a line
  double most_line_m = 0.1;
  std::map<std::string, Mount> mounts;  // by the topic of the camera's picture

  // "yellow", "green" or "red".
  bool HasColor(std::string_view name) const {
    return name == "yellow"  ? yellow.has_value()
           : name == "green" ? green.has_value()
                             : red.has_value();
  }
};

Hall ReadHall(config_toml::TableReader& root, config_toml::Findings& findings);

// A table { from = [hue, saturation, value], to = [...] }. Returns whether there is one.
bool ReadColor(config_toml::TableReader& reader, std::string_view key, HsvRange& range,
               config_toml::Findings& findings);

// A table { top = …, bottom = …, left = …, right = … }; what it does not say stays. Returns whether
// there is one.
bool ReadRegion(config_toml::TableReader& reader, std::string_view key, Region& region,
                config_toml::Findings& findings);
// The same of the table itself, whose keys stand at `path`.
void ReadRegion(const config_toml::Table& table, config_toml::Position at, const std::string& path,
                Region& region, config_toml::Findings& findings);

}  // namespace musher::vision
