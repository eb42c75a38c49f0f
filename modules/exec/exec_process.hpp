#pragma once
// A musher-exec process: an actuator whose callbacks run commands. It also watches its program and
// handles the signals that end it.
//
// Threads: Run() belongs to the main thread, with a loop for signals and the program's exit. A
// second thread starts the actuator and waits for its end, since both block. Commands run on the
// actuator's worker, the action of an emergency stop on a thread of its own: a command that hangs
// does not keep it from running.

#include <csignal>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/base/work_queue.hpp"
#include "musher/modules/exec/state_runner.hpp"
#include "musher/modules/exec/stop_confirmation.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::exec {

class ExecActuator : public MachineActuator {
 public:
  // `on_stop` is called on the actuator's loop, and must return at once.
  ExecActuator(const std::string& name, std::function<void()> on_stop)
      : MachineActuator(name), on_stop_(std::move(on_stop)) {}

 protected:
  void OnEmergencyStop() override { on_stop_(); }

 private:
  const std::function<void()> on_stop_;
};

class ExecProcess {
 public:
  // Blocks SIGTERM, SIGINT and SIGHUP and reads them from a descriptor: construct it before any
  // thread. The reaper must outlive the process.
  ExecProcess(const std::string& actuator_name, ExecConfig config, const Reaper& reaper);

  // Runs from SetUp to the end; returns the exit code: 0 after TearDown or a signal, 1 when SetUp
  // failed or the program exited by itself, which is printed on stderr.
  int Run(const std::string& state_config);

 private:
  void RunActuator();                     // on the second thread
  Result<> RunState(const State& state);  // on the worker
  // On the worker. Returns whether an emergency stop is engaged, below which the command runs.
  bool BeginCommand(const State& state);
  void EndCommand(bool nothing_left);
  void OnEmergencyStop();  // on the actuator's loop
  void BeginStopAction();  // stops_mutex_ is held
  void RunStopAction(std::uint64_t number);
  void OnSetUp(bool ok);
  void OnSignal();
  void EvaluateProgram();
  void End(int exit_code, Wanted wanted);

  std::mutex stops_mutex_;  // guards the next one, together with what is reported of it
  StopConfirmation confirmation_;
  const bool has_stop_action_;
  transport::LinuxEventLoop loop_;
  StateRunner runner_;
  UniqueFd signals_;  // before any thread
  WorkQueue stop_thread_{{.name = "emergency-stop"}};
  ActuatorRunner<ExecActuator> actuator_;
  transport::LoopHandlePtr signal_watch_;
  transport::LoopHandlePtr program_watch_;
  bool set_up_ended_ = false;     // Start() has returned
  std::optional<int> exit_code_;  // the process is ending
  bool program_lost_ = false;
};

}  // namespace musher::exec
