// musher-sensor-manager: range sensors and GPS of a robot. See README.md in this folder.

#include "musher/actuator/program/module_main.hpp"
#include "musher/modules/sensor/sensor_config.hpp"
#include "musher/modules/sensor/sensor_manager.hpp"

namespace {

int Run(const musher::program::Options& options) {
  return musher::program::RunModule<musher::sensor::SensorManager>(
      options, musher::sensor::ReadManagerFile(options.file));
}

}  // namespace

int main(int argc, char** argv) {
  return musher::program::Main(
      argc, argv,
      {"musher-sensor-manager", "Range sensors and GPS of a robot, as the actuator sensor_manager.",
       "Exit codes: 0 torn down; 1 not started (reason on stderr); 2 usage or config."},
      Run);
}
