// The invariants of hosts and the processes on them.

#include "musher/simulation/checker.hpp"

namespace musher::simulation {
namespace {

// After this long with a working link a controller has received a process's status.
constexpr Duration kReceivedAfter = std::chrono::seconds(2);
// A controller may react so long to a fault of a process, or of its link, that is over.
constexpr Duration kReactsFor = std::chrono::seconds(30);

}  // namespace

// A controller starts a process. If one of the same actuator runs on another host, the controller
// knows of it unless the link was cut shortly before.
void Checker::CheckRunsNowhereElse(const ControllerProcess& controller, const std::string& name) {
  CheckProgramRunsOnce(controller, name);
  const Processes& processes = robot_.processes();
  const Time now = robot_.network().now();
  for (std::size_t host = 0; host < robot_.hosts().size(); ++host) {
    const ActuatorReport* report = processes.ReportOf(name, host);
    if (host == controller.host() || report == nullptr || report->state == kTearDown) continue;
    const std::string& endpoint = processes.EndpointOf(name, host);
    const auto in_reach = [&](const std::string& from, const std::string& to) {
      const auto blocked = robot_.hosts().BlockedUntil(from, to);
      return !blocked || *blocked <= now - kReceivedAfter;
    };
    const bool known =
        in_reach(endpoint, controller.endpoint()) && in_reach(controller.endpoint(), endpoint) &&
        processes.StartOf(name, host) <= now - kReceivedAfter && !processes.IsFrozen(name, host);
    if (!known) {
      const ActuatorIndex process = robot_.layout().ProcessOf(*config_.IndexOf(name));
      for (const ActuatorIndex i : config_.actuators.Indices()) {
        if (robot_.layout().ProcessOf(i) == process) duplicated_.insert(config_.actuators[i].name);
      }
      continue;
    }
    ReportViolation(Invariant::kNoDuplicateActuator,
                    "the controller on host " + robot_.hosts().name(controller.host()) +
                        " starts " + name + ", which runs on host " + robot_.hosts().name(host));
  }
}

// A controller signals a process: it must be its child, or hold the name of the actuator that the
// controller takes it for.
void Checker::CheckSignal(const ControllerProcess& controller, std::int32_t pid) {
  const Machine& machine = controller.shell().machine();
  bool unproven = true;
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    const ActuatorRecord& record = machine.actuators[i];
    const bool terminated = record.process.termination && record.process.termination->pid == pid;
    const bool meant = record.process.pid == pid || terminated || record.report.pid == pid;
    const bool holds =
        robot_.processes().PidOf(config_.actuators[i].name, controller.host()) == pid;
    unproven &= !(meant && holds);
  }
  if (!unproven || !robot_.processes().Exists(controller.host(), pid)) return;
  ReportViolation(Invariant::kOnlyOwnProcessesSignalled,
                  "the controller signals process " + std::to_string(pid) +
                      ", which is not the process of that actuator");
}

void Checker::OnLinkFaults(bool active) {
  if (active) {
    link_faults_until_ = Time::max();
  } else if (link_faults_until_ == Time::max()) {
    link_faults_until_ = robot_.network().now();
  }
}

// Whether nothing is, or was a short while ago, wrong with the process and its link to a controller
// of its host.
bool Checker::IsWell(const ControllerProcess& controller, const std::string& name) const {
  const Time now = robot_.network().now();
  const auto recent = [&](const std::optional<Time>& until) {
    return until && (*until == Time::max() || now - *until < kReactsFor);
  };
  const Processes& processes = robot_.processes();
  const std::size_t host = controller.host();
  const std::string& endpoint = processes.EndpointOf(name, host);
  const ActuatorReport* report = processes.ReportOf(name, host);
  if (report == nullptr || report->busy() || report->state == kTearDown) return false;
  return !recent(processes.FrozenUntil(name, host)) && !recent(controller.thawed) &&
         !recent(link_faults_until_) &&
         !recent(robot_.hosts().BlockedUntil(endpoint, controller.endpoint())) &&
         !recent(robot_.hosts().BlockedUntil(controller.endpoint(), endpoint));
}

// A controller signals a process of its host. Unless it tears the machine down, or was requested to
// restart an actuator of that process, the process must have a fault of its own.
void Checker::CheckKill(const ControllerProcess& controller, std::int32_t pid) {
  const Machine& machine = controller.shell().machine();
  if (machine.phase == Phase::kStopping || machine.phase == Phase::kStopped) return;
  std::string killed;
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    const std::string& name = config_.actuators[i].name;
    if (robot_.processes().PidOf(name, controller.host()) != pid) continue;
    const ActuatorRecord& record = machine.actuators[i];
    if (record.restart.requested || !IsWell(controller, name)) return;
    killed = name;
  }
  if (killed.empty()) return;
  ReportViolation(Invariant::kNoKillForTheNetwork,
                  "the controller ends the process of " + killed + ", which is well");
}

// A controller starts a program of another protocol. The program holds no name that would prevent a
// second process; the controller has to know that the first one runs.
void Checker::CheckProgramRunsOnce(const ControllerProcess& controller, const std::string& name) {
  const Processes& processes = robot_.processes();
  if (!processes.IsProgram(name) || !processes.IsAlive(name, controller.host())) return;
  ReportViolation(Invariant::kNoDuplicateActuator,
                  "the controller starts " + name + ", which already runs as process " +
                      std::to_string(processes.PidOf(name, controller.host())));
}

void Checker::CheckRunsOnce(const std::string& name) {
  if (robot_.processes().CountOf(name) < 2 || duplicated_.contains(name)) return;
  ReportViolation(Invariant::kNoDuplicateActuator, name + " runs on several hosts");
}

}  // namespace musher::simulation
