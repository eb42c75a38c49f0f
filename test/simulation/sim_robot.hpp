#pragma once
// A whole robot in virtual time: the real shells and decision code of controller and actuators, on
// the simulated network, with simulated processes. Every actuator is a host of its own,
// "controller" is one more.

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "musher/actuator/actuator_shell.hpp"
#include "musher/controller/controller_shell.hpp"
#include "musher/controller/journal_reader.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::testing {

// What the callback of an actuator's state does, asked each time it begins.
struct Act {
  Duration takes = Milliseconds(5);
  Error error{kCodeOk, ""};
};
using Script = std::function<Act(const std::string& actuator, const State& state)>;

class SimRobot : private ProcessRunner, private ProcessWitness, private JournalSink {
 public:
  SimRobot(std::uint64_t seed, MachineConfig config, Script script = {});
  ~SimRobot() override;

  transport::sim::Network& network() { return network_; }

  // A program that is no actuator of ours runs behind that name; made anew with each process.
  using Program = std::function<std::shared_ptr<void>(transport::Node& node)>;
  void UseProgram(const std::string& name, Program program) {
    programs_[name] = std::move(program);
  }

  // `listens`: so long it only listens, as one that may have rivals on other hosts does.
  void StartController(Duration listens = {});
  void CrashController();
  void StartActuator(const std::string& name);  // as a person would
  void CrashActuator(const std::string& name);
  void FreezeActuator(const std::string& name);  // SIGSTOP
  void ThawActuator(const std::string& name);    // SIGCONT
  // Somebody engages an emergency stop, from a host of his own.
  void EngageEmergencyStop(std::uint64_t id);
  void ReleaseEmergencyStop();  // by the controller, for a person
  // A person restarts an actuator and does not wait for it.
  void Restart(const std::string& name);
  bool IsAlive(const std::string& name) const { return actuators_.count(name) > 0; }

  bool RunUntil(const std::function<bool()>& done, Duration limit = std::chrono::minutes(10));
  void RunFor(Duration duration) { network_.RunFor(duration); }

  // Asks for a switch; nothing when there is no controller or it does not answer in time.
  std::optional<SwitchResult> Set(const State& target,
                                  const std::optional<std::string>& actuator = std::nullopt,
                                  Duration limit = std::chrono::minutes(10));

  const Machine& machine() const { return controller_->shell->machine(); }
  bool has_controller() const { return controller_ != nullptr; }
  const MachineConfig& config() const { return config_; }
  // What the actuator itself says; nothing when its process does not live.
  std::optional<ActuatorReport> ReportOf(const std::string& name) const;
  std::vector<std::string> journal() const;  // the messages of its entries
  const std::vector<JournalRow>& recording() const { return recording_; }

 private:
  class SimWorker;
  struct ControllerProcess {
    std::unique_ptr<transport::Node> node;
    std::unique_ptr<ControllerShell> shell;
  };
  struct ActuatorProcess {
    std::int32_t pid = 0;
    std::unique_ptr<transport::Node> node;
    std::unique_ptr<Worker> worker;
    std::unique_ptr<ActuatorShell> shell;
    bool frozen = false;
    std::shared_ptr<void> program;  // instead of the shell
  };

  Result<pid_t> Start(const ProcessSpec& spec, OnExit on_exit) override;
  Result<> Watch(pid_t pid, OnExit on_exit) override;
  Result<> Signal(pid_t pid, int signal) override;
  void Mark(pid_t pid, Time now) override;
  Examination Examine(pid_t pid, Time now) override;
  void TakeBacktrace(pid_t pid, Duration timeout,
                     std::function<void(Result<std::string>)> done) override;
  void Append(JournalItem item) noexcept override;
  bool WantsSnapshot() noexcept override { return ++inputs_ % 41 == 0; }

  std::int32_t Launch(const std::string& name);
  void End(const std::string& name, const ProcessExit& exit);
  // Ends it after the callback that is running now.
  void EndLater(const std::string& name, std::int32_t pid, const ProcessExit& exit);

  MachineConfig config_;
  Script script_;
  std::map<std::string, Program> programs_;
  transport::sim::Network network_;
  std::unique_ptr<transport::Node> keeper_;  // whose loop runs what belongs to no process
  std::unique_ptr<transport::Publisher<msg::EmergencyStop>> button_;
  std::unique_ptr<ControllerProcess> controller_;
  std::map<std::string, ActuatorProcess> actuators_;
  std::map<pid_t, OnExit> watchers_;  // of the living controller
  std::int32_t next_pid_ = 1000;
  std::uint64_t epoch_on_disk_ = 0;
  std::optional<EmergencyStop> emergency_stop_on_disk_;
  std::vector<JournalRow> recording_;
  std::size_t inputs_ = 0;
};

}  // namespace musher::testing
