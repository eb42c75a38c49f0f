#pragma once
// The options of `musher-camera`, as values.

#include <string>
#include <variant>
#include <vector>

#include "musher/actuator/program/command_line_tool.hpp"

namespace musher::camera::tool {

using program::ExitCode;
using program::ParseEnd;
using program::ToolOptions;

struct ListOptions {
  std::vector<std::string> topics;  // empty: those of a CyberDog
  double seconds = 2;
};
struct ShotOptions {
  std::string topic;
  std::string file;
  double timeout_s = 10;
};
struct StripOptions {
  std::string topic;
  std::string file;
  double every_s = 2;   // of the pictures' own time
  std::string changes;  // a topic of texts: a picture `every_s` after each change; empty: none
  std::vector<std::string> beside;  // topics of further cameras, beside the first in each tile
  bool on_demand = false;           // subscribes to the pictures only until a change has its own
  int count = 8;
  int columns = 0;     // 0: as many as pictures, up to 8
  int width_px = 320;  // of one picture
  double timeout_s = 30;
};
struct WatchOptions {
  std::string topic;
  double seconds = 0;  // 0: until Ctrl-C
  double timeout_s = 10;
};

using CommandOptions = std::variant<ListOptions, ShotOptions, StripOptions, WatchOptions>;

struct CommandLine {
  ToolOptions global;
  CommandOptions command;
};

std::variant<CommandLine, ParseEnd> ParseCommandLine(int argc, const char* const* argv);

}  // namespace musher::camera::tool
