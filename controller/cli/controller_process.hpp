#pragma once
// The process that leads a machine, as `musher up` starts it. In a session of its own: Ctrl-C in
// the terminal is for the front, which asks with SIGTERM; the machine is then taken down within its
// shutdown budget, and the process ends.
//
//   Run(): join the domain ─▶ take the machine over ─▶ lead it until it is stopped ─▶ exit code 0
//                 └──────────────────┴─▶ "not-started" to the front ─▶ exit code 2
//   led by another controller from now on: "fenced" to the front ─▶ exit code 1
//
// In the latter two the actuators' processes go on.
//
// A machine that was started from a root (slot_run.hpp) may end to start again, from another slot:
// Run() returns when it is stopped, and StartsAgain() holds.
//
// Threads: the loop's; the disk, the journal and Cyclone have their own.

#include <sys/types.h>

#include <memory>
#include <optional>
#include <string>

#include "musher/controller/cli/controller_log.hpp"
#include "musher/controller/cli/exit_code.hpp"
#include "musher/controller/cli/progress.hpp"
#include "musher/controller/cli/service_manager.hpp"
#include "musher/controller/cli/slot_run.hpp"
#include "musher/controller/controller.hpp"
#include "musher/lifecycle/config.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::cli {

class ControllerProcess {
 public:
  // How it begins; each as ControllerOptions has it.
  struct Start {
    bool takeover = false;
    bool adopt = false;
    bool restarted = false;
  };
  // `front`: the process in the foreground. If it is killed, so are we, until it has left: after a
  // failed start, or because its terminal was closed (SIGHUP). 0: there is none. `restarted`: see
  // ControllerOptions.
  ControllerProcess(const MachineConfig& config, std::optional<SlotRun> run,
                    transport::UniqueFd progress, pid_t front, Start start);

  // In a new process, before it has threads. Gives its exit code.
  int Run();
  bool StartsAgain() const { return start_again_; }
  pid_t front() const { return front_; }  // 0: there is none, or none any more

 private:
  Result<> Begin();
  void BeginRun();
  void OnTrialBootEnd(const Result<>& outcome);
  void StartAgain(const std::string& why);
  ControllerOptions Options();
  void OnRecord(const action::Record& record);
  void OnStartUpEnded(const action::StartUpEnded& ended);
  void OnFenced(const std::string& message);
  void OnTrouble(const std::string& message);
  void OnSignal();
  void GoOnAlone();
  void TakeDown();
  void LeaveFront();
  void Tell(const std::string& kind, const std::string& message, std::int32_t code = kCodeOk);

  const MachineConfig& config_;
  const std::optional<SlotRun> run_;
  pid_t front_;
  const Start start_;
  bool start_again_ = false;
  ExitCode exit_ = ExitCode::kDone;
  transport::UniqueFd signals_;
  transport::UniqueFd let_go_;
  transport::UniqueFd again_;
  transport::UniqueFd children_;
  transport::LinuxEventLoop loop_;
  ProgressSender progress_;
  DiskWriter disk_;  // for the log and the end of a trial
  ControllerLog log_;
  ServiceManager service_manager_;
  std::unique_ptr<transport::Node> node_;
  std::unique_ptr<Controller> controller_;
  transport::LoopHandlePtr signal_watch_;
  transport::LoopHandlePtr let_go_watch_;
  transport::LoopHandlePtr again_watch_;
  transport::LoopHandlePtr children_watch_;
  RootLock root_lock_;
  std::optional<action::StartUpEnded> start_up_;  // of a version on trial, not told yet
  std::optional<TrialBoot> trial_boot_;
};

}  // namespace musher::cli
