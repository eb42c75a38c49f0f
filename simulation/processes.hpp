#pragma once
// The processes of a simulated robot's actuators: the real shell and decision code of each, with a
// Module behind it instead of a program. Several actuators may share a process; an actuator may run
// on several hosts at once, and then should not.
//
// Threads: one, that of the network.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "musher/actuator/actuator_shell.hpp"
#include "musher/controller/process_runner.hpp"
#include "musher/lifecycle/health_monitor.hpp"
#include "musher/simulation/hosts.hpp"
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
  // All must outlive it.
  Processes(transport::sim::Network& network, const MachineConfig& config, Hosts& hosts,
            const Layout& layout);
  ~Processes();
  Processes(const Processes&) = delete;
  Processes& operator=(const Processes&) = delete;

  std::function<std::unique_ptr<Module>(const std::string& name)> make_module;
  // After each step of an actuator; may be empty.
  std::function<void(const std::string& name, std::size_t host, const ActuatorReport& report)>
      on_report;
  // A process has ended.
  std::function<void(std::size_t host, std::int32_t pid, const ProcessExit& exit)> on_end;

  // A program that is no actuator of ours runs behind that name; made anew with each process.
  using Program = std::function<std::shared_ptr<void>(transport::Node& node)>;
  void UseProgram(const std::string& name, Program program) {
    programs_[name] = std::move(program);
  }

  // Where a name stands without a host, the process on the actuator's own host is meant, else any.

  // Starts the process of an actuator that does not run there; gives its pid.
  std::int32_t Launch(const std::string& name) { return Launch(name, HomeOf(name)); }
  std::int32_t Launch(const std::string& name, std::size_t host);
  bool IsAlive(const std::string& name) const { return Find(name) != nullptr; }
  bool IsAlive(const std::string& name, std::size_t host) const {
    return Find(name, host) != nullptr;
  }
  std::size_t CountOf(const std::string& name) const;  // of its processes, on all hosts
  void End(const std::string& name, const ProcessExit& exit);
  void End(const std::string& name, std::size_t host, const ProcessExit& exit);
  void EndAllOn(std::size_t host);
  // Its configuration is wrong, or is mended: while it is wrong a process that starts ends with
  // exit code 2 before it says a word.
  void Misconfigure(const std::string& name, bool wrong);
  bool IsMisconfigured(const std::string& name) const { return misconfigured_.count(name) > 0; }
  void Freeze(const std::string& name);  // SIGSTOP
  void Thaw(const std::string& name);    // SIGCONT
  bool IsFrozen(const std::string& name) const;
  bool IsFrozen(const std::string& name, std::size_t host) const;
  // It says once that it is in that state, which it is not.
  void Lie(const std::string& name, const State& state);
  // One that is stopped dies of SIGKILL only.
  Result<> Signal(std::size_t host, std::int32_t pid, int signal);
  Examination Examine(std::size_t host, std::int32_t pid) const;
  std::int32_t PidOf(const std::string& name) const;  // 0: it does not live
  std::int32_t PidOf(const std::string& name, std::size_t host) const;
  // Of the process, among all that ever ran; 0: there is none.
  std::uint64_t SerialOf(std::size_t host, std::int32_t pid) const;
  bool IsProgram(const std::string& name) const { return programs_.contains(name); }
  bool Exists(std::size_t host, std::int32_t pid) const { return Find(host, pid) != nullptr; }
  std::size_t HomeOf(const std::string& name) const;

  // What the actuator itself says; null when its process does not live or is a program.
  const ActuatorReport* ReportOf(const std::string& name) const;
  const ActuatorReport* ReportOf(const std::string& name, std::size_t host) const;
  // Null as above.
  const ActuatorCore* CoreOf(const std::string& name, std::size_t host) const;
  // Whether its hardware is energised: a callback that leads up switches it on at its end, one that
  // leads to DeActive or below switches it off, and so does an emergency stop. Not of a module with
  // a worker of its own.
  bool IsPowered(const std::string& name, std::size_t host) const;
  // Whether the last is known: of a module with a worker of its own it is not.
  bool HasPower(const std::string& name, std::size_t host) const;
  // The endpoint of its process on the network, and since when it runs; the process must live.
  const std::string& EndpointOf(const std::string& name, std::size_t host) const;
  Time StartOf(const std::string& name, std::size_t host) const;

 private:
  class SimWorker;
  struct Part {  // an actuator of the process
    std::string name;
    std::unique_ptr<transport::Publisher<msg::ActuatorStatus>> lies;
    std::unique_ptr<Module> module;
    std::unique_ptr<Worker> worker;
    std::unique_ptr<ActuatorShell> shell;
    std::shared_ptr<void> program;  // instead of the shell
    bool torn_down = false;
    bool has_power = false;
    bool powered = false;
  };
  // A callback that runs.
  struct Running {
    Duration takes{};
    State target;
  };
  struct Process {
    std::uint64_t serial = 0;  // of all hosts, ever
    std::size_t host = 0;
    std::int32_t pid = 0;
    std::string endpoint;
    Time started{};
    bool frozen = false;
    std::unique_ptr<transport::Node> node;
    std::vector<std::unique_ptr<Part>> parts;
  };

  const Process* Find(const std::string& name) const;
  const Process* Find(const std::string& name, std::size_t host) const;
  const Process* Find(std::size_t host, std::int32_t pid) const;
  Process* Find(const std::string& name) {
    return const_cast<Process*>(std::as_const(*this).Find(name));
  }
  static const Part& PartOf(const Process& process, const std::string& name);
  void AddPart(Process& process, const std::string& name);
  void OnFinished(const std::string& name, std::uint64_t serial, const Error& error);
  // Ends it after the callback that is running now.
  void EndLater(std::uint64_t serial, const ProcessExit& exit);
  void End(std::uint64_t serial, const ProcessExit& exit);
  ActuatorShell::Hooks HooksOf(const Process& process, Part& part,
                               const std::shared_ptr<Running>& running);
  void SwitchPower(Part& part, const State& target) const;

  transport::sim::Network& network_;
  const MachineConfig& config_;
  Hosts& hosts_;
  const Layout& layout_;
  std::unique_ptr<transport::Node> keeper_;  // whose loop runs what belongs to no process
  std::map<std::string, Program> programs_;
  std::map<std::uint64_t, Process> alive_;                      // by serial
  std::map<std::string, std::vector<const Process*>> running_;  // by actuator
  std::set<std::string> misconfigured_;
};

}  // namespace musher::simulation
