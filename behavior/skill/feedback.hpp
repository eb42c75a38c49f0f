#pragma once
// What a skill reports while it runs and at its end.

#include <cstdint>
#include <string>
#include <string_view>

#include "musher/behavior/skill/value.hpp"

namespace musher::skill {

enum class Status : std::uint8_t { kProcessing, kCompleted, kFailed, kCancelled };
std::string_view Name(Status status);  // "processing", "completed", "failed", "cancelled"

struct Feedback {
  Status status = Status::kProcessing;
  std::string state;  // "EXECUTING"; of a skill that runs skills "RUNNING/take_off/EXECUTING"
  int progress = 0;   // in percent; 100 if and only if it is completed
  std::string message;
  Values details;       // of the last step: distance_to_goal, ...
  bool paused = false;  // its run is not stepped; status is kProcessing

  friend bool operator==(const Feedback&, const Feedback&) = default;
};

// "Planning the path"; of a paused run "paused: Planning the path".
std::string MessageText(const Feedback& feedback);
// "processing: Planning the path (30%)".
std::string ToText(const Feedback& feedback);

}  // namespace musher::skill
