#pragma once
// What the terminal sees of `musher up`: the process in the foreground, which shows what the
// controller process tells and hands signals on to it.
//
//                       ┌ detached: leaves with 0
//   starting ─ usable ──┴▶ stays ─ stopped ─▶ 0
//      ├─ SIGHUP, its terminal was closed ─▶ leaves with 0; the controller goes on, as if detached
//      ├─ failed ─▶ leaves with 1; the controller and the actuators stay up for inspection
//      ├─ not started ─▶ 2
//      ├─ taken over by another controller, now or later ─▶ 1
//      └─ stopped before it was usable ─▶ 1; 0 where a supervisor may have started it again and
//         it has finished the TearDown of the controller before
//
// A reader of its output that ends (`musher up … | head -2`) changes nothing but that this process
// says so once on stderr. A service has no terminal: there SIGHUP does nothing.
//
// As process 1 of a container it reaps what has lost its parent.
//
// SIGABRT, which systemd's watchdog sends to its main process, this one, is handed on too, so that
// it is the controller that ends and leaves a core dump.
//
// Threads: one. Has no DDS.

#include <sys/types.h>

#include <string>

#include "musher/controller/cli/console.hpp"
#include "musher/controller/cli/progress.hpp"
#include "musher/controller/cli/repetitions.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::cli {

class UpLauncher {
 public:
  // `signals`: TakeEndSignals(). `restarted`: as UpOptions has it.
  UpLauncher(Console& console, std::string machine, pid_t controller, transport::UniqueFd progress,
             transport::UniqueFd signals, bool detach, bool restarted);

  ExitCode Run();

 private:
  void OnProgress(const Progress& progress);
  void OnStartUp(const Progress& progress);
  void OnEnd();
  void Show(const Progress& progress);
  void OnSignal();
  void OnTerminalClosed();
  void OnAbort();
  void ReapOrphans();
  void Leave(ExitCode exit);
  std::string Controller() const;  // "the controller, process 4711"

  Console& console_;
  const std::string machine_;
  const pid_t controller_;
  const bool detach_;
  const bool restarted_;
  Repetitions repetitions_;
  bool said_unread_ = false;
  bool came_up_ = false;
  bool stopped_ = false;
  bool stop_asked_ = false;
  bool failed_to_start_ = false;
  bool fenced_ = false;
  ExitCode exit_ = ExitCode::kNotDone;
  transport::UniqueFd signals_;
  transport::UniqueFd abort_;
  transport::UniqueFd children_;  // as process 1 only
  transport::LinuxEventLoop loop_;
  transport::LoopHandlePtr signal_watch_;
  transport::LoopHandlePtr abort_watch_;
  transport::LoopHandlePtr children_watch_;
  ProgressReceiver progress_;
};

}  // namespace musher::cli
