// The processes of the actuators: those that already run when a controller starts, and their logs.

#include <unistd.h>

#include <csignal>
#include <utility>

#include "musher/base/host.hpp"
#include "musher/controller/controller.hpp"

namespace musher {
namespace {

// A process that an earlier controller has started and the config does not list gets SIGKILL after
// this time.
constexpr Duration kUnlistedEndsWithin = Milliseconds(2000);

}  // namespace

// Finds the actuators' processes that already run on this host, started by an earlier controller or
// by hand; returns those that a controller has started. Only trusted ones are watched and stopped
// with the machine.
std::vector<ChildProcess> Controller::FindRunning(event::Begin& begin) {
  std::vector<ChildProcess> stored;
  for (const std::string& folder : {store_ ? config_.state_dir : std::string(), taken_from_}) {
    if (folder.empty()) continue;
    const auto more = StateStore::LoadChildren(folder, HostId());
    stored.insert(stored.end(), more.begin(), more.end());
  }
  std::vector<MarkedActuator> marked;
  for (const ActuatorConfig& actuator : config_.actuators) {
    const std::string name = LockOf(actuator.name);
    begin.running.push_back(NameLock::IsHeld(name));
    begin.processes.push_back(0);
    if (!actuator.command.empty()) marked.push_back({actuator.name, name, begin.running.back()});
  }
  std::vector<ChildProcess> children = FindChildren(marked, stored);
  for (const ChildProcess& child : children) {
    const ActuatorIndex i = *config_.IndexOf(child.actuator);
    begin.running[i] = true;
    begin.processes[i] = child.pid;
  }
  for (const ActuatorIndex i : config_.actuators.Indices()) {
    if (begin.running[i] && begin.processes[i] == 0) begin.processes[i] = HolderOf(i);
  }
  for (const ChildProcess& child : stored) {
    const auto i = config_.IndexOf(child.actuator);
    if ((!i || config_.actuators[*i].command.empty()) && IsRunning(child)) EndUnlisted(child);
  }
  return children;
}

pid_t Controller::HolderOf(ActuatorIndex i) {
  const std::string& actuator = config_.actuators[i].name;
  const auto holder = NameLock::HolderOf(LockOf(actuator));
  if (holder.trusted) return holder.pid;
  shell_->Remark(kCodePermissionDenied,
                 holder.Text() + " holds the name of " + actuator +
                     " but belongs neither to root nor to user " + std::to_string(geteuid()) +
                     ": it is not watched or signalled, and " + actuator + " is not started");
  return 0;
}

// Stops a process that no controller controls any more. A process that holds its name is reported
// instead, see ControllerShell::RecordUnlisted.
void Controller::EndUnlisted(const ChildProcess& child) {
  if (NameLock::IsHeld(LockOf(child.actuator))) return;
  if (!processes_.Adopt(child.pid, child.start_time, nullptr)) return;
  shell_->Remark(kCodeStateInvalid, child.actuator + " (pid " + std::to_string(child.pid) +
                                        ") was started by an earlier controller, and " +
                                        config_.file + " does not start it: it is stopped");
  static_cast<void>(processes_.Signal(child.pid, SIGTERM).ok());
  kill_later_.push_back(node_.loop().At(node_.loop().Now() + kUnlistedEndsWithin, [this, child] {
    static_cast<void>(processes_.Signal(child.pid, SIGKILL).ok());
  }));
}

// Without a log the process is started anyway, and its output is lost.
void Controller::OpenLogs() {
  LogFilesOptions options;
  options.max_total_bytes = config_.logs_size_bytes;
  options.on_trouble = [this](const std::string& message) { Trouble(message); };
  const auto add = [&](const std::string& name, std::int64_t bytes) {
    options.logs.push_back({name, store_->LogFile(name), bytes});
  };
  for (const ActuatorConfig& actuator : config_.actuators) {
    if (!actuator.command.empty()) add(actuator.name, actuator.log_size_bytes);
  }
  if (config_.view) add("musher-view", config_.log_size_bytes);
  if (config_.policy) {
    const PowerPolicy& power = config_.policy->power;
    if (!power.off_command.empty()) add("power_off", config_.log_size_bytes);
    if (!power.reboot_command.empty()) add("reboot", config_.log_size_bytes);
  }
  options.logs.push_back(
      {"the controller", ControllerLogFile(config_), config_.log_size_bytes, /*open=*/false});
  logs_ = std::make_unique<LogFiles>(node_.loop(), std::move(options));
}

}  // namespace musher
