// musher-camera-manager: the cameras of a robot. See README.md in this folder.

#include "musher/actuator/program/module_main.hpp"
#include "musher/modules/camera/camera_config.hpp"
#include "musher/modules/camera/camera_manager.hpp"
#include "musher/modules/camera/media.hpp"

namespace {

int Run(const musher::program::Options& options) {
  return musher::program::RunModule<musher::camera::CameraManager>(
      options, musher::camera::ReadCamerasFile(options.file));
}

}  // namespace

int main(int argc, char** argv) {
  musher::camera::SetUpCodecs();
  return musher::program::Main(
      argc, argv,
      {"musher-camera-manager", "The cameras of a robot, as the actuator RealSenseActuator.",
       "Exit codes: 0 torn down; 1 not started (reason on stderr); 2 usage or config."},
      Run);
}
