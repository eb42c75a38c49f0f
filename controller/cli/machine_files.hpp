#pragma once
// The files of a machine on this host: its config and its state folder. They are found with the
// controller running, crashed or stopped:
//
//   1. --config FILE: that config
//   2. a controller of this host leads: the folder whose lock it holds
//   3. robot.toml in the working directory, if it has this namespace and its machine has run
//   4. the folder below the default place whose machine has this namespace and domain
//
// Waits for the disk, never for the network.

#include <optional>
#include <string>
#include <variant>

#include "musher/controller/cli/exit_code.hpp"
#include "musher/controller/cli/options.hpp"
#include "musher/lifecycle/config/config.hpp"

namespace musher::cli {

struct MachineFiles {
  std::string name;                     // of the machine
  std::string state_dir;                // with the journal and the logs
  std::string config_file;              // may be missing or faulty by now
  std::optional<MachineConfig> config;  // none: it cannot be read
  bool led = false;                     // a controller of this host leads the machine
};

// `config`: of --config; empty: not given. Fails with kNoController where no machine is found.
std::variant<MachineFiles, Failure> FindMachineFiles(const std::string& config,
                                                     const GlobalOptions& global);

// The word for the controller's own log where no actuator has that name.
inline constexpr const char* kControllerWord = "controller";
std::string LogPathOf(const MachineFiles& files, const std::string& actuator);

}  // namespace musher::cli
