#pragma once
// Without `state_dir` in its config a machine has its state folder in a default place, which
// depends on how it is started: by a user, or by systemd's unit. So one machine can have several
// state folders. The emergency stops that are engaged in the other folders hold as well, what a
// released stop has switched off stays off, and a battery that was low there is low here: a robot
// that was stopped by hand must not move because systemd starts it at the next boot.
//
// The folder also depends on the name, the namespace and the domain. A config that is started with
// others than before makes another machine, of the same motors: the folders that name its file
// count, too.
//
// A folder may belong to another user, who may put links and pipes in it: its files are read by
// OpenRegular() alone.
//
// Threads: any; they read the disk.

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/controller/process/child_processes.hpp"
#include "musher/controller/storage/machine_origin.hpp"
#include "musher/lifecycle/machine/policy_state.hpp"
#include "musher/lifecycle/machine/stored.hpp"

namespace musher {

// StateDirectory= of musher@.service.
inline constexpr const char* kServicePlace = "/var/lib/musher";

// The places of the machine's state folder when the machine is started in another way: by this
// user, by systemd, or by the owner of its config file. For root also by each user in the file
// `users` whose home is on a disk of this host, according to the file `mounts`. A folder of another
// user is only listed if it exists.
std::vector<std::string> DefaultStateDirs(const MachineOrigin& machine,
                                          const std::string& users = "/etc/passwd",
                                          const std::string& mounts = "/proc/self/mountinfo");

// The folders beside `folders`, in the same places, that name the machine's config file, with
// another name, namespace or domain. None of another computer.
std::vector<std::string> FoldersOfFile(const MachineOrigin& machine,
                                       const std::vector<std::string>& folders);

// What runs on this host by the same config file, in another namespace or domain.
struct OtherRun {
  MachineOrigin machine;
  pid_t controller = 0;                 // 0: none leads
  std::vector<ChildProcess> actuators;  // of an earlier controller; none where one leads

  // Why a start beside it would run each actuator twice, and how to end it.
  std::string Text(const MachineOrigin& now) const;
};
std::optional<OtherRun> FindOtherRun(const MachineOrigin& machine,
                                     const std::vector<std::string>& folders);

// The stops in a folder of this machine. None where this user may not read them: that is known by
// FindUnreadFolders(). A file that cannot be read for another reason is a stop, kUnknownStop.
StoredStops OpenStopsIn(const std::string& folder);

// The emergency stops in another state folder of the machine.
struct StopsElsewhere {
  std::string state_dir;
  StoredStops stops;
};

// Finds the folders of this machine, other than `state_dir`, with a stop that is not released in
// `known`: the stop is engaged there, or was released and waits for a request. A folder that does
// not name its machine may belong to this machine. A damaged file counts as a stop, with an id of
// its own until the file is written again, so that a release ends it. Folders that this user may
// not read are left to FindUnreadFolders().
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

// Finds the folders of this machine, other than `state_dir`, with a low battery. The machine's own
// folder has the marks of the levels that it has taken over (StateStore::SaveLevelsTaken): samples
// may have lifted a level since.
std::vector<LevelElsewhere> FindLevelsElsewhere(const std::string& state_dir,
                                                const MachineOrigin& machine,
                                                const std::vector<std::string>& folders);

// The actuators that only a person starts again, by another state folder of the machine.
struct StayDownElsewhere {
  std::string state_dir;
  std::vector<StoredActuator> actuators;
  std::uint64_t mark = 0;  // another one once they were stored again
};

// Finds the folders of this machine, other than `state_dir`, with such actuators. The machine's own
// folder has the marks of those that it has taken over (StateStore::SaveActuatorsTaken): a person
// may have started them since.
std::vector<StayDownElsewhere> FindStayDownElsewhere(const std::string& state_dir,
                                                     const MachineOrigin& machine,
                                                     const std::vector<std::string>& folders);

// Finds the folders, other than `state_dir`, that may belong to this machine and cannot be read: a
// stop may be engaged there, or the battery low. Only what is visible from outside is known of
// them.
//
//   the folder is there                  it has the machine's name, namespace and domain: it counts
//   the place is there, and closed       it counts, by the place: one may be in it
//   the place cannot be seen either      no start is known to have been there: it does not count
//   the disk fails                       it counts, at each start
//
// `state_dir`: empty if this machine's own folder could not be opened; then it is one of `folders`.
// `known`: the folders that an earlier start has found. A folder that a person has answered stays
// answered until the folder or its place changes: each start of a controller touches both
// (StateStore::Open). If other users than the owner can start a machine in a closed place, they may
// be unable to touch the place: then a person has to answer at each start.
std::vector<UnreadFolder> FindUnreadFolders(const std::string& state_dir,
                                            const MachineOrigin& machine,
                                            const std::vector<std::string>& folders,
                                            const std::vector<UnreadFolder>& known);

}  // namespace musher
