#pragma once
// The config of the line walker, a TOML file; config/line_walker/walker.toml explains its keys.

#include <string>
#include <string_view>

#include "musher/base/time.hpp"
#include "musher/base/toml/parsed.hpp"
#include "musher/modules/line_walker/line_walker.hpp"

namespace musher::line_walker {

// Names of topics; relative ones are in the machine's namespace.
struct TopicNames {
  std::string left = "yellow_line_detector/left";
  std::string right = "yellow_line_detector/right";
  std::string front = "yellow_line_detector/front";
  std::string command = "yellow_line_walker/command";
  std::string status = "yellow_line_walker/status";
  std::string odometry = "odom_out";
  std::string servo = "motion_servo_cmd";
  std::string servo_response = "motion_servo_response";

  friend bool operator==(const TopicNames&, const TopicNames&) = default;
};

struct WalkerConfig {
  TopicNames topics;
  double step_height_m = 0.05;
  Duration self_check_time = Milliseconds(5000);  // of the steady clock
  WalkRules walk;

  friend bool operator==(const WalkerConfig&, const WalkerConfig&) = default;
};

// Never throws; an unreadable file is a diagnostic.
Parsed<WalkerConfig> ReadWalkerFile(const std::string& path);

// The same for a text; `path` is what diagnostics refer to.
Parsed<WalkerConfig> ReadWalkerText(std::string_view text, const std::string& path);

}  // namespace musher::line_walker
