#pragma once
// A controller with everything it needs: folder, lock, epoch, journal, processes, services. What
// the `musher up` program and MachineController have in common.
//
// Threads: loop thread only.

#include <csignal>
#include <functional>
#include <memory>
#include <string>

#include "musher/controller/controller_services.hpp"
#include "musher/controller/controller_shell.hpp"
#include "musher/controller/cyberdog/manager.hpp"
#include "musher/controller/disk_writer.hpp"
#include "musher/controller/journal.hpp"
#include "musher/controller/log_files.hpp"
#include "musher/controller/process_probe.hpp"
#include "musher/controller/process_supervisor.hpp"
#include "musher/controller/ros2_tools.hpp"
#include "musher/controller/state_store.hpp"
#include "musher/transport/host.hpp"

namespace musher {

struct ControllerOptions {
  bool takeover = false;  // a living controller of this machine is ended instead of refused by it
  // Actuators that run already with another config than this machine's are taken over instead of
  // refusing to begin beside them. A supervisor's start takes them over in any case.
  bool adopt = true;
  // What the machine was started from, where that is not its config's file: a root of upgrades.
  std::string started_from;
  bool by_hand = false;  // the start-up is driven by requests instead of by the controller itself
  // Started again by a supervisor, not by a person: where the controller before was taking the
  // machine down, that is finished, and the machine stays down.
  bool restarted = false;
  ControllerShell::Hooks hooks;
  // Told about trouble that does not stop the robot (a full disk, say), once each. From any thread.
  std::function<void(const std::string&)> on_trouble;
};

// By this signal a controller is asked to let go of its machine, by the one that takes it over. One
// that does not end within a second, for it hangs or is a program that cares nothing, is killed.
inline constexpr int kLetGoSignal = SIGUSR1;

class Controller {
 public:
  // Takes the machine over. Fails with kCodeTargetBusy when a living controller of this host has
  // it. It begins, and calls hooks, on the loop's next turn; where hosts are several it listens for
  // others for a moment first, and begins, or calls hooks.on_fenced, after that.
  // The node, whose domain is `domain_id`, and the config must outlive the controller.
  static Result<std::unique_ptr<Controller>> Make(transport::Node& node, int domain_id,
                                                  const MachineConfig& config,
                                                  ControllerOptions options);
  // Leaves all processes running.
  ~Controller();

  ControllerShell& shell() { return *shell_; }
  // As ProcessSupervisor has them: for a process that is nothing but this controller.
  void AdoptOrphans() { processes_.AdoptOrphans(); }
  void ReapOrphans() { processes_.ReapOrphans(); }
  // Waits until what was recorded and what is to be saved is on disk, at most `timeout`; says
  // whether it is.
  bool Flush(Duration timeout);

 private:
  Controller(transport::Node& node, int domain_id, const MachineConfig& config,
             ControllerOptions options);
  Result<> Open();
  Result<> OpenStore();
  Result<> TakeName();
  Result<> OpenShell();
  Result<> OpenServices();
  MachineOrigin Origin() const;
  Result<> MayTakeOver(pid_t controller) const;
  void BeginAfter(Duration listen);
  void BeginOnceHeard(Time deadline);
  void Begin();
  std::string LockOf(const std::string& actuator) const;
  void FindRunning(event::Begin& begin);
  std::uint64_t LoadEpoch();
  void OpenLogs();
  void Trouble(const std::string& message);

  transport::Node& node_;
  const int domain_id_;
  const MachineConfig& config_;
  ControllerOptions options_;
  std::shared_ptr<StateStore> store_;  // null when the disk does not let us; saves hold it, too
  std::unique_ptr<JournalSink> journal_;
  Journal* file_journal_ = nullptr;          // the same, when there is a store
  std::optional<HistoryReader> history_;     // of that one
  std::optional<transport::NameLock> name_;  // of the leader of this namespace on this host
  std::size_t held_ = 0;                     // actuators of this host whose name is taken
  std::string led_with_;                     // hash of the config it was led with before
  bool look_around_ = false;                 // another controller may lead already
  const std::uint64_t incarnation_ = transport::NewIncarnation();
  DiskWriter disk_;
  std::unique_ptr<LogFiles> logs_;  // null without a store
  ProcessSupervisor processes_;
  KernelProbe process_probe_;
  std::unique_ptr<ControllerShell> shell_;
  std::unique_ptr<ControllerServices> services_;  // null unless this controller leads
  std::unique_ptr<cyberdog::Manager> manager_;    // the same, and where the config wants none
  std::unique_ptr<Ros2Tools> ros2_tools_;         // the same
  transport::LoopHandlePtr begin_later_;
};

}  // namespace musher
