#pragma once
// Runs what an ExecConfig says for a state: commands, and the start and stop of the program.
//
//   SetUp     start the program, then run the command; both must succeed
//   others    run the command
//   TearDown  run the command, and when that has succeeded stop the program
//
// At an emergency stop it runs the command of [emergency_stop], then ends the program if the config
// says so. A program that was ended so is started by a new process alone.
//
// Commands and the program inherit the environment and get that of the config, MUSHER_STATE,
// MUSHER_ACTUATOR and, beside a program, MUSHER_PROGRAM_PID (which is also the number of its
// process group). A command of a state that runs during an emergency stop has also
// MUSHER_EMERGENCY_STOP=1.
//
// Threads: Run() on one thread at a time, RunEmergencyStop() on another one beside it; exceptions
// are stated below.

#include <atomic>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/lifecycle/state.hpp"
#include "musher/modules/exec/command.hpp"
#include "musher/modules/exec/exec_config.hpp"

namespace musher::exec {

// A command as a person wrote it, at most one line of a table.
std::string CommandText(const std::vector<std::string>& argv);

class StateRunner {
 public:
  // The reaper must outlive the runner. What still runs when the runner is destroyed is killed.
  StateRunner(std::string actuator, ExecConfig config, const Reaper& reaper);

  // An Error has CyberDog's code in the config's module, and the last line of the command's
  // output. `stopped`: an emergency stop is engaged, which the command is given to know.
  Result<> Run(const State& state, const std::function<bool()>& stop_requested, bool stopped);

  // Whether Run() of the state runs a command. Any thread.
  bool HasCommand(const State& state) const;

  // What the config says for an emergency stop. An Error says what was not done.
  Result<> RunEmergencyStop();

  // Why no state can be entered any more that switches on: an emergency stop has ended the program.
  // Nothing while it has not. Any thread.
  std::optional<Error> EndedByStop() const;

  // From now on commands are stopped (kNo) or killed (kGetDone), and no new ones started. Any
  // thread.
  void Hurry(Wanted wanted) { wanted_ = wanted; }

  // Any thread, from the end of SetUp on: readable as soon as the program has exited, -1 when
  // there is none. Stays open as long as the runner.
  int program_watch() const { return program_watch_.get(); }

  // Whether the program is being stopped, so that its exit is expected. Any thread.
  bool tearing_down() const { return tearing_down_; }

  // Not while Run() runs. Waits for the program and returns how it exited; nothing without a
  // program.
  std::optional<ExitStatus> AwaitProgram();
  // Not while Run() runs. Ends the program with SIGTERM, or SIGKILL after the config's stop_ms.
  void StopProgram();

 private:
  using StopRequested = std::function<bool()>;

  Result<> StartProgram(const std::vector<std::string>& argv);
  Result<> EndProgram();
  Result<> RunStopCommand(const EmergencyStopAction& action);
  Result<> SetUp(const StateActions& actions, const StopRequested& stop_requested);
  Result<> TearDown(const StateActions& actions, const StopRequested& stop_requested);
  Result<> RunOne(const State& state, const StateActions& actions,
                  const StopRequested& stop_requested);
  // `why_stopped` follows the command in the reason if it was stopped.
  Result<> ResultOf(const CommandEnd& end, const std::vector<std::string>& argv,
                    const std::string& why_stopped) const;
  ChildSpec Spec(const State& state, const std::vector<std::string>& argv) const;
  Error Failure(KeyCode key, const std::string& message) const;

  const std::string actuator_;
  const ExecConfig config_;
  const Reaper& reaper_;
  bool stopped_ = false;  // of the command that runs; of Run() alone
  std::atomic<Wanted> wanted_ = Wanted::kYes;
  std::atomic<bool> tearing_down_ = false;
  std::atomic<bool> ended_by_stop_ = false;
  std::mutex program_mutex_;  // held while the program is started, ended or reaped
  std::optional<Child> program_;
  std::atomic<pid_t> program_pid_ = 0;  // 0: there is none
  UniqueFd program_watch_;
};

}  // namespace musher::exec
