#pragma once
// The options of `musher-audio`, as values.

#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "musher/actuator/program/command_line_tool.hpp"

namespace musher::audio::tool {

using program::ExitCode;
using program::ParseEnd;

struct GlobalOptions : program::ToolOptions {
  std::string phrases;  // the table of phrases; empty: the one installed with this program
};

// A text, or a phrase without one.
struct PlayOptions {
  std::optional<std::string> text;
  std::uint16_t play_id = 0;
  bool now = false;  // interrupts what plays, and does not wait
};
struct StopOptions {};
struct VolumeOptions {
  std::optional<int> percent;  // to set it
};
struct PhrasesOptions {};

using CommandOptions = std::variant<PlayOptions, StopOptions, VolumeOptions, PhrasesOptions>;

struct CommandLine {
  GlobalOptions global;
  CommandOptions command;
};

std::variant<CommandLine, ParseEnd> ParseCommandLine(int argc, const char* const* argv);

}  // namespace musher::audio::tool
