// What is under way, and the invariants of a stable state.

#include "musher/lifecycle/config/flow.hpp"
#include "musher/lifecycle/policy/policy.hpp"
#include "musher/simulation/checker.hpp"

namespace musher::simulation {

// What an actuator will do by itself; empty: nothing.
std::string Checker::PendingActivity(const Machine& machine, ActuatorIndex i) const {
  const ActuatorRecord& r = machine.actuators[i];
  const bool alive = robot_.IsAlive(config_.actuators[i].name);
  if (r.set_up_by && r.presence != Presence::kPresent && alive) return "is being set up";
  if (r.fault && !r.command && !r.restart.at && !r.process.termination && !r.restart.requested)
    return {};
  if (r.command) return "has a command to " + r.command->target;
  if (r.restart.at || r.restart.requested) return "is to be restarted";
  if (r.process.termination) return "is to be killed";
  if (r.free_by) return "is busy with the callback that it was found in";
  if (r.control.again && r.presence == Presence::kStarting && alive) return "is being attached";
  const bool waits = machine.emergency.stop || r.held || machine.phase != Phase::kRunning ||
                     r.presence != Presence::kPresent;
  return r.due && !waits ? "is to be switched to the machine's state" : "";
}

std::string Checker::PendingActivity() const {
  const ControllerProcess* controller = robot_.leader();
  if (controller == nullptr) return "no controller leads the machine";
  if (robot_.leaders() > 1) return "two controllers lead the machine";
  const Machine& machine = controller->shell().machine();
  if (machine.phase == Phase::kStopped) return {};
  if (machine.current) return "a switch to " + machine.current->target + " is under way";
  if (machine.policy.keep) return "an application keeps it in " + machine.policy.keep->state;
  if (machine.policy.power) return "the robot is being powered off";
  const PolicyState& policy = machine.policy;
  if (ConfirmedAt(policy.lifting, {})) return "the battery is about to lift its ceiling";
  if (ConfirmedAt(policy.emptying, {}) && !policy.empty) return "it is about to be powered off";
  if (machine.policy.still_since) return "it is about to go to LowPower";
  if (machine.emergency.release) return "the release of an emergency stop is being confirmed";
  if (machine.fallback.target) return "it is about to fall back to " + *machine.fallback.target;
  if (machine.phase != Phase::kRunning && machine.phase != Phase::kFailed) {
    return "the machine is " + std::string(PhaseName(machine.phase));
  }
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    const std::string activity = PendingActivity(machine, i);
    if (!activity.empty()) return config_.actuators[i].name + " " + activity;
  }
  return {};
}

void Checker::CheckRest(bool provided) {
  const ControllerProcess* controller = robot_.leader();
  if (controller == nullptr) return;
  ++checks_;
  const Machine& machine = controller->shell().machine();
  if (!open_requests_.empty()) {
    ReportViolation(Invariant::kOneReplyPerRequest,
                    "a request for " + open_requests_.begin()->second.target + " has no reply");
  }
  CheckCeiling(machine, true);
  if (machine.phase != Phase::kStopped) {
    CheckStopsAtRest(machine);
    CheckClientsAtRest();
  }
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    if (machine.phase == Phase::kStopped) {
      const std::string& name = config_.actuators[i].name;
      const bool here = robot_.processes().IsAlive(name, controller->host());
      if (!config_.actuators[i].command.empty() && here) {
        ReportViolation(Invariant::kTearDownEndsProcesses,
                        "the process of " + name + " outlives the machine");
      }
      continue;
    }
    CheckPlaceInStart(machine, i);
    if (machine.phase != Phase::kRunning) continue;
    CheckRunsOnce(config_.actuators[i].name);
    CheckPlace(machine, i);
    CheckLoss(machine, i, provided);
  }
}

void Checker::CheckPlace(const Machine& machine, ActuatorIndex i) {
  const ActuatorRecord& record = machine.actuators[i];
  const std::string& name = config_.actuators[i].name;
  const ActuatorReport* report = robot_.ReportOf(i, record.report);
  if (report == nullptr || record.held || record.fault || false_reporters_.contains(name)) return;
  const auto own = config_.RankOf(report->state);
  const auto rank = config_.RankOf(machine.state);
  const bool waits = machine.emergency.stop && (!own || (rank && *own < *rank));
  if (machine.emergency.stop && record.presence == Presence::kPresent &&
      report->emergency_stop == 0) {
    ReportViolation(Invariant::kEmergencyStopHolds, name + " has not latched the emergency stop");
  }
  if (report->state == machine.state || waits || !rank) return;
  if (config_.actuators[i].stage > machine.start_up.stage && record.presence == Presence::kAbsent)
    return;
  ReportViolation(Invariant::kStatesAgree, name + " is in " + report->state +
                                               " while the machine is in " + machine.state +
                                               ", without a recorded reason");
}

// In a step of a start, even a failed start, the machine has no state for its actuators.
// They stay where a rollback leads: in DeActive or else LowPower, or less active. One that cannot
// be brought there is listed.
void Checker::CheckPlaceInStart(const Machine& machine, ActuatorIndex i) {
  const ActuatorRecord& record = machine.actuators[i];
  const ActuatorConfig& actuator = config_.actuators[i];
  const ActuatorReport* report = robot_.ReportOf(i, record.report);
  if (config_.RankOf(machine.state) || record.presence != Presence::kPresent || record.held) return;
  if (report == nullptr || report->busy() || false_reporters_.contains(actuator.name)) return;
  const bool rests = actuator.Lists(kDeActive) || actuator.Lists(kLowPower);
  const State most(actuator.Lists(kDeActive) || !rests ? kDeActive : kLowPower);
  if (!config_.RankOf(report->state) || !Falls(config_, report->state, most)) return;
  // Where it was to be brought back, its callback has failed, or it must not be commanded.
  const bool fails = !rests || report->outcome_code != kCodeOk || record.health == Health::kHung ||
                     record.restart.given_up;
  if (record.fault && fails) return;
  ReportViolation(Invariant::kStatesAgree, actuator.name + " stays in " + report->state +
                                               " while the machine is in " + machine.state);
}

void Checker::CheckLoss(const Machine& machine, ActuatorIndex i, bool provided) {
  const ActuatorRecord& record = machine.actuators[i];
  const ActuatorConfig& actuator = config_.actuators[i];
  const auto rank = config_.RankOf(machine.state);
  if (record.presence == Presence::kPresent || record.held || !rank) return;
  if (record.presence == Presence::kAbsent && machine.emergency.stop) return;  // of a later stage
  if (!actuator.on_lost.empty()) {
    if (*rank <= *config_.RankOf(actuator.on_lost)) return;
    // An operator may continue without an actuator that is not critical.
    if (!actuator.critical && requested_state_at_ >= lost_at_[i]) return;
    return ReportViolation(
        actuator.critical ? Invariant::kSafeWithoutCritical : Invariant::kOnLostCoversLoss,
        "the machine stays in " + machine.state + " without " + actuator.name +
            ", whose on_lost is " + actuator.on_lost);
  }
  if (!provided || actuator.command.empty()) return;  // others are not started by the controller
  ReportViolation(Invariant::kOnLostCoversLoss,
                  "the machine stays in " + machine.state + " without " + actuator.name + ", " +
                      (record.restart.given_up
                           ? (record.restart.count < actuator.restart.limit
                                  ? "which is not restarted after its exit code"
                                  : "which was given up after " +
                                        std::to_string(record.restart.count) + " restarts")
                           : (robot_.IsAlive(actuator.name) ? "which hangs, and is not killed"
                                                            : "which is not restarted")) +
                      "; it has no on_lost (\"Active\" if the machine may run without it)");
}

}  // namespace musher::simulation
