#include "musher/simulation/process_checker.hpp"

#include <algorithm>

#include "musher/lifecycle/switch/tear_down.hpp"

namespace musher::simulation {
namespace {

// A controller may react so long to a fault of a process, or of its link, that is over.
constexpr Duration kReactsFor = std::chrono::seconds(30);

}  // namespace

// A controller knows the exit code of its own children, and of units as soon as systemd says it.
void ProcessChecker::OnWrongConfig(const std::string& name) {
  const SimulatedController* leader = robot_.leader();
  if (leader == nullptr) return;
  if (config_.own_units && robot_.systemds()->IsSilent(leader->host())) return;
  const ActuatorIndex i = *config_.IndexOf(name);
  const RestartConfig& restart = config_.actuators[i].restart;
  const KnownActuator& known = leader->shell().machine().actuators[i];
  const bool its_child = known.process.pid != 0 &&
                         known.process.pid == robot_.processes().PidOf(name, leader->host()) &&
                         known.process.launch != Launch::kFoundRunning;
  const bool counts = restart.policy != RestartPolicy::kNo && restart.Prevents(kUsageExitCode);
  if (its_child && counts && !known.restart.requested) config_errors_[name] = leader->serial();
}

void ProcessChecker::OnStart(const SimulatedController& controller, const std::string& name) {
  CheckRunsNowhereElse(controller, name);
  const auto ended = config_errors_.find(name);
  if (ended != config_errors_.end() && ended->second == controller.serial()) {
    ReportViolation(Invariant::kNoRestartOnConfigError,
                    name + ", which exited with code 2, is restarted without a request");
  }
  config_errors_.erase(name);
  const ActuatorIndex i = *config_.IndexOf(name);
  const RestartConfig& restart = config_.actuators[i].restart;
  const bool ends_at_once = robot_.processes().IsMisconfigured(name);
  const bool counts = restart.policy != RestartPolicy::kNo && restart.Prevents(kUsageExitCode);
  if (ends_at_once && counts) config_errors_[name] = controller.serial();
}

// A controller starts a process. If one of the same actuator runs on another host, the controller
// knows of it unless the link was cut shortly before.
void ProcessChecker::CheckRunsNowhereElse(const SimulatedController& controller,
                                          const std::string& name) {
  CheckProgramRunsOnce(controller, name);
  const SimulatedProcesses& processes = robot_.processes();
  const Time now = robot_.network().now();
  for (std::size_t host = 0; host < robot_.hosts().size(); ++host) {
    const ActuatorReport* report = processes.ReportOf(name, host);
    if (host == controller.host() || report == nullptr) continue;
    const std::string& endpoint = processes.EndpointOf(name, host);
    const auto in_reach = [&](const std::string& from, const std::string& to) {
      const auto blocked = robot_.hosts().BlockedUntil(from, to);
      return !blocked || *blocked <= now - kReceivedAfter;
    };
    const bool known =
        in_reach(endpoint, controller.endpoint()) && in_reach(controller.endpoint(), endpoint) &&
        processes.StartOf(name, host) <= now - kReceivedAfter && !processes.IsFrozen(name, host);
    // Nothing says that an actuator without a command runs in the process that this one has left.
    const bool left = report->state == kTearDown && processes.CoreOf(name, host) == nullptr;
    if (!known || left) {
      const ActuatorIndex process = robot_.layout().ProcessOf(*config_.IndexOf(name));
      for (const ActuatorIndex i : config_.actuators.Indices()) {
        if (robot_.layout().ProcessOf(i) == process) duplicated_.insert(config_.actuators[i].name);
      }
      continue;
    }
    if (report->state == kTearDown) continue;
    ReportViolation(Invariant::kNoDuplicateActuator,
                    "the controller on host " + robot_.hosts().name(controller.host()) +
                        " starts " + name + ", which runs on host " + robot_.hosts().name(host));
  }
}

// A controller signals a process: it must be its child, or hold the name of the actuator that the
// controller takes it for.
void ProcessChecker::CheckSignal(const SimulatedController& controller, std::int32_t pid) {
  const Machine& machine = controller.shell().machine();
  bool unproven = true;
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    const KnownActuator& known = machine.actuators[i];
    const bool terminated = known.process.termination && known.process.termination->pid == pid;
    const bool meant = known.process.pid == pid || terminated || known.report.pid == pid;
    const bool holds =
        robot_.processes().PidOf(config_.actuators[i].name, controller.host()) == pid;
    unproven &= !(meant && holds);
  }
  if (!unproven || !robot_.processes().Exists(controller.host(), pid)) return;
  ReportViolation(Invariant::kOnlyOwnProcessesSignalled,
                  "the controller signals process " + std::to_string(pid) +
                      ", which is not the process of that actuator");
}

// Runs after each step of an actuator. Until the end of a callback its heartbeats report that it
// has run for longer than without a checkpoint.
void ProcessChecker::NoteOverrun(const std::string& name, std::size_t host, bool begun,
                                 const ActuatorReport& report) {
  const ActuatorConfig& actuator = config_.actuators[*config_.IndexOf(name)];
  const Time now = robot_.network().now();
  RunningCallback& callback = callbacks_[{name, host}];
  if (begun) {
    const auto longer = actuator.checkpoint_in.find(report.target);
    const auto limit =
        longer != actuator.checkpoint_in.end() ? longer->second : actuator.checkpoint;
    callback.late_at.reset();
    if (limit) callback.late_at = now + *limit;
  } else if (!report.busy()) {
    if (callback.late_at && *callback.late_at < now) callback.overran_until = now;
    callback.late_at.reset();
  }
}

// Whether nothing is, or was a short while ago, wrong with the process and its link to a controller
// of its host.
bool ProcessChecker::IsWell(const SimulatedController& controller, const std::string& name) const {
  const std::size_t host = controller.host();
  const ActuatorReport* report = robot_.processes().ReportOf(name, host);
  if (report == nullptr || report->busy() || report->state == kTearDown) return false;
  const auto callback = callbacks_.find({name, host});
  const bool overran = callback != callbacks_.end() && callback->second.overran_until &&
                       robot_.network().now() - *callback->second.overran_until < kReceivedAfter;
  return !overran && !WasDisturbed(controller, name, host, kReactsFor);
}

// A controller signals a process of its host. Unless it tears the machine down, or was requested to
// restart an actuator of that process, the process must have a fault of its own.
void ProcessChecker::CheckKill(const SimulatedController& controller, std::int32_t pid) {
  const Machine& machine = controller.shell().machine();
  if (machine.phase == Phase::kStopping) return CheckTornDownFirst(controller, pid);
  if (machine.phase == Phase::kStopped) return;
  std::string killed;
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    const std::string& name = config_.actuators[i].name;
    if (robot_.processes().PidOf(name, controller.host()) != pid) continue;
    if (machine.actuators[i].restart.requested) return;
    const ActuatorReport* report = robot_.processes().ReportOf(name, controller.host());
    if (report != nullptr && report->state == kTearDown) continue;  // torn down alone
    if (!IsWell(controller, name)) return;
    killed = name;
  }
  if (killed.empty()) return;
  ReportViolation(Invariant::kNoKillForTheNetwork,
                  "the controller ends the process of " + killed + ", which is well");
}

// TearDown awaits the status of a process that runs already: a signal would end it in a state such
// as Active.
void ProcessChecker::CheckTornDownFirst(const SimulatedController& controller, std::int32_t pid) {
  const Shutdown& stopping = *controller.shell().machine().stopping;
  const Duration awaited = std::min(kLongestDiscovery, config_.shutdown_budget * 3 / 10);
  if (stopping.result || robot_.network().now() >= stopping.begun + awaited) return;
  for (const ActuatorIndex i : config_.actuators.Indices()) {
    const std::string& name = config_.actuators[i].name;
    if (robot_.processes().PidOf(name, controller.host()) != pid) continue;
    const ActuatorReport* report = robot_.processes().ReportOf(name, controller.host());
    const bool up = report != nullptr && config_.RankOf(report->state);
    if (!up || !config_.actuators[i].Lists(kTearDown) || !IsWell(controller, name)) continue;
    ReportViolation(Invariant::kTornDownBeforeSignals, "the controller signals the process of " +
                                                           name + ", which is in " + report->state +
                                                           " and has had no time for TearDown");
  }
}

// A controller starts a program of another protocol. The program holds no name that would prevent a
// second process; the controller has to know that the first one runs.
void ProcessChecker::CheckProgramRunsOnce(const SimulatedController& controller,
                                          const std::string& name) {
  const SimulatedProcesses& processes = robot_.processes();
  if (!processes.IsProgram(name) || !processes.IsAlive(name, controller.host())) return;
  ReportViolation(Invariant::kNoDuplicateActuator,
                  "the controller starts " + name + ", which already runs as process " +
                      std::to_string(processes.PidOf(name, controller.host())));
}

void ProcessChecker::CheckRunsOnce(const std::string& name) {
  if (robot_.processes().CountOf(name) < 2 || duplicated_.contains(name)) return;
  ReportViolation(Invariant::kNoDuplicateActuator, name + " runs on several hosts");
}

}  // namespace musher::simulation
