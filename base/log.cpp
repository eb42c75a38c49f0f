#include "musher/base/log.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <iostream>

namespace musher {
namespace {

constexpr std::array<std::string_view, 4> kNames = {"debug", "info", "warning", "error"};

// In one piece, so that the lines of several threads, and of processes that share the file, do not
// mix.
void WriteLine(const std::string& line) {
  std::cerr << line << std::flush;
}

LogLevel LevelFromEnvironment() {
  const char* chosen = std::getenv("MUSHER_LOG");
  if (chosen == nullptr || *chosen == '\0') return LogLevel::kInfo;
  const auto level = LogLevelNamed(chosen);
  if (!level) {
    WriteLine("MUSHER_LOG is \"" + std::string(chosen) +
              "\": expected debug, info, warning or error; info is used\n");
  }
  return level.value_or(LogLevel::kInfo);
}

}  // namespace

std::optional<LogLevel> LogLevelNamed(std::string_view name) {
  const auto found = std::find(kNames.begin(), kNames.end(), name);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<LogLevel>(found - kNames.begin());
}

std::string LogLine(LogLevel level, std::string_view name, std::string_view text) {
  const bool has_word =
      level == LogLevel::kError && text.find(": error: ") != std::string_view::npos;
  std::string line(name);
  line += ": ";
  if (level != LogLevel::kInfo && !has_word) {
    line += kNames.at(static_cast<std::size_t>(level));
    line += ": ";
  }
  line += text;
  return line += '\n';
}

LogLevel LowestLogLevel() {
  static const LogLevel lowest = LevelFromEnvironment();
  return lowest;
}

void WriteLog(LogLevel level, std::string_view name, std::string_view text) {
  if (level >= LowestLogLevel()) WriteLine(LogLine(level, name, text));
}

}  // namespace musher
