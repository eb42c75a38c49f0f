#pragma once
// A machine whose config has no `state_dir` has its state folder in the default place of who starts
// it: a user's, or the one of systemd's unit. So one machine can have several state folders, one a
// way to start it. The emergency stops that are engaged in the others hold as well, and so does
// what a released one has switched off: a robot that was stopped by hand must not move because
// systemd starts it at the next boot.
//
// Threads: any; they read the disk.

#include <string>
#include <vector>

#include "musher/controller/storage/machine_origin.hpp"
#include "musher/lifecycle/machine/stored.hpp"

namespace musher {

// StateDirectory= of musher@.service.
inline constexpr const char* kServicePlace = "/var/lib/musher";

// Where the machine has its state folder when it is started otherwise: by this user, by systemd, by
// the owner of its config file.
std::vector<std::string> DefaultStateDirs(const MachineOrigin& machine);

// The emergency stops in another state folder of the machine.
struct StopsElsewhere {
  std::string state_dir;
  StoredStops stops;
};

// Of the folders other than `state_dir` that belong to this machine, those with a stop that `known`
// does not know as released: it is engaged there, or was released and waits for a request. What
// this user may not read is passed over, and a damaged file, too: it would engage a stop at each
// start, as no release can end it.
std::vector<StopsElsewhere> FindStopsElsewhere(const std::string& state_dir,
                                               const MachineOrigin& machine,
                                               const std::vector<std::string>& folders,
                                               const StoredStops& known);

}  // namespace musher
