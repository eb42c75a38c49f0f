#pragma once
// What a person can ask of `musher-motion`, as values.

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "musher/modules/motion/motion_command.hpp"

namespace musher::motion::tool {

enum class ExitCode : int {
  kDone = 0,
  kNotDone = 1,  // refused, failed, or nobody answered
  kUsage = 2,
  kInterrupted = 130  // by Ctrl-C, as shells have it
};

struct GlobalOptions {
  bool json = false;
  std::string name_space;
  std::optional<int> domain;
  std::optional<std::string> transport;
  bool clock_topic = false;  // time goes by /clock
  std::string keys;
  std::string identity;
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

// A command line that asks for no command: help, or a mistake.
struct ParseEnd {
  ExitCode exit = ExitCode::kUsage;
  std::string text;
};

std::variant<CommandLine, ParseEnd> ParseCommandLine(int argc, const char* const* argv);

}  // namespace musher::motion::tool
