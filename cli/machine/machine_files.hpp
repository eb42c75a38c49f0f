#pragma once
// The files of a machine on this host: its config and its state folder. They are found with the
// controller running, crashed or stopped:
//
//   1. --config FILE: that config
//   2. a controller of this host leads: the folder whose lock it holds
//   3. robot.toml in the working directory, if it has this namespace and its machine has run
//   4. the folder below a default place whose machine has this namespace and domain
//
// The default places are that of this user, and /var/lib/musher of robots that systemd starts.
//
// Waits for the disk, never for the network.

#include <sys/types.h>

#include <optional>
#include <string>
#include <variant>

#include "musher/cli/console/exit_code.hpp"
#include "musher/cli/console/options.hpp"
#include "musher/controller/storage/machine_origin.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/machine/machine_identity.hpp"

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

// The machine that they belong to, whether or not it runs; nullopt: this host has files of none.
std::optional<MachineIdentity> MachineOfFilesHere(const GlobalOptions& global);

// A machine of this host that runs in another network namespace, where commands of this one do not
// reach it.
struct MachineInOtherNetwork {
  std::string name;
  pid_t pid = 0;            // of its controller, else of an actuator
  std::string actuators{};  // "legs (pid 4711)", that run without a controller; empty: it is led

  // "process 4711 leads dog in another network namespace of this host, …", with what to do.
  std::string Text() const;
};
// That of these files; nullopt: it runs in this network, does not run, or this user may not see it.
std::optional<MachineInOtherNetwork> InOtherNetwork(const MachineFiles& files);
// The first one of the namespace and domain whose files are found, and that --machine may mean.
std::optional<MachineInOtherNetwork> FindInOtherNetwork(const GlobalOptions& global);

// Where a machine whose config has no state_dir was last started: `by_user`, or the folder of that
// name in `service_place`, that of systemd's unit.
std::string StateDirOf(const MachineOrigin& machine, const std::string& by_user,
                       const std::string& service_place);
// Takes that folder for a config as it was read.
void TakeStateDir(MachineConfig& config, int domain);
// "; …" where this user cannot read files of systemd's robots; empty: it can.
std::string HiddenFilesNote();

// Why the files of a machine that is led on this host are not found.
std::string FilesOfAnotherUser();
// Why this user cannot read the logs; empty: it can, or there are none.
std::string WhyUnreadable(const MachineFiles& files);

// The word for the controller's own log where no actuator has that name.
inline constexpr const char* kControllerWord = "controller";
std::string LogPathOf(const MachineFiles& files, const std::string& actuator);

}  // namespace musher::cli
