#pragma once
// The log of a process: lines on standard error, each with a level. The controller keeps what its
// actuators write in `logs/<actuator>.log`, systemd in its journal.
//
//   gripper: grips the cup
//   gripper: warning: the jaw is at 71 °C
//
// MUSHER_LOG=debug|info|warning|error in the environment is the lowest level that is written; info
// if it is not set. With MUSHER_LOG_TIME each line begins with the local time; the controller sets
// it for the processes that it starts.
//
//   2026-03-01 13:00:05.250 gripper: warning: the jaw is at 71 °C
//
// Threads: any.

#include <optional>
#include <string>
#include <string_view>

namespace musher {

enum class LogLevel {
  kDebug,    // for the developer of the module; off by default
  kInfo,     // what the program does
  kWarning,  // what needs attention, while the program does its work
  kError,    // what the program cannot do
};

// The level of that name ("debug", "info", "warning", "error"); nullopt for any other text.
std::optional<LogLevel> LogLevelNamed(std::string_view name);

// "gripper: warning: the jaw is at 71 °C\n". Info has no word, nor an error whose text has
// one of its own after a place in a file ("robot.toml:3:7: error: ").
std::string LogLine(LogLevel level, std::string_view name, std::string_view text);

// What a line of WriteLog() that begins with the time says, without the time, this name and the
// word of the level; another line stays as it is.
std::string TextOfLogLine(std::string_view line, std::string_view name);

// The lowest level that is written, as read from the environment once; another value than the four
// is reported and counts as info.
LogLevel LowestLogLevel();

// Writes the line of the program or actuator `name` in one piece, if its level is written.
void WriteLog(LogLevel level, std::string_view name, std::string_view text);

}  // namespace musher
