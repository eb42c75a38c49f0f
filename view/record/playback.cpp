#include "musher/view/record/playback.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>

#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"

namespace musher::view {
namespace {

// The number at the beginning of `text` and what follows it.
struct Measure {
  double number = 0;
  std::string unit;
};

std::optional<Measure> MeasureFrom(std::string_view text) {
  const auto is_of_number = [](char c) {
    return std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '.';
  };
  const std::string all(text);
  const auto end = std::find_if_not(all.begin(), all.end(), is_of_number);
  const std::string number(all.begin(), end);
  if (number.empty() || std::count(number.begin(), number.end(), '.') > 1 || number == ".") {
    return std::nullopt;
  }
  return Measure{std::strtod(number.c_str(), nullptr), std::string(end, all.end())};
}

bool IsTopic(std::string_view name) {
  if (name.empty() || name.ends_with('/') || name.find("//") != std::string_view::npos) {
    return false;
  }
  return std::all_of(name.begin(), name.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '/';
  });
}

std::string Absolute(std::string_view name) {
  return name.starts_with('/') ? std::string(name) : "/" + std::string(name);
}

}  // namespace

Time PlaySchedule::DueAt(std::int64_t log_ns) const {
  const auto ahead = static_cast<double>(std::max<std::int64_t>(log_ns - from_ns_, 0));
  return begin_ + Duration(static_cast<std::int64_t>(std::llround(ahead / rate_)));
}

std::int64_t PlaySchedule::At(Time now) const {
  const auto passed = static_cast<double>(std::max((now - begin_).count(), Duration::rep{0}));
  return from_ns_ + static_cast<std::int64_t>(std::llround(passed * rate_));
}

Result<TopicNames> TopicNames::Of(const std::vector<std::string>& rules) {
  TopicNames remapping;
  for (const std::string& rule : rules) {
    const std::size_t at = rule.find(":=");
    const std::string from = at == std::string::npos ? "" : rule.substr(0, at);
    const std::string to = at == std::string::npos ? "" : rule.substr(at + 2);
    if (!IsTopic(from) || !IsTopic(to)) {
      return Error{kCodeParametersInvalid,
                   "invalid remapping '" + rule + "'; expected FROM:=TO, as in /chat:=/old/chat"};
    }
    if (!remapping.to_.emplace(Absolute(from), Absolute(to)).second) {
      return Error{kCodeParametersInvalid, "two remappings of the topic " + Absolute(from)};
    }
  }
  return remapping;
}

std::string TopicNames::NameOf(const std::string& topic) const {
  const auto found = to_.find(topic);
  return found == to_.end() ? topic : found->second;
}

bool IsOfMachine(std::string_view topic, std::string_view type) {
  if (topic.starts_with("/musher/") || topic.find("/musher/") != std::string_view::npos)
    return true;
  return type.starts_with("musher_msgs/msg/ActuatorCommand") ||
         type.starts_with("musher_msgs/msg/ActuatorStatus") ||
         type.starts_with("musher_msgs/msg/EmergencyStop");
}

bool IsCommand(std::string_view topic, std::string_view type) {
  constexpr std::string_view kTypes[] = {
      "geometry_msgs::msg::dds_::Twist_",
      "geometry_msgs::msg::dds_::TwistStamped_",
      "ackermann_msgs::msg::dds_::AckermannDrive_",
      "ackermann_msgs::msg::dds_::AckermannDriveStamped_",
      "trajectory_msgs::msg::dds_::JointTrajectory_",
      "trajectory_msgs::msg::dds_::MultiDOFJointTrajectory_",
      "control_msgs::msg::dds_::JointJog_",
      "actuator_msgs::msg::dds_::Actuators_",
      "mavros_msgs::msg::dds_::PositionTarget_",
      "mavros_msgs::msg::dds_::AttitudeTarget_",
      "mavros_msgs::msg::dds_::OverrideRCIn_",
      "protocol::msg::dds_::MotionServoCmd_",
  };
  if (std::ranges::find(kTypes, type) != std::end(kTypes)) return true;
  const std::string_view name = topic.substr(topic.rfind('/') + 1);
  constexpr std::string_view kNames[] = {"cmd", "command", "commands", "joint_trajectory",
                                         "goal_pose"};
  constexpr std::string_view kEnds[] = {"_cmd", "_command", "_commands"};
  return name.starts_with("cmd_") || std::ranges::find(kNames, name) != std::end(kNames) ||
         std::ranges::any_of(kEnds, [&](std::string_view end) { return name.ends_with(end); });
}

bool IsViewer(std::string_view nodes) {
  constexpr std::string_view kNext = ", ";
  if (const auto next = nodes.find(kNext); next != std::string_view::npos) {
    return IsViewer(nodes.substr(0, next)) && IsViewer(nodes.substr(next + kNext.size()));
  }
  if (nodes.find(' ') != std::string_view::npos) return false;  // "/rviz2 and 2 more"
  const std::string_view name = nodes.substr(nodes.rfind('/') + 1);
  constexpr std::string_view kBegins[] = {"rviz", "rqt", "foxglove_bridge", "plotjuggler",
                                          "rosbag2_recorder"};
  return std::ranges::any_of(kBegins,
                             [&](std::string_view begin) { return name.starts_with(begin); });
}

bool IsReportOfRobot(std::string_view type) {
  return type == msg::MachineStatus::kTypeName || type == msg::ActuatorStatus::kTypeName;
}

Result<Duration> DurationFrom(std::string_view text) {
  const auto measure = MeasureFrom(text);
  double seconds = 0;
  bool good = measure.has_value();
  if (good) {
    const std::string& unit = measure->unit;
    const double factor = unit.empty() || unit == "s" ? 1
                          : unit == "ms"              ? 0.001
                          : unit == "m"               ? 60
                          : unit == "h"               ? 3600
                          : unit == "d"               ? 86'400
                                                      : 0;
    seconds = measure->number * factor;
    good = seconds > 0 && seconds <= 1e8;
  }
  if (!good) {
    return Error{kCodeParametersInvalid,
                 "invalid duration '" + std::string(text) +
                     "'; expected a number with a unit, as in 90s, 10m, 2h"};
  }
  return Duration(static_cast<std::int64_t>(seconds * 1e9));
}

Result<std::uint64_t> BytesFrom(std::string_view text) {
  const auto measure = MeasureFrom(text);
  double bytes = 0;
  bool good = measure.has_value();
  if (good) {
    const std::string& unit = measure->unit;
    const double factor = unit.empty()  ? 1
                          : unit == "K" ? 1024.0
                          : unit == "M" ? 1024.0 * 1024
                          : unit == "G" ? 1024.0 * 1024 * 1024
                                        : 0;
    bytes = measure->number * factor;
    good = bytes >= 1 && bytes < 1e18;
  }
  if (!good) {
    return Error{kCodeParametersInvalid, "invalid size '" + std::string(text) +
                                             "'; expected a number with K, M or G, as in 500M"};
  }
  return static_cast<std::uint64_t>(bytes);
}

}  // namespace musher::view
