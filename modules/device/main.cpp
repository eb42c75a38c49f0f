// musher-device-manager: battery, lights and touch of a robot. See README.md in this folder.

#include "musher/actuator/program/module_main.hpp"
#include "musher/modules/device/device_config.hpp"
#include "musher/modules/device/device_manager.hpp"

namespace {

int Run(const musher::program::Options& options) {
  return musher::program::RunModule<musher::device::DeviceManager>(
      options, musher::device::ReadDeviceFile(options.file));
}

}  // namespace

int main(int argc, char** argv) {
  return musher::program::Main(
      argc, argv,
      {"musher-device-manager",
       "Battery, lights and touch of a robot, as the actuator device_manager.",
       "Exit codes: 0 torn down; 1 not started (reason on stderr); 2 usage or config."},
      Run);
}
