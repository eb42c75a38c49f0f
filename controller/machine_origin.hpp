#pragma once
// Which machine a state folder belongs to, and a controller leads: name, namespace, domain and the
// file that it was started from. What differs in one of them is another machine, with a history,
// epochs and emergency stops of its own.
//
// It is kept in the folder's file `machine`.
//
// Threads: any; Save() and Load() wait for the disk.

#include <sys/types.h>

#include <optional>
#include <string>

#include "musher/lifecycle/result.hpp"

namespace musher {

struct MachineOrigin {
  std::string name;
  std::string name_space;
  int domain = 0;
  std::string file;  // absolute: its config, or the root of its upgrades

  // "robot of /etc/musher/robot.toml (namespace 'fleet', domain 7)"
  std::string Text() const;
  // Whether this one was recorded for the machine `now`. A file may be reached by another path; one
  // that is not there any more has been moved, unless a controller still leads the machine.
  bool IsOf(const MachineOrigin& now, bool led) const;

  friend bool operator==(const MachineOrigin&, const MachineOrigin&) = default;
};

// Of a folder; nothing where none was saved, or what is there cannot be read.
std::optional<MachineOrigin> LoadOrigin(const std::string& state_dir);
Result<> SaveOrigin(const std::string& state_dir, const MachineOrigin& origin);

// The folder whose lock the controller that is process `pid` has open; empty where it has none, or
// its files are not ours to see.
std::string StateDirOfProcess(pid_t pid);

// Of the controller that is process `pid`, by the folder whose lock it has open; nothing where it
// has none, or its files are not ours to see.
std::optional<MachineOrigin> OriginOfProcess(pid_t pid);

}  // namespace musher
