#pragma once
// When a recorded message is published, what /clock says meanwhile, and under which name. Pure: the
// loop's time is an argument; recorded times are nanoseconds since 1970.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"

namespace musher::view {

// The recording's time while it is played: `from_ns` at `begin`, then `rate` times as fast.
class PlaySchedule {
 public:
  PlaySchedule(Time begin, std::int64_t from_ns, double rate)
      : begin_(begin), from_ns_(from_ns), rate_(rate) {}

  // When a message of that time is due. One from before the beginning is due at once.
  Time DueAt(std::int64_t log_ns) const;
  // The time of the recording now.
  std::int64_t At(Time now) const;

 private:
  Time begin_;
  std::int64_t from_ns_;
  double rate_;
};

// Topics under other names: "/chat:=/old/chat".
class TopicNames {
 public:
  // Fails, naming the rule, unless each is FROM:=TO with two topics' names and no FROM twice.
  static Result<TopicNames> Of(const std::vector<std::string>& rules);

  std::string NameOf(const std::string& topic) const;

 private:
  std::map<std::string, std::string> to_;
};

// Whether a robot would obey what is published there, or take it for another machine's reports: the
// topics of a machine ("/musher/…", "/dog1/musher/…") and the commands and latched states of its
// actuators. Published again only on request.
bool IsOfMachine(std::string_view topic, std::string_view type);

// Whether what reads the topic may move something by it, by its type
// ("geometry_msgs::msg::dds_::Twist_") or the last part of its name: velocities, servo commands,
// trajectories, goals. Measurements, pictures and transforms are only looked at.
bool IsCommand(std::string_view topic, std::string_view type);

// Whether a ROS 2 node of that name ("/rviz2"), or each of "/rqt, /rviz2", is a tool that shows or
// records what it reads.
bool IsViewer(std::string_view nodes);

// Whether a writer of this type ("musher_msgs::msg::dds_::MachineStatus_") belongs to a robot that
// runs: to a controller or an actuator.
bool IsReportOfRobot(std::string_view type);

// "90s", "10m", "2h", "1.5s"; a number alone is seconds.
Result<Duration> DurationFrom(std::string_view text);
// "500M", "2G", "64K"; a number alone is bytes.
Result<std::uint64_t> BytesFrom(std::string_view text);

}  // namespace musher::view
