// musher-camera-manager: the cameras of a robot. See README.md beside this.

#include <iostream>

#include "musher/modules/camera/camera_config.hpp"
#include "musher/modules/camera/camera_manager.hpp"
#include "musher/modules/camera/media.hpp"
#include "musher/modules/program/module_main.hpp"

namespace {

using musher::program::kUsageError;

int Run(const musher::program::Options& options) {
  const musher::camera::CamerasReading reading = musher::camera::ReadCamerasFile(options.file);
  musher::program::PrintErrors(reading.diagnostics);
  if (!reading.config) return kUsageError;
  musher::camera::CameraManager manager(options.actuator, *reading.config);
  if (const musher::Result<> ready = manager.Prepare(options.state_config); !ready) {
    std::cerr << options.actuator << ": " << ready.error().message << std::endl;
    return kUsageError;
  }
  if (!manager.ActuatorStart()) return musher::program::kNotStarted;
  return manager.Wait();
}

}  // namespace

int main(int argc, char** argv) {
  musher::camera::SetUpCodecs();
  return musher::program::Main(
      argc, argv,
      {"musher-camera-manager", "The cameras of a robot, as the actuator RealSenseActuator.",
       "Exit codes: 0 torn down; 1 not started, which is said on stderr; 2 usage or config."},
      Run);
}
