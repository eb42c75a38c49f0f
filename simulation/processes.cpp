#include "musher/simulation/processes.hpp"

#include <signal.h>

#include <utility>

#include "musher/transport/lifecycle_wire.hpp"

namespace musher::simulation {

// Runs the callback at once and says so as much later as the module wants.
class Processes::SimWorker : public Worker {
 public:
  SimWorker(transport::EventLoop& loop, std::shared_ptr<Duration> takes)
      : loop_(loop), takes_(std::move(takes)) {}

  void Run(Work work, Done done) override {
    const Result<> result = work();
    end_ = loop_.At(loop_.Now() + *takes_, [done = std::move(done), result] { done(result); });
  }

 private:
  transport::EventLoop& loop_;
  std::shared_ptr<Duration> takes_;
  transport::LoopHandlePtr end_;
};

Processes::Processes(transport::sim::Network& network, const MachineConfig& config)
    : network_(network), config_(config), keeper_(network.MakeNode("keeper")) {}

Processes::~Processes() {
  while (!alive_.empty()) End(alive_.begin()->first, {ProcessExit::Kind::kKilled, SIGKILL});
}

std::int32_t Processes::Launch(const std::string& name) {
  const std::int32_t pid = NewPid();
  Process& process = alive_[name];
  process.pid = pid;
  process.node = network_.MakeNode(name);
  if (IsMisconfigured(name)) {
    EndLater(name, pid, WrongConfigExit());
    return pid;
  }
  if (const auto program = programs_.find(name); program != programs_.end()) {
    process.program = program->second(*process.node);
    return pid;
  }
  auto takes = std::make_shared<Duration>();
  process.module = make_module(name);
  process.worker = process.module->MakeWorker(process.node->loop());
  if (!process.worker) process.worker = std::make_unique<SimWorker>(process.node->loop(), takes);
  const ActuatorIdentity identity{static_cast<std::uint64_t>(pid), pid, "sim"};
  auto shell = ActuatorShell::Make(*process.node, *process.worker, config_, *config_.IndexOf(name),
                                   identity, HooksOf(name, process, takes));
  process.shell = std::move(shell).value();
  process.shell->Start();
  return pid;
}

ActuatorShell::Hooks Processes::HooksOf(const std::string& name, const Process& process,
                                        const std::shared_ptr<Duration>& takes) {
  ActuatorShell::Hooks hooks;
  Module* module = process.module.get();
  hooks.run_callback = [module, takes](const State& state) -> Result<> {
    const Act act = module->Run(state);
    *takes = act.takes;
    if (act.error.code != kCodeOk) return act.error;
    return Ok();
  };
  hooks.set_stop_requested = [module](bool requested) { module->SetStopRequested(requested); };
  hooks.on_emergency_stop = [module] { module->OnEmergencyStop(); };
  hooks.on_report = [this, name, module](const ActuatorReport& report) {
    module->OnReport(report);
    if (on_report) on_report(name, report);
  };
  hooks.on_finished = [this, name, pid = process.pid](const Error& error) {
    EndLater(name, pid, {ProcessExit::Kind::kExited, error.code == kCodeOk ? 0 : 1});
  };
  return hooks;
}

void Processes::EndLater(const std::string& name, std::int32_t pid, const ProcessExit& exit) {
  keeper_->loop().Post([=, this] {
    const auto process = alive_.find(name);
    if (process != alive_.end() && process->second.pid == pid) End(name, exit);
  });
}

void Processes::End(const std::string& name, const ProcessExit& exit) {
  auto process = alive_.extract(name);
  Process& dead = process.mapped();
  network_.Crash(*dead.node);
  dead.shell.reset();
  dead.worker.reset();
  dead.program.reset();
  if (on_end) on_end(dead.pid, exit);
}

void Processes::Misconfigure(const std::string& name, bool wrong) {
  if (wrong) {
    misconfigured_.insert(name);
  } else {
    misconfigured_.erase(name);
  }
}

void Processes::Freeze(const std::string& name) {
  alive_.at(name).frozen = true;
  network_.Pause(*alive_.at(name).node);
}

void Processes::Thaw(const std::string& name) {
  alive_.at(name).frozen = false;
  network_.Resume(*alive_.at(name).node);
}

std::string Processes::NameOf(std::int32_t pid) const {
  for (const auto& [name, process] : alive_) {
    if (process.pid == pid) return name;
  }
  return {};
}

Result<> Processes::Signal(std::int32_t pid, int signal) {
  const std::string name = NameOf(pid);
  if (name.empty()) return Error{kCodeFailed, "no such process"};
  if (alive_.at(name).frozen && signal != SIGKILL) return Ok();  // it would come when it goes on
  EndLater(name, pid, {ProcessExit::Kind::kKilled, signal});
  return Ok();
}

Examination Processes::Examine(std::int32_t pid) const {
  const std::string name = NameOf(pid);
  if (name.empty()) return {Examination::Process::kGone, {}};
  return {IsFrozen(name) ? Examination::Process::kStopped : Examination::Process::kRunning, {}};
}

const ActuatorReport* Processes::ReportOf(const std::string& name) const {
  const auto process = alive_.find(name);
  if (process == alive_.end() || !process->second.shell) return nullptr;
  return &process->second.shell->report();
}

void Processes::Lie(const std::string& name, const State& state) {
  Process& process = alive_.at(name);
  if (!process.shell || process.frozen) return;
  if (!process.lies) {
    process.lies = transport::MakePublisher<msg::ActuatorStatus>(
                       *process.node, transport::ActuatorStatusTopic(config_.name_space),
                       transport::kLatchedQos)
                       .value();
  }
  ActuatorReport lie = process.shell->report();
  lie.state = state;
  lie.stamp = process.node->loop().Now();
  static_cast<void>(process.lies->Publish(transport::ToMessage(name, lie)));
}

}  // namespace musher::simulation
