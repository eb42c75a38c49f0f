#pragma once
// The controller process that `musher up` starts. It runs in a session of its own: Ctrl-C in the
// terminal reaches the launcher (up_launcher.hpp), which sends SIGTERM; the controller then takes
// the machine down within its shutdown budget and exits.
//
//   Run(): join the domain ─▶ take the machine over ─▶ lead it until it is stopped ─▶ exit code 0
//                 └──────────────────┴─▶ "not-started" to the launcher ─▶ exit code 2
//   another controller takes the machine over: "fenced" to the launcher ─▶ exit code 1
//
// In the latter two cases the actuators' processes keep running.
//
// A machine that was started from an upgrade root (slot_run.hpp) may stop and restart from another
// slot: Run() then returns once the machine is stopped, and StartsAgain() is true.
//
// Threads: loop thread; the disk, the journal and Cyclone have threads of their own.

#include <sys/types.h>

#include <memory>
#include <optional>
#include <string>

#include "musher/cli/console/exit_code.hpp"
#include "musher/cli/start/controller_log.hpp"
#include "musher/cli/start/progress.hpp"
#include "musher/cli/start/service_manager.hpp"
#include "musher/cli/start/slot_run.hpp"
#include "musher/cli/start/view_process.hpp"
#include "musher/controller/controller.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::cli {

class ControllerProcess {
 public:
  // Start options; see ControllerOptions.
  struct Start {
    bool takeover = false;
    bool adopt = false;
    bool restarted = false;
    bool supervised = false;
    bool standby = false;
  };
  // `launcher`: pid of the process in the foreground, 0 for none. If it is killed, this process is
  // killed too, until the launcher detaches: after a failed start, or when its terminal was closed
  // (SIGHUP).
  // `root_lock`: of the run's root; it outlives this object, so that no other start comes between
  // this controller and the program that it executes after itself.
  ControllerProcess(const MachineConfig& config, std::optional<SlotRun> run, RootLock& root_lock,
                    UniqueFd progress, pid_t launcher, Start start);

  // Call in a new process, before it has threads. Returns its exit code.
  int Run();
  bool StartsAgain() const { return start_again_; }
  pid_t launcher() const { return launcher_; }  // 0: none, or detached

 private:
  Result<> Begin();
  void BeginRun();
  void PostponeTrial();
  bool Abandon(const Error& why);
  void OnTrialBootEnd(const Result<>& outcome);
  void StartAgain(const std::string& why);
  ControllerOptions Options();
  void OnRecord(const action::Record& record);
  void MarkTakingDown();
  void OnStartUpEnded(const action::StartUpEnded& ended);
  void OnFenced(const std::string& message);
  void OnTrouble(const std::string& message);
  void OnStandby(const std::string& why);
  void ShowPage();
  void OnSignal();
  void ContinueWithoutTerminal();
  void TakeDown();
  void DetachLauncher();
  void SendProgress(const std::string& kind, const std::string& message,
                    std::int32_t code = kCodeOk);

  const MachineConfig& config_;
  const std::optional<SlotRun> run_;
  RootLock& root_lock_;
  pid_t launcher_;
  const Start start_;
  bool start_again_ = false;
  bool released_ = false;    // to another controller of this host
  bool taken_down_ = false;  // by a signal: nothing starts again
  bool marked_ = false;      // that it takes the machine down for the slot that is due
  ExitCode exit_ = ExitCode::kDone;
  UniqueFd signals_;
  UniqueFd release_;
  UniqueFd again_;
  UniqueFd children_;
  transport::LinuxEventLoop loop_;
  ProgressSender progress_;
  transport::DiskWriter disk_;  // for the log and the end of a trial boot
  ControllerLog log_;
  ServiceManager service_manager_;
  std::unique_ptr<transport::Node> node_;
  std::unique_ptr<Controller> controller_;
  transport::LoopHandlePtr signal_watch_;
  transport::LoopHandlePtr release_watch_;
  transport::LoopHandlePtr again_watch_;
  transport::LoopHandlePtr children_watch_;
  std::optional<action::StartUpEnded> start_up_;  // of a trial boot; not reported yet
  bool start_held_ = false;                       // an emergency stop has refused the start-up
  std::optional<TrialBoot> trial_boot_;
  std::optional<ViewProcess> view_;
};

}  // namespace musher::cli
