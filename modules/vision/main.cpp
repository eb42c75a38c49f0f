// musher-vision-manager: detects faces in the robot's pictures. See README.md in this folder.

#include "musher/actuator/program/module_main.hpp"
#include "musher/modules/vision/vision_config.hpp"
#include "musher/modules/vision/vision_manager.hpp"

namespace {

int Run(const musher::program::Options& options) {
  const musher::Parsed<musher::vision::VisionConfig> reading =
      musher::vision::ReadVisionFile(options.file);
  musher::program::PrintErrors(reading.diagnostics);
  if (!reading.config) return musher::program::kUsageError;
  musher::vision::VisionManager manager(
      options.actuator, *reading.config,
      [cascade = reading.config->cascade] { return musher::vision::MakeCascadeDetector(cascade); });
  return musher::program::RunToEnd(manager, options.state_config);
}

}  // namespace

int main(int argc, char** argv) {
  return musher::program::Main(
      argc, argv,
      {"musher-vision-manager",
       "Finds faces in the robot's pictures: which person to look at, and whether a person is too "
       "close.",
       "Exit codes: 0 torn down; 1 not started, or the detector failed repeatedly (reason on "
       "stderr); 2 usage or config."},
      Run);
}
