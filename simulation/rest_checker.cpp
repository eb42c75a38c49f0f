#include "musher/simulation/rest_checker.hpp"

#include "musher/lifecycle/config/flow.hpp"
#include "musher/lifecycle/machine/under_way.hpp"
#include "musher/lifecycle/policy/policy.hpp"

namespace musher::simulation {

std::string RestChecker::PendingActivity() const {
  const SimulatedController* controller = robot_.leader();
  if (controller == nullptr) return "no controller leads the machine";
  if (robot_.leaders() > 1) return "two controllers lead the machine";
  const Machine& machine = controller->shell().machine();
  if (machine.phase == Phase::kStopped) return {};
  std::string under_way = UnderWay(
      config_, machine, [&](ActuatorIndex i) { return robot_.IsAlive(config_.actuators[i].name); });
  if (!under_way.empty()) return under_way;
  if (machine.policy.keep) return "an application keeps it in " + machine.policy.keep->state;
  if (machine.policy.power) return "the robot is being powered off";
  const PolicyState& policy = machine.policy;
  if (ConfirmedAt(policy.lifting, {})) return "the battery is about to lift its ceiling";
  if (ConfirmedAt(policy.emptying, {}) && !policy.empty) return "it is about to be powered off";
  const bool unknown = !policy.battery && policy.level != BatteryLevel::kFree;
  if (unknown && !policy.battery_silent) return "the battery may be silent";
  if (machine.policy.still_since) return "it is about to go to LowPower";
  return {};
}

void RestChecker::NotePresence(const SimulatedController& controller) {
  const Machine& machine = controller.shell().machine();
  Seen& seen = seen_[controller.serial()];
  if (seen.lost_at.empty()) {
    seen.lost_at = lost_at_;
    seen.requested_state_at = requested_state_at_;
  }
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    const bool present = machine.actuators[i].presence == Presence::kPresent;
    if (present) lost_at_[i] = seen.lost_at[i] = robot_.age();
  }
}

void RestChecker::CheckPlace(const Machine& machine, ActuatorIndex i) {
  const KnownActuator& known = machine.actuators[i];
  const std::string& name = config_.actuators[i].name;
  const ActuatorReport* report = robot_.ReportOf(i, known.report);
  if (report == nullptr || known.held || known.fault || context_.false_reporters.contains(name))
    return;
  const auto own = config_.RankOf(report->state);
  const auto rank = config_.RankOf(machine.state);
  const bool waits = machine.emergency.stop && (!own || (rank && *own < *rank));
  if (machine.emergency.stop && known.presence == Presence::kPresent &&
      report->emergency_stop == 0) {
    ReportViolation(Invariant::kEmergencyStopHolds, name + " has not latched the emergency stop");
  }
  if (report->state == machine.state || waits || !rank) return;
  if (config_.actuators[i].stage > machine.start_up.stage && known.presence == Presence::kAbsent)
    return;
  ReportViolation(Invariant::kStatesAgree, name + " is in " + report->state +
                                               " while the machine is in " + machine.state +
                                               ", without a recorded reason");
}

// In a step of a start, even a failed start, the machine has no state for its actuators.
// They stay where a rollback leads: in DeActive or else LowPower, or less active. One that cannot
// be brought there is listed.
void RestChecker::CheckPlaceInStart(const Machine& machine, ActuatorIndex i) {
  const KnownActuator& known = machine.actuators[i];
  const ActuatorConfig& actuator = config_.actuators[i];
  const ActuatorReport* report = robot_.ReportOf(i, known.report);
  if (config_.RankOf(machine.state) || known.presence != Presence::kPresent || known.held) return;
  if (report == nullptr || report->busy() || context_.false_reporters.contains(actuator.name))
    return;
  const bool rests = actuator.Lists(kDeActive) || actuator.Lists(kLowPower);
  const State most(actuator.Lists(kDeActive) || !rests ? kDeActive : kLowPower);
  if (!config_.RankOf(report->state) || !Falls(config_, report->state, most)) return;
  // Where it was to be brought back, its callback has failed, or it must not be commanded.
  const bool fails = !rests || report->outcome_code != kCodeOk || known.health == Health::kHung ||
                     known.restart.given_up;
  if (known.fault && fails) return;
  ReportViolation(Invariant::kStatesAgree, actuator.name + " stays in " + report->state +
                                               " while the machine is in " + machine.state);
}

void RestChecker::CheckLoss(const Machine& machine, ActuatorIndex i, bool provided) {
  const KnownActuator& known = machine.actuators[i];
  const ActuatorConfig& actuator = config_.actuators[i];
  const auto rank = config_.RankOf(machine.state);
  if (known.presence == Presence::kPresent || known.held || !rank) return;
  if (known.presence == Presence::kAbsent && machine.emergency.stop) return;  // of a later stage
  if (!actuator.on_lost.empty()) {
    if (*rank <= *config_.RankOf(actuator.on_lost)) return;
    // An operator may continue without an actuator that is not critical. Beyond a cut link another
    // controller may have it longer.
    const Seen& seen = seen_[SerialOf(machine)];
    const bool goes_on = seen.lost_at.Has(i) && seen.requested_state_at >= seen.lost_at[i];
    if (!actuator.critical && goes_on) return;
    return ReportViolation(
        actuator.critical ? Invariant::kSafeWithoutCritical : Invariant::kOnLostCoversLoss,
        "the machine stays in " + machine.state + " without " + actuator.name +
            ", whose on_lost is " + actuator.on_lost);
  }
  if (!provided || actuator.command.empty()) return;  // others are not started by the controller
  ReportViolation(Invariant::kOnLostCoversLoss,
                  "the machine stays in " + machine.state + " without " + actuator.name + ", " +
                      (known.restart.given_up
                           ? (known.restart.count < actuator.restart.limit
                                  ? "which is not restarted after its exit code"
                                  : "which was given up after " +
                                        std::to_string(known.restart.count) + " restarts")
                           : (robot_.IsAlive(actuator.name) ? "which hangs, and is not killed"
                                                            : "which is not restarted")) +
                      "; it has no on_lost (\"Active\" if the machine may run without it)");
}

}  // namespace musher::simulation
