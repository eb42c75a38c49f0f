// Starts, signals and watches the processes of the actuators.

#include <signal.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <utility>

#include "musher/controller/shell/controller_shell.hpp"
#include "musher/lifecycle/record/texts.hpp"
#include "musher/transport/network.hpp"
#include "musher/transport/ros_environment.hpp"

namespace musher {
namespace {

// A participant that keeps publishing wrong pids must not fill the journal.
constexpr Duration kUnprovenPeriod = std::chrono::minutes(1);

}  // namespace

void ControllerShell::Do(const action::StartProcess& a) {
  // A start that waits is replaced; until this returns it is kept, since it may be what calls.
  const auto replaced = std::exchange(starts_later_[a.actuator], nullptr);
  const Time at = presence_->MayStartProcessesAt();
  if (at > dependencies_.node->loop().Now()) {
    starts_later_[a.actuator] = dependencies_.node->loop().At(at, [this, a] { Do(a); });
    return;
  }
  const ActuatorConfig& actuator = config_.actuators[a.actuator];
  ProcessSpec spec;
  spec.name = actuator.name;
  spec.argv = actuator.command;
  spec.cwd = actuator.cwd;
  spec.env = actuator.env;
  if (!config_.file.empty()) {
    spec.env.emplace("MUSHER_CONFIG", std::filesystem::absolute(config_.file).string());
  }
  spec.env.emplace("MUSHER_ACTUATOR", actuator.name);
  const MachineIdentity machine = machine_identity();
  spec.env.emplace("MUSHER_MACHINE", machine.name);
  if (!machine.id.empty()) spec.env.emplace("MUSHER_MACHINE_ID", machine.id);
  if (actuator.protocol == Protocol::kRos2Lifecycle) {
    transport::Environment inherited = transport::OwnEnvironment();
    for (const auto& [name, value] : actuator.env) inherited[name] = value;
    spec.env.merge(transport::RosEnvironment(
        config_.transport, inherited,
        transport::OuterInterfaces(config_.transport, config_.interfaces)));
  }
  const bool alone =
      machine_.actuators[a.actuator].process.dead != 0;  // the other actuators already run
  if (alone) spec.env.emplace("MUSHER_FAST_DISCOVERY", "1");
  if (dependencies_.child_mark) spec.mark = dependencies_.child_mark(actuator.name);
  const auto output = dependencies_.output(actuator.name);
  if (output) spec.output = output->get();
  auto pid = std::make_shared<pid_t>(0);
  const auto started =
      dependencies_.processes->Start(spec, [this, i = a.actuator, pid](const ProcessExit& exit) {
        health_->Forget(i);
        ForgetChild(i, *pid);
        peers_[i].link->OnProcessEnded(*pid);
        if (exit.kind == ProcessExit::Kind::kNotRun) {
          return Handle(event::ProcessNotStarted{i, exit.Text()});
        }
        Handle(event::ProcessEnded{i, *pid, exit.clean(), exit.Text(), exit.code()});
      });
  if (!started) return Handle(event::ProcessNotStarted{a.actuator, started.error().message});
  *pid = started.value();
  NoteChild(a.actuator, started.value());
  peers_[a.actuator].link->OnProcess(*pid);
  Handle(event::ProcessStarted{a.actuator, started.value()});
}

void ControllerShell::Do(const action::FindProcesses&) {
  event::ProcessesFound found;
  found.processes.resize(config_.actuators.size());
  std::vector<ActuatorIndex> with_command;
  std::vector<std::string> names;
  for (const ActuatorIndex i : config_.actuators.Indices()) {
    if (config_.actuators[i].command.empty()) continue;
    with_command.push_back(i);
    names.push_back(config_.actuators[i].name);
  }
  const std::vector<pid_t> pids = dependencies_.process_probe->Find(names);
  for (std::size_t n = 0; n < with_command.size(); ++n) {
    const ActuatorIndex i = with_command[n];
    if (WatchFound(i, pids[n], nullptr)) found.processes[i] = pids[n];
  }
  Handle(found);
}

// Saves what the next controller needs to find the process again.
void ControllerShell::NoteChild(ActuatorIndex actuator, pid_t pid) {
  children_[actuator] = {config_.actuators[actuator].name, pid,
                         dependencies_.process_probe->StartTimeOf(pid)};
  SaveChildren();
}

void ControllerShell::ForgetChild(ActuatorIndex actuator, pid_t pid) {
  const auto child = children_.find(actuator);
  if (child == children_.end() || child->second.pid != pid) return;
  children_.erase(child);
  SaveChildren();
}

// If this controller exits before they are saved, the next one finds them by their marks.
void ControllerShell::SaveChildren() {
  if (!dependencies_.save_children) return;
  std::vector<ChildProcess> children;
  children.reserve(children_.size());
  for (const auto& [actuator, child] : children_) children.push_back(child);
  dependencies_.save_children(children, [this](const Result<>& saved) {
    if (!saved && !std::exchange(children_unsaved_, true)) {
      Remark(saved.error().code, "the list of processes is not saved: " + saved.error().message +
                                     "; the next controller finds them by their environment only");
    }
    if (saved) children_unsaved_ = false;
  });
}

void ControllerShell::Do(const action::SignalProcess& a) {
  // A process that has exited meanwhile needs no signal.
  static_cast<void>(dependencies_.processes->Signal(a.pid, a.kill ? SIGKILL : SIGTERM).ok());
}

// The command survives this controller, which is about to exit.
void ControllerShell::Do(const action::RunPowerCommand& a) {
  if (hooks_.on_power) hooks_.on_power(a.reboot);
  const PowerPolicy& power = config_.policy->power;
  ProcessSpec spec;
  spec.name = a.reboot ? "reboot" : "power_off";
  spec.argv = a.reboot ? power.reboot_command : power.off_command;
  if (spec.argv.empty()) return;
  if (power_command_runs_) return;  // it was requested again meanwhile
  const auto output = dependencies_.output(spec.name);
  if (output) spec.output = output->get();
  const auto failed = [this, name = spec.name](const std::string& how) {
    RecordHere("policy", std::nullopt, kCodeFailed, texts::PowerCommandFailed(name, how));
  };
  const auto started =
      dependencies_.processes->Start(spec, [this, failed](const ProcessExit& exit) {
        power_command_runs_ = false;
        if (!exit.clean()) failed("failed: " + exit.Text());
      });
  power_command_runs_ = started.ok();
  if (!started) failed("could not be executed: " + started.error().message);
}

// The report, with pid 0 unless the pid is proven. Any participant on the network can publish a
// status with any pid of this host; a pid that is not proven to be the actuator's is dropped here:
// nothing is watched, traced or signalled because of it. The result is kept for as long as the
// process of that incarnation reports the same pid.
ActuatorReport ControllerShell::WithProvenPid(ActuatorIndex actuator, ActuatorReport report) {
  if (report.pid == 0 || report.host.empty() || report.host != dependencies_.host) return report;
  Process& process = ProcessOf(actuator, report);
  if (process.pid != report.pid) {
    process.pid = report.pid;
    const Result<> proven = ProveAndWatch(actuator, report);
    process.proven = proven.ok();
    // If the process has exited meanwhile, its writer is lost as well: no record needed.
    const bool ended = !proven && proven.error().code == kCodeStateInvalid;
    if (!proven && !ended) RecordUnproven(actuator, report.pid, proven.error().message);
  }
  if (!process.proven) report.pid = 0;
  return report;
}

// The exit of a process that we did not start is noticed as fast as a child's, but without the exit
// code. Several actuators may share a process: each watches it.
Result<> ControllerShell::ProveAndWatch(ActuatorIndex actuator, const ActuatorReport& report) {
  const std::int32_t child = machine_.actuators[actuator].process.pid;
  if (report.pid == child) return Ok();  // watched since it was started
  Result<> proven =
      dependencies_.process_probe->Prove(config_.actuators[actuator].name, report.pid, child);
  if (!proven || report.pid == dependencies_.pid) return proven;
  return dependencies_.processes->Watch(
      report.pid, [this, actuator, incarnation = report.incarnation,
                   pid = report.pid](const ProcessExit& exit) {
        const bool known = exit.kind != ProcessExit::Kind::kUnknown;
        health_->Forget(actuator);
        Handle(event::Vanished{
            actuator, incarnation, true,
            "its process " + std::to_string(pid) + " ended" + (known ? ": " + exit.Text() : "")});
      });
}

// The exit of a program of another protocol that we did not start: its participant says which
// process it has. That is used for nothing but this watch, and only if the process takes part in
// our domain: in a container the same number may be another process.
void ControllerShell::WatchProgram(ActuatorIndex actuator) {
  Peer& peer = peers_[actuator];
  const transport::ParticipantId participant =
      peer.link ? peer.link->ProgramsParticipant() : transport::ParticipantId();
  if (participant == peer.looked_at) return;
  peer.looked_at = participant;
  if (participant == 0 || dependencies_.host_name.empty()) return;
  const std::vector<transport::PeerInfo> peers = dependencies_.node->Peers();
  const auto found = std::ranges::find(peers, participant, &transport::PeerInfo::id);
  if (found == peers.end() || found->pid == 0 || found->host != dependencies_.host_name) return;
  const std::int32_t pid = found->pid;
  if (!dependencies_.process_probe->SharesDomain(pid)) return;
  const Result<> watched =
      dependencies_.processes->Watch(pid, [this, actuator, participant, pid](const ProcessExit&) {
        health_->Forget(actuator);
        peers_[actuator].link->OnParticipantEnded(participant, pid);
      });
  if (watched) peer.link->OnParticipantWatched(participant);
}

void ControllerShell::RecordUnproven(ActuatorIndex actuator, std::int32_t pid,
                                     const std::string& why) {
  std::optional<Time>& recorded = peers_[actuator].unproven_recorded;
  const Time now = dependencies_.node->loop().Now();
  if (recorded && now - *recorded < kUnprovenPeriod) return;
  recorded = now;
  RecordHere("process", actuator, kCodePermissionDenied,
             texts::ProcessUnproven(config_.actuators[actuator].name, pid, why));
}

// Watches a process that ran before this controller and may never publish a status. A `child` was
// started for this actuator by an earlier controller; null: it was not.
bool ControllerShell::WatchFound(ActuatorIndex actuator, pid_t pid, const ChildProcess* child) {
  if (pid == 0 || pid == dependencies_.pid) return false;
  const auto on_exit = [this, actuator, pid](const ProcessExit&) {
    health_->Forget(actuator);
    ForgetChild(actuator, pid);
    peers_[actuator].link->OnProcessEnded(pid);
    Handle(event::ProcessEnded{actuator, pid, false, "exit code unknown"});
  };
  const bool watched = child ? dependencies_.processes->Adopt(pid, child->start_time, on_exit).ok()
                             : dependencies_.processes->Watch(pid, on_exit).ok();
  if (!watched) return false;
  if (child) NoteChild(actuator, pid);
  peers_[actuator].link->OnProcessFound(pid);
  return true;
}

}  // namespace musher
