#pragma once
// The upgrade root of a `musher ota` command, and the machine that runs from it.
//
// Threads: one. Ctrl-C ends the waiting for the machine, and then the command.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "musher/cli/machine/link.hpp"
#include "musher/ota/root.hpp"

namespace musher::cli {

// Why a robot with this config could not be upgraded any more; nullopt: it can.
std::optional<std::string> UpgradeFault(const MachineConfig& config);

// --root, else $MUSHER_OTA_ROOT, else that of the machine that runs in the command's namespace.
Result<std::string> FindRoot(const std::string& option, const GlobalOptions& global);

// Of the last switch of a machine, or of the one under way: the controller's epoch and the number.
using SwitchNumber = std::pair<std::uint64_t, std::uint64_t>;

// The machine that was started from a root, on this host.
class RootMachine {
 public:
  // nullptr: no machine runs from it.
  static std::variant<std::unique_ptr<RootMachine>, Failure> Find(const ota::Root& root,
                                                                  const GlobalOptions& global);

  // The slot that it runs from.
  ota::Slot slot() const { return slot_; }

  Result<> EnterOta();
  // Switches back to the state before EnterOta(), unless another command has switched the machine
  // since then.
  Result<> LeaveOta();
  // Signals its controller to take the machine down and to start it from the slot that is due.
  // Fails if the machine is no longer in OTA.
  Result<> StartAgain();
  // Waits for the end of the trial boot, and after a rollback for the machine. Error:
  // Fault::kRolledBack, or that the outcome is unknown.
  Result<> AwaitTrialBoot();

  // Whether the command was interrupted. To be called repeatedly.
  bool Interrupted();

 private:
  RootMachine(const ota::Root& root, GlobalOptions global, int pid)
      : root_(root), global_(std::move(global)), pid_(pid) {}
  std::optional<Failure> Connect();
  Result<msg::MachineStatus> Look();
  Result<> RequestPolicy(bool enter);
  Result<> Switch(const std::string& state);
  Result<> SwitchBack();
  std::optional<Result<>> TrialBootEnd() const;
  // What the end of the controller means for the trial boot.
  std::string ControllerExited() const;
  void AwaitMachine();

  const ota::Root& root_;
  const GlobalOptions global_;
  const int pid_;
  ota::Slot slot_ = ota::Slot::kA;
  std::string before_;                      // its state before it went to OTA
  std::optional<SwitchNumber> ota_switch_;  // that took it there, or tried; not known: {}
  bool interrupted_ = false;
  std::unique_ptr<Link> link_;
};

}  // namespace musher::cli
