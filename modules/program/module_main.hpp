#pragma once
// What the programs of all modules have in common: their command line, and how they run.
//
//   musher-device-manager [--actuator NAME] [--config STATE_CONFIG] FILE
//
// The controller gives name and state config in MUSHER_ACTUATOR and MUSHER_CONFIG.

#include <functional>
#include <string>
#include <vector>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/lifecycle/diagnostic.hpp"

namespace musher::program {

inline constexpr int kUsageError = 2;

struct About {
  std::string name;         // of the program
  std::string description;  // one sentence
  std::string footer;       // after the options: keys of the file, exit codes
};

struct Options {
  std::string file;      // the module's own config
  std::string actuator;  // which one of the state config it is
  std::string state_config;
  bool check = false;  // judge the configs, then end
};

// Reads the command line and runs the module; the exit code. Usage errors and --help are dealt with
// here.
int Main(int argc, char** argv, const About& about, const std::function<int(const Options&)>& run);

// From now on RunToEnd() judges the state config alone: 0, or kUsageError.
void OnlyCheck();

// Starts the actuator and waits for its end; the exit code. What is wrong is said on stderr.
int RunToEnd(MachineActuator& actuator, const std::string& state_config);

// Errors on stderr, one a line. Warnings are for `musher check`.
void PrintErrors(const std::vector<Diagnostic>& diagnostics);

// The same with what Module(actuator, config) makes, where there were no errors in its config.
template <class Module, class Reading>
int RunModule(const Options& options, const Reading& reading) {
  PrintErrors(reading.diagnostics);
  if (!reading.config) return kUsageError;
  Module module(options.actuator, *reading.config);
  return RunToEnd(module, options.state_config);
}

}  // namespace musher::program
