#pragma once
// What clients see of the machine while this controller leads it, each latched: its status, what it
// can do, and that it exists.
//
// Threads: loop thread only.

#include <memory>
#include <string>
#include <vector>

#include "musher/controller/shell/capability_board.hpp"
#include "musher/controller/shell/controller_presence.hpp"
#include "musher/controller/shell/shell_context.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"
#include "musher/transport/node.hpp"

namespace musher {

class MachineBoard {
 public:
  // All must outlive it.
  MachineBoard(ShellContext context, const ControllerPresence& presence);

  Result<> Open();
  // Publishes that the machine exists. To be called when its services are open.
  Result<> Announce();
  void Close();
  bool is_open() const { return status_ != nullptr; }

  // The machine may have changed.
  void Refresh();
  void PublishSoon();
  // Publishes a changed status at once, not with the next changes.
  void PublishStatus();
  msg::MachineStatus Status() const;
  msg::Capabilities Capabilities() const;
  // The participants of another DDS, for the status.
  void SetOtherVendors(std::vector<std::string> others);
  // The rules of the user that are violated, for the status.
  void SetViolatedRules(std::vector<std::string> rules);
  // The actuators that have not stopped at the engaged stop, with why, for the status.
  void SetNotStopped(std::vector<std::string> actuators);

 private:
  void PublishWhileUnsaved();

  const ShellContext context_;
  const ShellDependencies& dependencies_;
  const MachineConfig& config_;
  const Machine& machine_;
  const ControllerPresence& presence_;
  msg::MachineStatus published_;
  Time published_at_{};
  std::vector<std::string> other_vendors_;  // participants of another DDS
  std::vector<std::string> violated_rules_;
  std::vector<std::string> not_stopped_;
  transport::LoopHandlePtr publish_later_;
  transport::LoopHandlePtr unsaved_timer_;  // while something is not on disk
  // Null while it is closed.
  std::unique_ptr<transport::Publisher<msg::MachineStatus>> status_;
  std::unique_ptr<transport::Publisher<msg::MachineInfo>> info_;
  std::unique_ptr<CapabilityBoard> capabilities_;
};

}  // namespace musher
