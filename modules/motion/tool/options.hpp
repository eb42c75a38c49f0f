#pragma once
// What a person can ask of `musher-motion`, as values.

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "musher/modules/motion/motion_command.hpp"
#include "musher/modules/program/command_line_tool.hpp"

namespace musher::motion::tool {

using program::ExitCode;
using program::ParseEnd;

struct GlobalOptions : program::HandOptions {
  std::string motions;  // the file of the motion id table; empty: the one beside this program
};

struct ResultOptions {
  MotionOrder order;
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
