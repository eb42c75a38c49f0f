// musher-sensor-manager: range sensors and GPS of a robot. See README.md beside this.

#include <CLI/CLI.hpp>
#include <iostream>
#include <string>

#include "musher/modules/sensor/sensor_config.hpp"
#include "musher/modules/sensor/sensor_manager.hpp"

namespace {

constexpr int kUsageError = 2;

int Run(const std::string& file, const std::string& actuator, const std::string& state_config) {
  const musher::sensor::ManagerReading reading = musher::sensor::ReadManagerFile(file);
  for (const musher::Diagnostic& diagnostic : reading.diagnostics) {
    std::cerr << musher::FormatDiagnostic(diagnostic) << std::endl;
  }
  if (!reading.config) return kUsageError;
  musher::sensor::SensorManager manager(actuator, *reading.config);
  if (const musher::Result<> ready = manager.Prepare(state_config); !ready) {
    std::cerr << actuator << ": " << ready.error().message << std::endl;
    return kUsageError;
  }
  if (!manager.ActuatorStart()) return 1;
  return manager.Wait();
}

}  // namespace

int main(int argc, char** argv) {
  std::string file;
  std::string actuator;
  std::string state_config;
  CLI::App app("Range sensors and GPS of a robot, as the actuator sensor_manager.",
               "musher-sensor-manager");
  app.footer("Exit codes: 0 torn down; 1 not started, which is said on stderr; 2 usage or config.");
  app.add_option("FILE", file, "The module's config (TOML)")->required();
  app.add_option("--actuator", actuator, "Which actuator of the state config this is")
      ->envname("MUSHER_ACTUATOR")
      ->required();
  app.add_option("--config", state_config, "The state config (TOML)")
      ->envname("MUSHER_CONFIG")
      ->required();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kUsageError;
  }
  return Run(file, actuator, state_config);
}
