#pragma once
// Lines of log files: their time and level, several logs as one, and how they are shown. Pure.
//
// A line begins with a time if a process of Musher wrote it (MUSHER_LOG_TIME), or a ROS 2 node, or
// a program with a usual pattern:
//
//   2026-03-01 13:00:05.250 gripper: warning: the jaw is at 71 °C
//   2026-03-01 13:00:05.250 info: the machine is Active
//   [WARN] [1772366405.250000000] [talker]: slow
//   [2026-03-01 13:00:05.250] [legs] [warning] hot
//
// Other lines have the time at which they were written, as far as it is known (log_times.hpp), and
// the level of the line before them if they are indented.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/log.hpp"
#include "musher/controller/storage/log_reader.hpp"

namespace musher::cli {

struct LogEntry {
  std::string source;        // the actuator, or "controller"
  std::int64_t wall_ns = 0;  // since 1970: its own time, else when it was written; 0: not known
  LogLevel level = LogLevel::kInfo;
  std::string text;  // without time, and without the name of the source where it begins with it

  friend bool operator==(const LogEntry&, const LogEntry&) = default;
};

// Reads the lines of one log in their order.
class LogLines {
 public:
  explicit LogLines(std::string source) : source_(std::move(source)) {}

  LogEntry Take(const WrittenLine& line);

 private:
  std::string source_;
  LogLevel level_ = LogLevel::kInfo;
};

std::vector<LogEntry> LogEntriesOf(const std::string& source,
                                   const std::vector<WrittenLine>& lines);

// All entries by time; each log keeps its order. An entry without a time comes with the next one of
// its log that has one.
std::vector<LogEntry> Merge(std::vector<std::vector<LogEntry>> logs);

// Which entries are shown.
struct LogFilter {
  std::int64_t since_ns = 0;  // entries without a time stay
  LogLevel level = LogLevel::kDebug;

  bool Shows(const LogEntry& entry) const {
    return entry.level >= level && (entry.wall_ns == 0 || entry.wall_ns >= since_ns);
  }
};

// One line; `width` of the column of sources, 0: without it.
std::string LogText(const LogEntry& entry, std::size_t width, bool colour);
std::string LogJson(const LogEntry& entry);

}  // namespace musher::cli
