#include "musher/base/log.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "musher/base/date_text.hpp"
#include "musher/base/output_thread.hpp"

namespace musher {
namespace {

constexpr std::array<std::string_view, 4> kNames = {"debug", "info", "warning", "error"};

LogLevel LevelFromEnvironment() {
  const char* chosen = std::getenv("MUSHER_LOG");
  if (chosen == nullptr || *chosen == '\0') return LogLevel::kInfo;
  const auto level = LogLevelNamed(chosen);
  if (!level) {
    StandardError().Write("MUSHER_LOG is \"" + std::string(chosen) +
                          "\": expected debug, info, warning or error; info is used\n");
  }
  return level.value_or(LogLevel::kInfo);
}

bool WantsTime() {
  static const bool wants = [] {
    const char* set = std::getenv("MUSHER_LOG_TIME");  // NOLINT(concurrency-mt-unsafe)
    return set != nullptr && *set != '\0';
  }();
  return wants;
}

// "2026-03-01 13:00:05.250 "
std::string LocalNow() {
  const auto now = std::chrono::system_clock::now();
  const auto seconds = std::chrono::floor<std::chrono::seconds>(now);
  const auto rest = std::chrono::duration_cast<std::chrono::milliseconds>(now - seconds);
  std::array<char, 8> fraction{};
  std::snprintf(fraction.data(), fraction.size(), ".%03d ", static_cast<int>(rest.count()));
  return FormatLocal(seconds, "%Y-%m-%d %H:%M:%S") + fraction.data();
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

std::string TextOfLogLine(std::string_view line, std::string_view name) {
  constexpr std::string_view kTime = "dddd-dd-dd dd:dd:dd.ddd ";
  const auto fits = [](char c, char p) { return p == 'd' ? c >= '0' && c <= '9' : c == p; };
  if (line.size() < kTime.size() || !std::equal(kTime.begin(), kTime.end(), line.begin(),
                                                [&](char p, char c) { return fits(c, p); })) {
    return std::string(line);
  }
  line.remove_prefix(kTime.size());
  const auto drop = [&line](std::string_view word) {
    if (!line.starts_with(word) || !line.substr(word.size()).starts_with(": ")) return false;
    line.remove_prefix(word.size() + 2);
    return true;
  };
  if (!name.empty()) drop(name);
  for (const std::string_view level : kNames) {
    if (drop(level)) break;
  }
  return std::string(line);
}

LogLevel LowestLogLevel() {
  static const LogLevel lowest = LevelFromEnvironment();
  return lowest;
}

void WriteLog(LogLevel level, std::string_view name, std::string_view text) {
  if (level < LowestLogLevel()) return;
  StandardError().Write((WantsTime() ? LocalNow() : "") + LogLine(level, name, text));
}

}  // namespace musher
