#pragma once
// The id of an action's goal as text: 32 hexadecimal digits, as in messages, logs and on the
// command line. Any thread.

#include <cstdio>
#include <string>

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

}  // namespace musher::transport
