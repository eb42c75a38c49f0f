#pragma once
// The processes of a simulated robot's actuators: the real shell and decision code of each, with a
// Module behind it instead of a program. Several actuators may share a process. An actuator can run
// on several hosts at once, although it should not.
//
// Threads: the one of the network.

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
#include "musher/controller/process/process_runner.hpp"
#include "musher/lifecycle/health/health_monitor.hpp"
#include "musher/lifecycle/machine/machine_identity.hpp"
#include "musher/simulation/hosts.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::simulation {

// The outcome of a callback: how long it takes, and its code.
struct Act {
  Duration takes = Milliseconds(5);
  Error error{kCodeOk, ""};
};

// The callbacks behind an actuator; each process makes one. Run() is called at once when the state
// is commanded, and the callback's end is reported Act::takes later, in virtual time, unless the
// module has a worker of its own.
class Module {
 public:
  virtual ~Module() = default;
  virtual Act Run(const State& state) = 0;
  // Runs its callbacks on the loop of its process; null: as described above.
  virtual std::unique_ptr<Worker> MakeWorker(transport::EventLoop& /*loop*/) { return nullptr; }
  virtual void SetStopRequested(bool /*requested*/) {}
  virtual void OnEmergencyStop() {}
  virtual void OnReport(const ActuatorReport& /*report*/) {}  // after each step of the actuator
};

// The exit of a process with a configuration error.
inline ProcessExit WrongConfigExit() {
  return {ProcessExit::Kind::kExited, kUsageExitCode, "its configuration is wrong"};
}

class SimulatedProcesses {
 public:
  // All must outlive it.
  SimulatedProcesses(transport::sim::Network& network, const MachineConfig& config, Hosts& hosts,
                     const Layout& layout);
  ~SimulatedProcesses();
  SimulatedProcesses(const SimulatedProcesses&) = delete;
  SimulatedProcesses& operator=(const SimulatedProcesses&) = delete;

  std::function<std::unique_ptr<Module>(const std::string& name)> make_module;
  // After each step of an actuator; may be empty.
  std::function<void(const std::string& name, std::size_t host, const ActuatorReport& report)>
      on_report;
  // A process has ended.
  std::function<void(std::size_t host, std::int32_t pid, const ProcessExit& exit)> on_end;
  // Whether that process is the controller that holds the machine's name on that host; empty: none
  // does.
  std::function<bool(std::size_t host, std::int32_t pid)> leads_on;

  // A program that is not a Musher actuator runs under that name; each process makes one.
  using Program = std::function<std::shared_ptr<void>(transport::Node& node)>;
  void UseProgram(const std::string& name, Program program) {
    programs_[name] = std::move(program);
  }

  // A function without a host takes the process on the actuator's own host, or else any.

  // Starts the process of an actuator that does not run on that host; returns its pid.
  std::int32_t Launch(const std::string& name) { return Launch(name, HomeOf(name)); }
  // `machine`: as the controller that starts it says; empty: it is started by hand.
  std::int32_t Launch(const std::string& name, std::size_t host,
                      const MachineIdentity& machine = {});
  bool IsAlive(const std::string& name) const { return Find(name) != nullptr; }
  bool IsAlive(const std::string& name, std::size_t host) const {
    return Find(name, host) != nullptr;
  }
  // Processes in which it runs, on all hosts: not those that it has left by its TearDown.
  std::size_t CountOf(const std::string& name) const;
  void End(const std::string& name, const ProcessExit& exit);
  void End(const std::string& name, std::size_t host, const ProcessExit& exit);
  void EndAllOn(std::size_t host);
  // Makes its configuration invalid, or valid again: while it is invalid, a process that starts
  // exits with code 2 before it publishes anything.
  void Misconfigure(const std::string& name, bool wrong);
  bool IsMisconfigured(const std::string& name) const { return misconfigured_.count(name) > 0; }
  void Freeze(const std::string& name);  // SIGSTOP
  void Thaw(const std::string& name);    // SIGCONT
  bool IsFrozen(const std::string& name) const;
  bool IsFrozen(const std::string& name, std::size_t host) const;
  // Until when it was frozen; nullopt: never.
  std::optional<Time> FrozenUntil(const std::string& name, std::size_t host) const;
  // It publishes that state once, although it is not in it.
  void Lie(const std::string& name, const State& state);
  // A frozen process handles SIGKILL only.
  Result<> Signal(std::size_t host, std::int32_t pid, int signal);
  Examination Examine(std::size_t host, std::int32_t pid) const;
  std::int32_t PidOf(const std::string& name) const;  // 0: it does not run
  std::int32_t PidOf(const std::string& name, std::size_t host) const;
  // The serial number of the process among all that ever ran; 0: no such process.
  std::uint64_t SerialOf(std::size_t host, std::int32_t pid) const;
  bool IsProgram(const std::string& name) const { return programs_.contains(name); }
  bool Exists(std::size_t host, std::int32_t pid) const { return Find(host, pid) != nullptr; }
  std::size_t HomeOf(const std::string& name) const;

  // The actuator's own report; null when its process does not run or is a program.
  const ActuatorReport* ReportOf(const std::string& name) const;
  const ActuatorReport* ReportOf(const std::string& name, std::size_t host) const;
  // Null as above.
  const ActuatorCore* CoreOf(const std::string& name, std::size_t host) const;
  // Whether its hardware is energised: a callback towards a more active state switches it on at its
  // end, a callback to DeActive or below and an emergency stop switch it off. Not known of a module
  // with a worker of its own.
  bool IsPowered(const std::string& name, std::size_t host) const;
  // Whether IsPowered() is known.
  bool HasPower(const std::string& name, std::size_t host) const;
  // The endpoint of its process on the network, and since when it runs; the process must run.
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
    std::shared_ptr<void> program;       // instead of the shell
    std::optional<ActuatorReport> left;  // the last one of a shell that ended before its process
    bool torn_down = false;
    bool has_power = false;
    bool powered = false;
  };
  // The running callback.
  struct RunningCallback {
    Duration takes{};
    State target;
  };
  struct Process {
    std::uint64_t serial = 0;  // unique among all hosts
    std::size_t host = 0;
    std::int32_t pid = 0;
    std::string endpoint;
    Time started{};
    bool frozen = false;
    std::optional<Time> thawed;
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
  void AddPart(Process& process, const std::string& name, const MachineIdentity& machine);
  void OnFinished(const std::string& name, std::uint64_t serial, const Error& error);
  void LeaveLater(std::uint64_t serial);
  // Ends it after the current callback of the event loop.
  void EndLater(std::uint64_t serial, const ProcessExit& exit);
  void End(std::uint64_t serial, const ProcessExit& exit);
  ActuatorShell::Hooks HooksOf(const Process& process, Part& part,
                               const std::shared_ptr<RunningCallback>& running);
  void SwitchPower(Part& part, const State& target) const;

  transport::sim::Network& network_;
  const MachineConfig& config_;
  Hosts& hosts_;
  const Layout& layout_;
  std::unique_ptr<transport::Node> environment_;  // its loop runs what belongs to no process
  std::map<std::string, Program> programs_;
  std::map<std::uint64_t, Process> alive_;                      // by serial
  std::map<std::string, std::vector<const Process*>> running_;  // by actuator
  std::set<std::string> misconfigured_;
};

}  // namespace musher::simulation
