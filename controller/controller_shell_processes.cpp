// The processes of the actuators: started, signalled, watched.

#include <signal.h>

#include <filesystem>
#include <memory>
#include <utility>

#include "musher/controller/controller_shell.hpp"

namespace musher {

void ControllerShell::Do(const action::StartProcess& a) {
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
  const bool alone = machine_.actuators[a.actuator].dead != 0;  // the others are there already
  if (alone) spec.env.emplace("MUSHER_IMPATIENT", "1");
  const auto output = world_.output(actuator.name);
  if (output) spec.output = output->get();
  auto pid = std::make_shared<pid_t>(0);
  const auto started =
      world_.processes->Start(spec, [this, i = a.actuator, pid](const ProcessExit& exit) {
        health_->Forget(i);
        peers_[i].link->OnProcess(0);
        if (exit.kind == ProcessExit::Kind::kNotRun) {
          return Handle(event::ProcessNotStarted{i, exit.Text()});
        }
        Handle(event::ProcessEnded{i, *pid, exit.clean(), exit.Text(), exit.code()});
      });
  if (!started) return Handle(event::ProcessNotStarted{a.actuator, started.error().message});
  *pid = started.value();
  peers_[a.actuator].link->OnProcess(*pid);
  Handle(event::ProcessStarted{a.actuator, started.value()});
}

void ControllerShell::Do(const action::SignalProcess& a) {
  // One that ended meanwhile needs no signal.
  static_cast<void>(world_.processes->Signal(a.pid, a.kill ? SIGKILL : SIGTERM).ok());
}

// It outlives this controller, which is about to end.
void ControllerShell::Do(const action::RunPowerCommand& a) {
  if (hooks_.on_power) hooks_.on_power(a.reboot);
  const PowerPolicy& power = config_.policy->power;
  ProcessSpec spec;
  spec.name = a.reboot ? "reboot" : "power_off";
  spec.argv = a.reboot ? power.reboot_command : power.off_command;
  if (spec.argv.empty()) return;
  const auto output = world_.output(spec.name);
  if (output) spec.output = output->get();
  const auto failed = [this, name = spec.name](const std::string& how) {
    Do(action::Record{"policy", std::nullopt, 0, kCodeFailed, "the command of " + name + how});
  };
  const auto started = world_.processes->Start(spec, [failed](const ProcessExit& exit) {
    if (!exit.clean()) failed(" ended: " + exit.Text());
  });
  if (!started) failed(" could not be run: " + started.error().message);
}

// A process of this host that we did not start: its end is seen as fast as a child's, only the exit
// code is not.
void ControllerShell::WatchForeign(std::size_t actuator, const ActuatorReport& report) {
  Peer& peer = peers_[actuator];
  if (peer.watched == report.incarnation) return;
  peer.watched = report.incarnation;
  if (report.host != world_.host || report.host.empty() ||
      report.pid == machine_.actuators[actuator].process || report.pid == world_.pid) {
    return;
  }
  const auto watched = world_.processes->Watch(
      report.pid,
      [this, actuator, incarnation = report.incarnation, pid = report.pid](const ProcessExit&) {
        health_->Forget(actuator);
        Handle(event::Vanished{actuator, incarnation, true,
                               "its process " + std::to_string(pid) + " ended"});
      });
  // Failing means that it ended already; then its writer goes as well.
  static_cast<void>(watched.ok());
}

// One that ran before us, and that may never say a word.
bool ControllerShell::WatchFound(std::size_t actuator, pid_t pid) {
  if (pid == 0 || pid == world_.pid) return false;
  const auto on_exit = [this, actuator, pid](const ProcessExit&) {
    health_->Forget(actuator);
    Handle(event::ProcessEnded{actuator, pid, false, "how is not known"});
  };
  return world_.processes->Watch(pid, on_exit).ok();
}

}  // namespace musher
