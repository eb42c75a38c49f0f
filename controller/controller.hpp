#pragma once
// A controller with everything it needs: folder, lock, epoch, journal, processes, services. Shared
// by the `musher up` program and MachineController.
//
// Threads: loop thread only.

#include <csignal>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "musher/base/host.hpp"
#include "musher/controller/extension.hpp"
#include "musher/controller/journal/journal.hpp"
#include "musher/controller/process/host_processes.hpp"
#include "musher/controller/process/process_probe.hpp"
#include "musher/controller/process/process_supervisor.hpp"
#include "musher/controller/ros2/ros2_tools.hpp"
#include "musher/controller/shell/controller_services.hpp"
#include "musher/controller/shell/controller_shell.hpp"
#include "musher/controller/standby.hpp"
#include "musher/controller/storage/computer.hpp"
#include "musher/controller/storage/log_files.hpp"
#include "musher/controller/storage/state_store.hpp"
#include "musher/transport/disk_writer.hpp"
#include "musher/transport/network_watch.hpp"

namespace musher {

struct ControllerOptions {
  bool takeover = false;  // replace a running controller of this machine instead of failing
  // Take control of actuators that already run with another config instead of refusing to begin
  // beside them. A supervisor's start always takes control of them.
  bool adopt = true;
  // The upgrade root that the machine was started from; empty: its config file.
  std::string started_from;
  bool by_hand = false;  // requests drive the start-up instead of the controller itself
  // Restarted by a supervisor, not by a person: if the previous controller was taking the machine
  // down, complete that and stay down.
  bool restarted = false;
  // Started by a supervisor, at boot or again: such a start is no request to switch on what an
  // emergency stop has switched off. The first one since this host was booted undoes no person's
  // takeover.
  bool supervised = false;
  // Stands by for a controller of another host, which is to fail first: see
  // lifecycle/coordinator/failover.hpp. The config has a failover_ms.
  bool standby = false;
  std::vector<ControllerExtension> extensions;
  ControllerShell::Hooks hooks;
  // Called once the controller has listened for other controllers and is about to lead, before it
  // takes control of anything. The hook may wait for processes that it ends.
  std::function<void()> before_begin;
  // Called once for each problem that does not stop the robot, such as a full disk. From any
  // thread.
  std::function<void(const std::string&)> on_trouble;
  // Called when this controller begins to stand by, and whenever the reason changes.
  std::function<void(const std::string& why)> on_standby;
};

// With this signal a controller that takes over a machine makes the previous one release control.
// A process that does not exit within a second (it hangs or ignores the signal) is killed.
inline constexpr int kReleaseControlSignal = SIGUSR1;

class Controller {
 public:
  // Takes the machine over. Fails with kCodeTargetBusy if a running controller of this host leads
  // it. It begins, and calls hooks, on the loop's next turn; with several hosts it first listens
  // for other controllers for a moment, then begins or calls hooks.on_fenced. The node, whose
  // domain is `domain_id`, and the config must outlive the controller. A takeover runs the loop
  // until the controller that it ends is received: not for a callback.
  static Result<std::unique_ptr<Controller>> Make(transport::Node& node, int domain_id,
                                                  const MachineConfig& config,
                                                  ControllerOptions options);
  // Leaves all processes running.
  ~Controller();

  ControllerShell& shell() { return *shell_; }
  // It waits for the controller of another host to fail, and leads nothing.
  bool stands_by() const { return standby_ != nullptr; }
  // See ProcessSupervisor: for a process that only runs this controller.
  void AdoptOrphans() { processes_.AdoptOrphans(); }
  void ReapOrphans() { processes_.ReapOrphans(); }
  // Waits until all records and saves are on disk, at most `timeout`; returns whether they are.
  bool Flush(Duration timeout);
  // Calls `then` on the loop once everything recorded before is in the journal's file; of a disk
  // that does not answer after two seconds all the same.
  void OnceRecorded(std::function<void()> then);

 private:
  Controller(transport::Node& node, int domain_id, const MachineConfig& config,
             ControllerOptions options);
  Result<> Open();
  Result<> OpenStore();
  Result<> EndOwner();
  Result<> ReachesActuators() const;
  void ShareStore();
  Result<> TakeName();
  Result<> OpenShell();
  Result<> OpenHosts();
  void AddSaves(ShellDependencies& dependencies);
  ControllerShell::Hooks ShellHooks();
  Result<> OpenServices();
  std::unique_ptr<transport::HostServer> MakeHostServer();
  Result<> OpenExtensions();
  void CheckFolder();
  MachineOrigin Origin() const;
  std::string CopiedText() const;
  Result<> MayTakeOver(pid_t controller) const;
  void WatchStopsHere();
  void TakeStopsHere();
  void BeginAfter(Duration listen);
  bool StandBy();
  void GoOnWith(const msg::MachineStatus& status, event::Begin& begin);
  void BeginUnlessLed();
  void WatchMajority();
  ActuatorPeers::RunsHere RunsHere() const;
  void CountHeld();
  std::optional<Error> WhyNotBeside() const;
  void BeginOnceReceived(Time deadline);
  void Begin();
  std::string LockOf(const std::string& actuator) const;
  std::vector<ChildProcess> FindRunning(event::Begin& begin);
  pid_t HolderOf(ActuatorIndex i);
  void EndUnlisted(const ChildProcess& child);
  Epoch LoadEpoch();
  const std::string& LastFolder() const;
  std::vector<std::string> OtherFolders() const;
  StoredStops LoadStops();
  StoredPolicy LoadPolicy();
  std::vector<StoredActuator> LoadActuators();
  Result<> RunsOnce() const;
  std::string IdOfActuators() const;
  void TakeIdOfActuators();
  void TakeIdentity();
  void KeepIdentity(const std::string& id);
  void OpenLogs();
  void WatchNetwork();
  UserRules Rules();
  void Trouble(const std::string& message);

  transport::Node& node_;
  const int domain_id_;
  const std::vector<std::string> computer_ = ComputerParts();
  const MachineConfig& config_;
  ControllerOptions options_;
  std::shared_ptr<StateStore> store_;  // null if the folder is unusable; pending saves hold it, too
  std::unique_ptr<JournalSink> journal_;
  Journal* file_journal_ = nullptr;       // the same, when there is a store
  std::optional<HistoryReader> history_;  // of file_journal_
  std::optional<NameLock> name_;          // of the leader of this namespace on this host
  std::size_t held_ = 0;                  // actuators of this host whose name is held
  std::string taken_from_;                // state folder of the controller that was taken over
  std::string last_config_hash_;          // of the config of the previous controller
  bool began_in_this_boot_ = false;       // the previous controller, since this host was booted
  bool listen_for_others_ = false;        // another controller may already lead
  const Incarnation incarnation_{NewIncarnation()};
  transport::DiskWriter disk_;
  std::unique_ptr<LogFiles> logs_;  // null without a store
  ProcessSupervisor processes_;
  KernelProbe process_probe_;
  std::unique_ptr<HostProcesses> hosts_;  // null unless units run processes
  std::unique_ptr<ControllerShell> shell_;
  std::unique_ptr<transport::RosNodes> ros_nodes_;              // null unless this controller leads
  std::unique_ptr<ControllerServices> services_;                // null unless this controller leads
  std::vector<std::unique_ptr<ExtensionServices>> extensions_;  // none unless this one leads
  std::unique_ptr<Ros2Tools> ros2_tools_;                       // null unless this controller leads
  std::unique_ptr<Standby> standby_;              // null unless this controller stands by
  std::optional<std::string> stood_by_for_;       // why, as last reported
  std::optional<msg::MachineStatus> led_before_;  // by the controller that this standby replaces
  MajorityReach majority_;
  transport::LoopHandlePtr majority_watch_;
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);
  transport::LoopHandlePtr begin_later_;
  std::unique_ptr<transport::NetworkWatch> network_watch_;  // null unless the profile is lan
  transport::LoopHandlePtr stops_here_;    // receives stops of processes of this host
  bool folder_fails_ = false;              // files that were removed cannot be saved again
  transport::LoopHandlePtr check_folder_;  // periodically, from the beginning of the machine on
  std::vector<transport::LoopHandlePtr> kill_later_;  // for processes that the config does not list
};

}  // namespace musher
