#pragma once
// The options of `musher-motion`, as values.

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "musher/actuator/program/command_line_tool.hpp"
#include "musher/modules/motion/motion_command.hpp"

namespace musher::motion::tool {

using program::ExitCode;
using program::ParseEnd;

struct GlobalOptions : program::ToolOptions {
  std::string
      motions;  // the file of the motion id table; empty: the one installed with this program
};

struct ResultOptions {
  MotionRequest requested;
  std::int32_t source = 0;
};
struct ServoOptions {
  std::int32_t id = kUserTrot;
  std::int32_t source = 0;
  SpeedLimit speed{};  // x, y in m/s, yaw in rad/s
  double seconds = 1;
};
struct WalkOptions {
  double square_m = 1;
  double speed = 0.3;  // m/s
  std::int32_t source = 0;
};
struct StatusOptions {};
struct ListOptions {};

using CommandOptions =
    std::variant<ResultOptions, ServoOptions, WalkOptions, StatusOptions, ListOptions>;

struct CommandLine {
  GlobalOptions global;
  CommandOptions command;
};

std::variant<CommandLine, ParseEnd> ParseCommandLine(int argc, const char* const* argv);

}  // namespace musher::motion::tool
