#include "musher/behavior/skill/feedback.hpp"

#include <array>

namespace musher::skill {

std::string_view Name(Status status) {
  constexpr std::array<std::string_view, 4> kNames{"processing", "completed", "failed",
                                                   "cancelled"};
  return kNames[static_cast<std::size_t>(status)];
}

std::string MessageText(const Feedback& feedback) {
  if (!feedback.paused) return feedback.message;
  return feedback.message.empty() ? "paused" : "paused: " + feedback.message;
}

std::string ToText(const Feedback& feedback) {
  return std::string(Name(feedback.status)) + ": " + MessageText(feedback) + " (" +
         std::to_string(feedback.progress) + "%)";
}

}  // namespace musher::skill
