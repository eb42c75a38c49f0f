#pragma once
// The foreground process of `musher up`: prints what the controller process reports and forwards
// signals to it. On a terminal a table shows the actuators while the machine is on its way.
//
//                       ┌ --detach: exits with 0
//   starting ─ usable ──┴▶ stays ─ stopped ─▶ 0; 1 if the TearDown was done-degraded
//      ├─ SIGHUP, terminal closed ─▶ exits with 0; the controller continues, as with --detach
//      ├─ stands by ─▶ stays, with --detach exits with 0; it may become usable much later
//      ├─ failed ─▶ exits with 1; the controller and the actuators stay up for inspection
//      ├─ not started ─▶ 2
//      ├─ taken over by another controller, now or later ─▶ 1
//      └─ stopped before it was usable ─▶ 1
//
// With --restarted a machine that is stopped is 0 in each case: after a failure the supervisor
// would start it again; so a takeover is 2, which the unit has in RestartPreventExitStatus.
//
// If its output is lost (`musher up … | head -2`, a full disk), this process reports that once on
// stderr and continues; its exit code is about the machine. A service has no terminal: there SIGHUP
// does nothing.
//
// As process 1 of a container it reaps orphaned processes.
//
// SIGABRT, which systemd's watchdog sends to this process as the main process, is forwarded too, so
// that the controller exits and leaves a core dump.
//
// Threads: one. Does not use DDS.

#include <sys/types.h>

#include <string>

#include "musher/cli/commands/switch_progress.hpp"
#include "musher/cli/console/console.hpp"
#include "musher/cli/start/progress.hpp"
#include "musher/cli/start/repetitions.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::cli {

class UpLauncher {
 public:
  // `signals`: TakeEndSignals(). `restarted`: see UpOptions. The config must outlive this.
  UpLauncher(Console& console, const MachineConfig& config, pid_t controller, UniqueFd progress,
             UniqueFd signals, bool detach, bool restarted);

  ExitCode Run();

 private:
  void OnProgress(const Progress& progress);
  void OnStartUp(const Progress& progress);
  void OnStandby();
  void OnEnd();
  void Show(const Progress& progress);
  void OnSignal();
  void OnTerminalClosed();
  void OnAbort();
  void ReapOrphans();
  void Leave(ExitCode exit);
  std::string Controller() const;  // "the controller (pid 4711)"

  Console& console_;
  const std::string machine_;
  const pid_t controller_;
  const bool detach_;
  const bool restarted_;
  Repetitions repetitions_;
  bool reported_unread_ = false;
  bool came_up_ = false;
  bool stopped_ = false;
  std::string incomplete_stop_;  // why the TearDown was done-degraded; empty: it was not
  bool stop_requested_ = false;
  bool failed_to_start_ = false;
  bool fenced_ = false;
  ExitCode exit_ = ExitCode::kNotDone;
  UniqueFd signals_;
  UniqueFd abort_;
  UniqueFd children_;  // as process 1 only
  transport::LinuxEventLoop loop_;
  transport::LoopHandlePtr signal_watch_;
  transport::LoopHandlePtr abort_watch_;
  transport::LoopHandlePtr children_watch_;
  transport::LoopHandlePtr begin_watch_;  // until the controller has sent something
  SwitchProgress table_;
  ProgressReceiver progress_;
};

}  // namespace musher::cli
