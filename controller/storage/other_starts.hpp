#pragma once
// Without `state_dir` in its config a machine has its state folder in a default place, which
// depends on how it is started: by a user, or by systemd's unit. So one machine can have several
// state folders. The emergency stops that are engaged in the other folders hold as well, what a
// released stop has switched off stays off, and a battery that was low there is low here: a robot
// that was stopped by hand must not move because systemd starts it at the next boot.
//
// A folder may belong to another user, who may put links and pipes in it: its files are read by
// OpenRegular() alone.
//
// Threads: any; they read the disk.

#include <cstdint>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/controller/storage/machine_origin.hpp"
#include "musher/lifecycle/machine/policy_state.hpp"
#include "musher/lifecycle/machine/stored.hpp"

namespace musher {

// StateDirectory= of musher@.service.
inline constexpr const char* kServicePlace = "/var/lib/musher";

// Where the machine has its state folder when it is started otherwise: by this user, by systemd, by
// the owner of its config file; root finds those of every user in the file `users`, too, whose home
// is on a disk of this host by the file `mounts`. Folders of other users only where there is one.
std::vector<std::string> DefaultStateDirs(const MachineOrigin& machine,
                                          const std::string& users = "/etc/passwd",
                                          const std::string& mounts = "/proc/self/mountinfo");

// The stops in a folder of this machine. None where this user may not read them: that is known by
// FindUnreadFolders(). A file that cannot be read for another reason is a stop, kUnknownStop.
StoredStops OpenStopsIn(const std::string& folder);

// The emergency stops in another state folder of the machine.
struct StopsElsewhere {
  std::string state_dir;
  StoredStops stops;
};

// Of the folders other than `state_dir` that belong to this machine, those with a stop that `known`
// does not know as released: it is engaged there, or was released and waits for a request. A folder
// that does not say which machine it belongs to may be this one's. A damaged file is a stop, too,
// with an id of its own until it is written again: so a release ends it. What this user may not
// read is passed over here: see FindUnreadFolders().
std::vector<StopsElsewhere> FindStopsElsewhere(const std::string& state_dir,
                                               const MachineOrigin& machine,
                                               const std::vector<std::string>& folders,
                                               const StoredStops& known);

// The battery's level in another state folder of the machine.
struct LevelElsewhere {
  std::string state_dir;
  BatteryLevel level = BatteryLevel::kFree;
  std::uint64_t mark = 0;  // another one once the level was stored again
};

// Of the folders other than `state_dir` that belong to this machine, those with a low battery, as
// above. A level that this machine's own folder has taken over is known there by its mark
// (StateStore::SaveLevelsTaken): samples may have lifted it since.
std::vector<LevelElsewhere> FindLevelsElsewhere(const std::string& state_dir,
                                                const MachineOrigin& machine,
                                                const std::vector<std::string>& folders);

// Of the folders other than `state_dir`, those that may belong to this machine and that cannot be
// read: a stop may be engaged there, or the battery low. Known of them is what can be seen from
// outside.
//
//   the folder is there                  it has the machine's name, namespace and domain: it counts
//   the place is there, and closed       it counts, by the place: one may be in it
//   the place cannot be seen either      no start is known to have been there: it does not count
//   the disk fails                       it counts, at each start
//
// `state_dir`: empty if this machine's own folder could not be opened; then it is one of `folders`.
// `known`: those that an earlier start has found. What a person has answered stays answered until
// the folder has changed, or the place: each start of a controller touches both (StateStore::Open).
// Where others than the owner of a closed place can start a machine in it, and may not be able to
// touch it, each start has to be answered.
std::vector<UnreadFolder> FindUnreadFolders(const std::string& state_dir,
                                            const MachineOrigin& machine,
                                            const std::vector<std::string>& folders,
                                            const std::vector<UnreadFolder>& known);

}  // namespace musher
