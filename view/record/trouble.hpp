#pragma once
// What counts as trouble, for a recorder that keeps the minutes around it. Pure.

#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "musher/messages/musher_msgs/machine_status.hpp"

namespace musher::view {

// Finds what went wrong between one status and the next. What is wrong in the first status is old,
// not new trouble.
class TroubleWatch {
 public:
  // A short word for a file's name: "emergency-stop", "audio-crashed", "error", "audio-degraded".
  std::optional<std::string> On(const msg::MachineStatus& status);

 private:
  bool first_ = true;
  bool stopped_ = false;
  std::string state_;
  std::map<std::string, std::string> health_;  // of actuators
  std::set<std::string> degraded_;
};

// The same of an event of the journal (see "Events of records" in the reference): a switch that was
// undone or refused.
std::optional<std::string> TroubleOf(std::string_view event);

}  // namespace musher::view
