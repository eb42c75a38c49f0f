// musher-camera: shows and saves the robot's pictures. See README.md one folder above.

#include <variant>

#include "musher/modules/camera/media.hpp"
#include "musher/modules/camera/tool/commands.hpp"

int main(int argc, char** argv) {
  namespace tool = musher::camera::tool;
  musher::camera::SetUpCodecs();
  const auto parsed = tool::ParseCommandLine(argc, argv);
  if (const auto* end = std::get_if<tool::ParseEnd>(&parsed)) {
    return musher::program::Print(*end, "musher-camera");
  }
  const auto& line = std::get<tool::CommandLine>(parsed);
  return static_cast<int>(std::visit(
      [&](const auto& options) { return tool::Run(line.global, options); }, line.command));
}
