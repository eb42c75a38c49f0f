#pragma once
// Runs what an ExecConfig says for a state: commands, and the start and stop of the program.
//
//   SetUp     start the program, then run the command; both must succeed
//   others    run the command
//   TearDown  run the command, and when that has succeeded stop the program
//
// Commands and the program inherit the environment and get that of the config, MUSHER_STATE,
// MUSHER_ACTUATOR and, beside a program, MUSHER_PROGRAM_PID (which is also the number of its
// process group).
//
// Threads: Run() on one thread at a time; exceptions are stated below.

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/lifecycle/state.hpp"
#include "musher/modules/exec/command.hpp"
#include "musher/modules/exec/exec_config.hpp"

namespace musher::exec {

class StateRunner {
 public:
  // The reaper must outlive the runner. What still runs when the runner is destroyed is killed.
  StateRunner(std::string actuator, ExecConfig config, const Reaper& reaper);

  // An Error has CyberDog's code in the config's module, and the last line of the command's
  // output.
  Result<> Run(const State& state, const std::function<bool()>& stop_requested);

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

  Result<> SetUp(const StateActions& actions, const StopRequested& stop_requested);
  Result<> TearDown(const StateActions& actions, const StopRequested& stop_requested);
  Result<> RunOne(const State& state, const StateActions& actions,
                  const StopRequested& stop_requested);
  Result<> ResultOf(const CommandEnd& end, const std::vector<std::string>& argv) const;
  ChildSpec Spec(const State& state, const std::vector<std::string>& argv) const;
  Error Failure(KeyCode key, const std::string& message) const;

  const std::string actuator_;
  const ExecConfig config_;
  const Reaper& reaper_;
  std::atomic<Wanted> wanted_ = Wanted::kYes;
  std::atomic<bool> tearing_down_ = false;
  std::optional<Child> program_;
  UniqueFd program_watch_;
};

}  // namespace musher::exec
