#pragma once
// Without `state_dir` in its config a machine has its state folder in a default place, which
// depends on how it is started: by a user, or by systemd's unit. So one machine can have several
// state folders. The emergency stops that are engaged in the other folders hold as well, and what a
// released stop has switched off stays off: a robot that was stopped by hand must not move because
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
// does not know as released: it is engaged there, or was released and waits for a request. A
// damaged file engages none: it would at each start, as no release can end it. That and what this
// user may not read are for FindUnreadFolders().
std::vector<StopsElsewhere> FindStopsElsewhere(const std::string& state_dir,
                                               const MachineOrigin& machine,
                                               const std::vector<std::string>& folders,
                                               const StoredStops& known);

// Of the folders other than `state_dir`, those that may belong to this machine and whose stops this
// user may not read, or whose file of them is damaged: a stop may be engaged there. Known of them
// is what can be seen from outside.
//
//   the folder is there                  it has the machine's name, namespace and domain: it counts
//   the place is there, and closed       it counts, by the place: one may be in it
//   the place cannot be seen either      no start is known to have been there: it does not count
//
// `known`: those that an earlier start has found. What a person has answered stays answered until
// the folder has changed, or the place: each start of a controller touches both (StateStore::Open).
// Where others than the owner of a closed place can start a machine in it, and may not be able to
// touch it, each start has to be answered.
std::vector<UnreadFolder> FindUnreadFolders(const std::string& state_dir,
                                            const MachineOrigin& machine,
                                            const std::vector<std::string>& folders,
                                            const std::vector<UnreadFolder>& known);

}  // namespace musher
