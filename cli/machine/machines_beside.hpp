#pragma once
// The machines of this host beside the one of a command's namespace and domain: in another
// namespace, or in another domain. A person who types a command on a robot, in a shell without its
// MUSHER_NAMESPACE or with another ROS_DOMAIN_ID, means that robot, and no other one in range.
//
//   running   a process of this host holds the name of a controller or an actuator there
//             (in another domain only one that has such files: a simulation of a colleague has none)
//   stopped   robot.toml in the working directory, or a state folder in a default place, says so,
//             and its config is still there
//
// What the command line or the environment names expressly counts as meant: --machine and
// MUSHER_MACHINE, --namespace and MUSHER_NAMESPACE, --domain. ROS_DOMAIN_ID is for all that a
// shell starts, and names no robot.
//
// Threads: any; reads the disk.

#include <optional>
#include <string>
#include <vector>

#include "musher/cli/console/options.hpp"
#include "musher/controller/storage/machine_places.hpp"
#include "musher/lifecycle/machine/machine_identity.hpp"

namespace musher::cli {

MachinePlace PlaceOf(const GlobalOptions& global);

// Those that a stop without an express name has to reach beside its own: of this domain, and of the
// others where nothing runs in this one.
std::vector<MachinePlace> PlacesToStop(const GlobalOptions& global);

struct MachineBeside {
  MachinePlace place;
  MachineIdentity identity;  // empty: of another user
  bool runs = false;

  // "the machine of this host, dog (id d0900000), runs in namespace 'dogA'".
  std::string Text(const GlobalOptions& global) const;
  // Why a command that acts speaks to none of `others`, machines of other hosts.
  std::string InsteadOf(const std::string& others, const GlobalOptions& global) const;
};

// The running ones first. With --machine: those that it may mean, in any namespace and domain.
std::vector<MachineBeside> MachinesBeside(const GlobalOptions& global);

// The same, where this host has files of a machine in the command's own namespace, which does not
// run: they hide none that runs in another one.
std::vector<MachineBeside> MachinesBeside(const GlobalOptions& global,
                                          const std::optional<MachineIdentity>& of_files);

// Machines in this domain that do not run here, but have actuators on other hosts.
std::vector<MachinePlace> PlacesOfRemoteActuators(const GlobalOptions& global);

}  // namespace musher::cli
