#pragma once
// A host without any process of an actuator, for a controller's shell in virtual time.

#include <functional>
#include <string>
#include <vector>

#include "musher/controller/shell/controller_shell.hpp"

namespace musher::testing {

// A host without any of the actuators' processes, and what its controller starts there.
class EmptyHost : public ProcessRunner, public ProcessProbe, public JournalSink {
 public:
  Result<pid_t> Start(const ProcessSpec& spec, OnExit) override {
    started.push_back(spec.name);
    return 100 + static_cast<pid_t>(started.size());
  }
  Result<> Watch(pid_t, OnExit) override { return Error{kCodeFailed, "no such process"}; }
  Result<> Signal(pid_t, int) override { return Ok(); }
  Result<> Prove(const std::string&, pid_t, pid_t) override {
    return Error{kCodeStateInvalid, "no such process"};
  }
  std::vector<pid_t> Find(const std::vector<std::string>& actuators) override {
    return std::vector<pid_t>(actuators.size(), 0);
  }
  std::uint64_t StartTimeOf(pid_t) override { return 1; }
  void Mark(ActuatorIndex, pid_t, Time) override {}
  StartProgress ProgressOf(const std::string&, pid_t) override { return progress; }
  Examination Examine(ActuatorIndex, pid_t, Time) override { return {}; }
  void TakeBacktrace(pid_t, Duration, std::function<void(Result<std::string>)>) override {}
  void Append(JournalItem) noexcept override {}

  std::vector<std::string> started;
  StartProgress progress = StartProgress::kUnknown;  // of each of them

  // A shell on this host, whose disk takes no time.
  ControllerShell::Dependencies DependenciesOf(transport::Node& node) {
    ControllerShell::Dependencies dependencies;
    dependencies.node = &node;
    dependencies.processes = this;
    dependencies.process_probe = this;
    dependencies.journal = this;
    dependencies.save_epoch = [](auto, const auto& saved) { saved(Ok()); };
    dependencies.save_emergency_stops = [](const auto&, const auto& saved) { saved(Ok()); };
    dependencies.save_policy = [](const auto&, const auto& saved) { saved(Ok()); };
    dependencies.save_stop_intent = [](auto, const auto& saved) { saved(Ok()); };
    dependencies.save_actuators = [](const auto&, const auto& saved) { saved(Ok()); };
    dependencies.save_remote_actuators = [](const auto&, const auto& saved) { saved(Ok()); };
    dependencies.output = [](const auto&) { return nullptr; };
    dependencies.wall_ns = [] { return 0; };
    dependencies.host = "second";
    dependencies.pid = 1;
    dependencies.incarnation = 1;
    return dependencies;
  }
};

}  // namespace musher::testing
