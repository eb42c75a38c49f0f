#pragma once
// `musher up ROOT`: chooses a version of the robot's software from one of the two slots of an
// upgrade root (ota). The controller then evaluates a version on trial boot once it is
// up, and keeps it or rolls back.
//
// Threads: loop thread only. The end of a trial boot is saved on the disk thread.

#include <csignal>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "musher/cli/console/console.hpp"
#include "musher/lifecycle/machine/machine.hpp"
#include "musher/ota/disk.hpp"
#include "musher/ota/slots.hpp"
#include "musher/ota/trial_boot.hpp"
#include "musher/transport/disk_writer.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::cli {

// With this signal the controller of a machine that was started from a root takes the machine down
// and restarts it from the slot that is then due.
inline constexpr int kStartAgainSignal = SIGUSR2;

struct SlotRun {
  std::string root;  // absolute
  ota::Slot slot = ota::Slot::kA;
  bool on_trial_boot = false;
  // … that of a process which lives, and is to be taken over: until then it decides the outcome.
  bool trial_of_another = false;
  std::string version;
  Duration trial{};    // time limit of a trial boot
  std::string reason;  // why this slot was chosen
  // The actuators run from this slot, which is not due: take them down, then start again.
  bool takes_down = false;

  // Whether this start decides the trial boot before it leads the machine.
  bool DecidesTrial() const { return on_trial_boot && !trial_of_another; }
  std::string Folder() const { return root + "/slots/" + std::string(ota::SlotName(slot)); }
};

// Held while a machine is started and runs from a root: from before the slot is chosen on, so that
// of two starts the second one neither changes the choice nor ends what the first has started.
class RootLock {
 public:
  // kCodeTargetBusy: another process holds it. After another Error the machine runs without it:
  // `musher ota` then cannot find this machine.
  Result<> Take(const std::string& root);
  // Continues to hold the lock that this process had when it executed its program again: `fd` of
  // KeepForExec().
  Result<> Resume(const std::string& root, int fd);
  bool held() const { return lock_ != nullptr; }
  // The lock stays held while this process executes a program. Returns the descriptor that holds it
  // then; -1: it is not held.
  int KeepForExec() const;
  // After a fork, in the process that keeps it: the file names this process from now on.
  void NameThisProcess() const;

 private:
  std::string file_;
  std::unique_ptr<ota::Disk> disk_;
  std::unique_ptr<ota::Disk::Lock> lock_;
};

struct ChosenSlot {
  SlotRun run;
  MachineConfig config;
  RootLock lock;  // not held if it cannot be taken, or in a takeover from a controller that runs
};

// Chooses the slot of a root and saves the choice. A version on trial boot with a faulty config is
// abandoned for the previous one. Prints the error and returns nullopt if there is no version to
// start, or if the machine of this root already runs, or is being started, and `takeover` is false,
// or beside an installer that does not end.
//
// `lock`: of the root, if this process holds it already.
// `taken_down`: the machine was taken down for this start. Otherwise actuators that run, as after a
// crash of the controller or in a takeover, decide which slot is started: see ota::DecideBoot().
std::optional<ChosenSlot> ChooseSlot(const std::string& root, bool takeover, bool taken_down,
                                     RootLock lock, Console& console);

// Saves the outcome of the trial boot: the version is kept, or why not.
Result<> EndTrialBoot(const SlotRun& run, const Result<>& outcome);

// Saves that the version is still to be tried: this start has not begun that.
Result<> PostponeTrialBoot(const SlotRun& run);

// Saves that this start takes down what runs from the slot: the next one does not try it again.
Result<> SaveTakingDown(const SlotRun& run);

// Makes this process and the processes that it starts find the slot's programs first.
void PutSlotFirstInPath(const SlotRun& run);

// Stops the processes that a crashed controller left running from the other slot: otherwise two
// versions of a module would run. Not what a person has started, such as a shell that has exported
// MUSHER_CONFIG. Waits for them, some seconds at most. Only for the controller that leads: they may
// belong to another one, also of another host.
void EndOtherSlot(const SlotRun& run);

// The trial boot of a version.
class TrialBoot {
 public:
  // `outcome`: the version is kept, or why not. Called on the loop once the outcome is on disk.
  using OnEnd = std::function<void(const Result<>& outcome)>;
  TrialBoot(transport::EventLoop& loop, transport::DiskWriter& disk, const SlotRun& run,
            const MachineConfig& config, std::function<const Machine*()> machine, OnEnd on_end);

  bool under_way() const { return under_way_; }
  // Ends the trial boot for a reason that the machine does not show. No effect if it has ended.
  void Fail(const Error& why);
  // An emergency stop has refused the start-up, perhaps one that is released by now.
  void Hold() { stop_.start_refused = true; }

 private:
  void Evaluate();
  void ExpectEnd();
  void End(const Result<>& outcome);

  transport::EventLoop& loop_;
  transport::DiskWriter& disk_;
  const SlotRun& run_;
  const MachineConfig& config_;
  std::function<const Machine*()> machine_;
  OnEnd on_end_;
  bool under_way_ = true;
  bool ending_ = false;  // its outcome is being saved
  ota::UnderStop stop_;
  transport::LoopHandlePtr evaluation_;
  transport::LoopHandlePtr deadline_;
};

}  // namespace musher::cli
