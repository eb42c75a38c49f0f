#pragma once
// The id of an action's goal as text: 32 hexadecimal digits, as in messages, logs and on the
// command line. Any thread.

#include <charconv>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>

#include "musher/transport/action_goals.hpp"

namespace musher::transport {

inline std::string GoalIdText(const GoalId& id) {
  std::string text;
  char digits[3];
  for (const std::uint8_t byte : id) {
    std::snprintf(digits, sizeof digits, "%02x", byte);
    text += digits;
  }
  return text;
}

// nullopt: another text.
inline std::optional<GoalId> ReadGoalId(std::string_view text) {
  GoalId id{};
  if (text.size() != 2 * id.size()) return std::nullopt;
  for (std::size_t i = 0; i < id.size(); ++i) {
    const char* const begin = text.data() + 2 * i;
    const auto [stop, error] = std::from_chars(begin, begin + 2, id.at(i), 16);
    if (error != std::errc() || stop != begin + 2) return std::nullopt;
  }
  return id;
}

}  // namespace musher::transport
