#pragma once
// A musher-exec process: an actuator whose callbacks run commands. It also watches its program and
// handles the signals that end it.
//
// Threads: Run() belongs to the main thread, with a loop for signals and the program's exit. A
// second thread starts the actuator and waits for its end, since both block. Commands run on the
// actuator's worker.

#include <csignal>
#include <optional>
#include <string>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/modules/exec/state_runner.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::exec {

class ExecProcess {
 public:
  // Blocks SIGTERM, SIGINT and SIGHUP and reads them from a descriptor: construct it before any
  // thread. The reaper must outlive the process.
  ExecProcess(const std::string& actuator_name, ExecConfig config, const Reaper& reaper);

  // Runs from SetUp to the end; returns the exit code: 0 after TearDown or a signal, 1 when SetUp
  // failed or the program exited by itself, which is printed on stderr.
  int Run(const std::string& state_config);

 private:
  void RunActuator();  // on the second thread
  void OnSetUp(bool ok);
  void OnSignal();
  void EvaluateProgram();
  void End(int exit_code, Wanted wanted);

  transport::LinuxEventLoop loop_;
  StateRunner runner_;
  UniqueFd signals_;
  ActuatorRunner<MachineActuator> actuator_;
  transport::LoopHandlePtr signal_watch_;
  transport::LoopHandlePtr program_watch_;
  bool set_up_ended_ = false;     // Start() has returned
  std::optional<int> exit_code_;  // the process is ending
  bool program_lost_ = false;
};

}  // namespace musher::exec
