#include "musher/controller/shell/actuator_processes.hpp"

#include <signal.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <utility>

#include "musher/controller/process/own_systemd.hpp"
#include "musher/lifecycle/record/texts.hpp"
#include "musher/transport/network.hpp"
#include "musher/transport/ros_environment.hpp"

namespace musher {
namespace {

constexpr Duration kBacktraceTimeout = Milliseconds(4000);  // before a hung process is killed
// How long after the exit of a process its systemd may say how it has exited. It may wait for
// memory itself, where the process has just used that up. In a TearDown the budget of the machine
// counts.
constexpr Duration kUnitEndWithin = Milliseconds(2000);
constexpr Duration kUnitEndWithinTearDown = Milliseconds(500);

// What a child has by itself.
ProcessSpec AsUnit(ProcessSpec spec) {
  spec.env.emplace("MUSHER_LOG_TIME", "1");  // `musher logs` merges the lines by their times
  if (!spec.mark.empty()) spec.env[kChildMark] = UnitMarkOf(spec.mark);
  InheritForUnit(transport::OwnEnvironment(), spec);
  return spec;
}

}  // namespace

bool IsStillEnded(const Machine& machine, ActuatorIndex actuator, pid_t pid) {
  if (machine.phase == Phase::kStopping || machine.phase == Phase::kStopped) return true;
  const auto& termination = machine.actuators[actuator].process.termination;
  return termination && termination->pid == pid &&
         (termination->killed || !termination->for_silence);
}

ActuatorProcesses::ActuatorProcesses(ShellContext context, ControllerPresence& presence,
                                     HealthWatch& health, ActuatorPeers& peers)
    : context_(std::move(context)),
      dependencies_(context_.dependencies),
      config_(context_.config),
      presence_(presence),
      health_(health),
      peers_(peers) {}

void ActuatorProcesses::TakeOver(event::Begin& begin, const std::vector<ChildProcess>& children) {
  for (const ActuatorIndex i : begin.processes.Indices()) {
    const pid_t pid = begin.processes[i];
    const auto child = std::find_if(children.begin(), children.end(), [&](const ChildProcess& c) {
      return c.pid == pid && c.actuator == config_.actuators[i].name;
    });
    const bool is_child = child != children.end();
    if (WatchFound(i, pid, is_child ? &*child : nullptr)) continue;
    begin.processes[i] = 0;
    const bool exited =
        is_child && dependencies_.process_probe->StartTimeOf(pid) != child->start_time;
    if (exited && !peers_.RanBeforeBegin(i)) {
      begin.running[i] = false;
      if (begin.ended.Has(i)) begin.ended[i] = true;
    }
  }
  SaveChildren();  // else the next controller finds once more what has ended
}

std::vector<event::StartExamined> ActuatorProcesses::OverdueStarts(const Machine& machine,
                                                                   Time now) const {
  const Phase phase = machine.phase;
  if (phase != Phase::kStarting && phase != Phase::kRunning && phase != Phase::kFailed) return {};
  std::vector<event::StartExamined> examined;
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    const KnownActuator& known = machine.actuators[i];
    const bool here = known.process.pid != 0 && known.process.host.empty();
    const ActuatorConfig& actuator = config_.actuators[i];
    if (!here || actuator.protocol != Protocol::kMusher || !IsOverdue(known, now)) continue;
    const pid_t pid = known.process.pid;
    examined.push_back({i, pid, dependencies_.process_probe->ProgressOf(actuator.name, pid)});
  }
  return examined;
}

// --- the processes of other hosts ---

bool ActuatorProcesses::IsOnHost(ActuatorIndex i) const {
  return dependencies_.hosts != nullptr && !config_.actuators[i].host.empty();
}

bool ActuatorProcesses::RunsOnHost(ActuatorIndex i) const {
  return IsOnHost(i) && !context_.machine.actuators[i].process.host.empty();
}

// Whether the process that runs on another host for this controller follows another machine now.
bool ActuatorProcesses::IsOfOther(ActuatorIndex i, pid_t pid) const {
  return peers_.IsOfOther(i, context_.machine.actuators[i].process.host, pid);
}

void ActuatorProcesses::OpenHosts() {
  if (dependencies_.hosts != nullptr) dependencies_.hosts->Open(HookHosts());
}

HostProcesses::Hooks ActuatorProcesses::HookHosts() {
  HostProcesses::Hooks hooks;
  hooks.on_started = [this](const std::string& actuator, pid_t pid, const std::string& host,
                            bool found) {
    const ActuatorIndex i = *config_.IndexOf(actuator);
    if (IsOwnUnit(i)) return OwnUnitStarted(i, pid, found);
    context_.handle(event::ProcessStarted{i, pid, host, found});
    peers_.ReportTaken(i);
  };
  hooks.on_not_started = [this](const std::string& actuator, const std::string& why, bool waits) {
    context_.handle(event::ProcessNotStarted{*config_.IndexOf(actuator), why, waits});
  };
  hooks.on_ended = [this](const std::string& actuator, pid_t pid, const ProcessExit& exit) {
    const ActuatorIndex i = *config_.IndexOf(actuator);
    if (IsOwnUnit(i)) return OwnUnitEnded(i, pid, exit);
    context_.handle(event::ProcessEnded{i, pid, exit.clean(), exit.Text(), exit.code()});
    health_.ForgetUnlessPresent(i, context_.machine.actuators[i]);
  };
  hooks.on_reach = [this](bool reached, const std::string& message) {
    context_.records.Remark(reached ? kCodeOk : kCodeNetError, message);
  };
  hooks.still_starts = [this](const std::string&) {
    const Phase phase = context_.machine.phase;
    return phase != Phase::kStopping && phase != Phase::kStopped;
  };
  hooks.is_present = [this](const std::string& actuator) {
    const ActuatorIndex i = *config_.IndexOf(actuator);
    return context_.machine.actuators[i].presence == Presence::kPresent;
  };
  hooks.still_ends = [this](const std::string& actuator, pid_t pid) {
    const ActuatorIndex i = *config_.IndexOf(actuator);
    return !IsOfOther(i, pid) && IsStillEnded(context_.machine, i, pid);
  };
  hooks.has_exited = [this](const std::string& actuator, pid_t pid) {
    return own_units_[*config_.IndexOf(actuator)].exited == pid;
  };
  hooks.output = dependencies_.output;
  return hooks;
}

// --- units of this host ---

bool ActuatorProcesses::IsOwnUnit(ActuatorIndex i) const {
  return dependencies_.own_units && !config_.actuators[i].command.empty() &&
         config_.actuators[i].host.empty();
}

// The kernel reports the exit of the unit's process as of a child, also while D-Bus is silent. A
// unit that was found by its mark already is no news.
void ActuatorProcesses::OwnUnitStarted(ActuatorIndex i, pid_t pid, bool found) {
  if (context_.machine.actuators[i].process.pid == pid) return;
  const std::uint64_t start_time = dependencies_.process_probe->StartTimeOf(pid);
  OwnUnit& unit = own_units_[i];
  unit = {.log = unit.log};
  const auto on_exit = [this, i, pid](const ProcessExit&) { AwaitOwnEnd(i, pid); };
  const bool watched = dependencies_.processes->Adopt(pid, start_time, on_exit).ok();
  if (!watched) unit.unwatched = pid;
  NoteChild(i, pid);
  found ? peers_.OnProcessFound(i, pid) : peers_.OnProcess(i, pid);
  context_.handle(event::ProcessStarted{i, pid, "", found});
  const bool exited =
      start_time == 0 || dependencies_.process_probe->StartTimeOf(pid) != start_time;
  if (!watched && exited) AwaitOwnEnd(i, pid);
}

// The kernel has reported its exit.
void ActuatorProcesses::AwaitOwnEnd(ActuatorIndex i, pid_t pid) {
  OwnUnit& unit = own_units_[i];
  unit.exited = pid;
  if (context_.machine.actuators[i].process.pid != pid) return;
  if (unit.ended == pid) return EndOwnUnit(i, pid);
  const Duration within =
      context_.machine.phase == Phase::kStopping ? kUnitEndWithinTearDown : kUnitEndWithin;
  unit.silence = context_.loop().At(context_.loop().Now() + within, [this, i, pid, within] {
    ProcessExit unknown;
    unknown.last_output =
        "systemd has not reported it within " + std::to_string(ToMilliseconds(within)) + " ms";
    ReportEnd(i, pid, unknown);
  });
}

// systemd has reported that the unit of the actuator has ended. Its process may still run if
// systemd has lost the unit: until the kernel reports the exit of the process, no other one is
// started.
void ActuatorProcesses::OwnUnitEnded(ActuatorIndex i, pid_t pid, const ProcessExit& exit) {
  if (context_.machine.actuators[i].process.pid != pid) return;
  OwnUnit& unit = own_units_[i];
  unit.ended = pid;
  unit.how = exit;
  if (unit.exited == pid || unit.unwatched == pid) EndOwnUnit(i, pid);
}

void ActuatorProcesses::EndOwnUnit(ActuatorIndex i, pid_t pid) {
  OwnUnit& unit = own_units_[i];
  unit.silence = nullptr;
  const ProcessExit how = unit.how;  // which is forgotten meanwhile
  dependencies_.processes->AddLastOutput(
      how, config_.actuators[i].name, unit.log,
      [this, i, pid](const ProcessExit& exit) { ReportEnd(i, pid, exit); });
}

// A process whose exit code is unknown may have been torn down, as its last status says.
void ActuatorProcesses::ReportEnd(ActuatorIndex i, pid_t pid, const ProcessExit& exit) {
  if (exit.kind != ProcessExit::Kind::kUnknown) return Ended(i, pid, exit);
  peers_.ReportExit(i, [this, i, pid, exit] { Ended(i, pid, exit); });
}

// Once for each process: an exit code may arrive while the last status is awaited.
void ActuatorProcesses::Ended(ActuatorIndex i, pid_t pid, const ProcessExit& exit) {
  if (context_.machine.actuators[i].process.pid != pid) return;
  const OwnUnit waited = std::exchange(own_units_[i], {.exited = own_units_[i].exited});
  ForgetChild(i, pid);
  peers_.OnProcessEnded(i, pid);
  context_.handle(event::ProcessEnded{i, pid, exit.clean(), exit.Text(), exit.code()});
  health_.ForgetUnlessPresent(i, context_.machine.actuators[i]);
}

void ActuatorProcesses::CancelStarts() {
  starts_later_.clear();
  if (dependencies_.hosts != nullptr) dependencies_.hosts->Close();
}

// --- start, search, signals ---

void ActuatorProcesses::Do(const action::StartProcess& a) {
  // A start that waits is replaced; until this returns it is kept, since it may be what calls.
  const auto replaced = std::exchange(starts_later_[a.actuator], nullptr);
  const Time at = presence_.MayStartProcessesAt();
  if (at > context_.loop().Now()) {
    starts_later_[a.actuator] = context_.loop().At(at, [this, a] { Do(a); });
    return;
  }
  ProcessSpec spec = SpecOf(a.actuator);
  if (IsOnHost(a.actuator)) return dependencies_.hosts->Start(spec);
  const auto output = dependencies_.output(spec.name);
  if (IsOwnUnit(a.actuator)) {
    own_units_[a.actuator].log = dependencies_.processes->LogOf(output ? output->get() : -1);
    return dependencies_.hosts->Start(AsUnit(std::move(spec)));
  }
  if (output) spec.output = output->get();
  auto pid = std::make_shared<pid_t>(0);
  const auto started =
      dependencies_.processes->Start(spec, [this, i = a.actuator, pid](const ProcessExit& exit) {
        ForgetChild(i, *pid);
        peers_.OnProcessEnded(i, *pid);
        if (exit.kind == ProcessExit::Kind::kNotRun) {
          context_.handle(event::ProcessNotStarted{i, exit.Text()});
        } else {
          context_.handle(event::ProcessEnded{i, *pid, exit.clean(), exit.Text(), exit.code()});
        }
        health_.ForgetUnlessPresent(i, context_.machine.actuators[i]);
      });
  if (!started)
    return context_.handle(event::ProcessNotStarted{a.actuator, started.error().message});
  *pid = started.value();
  NoteChild(a.actuator, started.value());
  peers_.OnProcess(a.actuator, *pid);
  context_.handle(event::ProcessStarted{a.actuator, started.value()});
}

// How its process is started; without its output.
ProcessSpec ActuatorProcesses::SpecOf(ActuatorIndex i) const {
  const ActuatorConfig& actuator = config_.actuators[i];
  ProcessSpec spec;
  spec.name = actuator.name;
  spec.argv = actuator.command;
  spec.cwd = actuator.cwd;
  spec.env = actuator.env;
  spec.limits = actuator.limits;
  if (!config_.file.empty()) {
    spec.env.emplace("MUSHER_CONFIG", std::filesystem::absolute(config_.file).string());
  }
  spec.env.emplace("MUSHER_ACTUATOR", actuator.name);
  const MachineIdentity machine = presence_.machine();
  spec.env.emplace("MUSHER_MACHINE", machine.name);
  if (!machine.id.empty()) spec.env.emplace("MUSHER_MACHINE_ID", machine.id);
  if (IsOnHost(i)) {
    for (const auto& [name, value] : dependencies_.host_environment) spec.env.emplace(name, value);
  }
  if (actuator.protocol == Protocol::kRos2Lifecycle) {
    transport::Environment inherited = transport::OwnEnvironment();
    for (const auto& [name, value] : actuator.env) inherited[name] = value;
    spec.env.merge(transport::RosEnvironment(
        config_.transport, inherited,
        transport::OuterInterfaces(config_.transport, config_.interfaces)));
  }
  const bool alone =
      context_.machine.actuators[i].process.dead != 0;  // the other actuators already run
  if (alone) spec.env.emplace("MUSHER_FAST_DISCOVERY", "1");
  if (dependencies_.child_mark) spec.mark = dependencies_.child_mark(actuator.name);
  return spec;
}

event::ProcessesFound ActuatorProcesses::FindHere() {
  event::ProcessesFound found;
  found.processes.resize(config_.actuators.size());
  std::vector<ActuatorIndex> with_command;
  std::vector<std::string> names;
  for (const ActuatorIndex i : config_.actuators.Indices()) {
    if (config_.actuators[i].command.empty() || IsOnHost(i)) continue;
    with_command.push_back(i);
    names.push_back(config_.actuators[i].name);
  }
  const std::vector<pid_t> pids = dependencies_.process_probe->Find(names);
  for (std::size_t n = 0; n < with_command.size(); ++n) {
    const ActuatorIndex i = with_command[n];
    if (WatchFound(i, pids[n], nullptr)) found.processes[i] = pids[n];
  }
  return found;
}

void ActuatorProcesses::Do(const action::FindProcesses&) {
  if (dependencies_.hosts == nullptr) return context_.handle(FindHere());
  dependencies_.hosts->Find([this](const std::vector<HostProcesses::Found>& there) {
    // Only now: a process of this host may have exited while the other hosts were asked.
    event::ProcessesFound found = FindHere();
    found.hosts.resize(config_.actuators.size());
    found.unreached.resize(config_.actuators.size());
    for (const HostProcesses::Found& one : there) {
      const ActuatorIndex i = *config_.IndexOf(one.actuator);
      if (IsOwnUnit(i)) {
        const bool runs = one.pid != own_units_[i].exited;
        if (found.processes[i] == 0 && runs) found.processes[i] = one.pid;
        if (found.processes[i] == 0) found.unreached[i] = one.unreached;
        continue;
      }
      // A process that is found now and follows another machine is not ended with this machine.
      found.processes[i] = peers_.IsOfOther(i, one.host, one.pid) ? 0 : one.pid;
      found.hosts[i] = one.host;
      found.unreached[i] = one.unreached;
    }
    context_.handle(found);
  });
}

void ActuatorProcesses::Do(const action::SignalProcess& a) {
  const int signal = a.kill ? SIGKILL : SIGTERM;
  if (RunsOnHost(a.actuator)) {
    // It may have been found just now: the decision learns of that first, then of who leads it.
    if (IsOfOther(a.actuator, a.pid)) return;
    return dependencies_.hosts->Signal(config_.actuators[a.actuator].name, a.pid, signal);
  }
  // A process that has exited meanwhile needs no signal.
  static_cast<void>(dependencies_.processes->Signal(a.pid, signal).ok());
}

void ActuatorProcesses::Do(const action::TakeBacktrace& a) {
  if (RunsOnHost(a.actuator)) {
    return context_.handle(event::BacktraceTaken{
        a.actuator, a.pid,
        "no backtrace: its process runs on host " + config_.actuators[a.actuator].host});
  }
  const bool own = config_.actuators[a.actuator].protocol == Protocol::kMusher;
  const pid_t traced = own ? a.pid : dependencies_.process_probe->WorkerOf(a.pid);
  dependencies_.process_probe->TakeBacktrace(
      traced, kBacktraceTimeout, [this, a](Result<std::string> stacks) {
        context_.handle(event::BacktraceTaken{
            a.actuator, a.pid,
            stacks ? stacks.value() : "no backtrace: " + stacks.error().message});
      });
}

void ActuatorProcesses::Do(const action::RunPowerCommand& a) {
  const PowerPolicy& power = config_.policy->power;
  ProcessSpec spec;
  spec.name = a.reboot ? "reboot" : "power_off";
  spec.argv = a.reboot ? power.reboot_command : power.off_command;
  if (spec.argv.empty()) return;
  if (power_command_runs_) return;  // it was requested again meanwhile
  const auto output = dependencies_.output(spec.name);
  if (output) spec.output = output->get();
  const auto failed = [this, name = spec.name](const std::string& how) {
    context_.records.WriteOwn("policy", std::nullopt, kCodeFailed,
                              texts::PowerCommandFailed(name, how));
  };
  const auto started =
      dependencies_.processes->Start(spec, [this, failed](const ProcessExit& exit) {
        power_command_runs_ = false;
        if (!exit.clean()) failed("failed: " + exit.Text());
      });
  power_command_runs_ = started.ok();
  if (!started) failed("could not be executed: " + started.error().message);
}

// Watches a process that ran before this controller and may never publish a status. A `child` was
// started for this actuator by an earlier controller; null: it was not.
bool ActuatorProcesses::WatchFound(ActuatorIndex actuator, pid_t pid, const ChildProcess* child) {
  if (pid == 0 || pid == dependencies_.pid) return false;
  const auto on_exit = [this, actuator, pid](const ProcessExit&) {
    if (IsOwnUnit(actuator)) return AwaitOwnEnd(actuator, pid);
    ForgetChild(actuator, pid);
    peers_.ReportExit(actuator, [this, actuator, pid] {
      peers_.OnProcessEnded(actuator, pid);
      context_.handle(event::ProcessEnded{actuator, pid, false, "exit code unknown"});
      health_.ForgetUnlessPresent(actuator, context_.machine.actuators[actuator]);
    });
  };
  const bool watched = child ? dependencies_.processes->Adopt(pid, child->start_time, on_exit).ok()
                             : dependencies_.processes->Watch(pid, on_exit).ok();
  if (!watched) return false;
  if (child) NoteChild(actuator, pid);
  peers_.OnProcessFound(actuator, pid);
  return true;
}

// Saves what the next controller needs to find the process again.
void ActuatorProcesses::NoteChild(ActuatorIndex actuator, pid_t pid) {
  children_[actuator] = {config_.actuators[actuator].name, pid,
                         dependencies_.process_probe->StartTimeOf(pid)};
  SaveChildren();
}

void ActuatorProcesses::ForgetChild(ActuatorIndex actuator, pid_t pid) {
  const auto child = children_.find(actuator);
  if (child == children_.end() || child->second.pid != pid) return;
  children_.erase(child);
  SaveChildren();
}

// If this controller exits before they are saved, the next one finds them by their marks.
void ActuatorProcesses::SaveChildren() {
  if (!dependencies_.save_children) return;
  std::vector<ChildProcess> children;
  children.reserve(children_.size());
  for (const auto& [actuator, child] : children_) children.push_back(child);
  dependencies_.save_children(children, [this](const Result<>& saved) {
    if (!saved && !std::exchange(children_unsaved_, true)) {
      context_.records.Remark(saved.error().code,
                              "the list of processes is not saved: " + saved.error().message +
                                  "; the next controller finds them by their environment only");
    }
    if (saved) children_unsaved_ = false;
  });
}

}  // namespace musher
