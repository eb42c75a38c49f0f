// musher-motion: moves the robot's body from the command line. See README.md one folder above.

#include <variant>

#include "musher/modules/motion/tool/commands.hpp"

int main(int argc, char** argv) {
  namespace tool = musher::motion::tool;
  const auto parsed = tool::ParseCommandLine(argc, argv);
  if (const auto* end = std::get_if<tool::ParseEnd>(&parsed)) {
    return musher::program::Print(*end, "musher-motion");
  }
  const auto& line = std::get<tool::CommandLine>(parsed);
  return static_cast<int>(std::visit(
      [&](const auto& options) { return tool::Run(line.global, options); }, line.command));
}
