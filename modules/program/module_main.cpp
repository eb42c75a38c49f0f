#include "musher/modules/program/module_main.hpp"

#include <CLI/CLI.hpp>
#include <iostream>

#include "musher/lifecycle/config_toml.hpp"

namespace musher::program {

int Main(int argc, char** argv, const About& about, const std::function<int(const Options&)>& run) {
  Options options;
  CLI::App app(about.description, about.name);
  app.footer(about.footer);
  app.add_option("FILE", options.file, "The module's own config (TOML)")->required();
  app.add_option("--actuator", options.actuator, "Which actuator of the state config this is")
      ->envname("MUSHER_ACTUATOR")
      ->required();
  app.add_option("--config", options.state_config, "The state config (TOML)")
      ->envname("MUSHER_CONFIG")
      ->required();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kUsageError;
  }
  return run(options);
}

int Refuse(const std::string& actuator, const Error& error) {
  std::cerr << actuator << ": " << error.message << std::endl;
  return kUsageError;
}

std::optional<ActuatorConfig> ReadActuator(const std::string& state_config,
                                           const std::string& actuator) {
  const ConfigReading machine = ReadConfigFile(state_config);
  PrintErrors(machine.diagnostics);
  if (!machine.config) return std::nullopt;
  const auto index = machine.config->IndexOf(actuator);
  if (!index) {
    std::cerr << state_config << ": there is no actuator '" << actuator << "'" << std::endl;
    return std::nullopt;
  }
  return machine.config->actuators[*index];
}

void PrintErrors(const std::vector<Diagnostic>& diagnostics) {
  for (const Diagnostic& diagnostic : diagnostics) {
    if (diagnostic.severity != Severity::kError) continue;
    std::cerr << FormatDiagnostic(diagnostic) << std::endl;
  }
}

}  // namespace musher::program
