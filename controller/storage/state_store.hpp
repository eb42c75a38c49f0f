#pragma once
// The controller's folder, and the lock by which it has a running owner:
//
//   controller.lock     held while the controller runs; names it: "4711 robot"
//   machine             the machine of the folder (machine_origin.hpp)
//   config              the hash of the config that the machine was led with last
//   boot                the boot of this host in which a controller began last
//   epoch               the last epoch that was begun, as a decimal number
//   emergency_stop      the engaged stops with origin and reason, the released ones (slot_file.hpp)
//   processes           the processes started for actuators (child_processes.hpp)
//   stop_intent         there from the start of a TearDown until a person starts the machine
//   actuators           how actuators have ended, and where a person holds one
//   remote_actuators    the actuators that run on other hosts, with the host
//   policy              the values of the policy: the low-power switch, where the battery took it
//   levels_taken        which battery levels of the machine's other folders are in `policy`
//   actuators_taken     which actuators of the machine's other folders are in `actuators`
//   last_selfcheck_info.json  what the self-check of the last start has found
//   journal.sqlite      see journal.hpp
//   logs/<actuator>.log what the actuator's process prints
//
// Threads: Save…(), which waits for the disk, from one thread. The loads may be on another thread;
// they end before the first save.

#include <sys/types.h>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/controller/process/child_processes.hpp"
#include "musher/controller/storage/machine_origin.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/machine/machine.hpp"

namespace musher {

// What the controller prints, for people.
inline std::string ControllerLogFile(const MachineConfig& config) {
  return config.log.empty() ? config.state_dir + "/controller.log" : config.log;
}

class StateStore {
 public:
  // Makes the folder (only for its owner) and takes the lock. Fails
  //   - with kCodePermissionDenied if the folder belongs to another machine, with its name, also
  //     one that cannot be locked, or if another user may change what is in it: exit;
  //   - with kCodeTargetBusy if a running controller of this machine has the lock, with its name:
  //     exit;
  //   - with kCodeFailed on a disk error: a controller may continue without a store, with what can
  //     be read and the epoch that the actuators report.
  // The kernel releases the lock when the process exits or crashes. The folder and the one around
  // it get a new time, if this user may set one.
  static Result<StateStore> Open(const std::string& dir, const MachineOrigin& machine);

  // The id of the folder's machine, also before it is saved; empty: it has none yet.
  const std::string& machine_id() const { return machine_.id; }
  void SetMachineId(std::string id) { machine_.id = std::move(id); }
  Result<> SaveMachineId();
  // The id that the folder had on another computer, if it was copied from there, as with an image.
  // The machine has a new id then, and no released emergency stop. nullopt: the folder was not
  // copied.
  const std::optional<std::string>& copied_from() const { return copied_from_; }

  // The functions …In(dir) read a folder without its lock: one that cannot be opened for writing,
  // or that another controller may use.

  // The saved epoch; 0 when there is none yet. Fails if the file is unreadable or damaged: report
  // the error and continue as with 0, because the epochs that the actuators report count as well.
  static Result<Epoch> EpochIn(const std::string& dir);
  Result<Epoch> LoadEpoch() const { return EpochIn(dir_); }

  // Replaces the saved epoch: after a power cut the file has the old one or the new one, never a
  // part. After an Error report it and continue: the epoch is then only in memory and in the
  // actuators.
  Result<> SaveEpoch(Epoch epoch);

  // The engaged emergency stops, and the last released ones. A file that cannot be read counts as
  // an engaged stop, kUnknownStop. Saves are possible on a full disk, too: Open() reserves the
  // file, if the disk has room for it then.
  Result<> SaveEmergencyStops(const StoredStops& stops);
  static StoredStops EmergencyStopsIn(const std::string& dir);
  StoredStops LoadEmergencyStops() const { return EmergencyStopsIn(dir_); }
  static std::string EmergencyStopFileIn(const std::string& dir) { return dir + "/emergency_stop"; }

  // Whether the machine is to be torn down, and to stay so until a person starts it.
  Result<> SaveStopIntent(bool intended);
  // StopIntentIn(): only if the file is known to exist.
  static bool StopIntentIn(const std::string& dir);
  bool LoadStopIntent() const;

  // The actuators on other hosts. `host`: HostId() of this host. LoadRemoteActuators() skips
  // damaged lines, and actuators that ran on this computer, such as in another container, before
  // its boot.
  Result<> SaveRemoteActuators(const std::vector<RemoteActuator>& actuators,
                               const std::string& host);
  std::vector<RemoteActuator> LoadRemoteActuators(const std::string& host) const {
    return RemoteActuatorsIn(dir_, host);
  }
  static std::vector<RemoteActuator> RemoteActuatorsIn(const std::string& dir,
                                                       const std::string& host);

  // What the next controller has to know of the actuators. What was lost, given up or held before
  // this computer was booted is skipped: its processes start afresh. So are damaged lines.
  Result<> SaveActuators(const std::vector<StoredActuator>& actuators, const std::string& host);
  static std::vector<StoredActuator> ActuatorsIn(const std::string& dir, const std::string& host);
  static std::string ActuatorsFileIn(const std::string& dir) { return dir + "/actuators"; }

  // Which actuators of other folders this one has taken over: see FindStayDownElsewhere().
  Result<> SaveActuatorsTaken(const std::vector<std::uint64_t>& marks);
  static std::vector<std::uint64_t> ActuatorsTakenIn(const std::string& dir);

  // The stored values of the policy; nothing without a file. A file that cannot be read counts as
  // the lowest battery level that powers nothing off.
  Result<> SavePolicy(const StoredPolicy& policy);
  static StoredPolicy PolicyIn(const std::string& dir);
  StoredPolicy LoadPolicy() const { return PolicyIn(dir_); }
  static std::string PolicyFileIn(const std::string& dir) { return dir + "/policy"; }

  // Which battery levels of other folders this one has taken over: see FindLevelsElsewhere().
  Result<> SaveLevelsTaken(const std::vector<std::uint64_t>& marks);
  static std::vector<std::uint64_t> LevelsTakenIn(const std::string& dir);

  // Another small file of the folder, for people and programs beside the controller.
  Result<> SaveText(const std::string& name, const std::string& text) {
    return Replace(dir_ + "/" + name, text);
  }

  // Takes the lock again, and saves the small files again that were removed or replaced since this
  // controller has read or saved them, for example by a volume that was mounted over the folder.
  // Returns the names of these files.
  Result<std::vector<std::string>> SaveRemoved();

  // The hash of the config that the machine was led with last; empty where none is known.
  Result<> SaveConfigHash(const std::string& hash);
  static std::string ConfigHashIn(const std::string& dir);
  std::string LoadConfigHash() const { return ConfigHashIn(dir_); }

  // Notes that a controller has begun on `host` (HostId()). BeganInBootOf(): the last one has begun
  // since that host was booted.
  Result<> SaveBootOf(const std::string& host);
  static bool BeganInBootOf(const std::string& dir, const std::string& host);

  // The running processes that were started for actuators. LoadChildren() returns only the
  // processes of `host` (HostId()).
  Result<> SaveChildren(const std::vector<ChildProcess>& children, const std::string& host);
  // Another controller of this host has taken them over, from a folder of its own.
  static Result<> ForgetChildren(const std::string& dir);
  static std::vector<ChildProcess> LoadChildren(const std::string& dir, const std::string& host);
  // The processes that no controller in this network namespace reaches.
  static std::vector<ChildProcess> ChildrenInOtherNetworkIn(const std::string& dir,
                                                            const std::string& host);

  // The process that is recorded as the holder of a folder's lock; 0 if none is.
  static pid_t OwnerOf(const std::string& dir);
  // Whether that process does hold it, as far as we may look into it.
  static bool IsOwner(const std::string& dir, pid_t pid);

  std::string JournalFile() const { return dir_ + "/journal.sqlite"; }
  std::string LogFile(std::string_view actuator) const;

 private:
  // What a file holds, and which file that is.
  struct Kept {
    std::string content;
    dev_t device = 0;
    ino_t inode = 0;
  };

  StateStore(std::string dir, MachineOrigin machine, UniqueFd lock);

  static std::string EpochFileIn(const std::string& dir) { return dir + "/epoch"; }
  std::string EpochFile() const { return EpochFileIn(dir_); }
  std::string EmergencyStopFile() const { return EmergencyStopFileIn(dir_); }
  std::string PolicyFile() const { return PolicyFileIn(dir_); }
  static std::string ConfigHashFileIn(const std::string& dir) { return dir + "/config"; }
  std::string ConfigHashFile() const { return ConfigHashFileIn(dir_); }
  static std::string StopIntentFileIn(const std::string& dir) { return dir + "/stop_intent"; }
  std::string StopIntentFile() const { return StopIntentFileIn(dir_); }
  static std::string RemoteActuatorsFileIn(const std::string& dir) {
    return dir + "/remote_actuators";
  }
  std::string RemoteActuatorsFile() const { return RemoteActuatorsFileIn(dir_); }
  void ReserveEmergencyStops();
  Result<> Replace(const std::string& path, const std::string& content);
  void Remember(const std::string& path, const std::string& content);
  void RememberFile(const std::string& path);
  Result<bool> TakeLockAgain();

  std::string dir_;
  MachineOrigin machine_;
  std::optional<std::string> copied_from_;
  UniqueFd lock_;
  std::map<std::string, Kept> kept_;  // by path
};

}  // namespace musher
