#include "musher/actuator/program/module_main.hpp"

#include <CLI/CLI.hpp>
#include <iostream>

#include "musher/base/usage_error.hpp"
#include "musher/base/version.hpp"

namespace musher::program {
namespace {

bool only_check = false;  // set once, by the command line

}  // namespace

int Main(int argc, char** argv, const About& about, const std::function<int(const Options&)>& run) {
  Options options;
  CLI::App app(about.description, about.name);
  app.footer(about.footer);
  app.set_version_flag("--version", about.name + " " + std::string(Version()), "Print the version");
  app.add_option("FILE", options.file, "The module's own config (TOML)")->required();
  app.add_option("--actuator", options.actuator, "Which actuator of the state config this is")
      ->envname("MUSHER_ACTUATOR")
      ->required();
  app.add_option("--config", options.state_config, "The state config (TOML)")
      ->envname("MUSHER_CONFIG")
      ->required();
  app.add_flag("--check", options.check, "Report every error of the configs, and start nothing");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return EndOfParse(app, error, kUsageError);
  }
  if (options.check) OnlyCheck();
  return run(options);
}

void OnlyCheck() {
  only_check = true;
}

int RunToEnd(MachineActuator& actuator, const std::string& state_config) {
  return only_check ? actuator.Check(state_config) : actuator.Run(state_config);
}

void PrintErrors(const std::vector<Diagnostic>& diagnostics) {
  for (const Diagnostic& diagnostic : diagnostics) {
    if (diagnostic.severity != Severity::kError) continue;
    std::cerr << FormatDiagnostic(diagnostic) << std::endl;
  }
}

}  // namespace musher::program
