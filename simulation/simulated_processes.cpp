#include "musher/simulation/simulated_processes.hpp"

#include <signal.h>

#include <algorithm>
#include <utility>

#include "musher/lifecycle/config/flow.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::simulation {

// Runs the callback at once, and reports its end as much later as the module says.
class SimulatedProcesses::SimWorker : public Worker {
 public:
  using OnDone = std::function<void(const State&)>;  // of a callback that succeeds

  SimWorker(transport::EventLoop& loop, std::shared_ptr<RunningCallback> running, OnDone on_done)
      : loop_(loop), running_(std::move(running)), on_done_(std::move(on_done)) {}

  void Run(Work work, Done done) override {
    const Result<> result = work();
    end_ = loop_.At(loop_.Now() + running_->takes, [this, done = std::move(done), result] {
      if (result) on_done_(running_->target);
      done(result);
    });
  }

 private:
  transport::EventLoop& loop_;
  std::shared_ptr<RunningCallback> running_;
  const OnDone on_done_;
  transport::LoopHandlePtr end_;
};

SimulatedProcesses::SimulatedProcesses(transport::sim::Network& network,
                                       const MachineConfig& config, Hosts& hosts,
                                       const Layout& layout)
    : network_(network),
      config_(config),
      hosts_(hosts),
      layout_(layout),
      environment_(network.MakeNode("environment")) {}

SimulatedProcesses::~SimulatedProcesses() {
  while (!alive_.empty()) End(alive_.begin()->first, {ProcessExit::Kind::kKilled, SIGKILL});
}

std::size_t SimulatedProcesses::HomeOf(const std::string& name) const {
  return layout_.HostOf(*config_.IndexOf(name));
}

const SimulatedProcesses::Process* SimulatedProcesses::Find(const std::string& name) const {
  const auto running = running_.find(name);
  if (running == running_.end() || running->second.empty()) return nullptr;
  if (running->second.size() == 1) return running->second.front();
  const Process* at_home = Find(name, HomeOf(name));
  return at_home == nullptr ? running->second.front() : at_home;
}

const SimulatedProcesses::Process* SimulatedProcesses::Find(const std::string& name,
                                                            std::size_t host) const {
  const auto running = running_.find(name);
  if (running == running_.end()) return nullptr;
  for (const Process* process : running->second) {
    if (process->host == host) return process;
  }
  return nullptr;
}

const SimulatedProcesses::Process* SimulatedProcesses::Find(std::size_t host,
                                                            std::int32_t pid) const {
  for (const auto& [serial, process] : alive_) {
    if (process.host == host && process.pid == pid) return &process;
  }
  return nullptr;
}

const SimulatedProcesses::Part& SimulatedProcesses::PartOf(const Process& process,
                                                           const std::string& name) {
  return **std::find_if(process.parts.begin(), process.parts.end(),
                        [&](const auto& part) { return part->name == name; });
}

std::size_t SimulatedProcesses::CountOf(const std::string& name) const {
  const auto running = running_.find(name);
  if (running == running_.end()) return 0;
  return static_cast<std::size_t>(std::ranges::count_if(
      running->second, [&](const Process* process) { return !PartOf(*process, name).left; }));
}

std::int32_t SimulatedProcesses::Launch(const std::string& name, std::size_t host,
                                        const MachineIdentity& machine) {
  const ActuatorIndex first = layout_.ProcessOf(*config_.IndexOf(name));
  const std::uint64_t serial = hosts_.NewSerial();
  Process& process = alive_[serial];
  process.serial = serial;
  process.host = host;
  process.pid = hosts_.NewPid(host);
  process.started = network_.now();
  process.endpoint = layout_.prefix + config_.actuators[first].name;
  if (host != layout_.HostOf(first)) process.endpoint += "@" + hosts_.name(host);
  process.node = network_.MakeNode(process.endpoint);
  hosts_.Attach(process.endpoint, host);
  for (const ActuatorIndex i : config_.actuators.Indices()) {
    if (layout_.ProcessOf(i) == first) AddPart(process, config_.actuators[i].name, machine);
  }
  return process.pid;
}

void SimulatedProcesses::AddPart(Process& process, const std::string& name,
                                 const MachineIdentity& machine) {
  Part& part = *process.parts.emplace_back(std::make_unique<Part>());
  part.name = name;
  const bool name_is_held = IsAlive(name, process.host);
  running_[name].push_back(&process);
  if (name_is_held) return EndLater(process.serial, {ProcessExit::Kind::kExited, 1});
  if (IsMisconfigured(name)) return EndLater(process.serial, WrongConfigExit());
  if (const auto program = programs_.find(name); program != programs_.end()) {
    part.program = program->second(*process.node);
    return;
  }
  auto running = std::make_shared<RunningCallback>();
  part.module = make_module(name);
  part.worker = part.module->MakeWorker(process.node->loop());
  part.has_power = !part.worker;
  if (part.has_power) {
    part.worker = std::make_unique<SimWorker>(
        process.node->loop(), running,
        [this, &part](const State& target) { SwitchPower(part, target); });
  }
  const ActuatorIdentity identity{hosts_.NewIncarnation(process.host), process.pid,
                                  hosts_.Id(process.host), machine.name, machine.id};
  auto shell = ActuatorShell::Make(*process.node, *part.worker, config_, *config_.IndexOf(name),
                                   identity, HooksOf(process, part, running));
  part.shell = std::move(shell).value();
  part.shell->Start();
}

ActuatorShell::Hooks SimulatedProcesses::HooksOf(const Process& process, Part& part,
                                                 const std::shared_ptr<RunningCallback>& running) {
  ActuatorShell::Hooks hooks;
  Module* module = part.module.get();
  hooks.run_callback = [module, running](const State& state) -> Result<> {
    const Act act = module->Run(state);
    *running = {act.takes, state};
    if (act.error.code != kCodeOk) return act.error;
    return Ok();
  };
  hooks.set_stop_requested = [module](bool requested) { module->SetStopRequested(requested); };
  hooks.on_emergency_stop = [module, &part] {
    part.powered = false;
    module->OnEmergencyStop();
  };
  hooks.on_report = [this, name = part.name, host = process.host,
                     module](const ActuatorReport& report) {
    module->OnReport(report);
    if (on_report) on_report(name, host, report);
  };
  hooks.leads_here = [this, host = process.host](std::int32_t pid) {
    return leads_on && leads_on(host, pid);
  };
  hooks.on_finished = [this, name = part.name, serial = process.serial](const Error& error) {
    OnFinished(name, serial, error);
  };
  return hooks;
}

// A process exits when all of its actuators are torn down, or when a SetUp has failed.
void SimulatedProcesses::OnFinished(const std::string& name, std::uint64_t serial,
                                    const Error& error) {
  const auto process = alive_.find(serial);
  if (process == alive_.end()) return;
  if (error.code != kCodeOk) return EndLater(serial, {ProcessExit::Kind::kExited, 1});
  bool all = true;
  for (const auto& part : process->second.parts) {
    part->torn_down |= part->name == name;
    all &= part->torn_down;
  }
  if (all) return EndLater(serial, {ProcessExit::Kind::kExited, 0});
  LeaveLater(serial);
}

// As in a program whose main() waits for its actuators in turn, a.Wait() and then b.Wait(): the
// shell of a ends with its TearDown, and the process runs on for b.
void SimulatedProcesses::LeaveLater(std::uint64_t serial) {
  environment_->loop().Post([this, serial] {
    const auto process = alive_.find(serial);
    if (process == alive_.end()) return;
    for (const auto& part : process->second.parts) {
      if (!part->torn_down) return;
      if (!part->shell) continue;
      part->left = part->shell->report();
      part->shell->Close();
      part->shell.reset();
      part->worker.reset();
      part->lies.reset();
    }
  });
}

void SimulatedProcesses::EndLater(std::uint64_t serial, const ProcessExit& exit) {
  environment_->loop().Post([=, this] {
    if (alive_.count(serial) > 0) End(serial, exit);
  });
}

void SimulatedProcesses::End(const std::string& name, const ProcessExit& exit) {
  End(Find(name)->serial, exit);
}

void SimulatedProcesses::End(const std::string& name, std::size_t host, const ProcessExit& exit) {
  End(Find(name, host)->serial, exit);
}

void SimulatedProcesses::EndAllOn(std::size_t host) {
  std::vector<std::uint64_t> serials;
  for (const auto& [serial, process] : alive_) {
    if (process.host == host) serials.push_back(serial);
  }
  for (const std::uint64_t serial : serials) End(serial, {ProcessExit::Kind::kKilled, SIGKILL});
}

void SimulatedProcesses::End(std::uint64_t serial, const ProcessExit& exit) {
  auto process = alive_.extract(serial);
  Process& dead = process.mapped();
  for (const auto& part : dead.parts) std::erase(running_[part->name], &dead);
  network_.Crash(*dead.node);
  for (const auto& part : dead.parts) {
    part->shell.reset();
    part->worker.reset();
    part->program.reset();
  }
  if (on_end) on_end(dead.host, dead.pid, exit);
}

void SimulatedProcesses::Misconfigure(const std::string& name, bool wrong) {
  if (wrong) {
    misconfigured_.insert(name);
  } else {
    misconfigured_.erase(name);
  }
}

void SimulatedProcesses::Freeze(const std::string& name) {
  Process& process = *Find(name);
  process.frozen = true;
  network_.Pause(*process.node);
}

void SimulatedProcesses::Thaw(const std::string& name) {
  Process& process = *Find(name);
  process.frozen = false;
  process.thawed = network_.now();
  network_.Resume(*process.node);
}

bool SimulatedProcesses::IsFrozen(const std::string& name) const {
  return Find(name)->frozen;
}

bool SimulatedProcesses::IsFrozen(const std::string& name, std::size_t host) const {
  return Find(name, host)->frozen;
}

std::optional<Time> SimulatedProcesses::FrozenUntil(const std::string& name,
                                                    std::size_t host) const {
  const Process& process = *Find(name, host);
  return process.frozen ? Time::max() : process.thawed;
}

std::int32_t SimulatedProcesses::PidOf(const std::string& name) const {
  const Process* process = Find(name);
  return process == nullptr ? 0 : process->pid;
}

std::int32_t SimulatedProcesses::PidOf(const std::string& name, std::size_t host) const {
  const Process* process = Find(name, host);
  return process == nullptr ? 0 : process->pid;
}

std::uint64_t SimulatedProcesses::SerialOf(std::size_t host, std::int32_t pid) const {
  const Process* process = Find(host, pid);
  return process == nullptr ? 0 : process->serial;
}

Result<> SimulatedProcesses::Signal(std::size_t host, std::int32_t pid, int signal) {
  const Process* process = Find(host, pid);
  if (process == nullptr) return Error{kCodeFailed, "no such process"};
  if (process->frozen && signal != SIGKILL) return Ok();  // pending until it is resumed
  EndLater(process->serial, {ProcessExit::Kind::kKilled, signal});
  return Ok();
}

Examination SimulatedProcesses::Examine(std::size_t host, std::int32_t pid) const {
  const Process* process = Find(host, pid);
  if (process == nullptr) return {Examination::Process::kExited, {}};
  return {process->frozen ? Examination::Process::kStopped : Examination::Process::kRunning, {}};
}

const ActuatorReport* SimulatedProcesses::ReportOf(const std::string& name) const {
  const Process* process = Find(name);
  return process == nullptr ? nullptr : ReportOf(name, process->host);
}

const ActuatorReport* SimulatedProcesses::ReportOf(const std::string& name,
                                                   std::size_t host) const {
  const Process* process = Find(name, host);
  if (process == nullptr) return nullptr;
  const Part& part = PartOf(*process, name);
  if (part.left) return &*part.left;
  return part.shell ? &part.shell->report() : nullptr;
}

void SimulatedProcesses::SwitchPower(Part& part, const State& target) const {
  const auto rank = config_.RankOf(target);
  if (!rank || !part.shell) return;
  const ActuatorReport& report = part.shell->report();
  const bool again = report.state == target ? report.emergency_stop == 0
                                            : SwitchesOnAgain(config_, report.state, target);
  if (*rank <= *BuiltInRank(kDeActive)) {
    part.powered = false;
  } else if (again || Rises(config_, report.state, target)) {
    part.powered = true;
  }
}

const ActuatorCore* SimulatedProcesses::CoreOf(const std::string& name, std::size_t host) const {
  const Process* process = Find(name, host);
  if (process == nullptr) return nullptr;
  const auto& shell = PartOf(*process, name).shell;
  return shell ? &shell->core() : nullptr;
}

bool SimulatedProcesses::IsPowered(const std::string& name, std::size_t host) const {
  const Process* process = Find(name, host);
  return process != nullptr && PartOf(*process, name).powered;
}

bool SimulatedProcesses::HasPower(const std::string& name, std::size_t host) const {
  const Process* process = Find(name, host);
  return process != nullptr && PartOf(*process, name).has_power;
}

const std::string& SimulatedProcesses::EndpointOf(const std::string& name, std::size_t host) const {
  return Find(name, host)->endpoint;
}

Time SimulatedProcesses::StartOf(const std::string& name, std::size_t host) const {
  return Find(name, host)->started;
}

void SimulatedProcesses::Lie(const std::string& name, const State& state) {
  Process& process = *Find(name);
  Part& part = const_cast<Part&>(PartOf(process, name));
  if (!part.shell || process.frozen) return;
  if (!part.lies) {
    part.lies = transport::MakePublisher<msg::ActuatorStatus>(
                    *process.node, transport::ActuatorStatusTopic(config_.name_space),
                    transport::kLatchedQos)
                    .value();
  }
  ActuatorReport lie = part.shell->report();
  lie.state = state;
  lie.stamp = process.node->loop().Now();
  msg::ActuatorStatus status = transport::ToMessage(name, lie);
  status.participant = process.node->participant().value();
  status.machine = config_.name;
  status.machine_id = layout_.machine_id;
  static_cast<void>(part.lies->Publish(status));
}

}  // namespace musher::simulation
