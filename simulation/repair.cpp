// How the operator repairs the robot, recovers it and switches it off.

#include <signal.h>

#include <algorithm>

#include "musher/simulation/path.hpp"
#include "musher/simulation/scenario.hpp"

namespace musher::simulation {
namespace {

// After this all hosts have noticed the end of a process that no controller of its host monitors.
constexpr Duration kUntilMissed = std::chrono::seconds(12);

}  // namespace

// The operator releases the stop, starts what nothing else starts again, and recovers the machine
// to its home state.
void Scenario::Repair() {
  if (config_.policy) {
    Note("the operator charges the battery");
    robot_.SetBattery(100, true);
    RunFor(std::chrono::seconds(3));  // three samples
    if (!ReachStableState("after the battery was charged")) return;
  }
  // The TearDown of a client that found no controller may reach the first one that starts.
  for (int tries = 0; tries < 3 && robot_.machine().phase == Phase::kStopped; ++tries) {
    Note("the machine was torn down; the operator starts it again");
    robot_.CrashController();
    for (const ActuatorIndex i : config_.actuators.Indices()) {
      if (!IsByHand(i)) continue;
      robot_.CrashActuator(config_.actuators[i].name);
      StartByHand(i);
    }
    StartController();
    if (!ReachStableState("after its start")) return;
  }
  for (int tries = 0; tries < 8 && robot_.machine().emergency.stop; ++tries) {
    Note("the operator releases the emergency stop");
    robot_.ReleaseEmergencyStop();
    RunFor(std::chrono::seconds(1));  // another one may be engaged as well
    if (Over() || !ReachStableState("after the release")) return;
  }
  RepairActuators();
  if (!ReachStableState("after its repair")) return;
  if (RecoverHome() && !Over()) CheckAllAvailable();
}

// The operator starts a controller where none is left: of two, each may have been replaced.
bool Scenario::ReachStableState(const std::string& when) {
  const auto none_runs = [this] { return !robot_.controller(0) && !robot_.controller(1); };
  for (int tries = 0; tries < 3; ++tries) {
    RunUntil([&] { return checker_.AtRest() || none_runs(); }, options_.bound);
    if (Over() || !none_runs()) break;
    Note("no controller runs; the operator starts one");
    StartController();
  }
  if (!checker_.AtRest()) {
    checker_.ReportViolation(Invariant::kReachesStableState, "the machine is not stable " + when +
                                                                 ": " + checker_.PendingActivity());
  }
  return !Over();
}

void Scenario::RepairActuators() {
  if (EndSurplus()) RunFor(kUntilMissed);
  const auto* leader = robot_.leader();
  for (const ActuatorIndex i : config_.actuators.Indices()) {
    if (leader == nullptr) break;
    const ActuatorIndex process = robot_.layout().ProcessOf(i);
    const ActuatorConfig& actuator = config_.actuators[process];
    const ActuatorRecord& record = leader->shell().machine().actuators[i];
    const ActuatorReport* report = robot_.ReportOf(i, record.report);
    const bool finished = report != nullptr && report->state == kTearDown;  // its process may run
    const bool well = report != nullptr && !report->busy() && !record.fault && !finished;
    if (well) continue;
    Note("the operator restarts " + actuator.name);
    EndElsewhere(actuator);
    if (!actuator.command.empty()) {
      checker_.OnRestartRequest(actuator.name);
      robot_.Restart(actuator.name);
      continue;
    }
    robot_.CrashActuator(actuator.name);
    RunFor(std::chrono::seconds(1));
    if (Over()) return;
    StartByHand(process);
  }
  RunFor(std::chrono::seconds(15));
}

// Ends the processes of the actuator on hosts other than the leading controller's.
void Scenario::EndElsewhere(const ActuatorConfig& actuator) {
  const std::size_t here = robot_.leader()->host();
  for (std::size_t host = 0; host < robot_.hosts().size(); ++host) {
    if (actuator.command.empty() || host == here) continue;
    if (!robot_.processes().IsAlive(actuator.name, host)) continue;
    robot_.processes().End(actuator.name, host, {ProcessExit::Kind::kKilled, SIGKILL});
    RunFor(kUntilMissed);
  }
}

// Of an actuator that runs on several hosts the operator keeps the process that the controller can
// restart.
bool Scenario::EndSurplus() {
  bool any = false;
  const std::size_t here = robot_.leader()->host();
  for (const ActuatorConfig& actuator : config_.actuators) {
    const bool by_controller =
        !actuator.command.empty() && robot_.processes().IsAlive(actuator.name, here);
    const std::size_t keep = by_controller ? here : robot_.processes().HomeOf(actuator.name);
    for (std::size_t host = 0; host < robot_.hosts().size(); ++host) {
      const bool surplus = host != keep && robot_.processes().CountOf(actuator.name) > 1;
      if (!surplus || !robot_.processes().IsAlive(actuator.name, host)) continue;
      Note("the operator ends " + actuator.name + " on host " + robot_.hosts().name(host));
      robot_.processes().End(actuator.name, host, {ProcessExit::Kind::kKilled, SIGKILL});
      any = true;
    }
  }
  return any;
}

bool Scenario::RecoverHome() {
  for (int tries = 0; tries < 3; ++tries) {
    const ControllerProcess* leader = robot_.leader();
    if (leader == nullptr) {
      checker_.ReportViolation(Invariant::kReachesStableState, "no controller leads the machine");
      return false;
    }
    const State from = leader->shell().machine().state;
    auto path = FindPath(config_, from, options_.home);
    if (!path) {
      checker_.ReportViolation(
          Invariant::kRecoverable,
          "the machine is in " + from + ", from where no switch leads to " + options_.home);
      return false;
    }
    // A requested self-check includes the actuators that failed theirs.
    if (config_.HasState(kSelfCheck)) path->insert(path->begin(), State(kSelfCheck));
    if (path->size() < 2 && from == options_.home) path->push_back(options_.home);
    for (const State& next : *path) {
      Note("the operator requests " + next);
      RequestSwitch(next);
      RunUntil([this] { return checker_.AtRest(); }, options_.bound);
      RunFor(std::chrono::seconds(2));
      if (Over()) return false;
    }
    const Machine& machine = robot_.machine();
    if (machine.state == options_.home && Degraded(config_, machine).empty()) return true;
  }
  return true;
}

void Scenario::CheckAllAvailable() {
  const Machine& machine = robot_.machine();
  if (machine.state != options_.home) {
    return checker_.ReportViolation(Invariant::kAllAvailableAfterRecovery,
                                    "after the repair and a switch to " + options_.home +
                                        ", the machine is in " + machine.state);
  }
  const auto degraded = Degraded(config_, machine);
  if (!degraded.empty()) {
    const ActuatorIndex i = *config_.IndexOf(degraded.front());
    return checker_.ReportViolation(
        Invariant::kAllAvailableAfterRecovery,
        "after the repair " + degraded.front() +
            " is still degraded: " + TroubleOf(machine.actuators[i])->message);
  }
  checker_.CheckRest(false);
  for (const ActuatorConfig& actuator : config_.actuators) {
    const ActuatorIndex i = *config_.IndexOf(actuator.name);
    const ActuatorReport* report = robot_.ReportOf(i, machine.actuators[i].report);
    const std::string state = report == nullptr ? "not running" : "in " + report->state;
    if (report == nullptr || report->state != options_.home) {
      checker_.ReportViolation(Invariant::kAllAvailableAfterRecovery,
                               "after the repair " + actuator.name + " is " + state);
    } else if (report->held_by_stop) {
      checker_.ReportViolation(
          Invariant::kAllAvailableAfterRecovery,
          "after the repair " + actuator.name + " is held by an emergency stop that was released");
    }
  }
}

void Scenario::SwitchOff() {
  if (!config_.HasState(kTearDown)) return;
  Note("the operator switches the robot off");
  RequestSwitch(State(kTearDown));
  const auto stopped = [this] { return robot_.machine().phase == Phase::kStopped; };
  if (!RunUntil(stopped, config_.shutdown_budget + Milliseconds(100))) {
    return checker_.ReportViolation(Invariant::kTearDownEndsProcesses,
                                    "the machine is not torn down within its budget");
  }
  RunFor(Milliseconds(100));
  checker_.CheckRest(false);
}

ScenarioOptions UsualOptions(const MachineConfig& config) {
  ScenarioOptions options;
  Duration longest{};
  Duration delay{};
  int restarts = 1;
  for (const ActuatorIndex i : config.actuators.Indices()) {
    Duration one{};
    for (const State& state : config.actuators[i].states) {
      one = std::max(one, config.TimeFor(i, state));
    }
    longest += one;  // as if each waited for the one before
    restarts = std::max(restarts, config.actuators[i].restart.limit);
    delay = std::max(delay, config.actuators[i].restart.max_delay);
  }
  options.bound = std::chrono::minutes(1) + 3 * (restarts + 1) * (longest + delay);
  for (const State& state : config.states) {
    const auto rank = config.RankOf(state);
    const bool higher = rank && (options.home.empty() || *rank > *config.RankOf(options.home));
    if (higher) options.home = state;
  }
  if (config.HasState(kActive)) options.home = State(kActive);
  return options;
}

}  // namespace musher::simulation
