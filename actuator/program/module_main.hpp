#pragma once
// What the programs of all modules share: their command line, and how they run.
//
//   musher-device-manager [--actuator NAME] [--config STATE_CONFIG] FILE
//
// The controller passes name and state config in MUSHER_ACTUATOR and MUSHER_CONFIG.

#include <functional>
#include <string>
#include <vector>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/base/diagnostic.hpp"

namespace musher::program {

inline constexpr int kUsageError = 2;

struct About {
  std::string name;         // of the program
  std::string description;  // one sentence
  std::string footer;       // after the options: keys of the file, exit codes
};

struct Options {
  std::string file;      // the module's own config
  std::string actuator;  // its name in the state config
  std::string state_config;
  bool check = false;  // check the configs, then exit
};

// Parses the command line and runs the module; returns the exit code. Handles usage errors and
// --help.
int Main(int argc, char** argv, const About& about, const std::function<int(const Options&)>& run);

// RunToEnd() only checks the state config from now on: 0, or kUsageError.
void OnlyCheck();

// Starts the actuator and waits for its end; returns the exit code. Prints errors on stderr.
int RunToEnd(MachineActuator& actuator, const std::string& state_config);

// Prints errors on stderr, one a line. Warnings are left to `musher check`.
void PrintErrors(const std::vector<Diagnostic>& diagnostics);

// Runs Module(actuator, config) when its config has no errors.
template <class Module, class Reading>
int RunModule(const Options& options, const Reading& reading) {
  PrintErrors(reading.diagnostics);
  if (!reading.config) return kUsageError;
  Module module(options.actuator, *reading.config);
  return RunToEnd(module, options.state_config);
}

}  // namespace musher::program
