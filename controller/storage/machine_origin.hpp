#pragma once
// The identity of a machine: name, namespace, domain and the file that it was started from. It
// identifies the machine of a state folder and of a controller. A machine that differs in one of
// them is another machine, with its own history, epochs and emergency stops. `id` is what it is
// known by on the network (lifecycle/machine/machine_identity.hpp).
//
// Stored in the state folder's file `machine`.
//
// Threads: any; Save() and Load() wait for the disk.

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

#include "musher/base/result.hpp"

namespace musher {

struct MachineOrigin {
  std::string name;
  std::string name_space;
  int domain = 0;
  std::string file;  // absolute: its config, or its upgrade root
  std::string id{};  // a UUID, made at the first start of the machine; empty: none yet
  std::vector<std::string> computer{};  // what it is known by (computer.hpp); empty: not known

  // "robot of /etc/musher/robot.toml (namespace 'fleet', domain 7)"
  std::string Text() const;
  // Whether this identity was recorded for the machine `now`. The same file may have another path;
  // a file that no longer exists was moved, unless a controller still leads the machine.
  bool IsOf(const MachineOrigin& now, bool led) const;

  friend bool operator==(const MachineOrigin&, const MachineOrigin&) = default;
};

// The file of a folder with its identity.
std::string OriginFile(const std::string& state_dir);
// The identity saved in a folder; nullopt if there is none or it cannot be read.
std::optional<MachineOrigin> LoadOrigin(const std::string& state_dir);
Result<> SaveOrigin(const std::string& state_dir, const MachineOrigin& origin, bool synced = false);

// A new random id of a machine.
std::string NewMachineId();

// The folder whose lock the controller process `pid` holds; empty if it holds none, or its open
// files are not visible to us.
std::string StateDirOfProcess(pid_t pid);

// The identity of the controller process `pid`, from the folder whose lock it holds; nullopt if it
// holds none, or its open files are not visible to us.
std::optional<MachineOrigin> OriginOfProcess(pid_t pid);

// The identity of the machine whose controller runs on this host; nullopt: none does, or as above.
std::optional<MachineOrigin> OriginHere(int domain, const std::string& name_space);

}  // namespace musher
