#pragma once
// The table that shows a switch or a start-up while it is under way: each actuator with its state,
// for how long, and its time limit.

#include <map>
#include <optional>
#include <string>

#include "musher/base/time.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"

namespace musher::cli {

struct ProgressView {
  struct Actuator {
    Duration elapsed{};             // in this state, or on the way to its target
    std::optional<Duration> limit;  // for that way; none: not known
  };

  msg::MachineStatus machine;
  Duration elapsed{};                         // since the machine's switch, or its start, began
  std::map<std::string, Actuator> actuators;  // by name
};

// An actuator, or the machine, is on its way to another state.
bool IsUnderWay(const msg::MachineStatus& machine);
bool IsUnderWay(const msg::ActuatorInfo& actuator);

// What the STATE column shows: "Active", "Active → LowPower", "starting", "absent", …
std::string StateText(const msg::ActuatorInfo& actuator);

// At most `lines` lines, from one on: if there is no room for all actuators, only those that are
// under way; with less than four, only the first line.
std::string ProgressTable(const ProgressView& view, std::size_t lines, bool colour);

}  // namespace musher::cli
