#pragma once
// What a person can ask of `musher-audio`, as values.

#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "musher/modules/program/command_line_tool.hpp"

namespace musher::audio::tool {

using program::ExitCode;
using program::ParseEnd;

struct GlobalOptions : program::HandOptions {
  std::string phrases;  // the table of phrases; empty: the one beside this program
};

// A text, or a phrase where there is none.
struct PlayOptions {
  std::optional<std::string> text;
  std::uint16_t play_id = 0;
  bool now = false;  // takes the place of what plays, and does not wait
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
