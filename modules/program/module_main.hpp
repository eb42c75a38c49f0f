#pragma once
// What the programs of all modules have in common: their command line, and their place in the state
// config.
//
//   musher-device-manager [--actuator NAME] [--config STATE_CONFIG] FILE
//
// The controller gives name and state config in MUSHER_ACTUATOR and MUSHER_CONFIG.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "musher/lifecycle/config.hpp"
#include "musher/lifecycle/diagnostic.hpp"
#include "musher/lifecycle/result.hpp"

namespace musher::program {

inline constexpr int kNotStarted = 1;
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
};

// Reads the command line and runs the module; the exit code. Usage errors and --help are dealt with
// here.
int Main(int argc, char** argv, const About& about, const std::function<int(const Options&)>& run);

// Says it on stderr; kUsageError.
int Refuse(const std::string& actuator, const Error& error);

// Prepares the module, starts it and waits for its end; the exit code.
template <class Manager>
int RunToEnd(Manager& manager, const Options& options) {
  if (const Result<> ready = manager.Prepare(options.state_config); !ready) {
    return Refuse(options.actuator, ready.error());
  }
  if (!manager.ActuatorStart()) return kNotStarted;
  return manager.Wait();
}

// Its part of the state config. Nothing: what is wrong was said on stderr.
std::optional<ActuatorConfig> ReadActuator(const std::string& state_config,
                                           const std::string& actuator);

// Errors on stderr, one a line. Warnings are for `musher check`.
void PrintErrors(const std::vector<Diagnostic>& diagnostics);

}  // namespace musher::program
