#include "musher/test/simulation/sim_robot.hpp"

#include <signal.h>

#include <utility>

#include "musher/transport/lifecycle_wire.hpp"

namespace musher::testing {

// Runs the callback at once and says so as much later as the script wants.
class SimRobot::SimWorker : public Worker {
 public:
  SimWorker(transport::EventLoop& loop, std::function<Duration()> takes)
      : loop_(loop), takes_(std::move(takes)) {}

  void Run(Work work, Done done) override {
    const Result<> result = work();
    end_ = loop_.At(loop_.Now() + takes_(), [done = std::move(done), result] { done(result); });
  }

 private:
  transport::EventLoop& loop_;
  std::function<Duration()> takes_;
  transport::LoopHandlePtr end_;
};

SimRobot::SimRobot(std::uint64_t seed, MachineConfig config, Script script)
    : config_(std::move(config)),
      script_(script ? std::move(script) : [](const std::string&, const State&) { return Act{}; }),
      network_(seed),
      keeper_(network_.MakeNode("keeper")),
      button_(transport::MakePublisher<msg::EmergencyStop>(
                  *keeper_, transport::EmergencyStopTopic(""), transport::kLatchedQos)
                  .value()) {}

SimRobot::~SimRobot() {
  CrashController();
  while (!actuators_.empty()) CrashActuator(actuators_.begin()->first);
}

void SimRobot::StartController(Duration listens) {
  controller_ = std::make_unique<ControllerProcess>();
  controller_->node = network_.MakeNode("controller");
  ControllerShell::World world;
  world.node = controller_->node.get();
  world.processes = this;
  world.witness = this;
  world.journal = this;
  world.save_epoch = [this](std::uint64_t epoch) { epoch_on_disk_ = epoch; };
  world.save_emergency_stop = [this](const auto& stop) { emergency_stop_on_disk_ = stop; };
  world.log_file = [](const std::string&) { return std::string(); };
  world.wall_ns = [this] { return Duration(network_.now().time_since_epoch()).count(); };
  world.host = "sim";
  world.pid = next_pid_++;
  world.incarnation = static_cast<std::uint64_t>(world.pid);
  auto shell = ControllerShell::Make(std::move(world), config_, {});
  controller_->shell = std::move(shell).value();
  RunFor(listens);
  std::vector<bool> running;
  for (const ActuatorConfig& actuator : config_.actuators)
    running.push_back(IsAlive(actuator.name));
  controller_->shell->Begin(
      {false, epoch_on_disk_, std::move(running), "", emergency_stop_on_disk_});
}

void SimRobot::CrashController() {
  if (!controller_) return;
  network_.Crash(*controller_->node);
  watchers_.clear();
  controller_->shell.reset();
  controller_.reset();
}

void SimRobot::StartActuator(const std::string& name) {
  Launch(name);
}

std::int32_t SimRobot::Launch(const std::string& name) {
  const std::int32_t pid = next_pid_++;
  ActuatorProcess& process = actuators_[name];
  process.pid = pid;
  process.node = network_.MakeNode(name);
  if (const auto program = programs_.find(name); program != programs_.end()) {
    process.program = program->second(*process.node);
    return pid;
  }
  auto takes = std::make_shared<Duration>();
  process.worker = std::make_unique<SimWorker>(process.node->loop(), [takes] { return *takes; });
  ActuatorShell::Hooks hooks;
  hooks.run_callback = [this, name, takes](const State& state) -> Result<> {
    const Act act = script_(name, state);
    *takes = act.takes;
    if (act.error.code != kCodeOk) return act.error;
    return Ok();
  };
  hooks.on_finished = [this, name, pid](const Error& error) {
    EndLater(name, pid, {ProcessExit::Kind::kExited, error.code == kCodeOk ? 0 : 1});
  };
  auto shell = ActuatorShell::Make(*process.node, *process.worker, config_, *config_.IndexOf(name),
                                   {static_cast<std::uint64_t>(pid), pid, "sim"}, std::move(hooks));
  process.shell = std::move(shell).value();
  process.shell->Start();
  return pid;
}

void SimRobot::EndLater(const std::string& name, std::int32_t pid, const ProcessExit& exit) {
  keeper_->loop().Post([=, this] {
    const auto process = actuators_.find(name);
    if (process != actuators_.end() && process->second.pid == pid) End(name, exit);
  });
}

void SimRobot::CrashActuator(const std::string& name) {
  if (IsAlive(name)) End(name, {ProcessExit::Kind::kKilled, SIGKILL});
}

void SimRobot::End(const std::string& name, const ProcessExit& exit) {
  const auto process = actuators_.find(name);
  network_.Crash(*process->second.node);
  const auto watcher = watchers_.extract(process->second.pid);
  process->second.shell.reset();
  process->second.worker.reset();
  process->second.program.reset();
  actuators_.erase(process);
  if (watcher.empty() || !controller_) return;
  controller_->node->loop().Post([on_exit = watcher.mapped(), exit] { on_exit(exit); });
}

Result<pid_t> SimRobot::Start(const ProcessSpec& spec, OnExit on_exit) {
  if (IsAlive(spec.name)) return Error{kCodeTargetBusy, "it runs already"};
  const std::int32_t pid = Launch(spec.name);
  watchers_[pid] = std::move(on_exit);
  return pid;
}

Result<> SimRobot::Watch(pid_t pid, OnExit on_exit) {
  for (const auto& [name, process] : actuators_) {
    if (process.pid != pid) continue;
    watchers_[pid] = [on_exit = std::move(on_exit)](const ProcessExit&) { on_exit({}); };
    return Ok();
  }
  return Error{kCodeFailed, "no such process"};
}

Result<> SimRobot::Signal(pid_t pid, int signal) {
  for (const auto& [name, process] : actuators_) {
    if (process.pid != pid) continue;
    if (process.frozen && signal != SIGKILL) return Ok();  // it would come when it goes on
    EndLater(name, pid, {ProcessExit::Kind::kKilled, signal});
    return Ok();
  }
  return Error{kCodeFailed, "no such process"};
}

void SimRobot::EngageEmergencyStop(std::uint64_t id) {
  static_cast<void>(button_->Publish({id, true, "a person", ""}));
}

void SimRobot::ReleaseEmergencyStop() {
  if (controller_) controller_->shell->ReleaseEmergencyStop("a person", [](const Result<>&) {});
}

void SimRobot::Restart(const std::string& name) {
  if (controller_) controller_->shell->Restart(name, [](const Result<>&) {});
}

void SimRobot::FreezeActuator(const std::string& name) {
  ActuatorProcess& process = actuators_.at(name);
  process.frozen = true;
  network_.Pause(*process.node);
}

void SimRobot::ThawActuator(const std::string& name) {
  ActuatorProcess& process = actuators_.at(name);
  process.frozen = false;
  network_.Resume(*process.node);
}

void SimRobot::Mark(pid_t, Time) {}

Examination SimRobot::Examine(pid_t pid, Time) {
  for (const auto& [name, process] : actuators_) {
    if (process.pid != pid) continue;
    return {process.frozen ? Examination::Process::kStopped : Examination::Process::kRunning, {}};
  }
  return {Examination::Process::kGone, {}};
}

void SimRobot::TakeBacktrace(pid_t, Duration, std::function<void(Result<std::string>)> done) {
  controller_->node->loop().Post([done = std::move(done)] { done(std::string("main()")); });
}

void SimRobot::Append(JournalItem item) noexcept {
  recording_.push_back({static_cast<std::int64_t>(recording_.size()) + 1, std::move(item)});
}

std::vector<std::string> SimRobot::journal() const {
  std::vector<std::string> messages;
  for (const JournalRow& row : recording_) {
    if (const auto* entry = std::get_if<JournalEntry>(&row.item)) {
      messages.push_back(entry->message);
    }
  }
  return messages;
}

bool SimRobot::RunUntil(const std::function<bool()>& done, Duration limit) {
  return network_.RunUntil(done, network_.now() + limit);
}

std::optional<SwitchResult> SimRobot::Set(const State& target,
                                          const std::optional<std::string>& actuator,
                                          Duration limit) {
  if (!controller_) return std::nullopt;
  auto answer = std::make_shared<std::optional<SwitchResult>>();
  controller_->shell->SetState(target, actuator,
                               [answer](const SwitchResult& result) { *answer = result; });
  RunUntil([&] { return answer->has_value(); }, limit);
  return *answer;
}

std::optional<ActuatorReport> SimRobot::ReportOf(const std::string& name) const {
  const auto process = actuators_.find(name);
  if (process == actuators_.end() || !process->second.shell) return std::nullopt;
  return process->second.shell->report();
}

}  // namespace musher::testing
