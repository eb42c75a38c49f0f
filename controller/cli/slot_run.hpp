#pragma once
// What `musher up ROOT` starts: a version of the robot's software, from one of the two slots of a
// root (controller/ota). And what its controller does about it: a version on trial boot is judged
// when it is up, and kept or left.
//
// Threads: loop thread only. The end of a trial boot is saved on the disk thread.

#include <csignal>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "musher/controller/cli/console.hpp"
#include "musher/controller/disk_writer.hpp"
#include "musher/controller/ota/disk.hpp"
#include "musher/controller/ota/slots.hpp"
#include "musher/lifecycle/machine.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::cli {

// By this signal the controller of a machine that was started from a root is asked to take it down
// and to start it again, from the slot that is then due.
inline constexpr int kStartAgainSignal = SIGUSR2;

struct SlotRun {
  std::string root;  // absolute
  ota::Slot slot = ota::Slot::kA;
  bool on_trial_boot = false;
  std::string version;
  Duration trial{};  // that it may take to come up
  std::string told;  // why it is this slot

  std::string Folder() const { return root + "/slots/" + std::string(ota::SlotName(slot)); }
};

struct ChosenSlot {
  SlotRun run;
  MachineConfig config;
};

// Chooses the slot of a root and remembers that. A version on trial boot whose config is faulty is
// given up for the one before. Says what is wrong, and gives nothing, when there is no version to
// start, or when the machine of this root runs already and is not to be taken over.
std::optional<ChosenSlot> ChooseSlot(const std::string& root, bool takeover, Console& console);

// Remembers how the trial boot has ended: the version is kept, or why not.
Result<> EndTrialBoot(const SlotRun& run, const Result<>& outcome);

// The programs of the slot are found before all others, from now on in this process and in those it
// starts.
void PutSlotFirstInPath(const SlotRun& run);

// Ends the processes that a controller, which has died, has left running from the other slot: two
// versions of a module would be two modules. Waits for them, some seconds at most.
void EndOtherSlot(const SlotRun& run);

// Says that a machine runs from this root, as long as it lives.
class RootLock {
 public:
  // An Error is to be told and gone on with: then nobody knows of this machine.
  Result<> Take(const std::string& root);

 private:
  std::unique_ptr<ota::Disk> disk_;
  std::unique_ptr<ota::Disk::Lock> lock_;
};

// The trial boot of a version.
class TrialBoot {
 public:
  // `outcome`: it is kept, or why not. Called once that is on disk, on the loop.
  using OnEnd = std::function<void(const Result<>& outcome)>;
  TrialBoot(transport::EventLoop& loop, DiskWriter& disk, const SlotRun& run,
            const MachineConfig& config, std::function<const Machine*()> machine, OnEnd on_end);

  bool under_way() const { return under_way_; }
  // It has ended for a reason that the machine does not show. Nothing where it had ended before.
  void Fail(const Error& why);

 private:
  void Judge();
  void End(const Result<>& outcome);

  DiskWriter& disk_;
  const SlotRun& run_;
  const MachineConfig& config_;
  std::function<const Machine*()> machine_;
  OnEnd on_end_;
  bool under_way_ = true;
  bool ending_ = false;  // its outcome is being saved
  transport::LoopHandlePtr evaluation_;
  transport::LoopHandlePtr deadline_;
};

}  // namespace musher::cli
