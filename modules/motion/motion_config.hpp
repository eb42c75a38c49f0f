#pragma once
// The motion manager's own config file (config/motion/motion_manager.toml explains every key).

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "musher/base/network_profile.hpp"
#include "musher/base/time.hpp"
#include "musher/base/toml/parsed.hpp"
#include "musher/modules/motion/motion_source.hpp"

namespace musher::motion {

enum class BoardKind {
  kTopic,  // world/body_command and world/body_state: a simulated body
  kLcm,    // a motion board on LCM, as that of a CyberDog 2
};

struct LcmConfig {
  std::string command_url = "udpm://239.255.76.67:7671";
  std::string response_url = "udpm://239.255.76.67:7670";
  std::string localization_url = "udpm://239.255.76.67:7667";
  std::string network_interface;  // to the board; empty: that of the route
  int ttl = 1;                    // of commands; 0: to a board on this computer
  std::string board;              // its IPv4 address; empty: the first host that responds

  friend bool operator==(const LcmConfig&, const LcmConfig&) = default;
};

// A frame that is fixed on another one, such as that of a lidar on the body.
struct Mount {
  std::string frame;
  std::string parent;
  std::array<double, 3> xyz_m{};    // of its origin, in the parent
  std::array<double, 3> rpy_rad{};  // roll, pitch and yaw, about the fixed axes of the parent

  friend bool operator==(const Mount&, const Mount&) = default;
};

// What it publishes on /tf and /tf_static.
struct TfConfig {
  bool publish = false;  // the odometry: from `odom` to `base`
  std::string odom = "odom";
  std::string base = "base_link";
  std::vector<Mount> mounts;

  friend bool operator==(const TfConfig&, const TfConfig&) = default;
};

struct MotionConfig {
  std::string motions;  // the file of the motion id table, absolute
  std::string gaits;    // the folder of the gaits of users, absolute
  Priorities priorities = DefaultPriorities();
  BoardKind board = BoardKind::kTopic;
  LcmConfig lcm;
  TfConfig tf;
  Duration board_wait = Milliseconds(10'000);   // how long SetUp waits for the first report
  Duration board_silent = Milliseconds(500);    // timeout without a report
  Duration board_feedback = Milliseconds(200);  // within which a command must be taken

  friend bool operator==(const MotionConfig&, const MotionConfig&) = default;
};

// What is unsafe about it with this clock of the machine; nullopt: nothing.
std::optional<std::string> WarningOfClock(const MotionConfig& config, ClockSource clock);

// Never throws; an unreadable file is a diagnostic.
Parsed<MotionConfig> ReadMotionConfigFile(const std::string& path);
// The same for a text; `path` is what diagnostics and relative paths refer to.
Parsed<MotionConfig> ReadMotionConfigText(std::string_view text, const std::string& path);

}  // namespace musher::motion
