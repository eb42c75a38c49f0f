// What has to hold of hosts and the processes on them.

#include "musher/simulation/checker.hpp"

namespace musher::simulation {
namespace {

// So long a process has to have been in reach for its status to be known at a controller.
constexpr Duration kHeardAfter = std::chrono::seconds(2);

}  // namespace

// A controller starts a process. One of the same actuator may run on another host; the controller
// knows of that unless the link was cut a moment ago.
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
      return !blocked || *blocked <= now - kHeardAfter;
    };
    const bool known =
        in_reach(endpoint, controller.endpoint()) && in_reach(controller.endpoint(), endpoint) &&
        processes.StartOf(name, host) <= now - kHeardAfter && !processes.IsFrozen(name, host);
    if (!known) {
      const std::size_t process = robot_.layout().ProcessOf(*config_.IndexOf(name));
      for (std::size_t i = 0; i < config_.actuators.size(); ++i) {
        if (robot_.layout().ProcessOf(i) == process) twice_.insert(config_.actuators[i].name);
      }
      continue;
    }
    ReportViolation(Invariant::kRunsOnce,
                    "the controller on host " + robot_.hosts().name(controller.host()) +
                        " starts " + name + ", which runs on host " + robot_.hosts().name(host));
  }
}

// A controller signals a process: one that it has started, or one that it takes for an actuator
// whose name that process holds.
void Checker::CheckSignal(const ControllerProcess& controller, std::int32_t pid) {
  const Machine& machine = controller.shell().machine();
  bool of_nobody = true;
  for (std::size_t i = 0; i < machine.actuators.size(); ++i) {
    const ActuatorRecord& record = machine.actuators[i];
    const bool meant =
        record.process == pid || record.terminating == pid || record.report.pid == pid;
    const bool holds =
        robot_.processes().PidOf(config_.actuators[i].name, controller.host()) == pid;
    of_nobody &= !(meant && holds);
  }
  if (!of_nobody || !robot_.processes().Exists(controller.host(), pid)) return;
  ReportViolation(Invariant::kOnlyProven,
                  "the controller signals process " + std::to_string(pid) +
                      ", which is not of the actuator that it is meant for");
}

// A controller starts a program of another protocol. It holds no name that would keep a second one
// from running beside it; the controller has to know that it runs.
void Checker::CheckProgramRunsOnce(const ControllerProcess& controller, const std::string& name) {
  const Processes& processes = robot_.processes();
  if (!processes.IsProgram(name) || !processes.IsAlive(name, controller.host())) return;
  ReportViolation(Invariant::kRunsOnce,
                  "the controller starts " + name + ", which runs already as process " +
                      std::to_string(processes.PidOf(name, controller.host())));
}

void Checker::CheckRunsOnce(const std::string& name) {
  if (robot_.processes().CountOf(name) < 2 || twice_.contains(name)) return;
  ReportViolation(Invariant::kRunsOnce, name + " runs on several hosts");
}

}  // namespace musher::simulation
