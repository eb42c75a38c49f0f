#pragma once
// The config of musher-meilin: names, the field, limits. A TOML file; config/meilin/mission.toml
// explains every key. The keys are the parameters of the competition's system, with their units.
//
// Reading reports all errors at once, with line and column. Pure; any thread.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "musher/base/toml/parsed.hpp"
#include "musher/modules/meilin/nodes/settings.hpp"

namespace musher::meilin {

struct MissionConfig {
  std::string file;
  double tick_frequency_hz = 100;
  std::uint16_t groot2_port = 0;  // 0: Groot2 cannot connect
  bool groot2_hooks = false;      // it may hold and replace nodes
  std::string record;             // relative to the machine's state_dir; empty: none
  std::size_t record_mib = 16;
  std::string tree_file;     // absolute
  std::string match_config;  // absolute; empty: none
  std::string segment_topic = "planning/segments";
  std::string action_topic = "mf_action_seq";
  std::string buffer_service = "get_action_seq";
  bool plan_service = false;  // plans are requested from it, too
  std::string pose_topic = "transformed/pose";
  std::string chassis_topic = "r0x0201";
  std::array<std::size_t, 4> wheel_order = {0, 1, 2, 3};
  std::string map_topic = "mf_r2_data";
  bool autostart = false;   // a robot outside the field begins by itself
  double self_check_s = 5;  // real time, for servers to be found
  Settings settings;
};

Parsed<MissionConfig> ReadMissionText(std::string_view text, const std::string& path);
Parsed<MissionConfig> ReadMissionFile(const std::string& path);

}  // namespace musher::meilin
