// musher-motion: moves the robot's body by hand. See README.md one folder above.

#include <cstdlib>
#include <iostream>
#include <variant>

#include "musher/modules/motion/tool/commands.hpp"

int main(int argc, char** argv) {
  namespace tool = musher::motion::tool;
  const auto parsed = tool::ParseCommandLine(argc, argv);
  if (const auto* end = std::get_if<tool::ParseEnd>(&parsed)) {
    const bool good = end->exit == tool::ExitCode::kDone;
    (good ? std::cout : std::cerr) << (good ? "" : "musher-motion: ") << end->text << std::endl;
    return static_cast<int>(end->exit);
  }
  const auto& line = std::get<tool::CommandLine>(parsed);
  // The transport reads it.
  if (line.global.transport) setenv("MUSHER_TRANSPORT", line.global.transport->c_str(), 1);
  return static_cast<int>(std::visit(
      [&](const auto& options) { return tool::Run(line.global, options); }, line.command));
}
