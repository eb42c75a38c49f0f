#pragma once
// Which root a `musher ota` command is about, and the machine that runs from it.
//
// Threads: one. Ctrl-C ends what waits for the machine, and then the command.

#include <memory>
#include <optional>
#include <string>

#include "musher/controller/cli/link.hpp"
#include "musher/controller/ota/root.hpp"

namespace musher::cli {

// Why a robot with this config could not be upgraded any more; nothing: it can.
std::optional<std::string> UpgradeFault(const MachineConfig& config);

// --root, else $MUSHER_OTA_ROOT, else that of the machine that runs in our namespace.
Result<std::string> FindRoot(const std::string& option, const GlobalOptions& global);

// The machine that was started from a root, on this host.
class RootMachine {
 public:
  // nullptr: none runs.
  static std::variant<std::unique_ptr<RootMachine>, Failure> Find(const ota::Root& root,
                                                                  const GlobalOptions& global);

  // The slot that it runs from.
  ota::Slot slot() const { return slot_; }

  Result<> EnterOta();
  // Back to where it was.
  Result<> LeaveOta();
  // Asks its controller to take it down, and to start it from the slot that is due.
  Result<> StartAgain();
  // Waits for the end of the trial boot, which a machine that has gone back survives. An Error:
  // Fault::kGoneBack, or that it is not known.
  Result<> AwaitTrialBoot();

  // Whether somebody wants the command to end. To be called now and then.
  bool Interrupted();

 private:
  RootMachine(const ota::Root& root, GlobalOptions global, int pid)
      : root_(root), global_(std::move(global)), pid_(pid) {}
  std::optional<Failure> Connect();
  Result<> AskPolicy(bool enter);
  Result<> Switch(const std::string& state);
  std::optional<Result<>> TrialBootEnd() const;
  void AwaitMachine();

  const ota::Root& root_;
  const GlobalOptions global_;
  const int pid_;
  ota::Slot slot_ = ota::Slot::kA;
  std::string before_;  // its state before it went to OTA
  bool asked_for_ota_ = false;
  bool interrupted_ = false;
  std::unique_ptr<Link> link_;
};

}  // namespace musher::cli
