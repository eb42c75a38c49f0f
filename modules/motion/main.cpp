// musher-motion-manager: the actuator that moves the body. See README.md beside this.

#include <CLI/CLI.hpp>
#include <iostream>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "musher/lifecycle/config_toml.hpp"
#include "musher/modules/motion/motion_manager.hpp"

namespace {

constexpr int kUsageError = 2;

constexpr const char* kFooter = R"(
FILE, every key of which may be left out:
  motions = "motions.toml"  # the motion id table, relative to FILE
  [priority]                # of sources: debug, app, audio, vis, blutele, algo
  [board]                   # wait_ms, silent_ms, feedback_ms

Exit codes: 0 torn down; 1 SetUp failed; 2 usage or config.)";

struct Options {
  std::string file;
  std::string actuator;
  std::string state_config;
};

// Nothing: the program is to end with `exit_code`.
std::optional<Options> ReadOptions(int argc, char** argv, int& exit_code) {
  Options options;
  CLI::App app(
      "The actuator that moves the body: servo and result commands, by the machine's state.",
      "musher-motion-manager");
  app.footer(kFooter);
  app.add_option("FILE", options.file, "The motion manager's own settings (TOML)")->required();
  app.add_option("--actuator", options.actuator, "Which actuator of the state config this is")
      ->envname("MUSHER_ACTUATOR")
      ->required();
  app.add_option("--config", options.state_config, "The state config (TOML)")
      ->envname("MUSHER_CONFIG")
      ->required();
  try {
    app.parse(argc, argv);
    return options;
  } catch (const CLI::ParseError& error) {
    exit_code = app.exit(error) == 0 ? 0 : kUsageError;
    return std::nullopt;
  }
}

void Print(const std::vector<musher::Diagnostic>& diagnostics) {
  for (const musher::Diagnostic& diagnostic : diagnostics) {
    if (diagnostic.severity != musher::Severity::kError) continue;
    std::cerr << musher::FormatDiagnostic(diagnostic) << std::endl;
  }
}

int Run(const Options& options) {
  const musher::ConfigReading machine = musher::ReadConfigFile(options.state_config);
  Print(machine.diagnostics);
  if (!machine.config) return kUsageError;
  const auto index = machine.config->IndexOf(options.actuator);
  if (!index) {
    std::cerr << options.state_config << ": there is no actuator '" << options.actuator << "'"
              << std::endl;
    return kUsageError;
  }
  musher::motion::ConfigReading config = musher::motion::ReadMotionConfigFile(options.file);
  Print(config.diagnostics);
  if (!config.config) return kUsageError;
  musher::motion::TableReading table = musher::motion::ReadTableFile(config.config->motions);
  Print(table.diagnostics);
  if (!table.table) return kUsageError;
  musher::motion::MotionManager manager(machine.config->actuators[*index],
                                        *std::move(config.config), *std::move(table.table));
  if (!manager.MachineActuatorInit(options.state_config) || !manager.ActuatorStart()) return 1;
  return manager.Wait();
}

}  // namespace

int main(int argc, char** argv) {
  int exit_code = 0;
  const std::optional<Options> options = ReadOptions(argc, argv, exit_code);
  return options ? Run(*options) : exit_code;
}
