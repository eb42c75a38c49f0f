#pragma once
// The processes of a simulated robot's actuators: the real shell and decision code of each, on a
// host of its own, with a Module behind it instead of a program.
//
// Threads: one, that of the network.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "musher/actuator/actuator_shell.hpp"
#include "musher/controller/process_runner.hpp"
#include "musher/lifecycle/health_monitor.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::simulation {

// How the callback of a state went: how long it took, and its code.
struct Act {
  Duration takes = Milliseconds(5);
  Error error{kCodeOk, ""};
};

// What stands behind an actuator; made anew with each process. Its callback runs at once when the
// state is commanded, and its end is told as much later, in virtual time, as it says; unless it
// brings a worker of its own.
class Module {
 public:
  virtual ~Module() = default;
  virtual Act Run(const State& state) = 0;
  // Runs its callbacks on the loop of its process; null: as said above.
  virtual std::unique_ptr<Worker> MakeWorker(transport::EventLoop& /*loop*/) { return nullptr; }
  virtual void SetStopRequested(bool /*requested*/) {}
  virtual void OnEmergencyStop() {}
  virtual void OnReport(const ActuatorReport& /*report*/) {}  // after each step of the actuator
};

// How one ends that finds its configuration wrong.
inline ProcessExit WrongConfigExit() {
  return {ProcessExit::Kind::kExited, kUsageExitCode, "its configuration is wrong"};
}

class Processes {
 public:
  // Both must outlive it.
  Processes(transport::sim::Network& network, const MachineConfig& config);
  ~Processes();
  Processes(const Processes&) = delete;
  Processes& operator=(const Processes&) = delete;

  std::function<std::unique_ptr<Module>(const std::string& name)> make_module;
  // After each step of an actuator; may be empty.
  std::function<void(const std::string& name, const ActuatorReport& report)> on_report;
  // A process has ended.
  std::function<void(std::int32_t pid, const ProcessExit& exit)> on_end;

  // A program that is no actuator of ours runs behind that name; made anew with each process.
  using Program = std::function<std::shared_ptr<void>(transport::Node& node)>;
  void UseProgram(const std::string& name, Program program) {
    programs_[name] = std::move(program);
  }

  // Starts the process of an actuator that is not alive; gives its pid.
  std::int32_t Launch(const std::string& name);
  std::int32_t NewPid() { return next_pid_++; }
  bool IsAlive(const std::string& name) const { return alive_.count(name) > 0; }
  void End(const std::string& name, const ProcessExit& exit);
  // Ends it after the callback that is running now, if it is that process still.
  void EndLater(const std::string& name, std::int32_t pid, const ProcessExit& exit);
  // Its configuration is wrong, or is mended: while it is wrong a process that starts ends with
  // exit code 2 before it says a word.
  void Misconfigure(const std::string& name, bool wrong);
  bool IsMisconfigured(const std::string& name) const { return misconfigured_.count(name) > 0; }
  void Freeze(const std::string& name);  // SIGSTOP
  void Thaw(const std::string& name);    // SIGCONT
  bool IsFrozen(const std::string& name) const { return alive_.at(name).frozen; }
  // It says once that it is in that state, which it is not.
  void Lie(const std::string& name, const State& state);
  // One that is stopped dies of SIGKILL only.
  Result<> Signal(std::int32_t pid, int signal);
  Examination Examine(std::int32_t pid) const;
  std::int32_t PidOf(const std::string& name) const {  // 0: it does not live
    const auto process = alive_.find(name);
    return process == alive_.end() ? 0 : process->second.pid;
  }
  bool Exists(std::int32_t pid) const { return !NameOf(pid).empty(); }

  // What the actuator itself says; null when its process does not live or is a program.
  const ActuatorReport* ReportOf(const std::string& name) const;

 private:
  class SimWorker;
  struct Process {
    std::int32_t pid = 0;
    std::unique_ptr<transport::Node> node;
    std::unique_ptr<transport::Publisher<msg::ActuatorStatus>> lies;
    std::unique_ptr<Module> module;
    std::unique_ptr<Worker> worker;
    std::unique_ptr<ActuatorShell> shell;
    bool frozen = false;
    std::shared_ptr<void> program;  // instead of the shell
  };

  std::string NameOf(std::int32_t pid) const;  // empty: none
  ActuatorShell::Hooks HooksOf(const std::string& name, const Process& process,
                               const std::shared_ptr<Duration>& takes);

  transport::sim::Network& network_;
  const MachineConfig& config_;
  std::unique_ptr<transport::Node> keeper_;  // whose loop runs what belongs to no process
  std::map<std::string, Program> programs_;
  std::map<std::string, Process> alive_;
  std::set<std::string> misconfigured_;
  std::int32_t next_pid_ = 1000;
};

}  // namespace musher::simulation
