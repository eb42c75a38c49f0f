#include "musher/simulation/rest_checker.hpp"

#include "musher/lifecycle/config/flow.hpp"
#include "musher/lifecycle/policy/policy.hpp"

namespace musher::simulation {

// What an actuator will do by itself; empty: nothing.
std::string RestChecker::PendingActivity(const Machine& machine, ActuatorIndex i) const {
  const KnownActuator& r = machine.actuators[i];
  const bool alive = robot_.IsAlive(config_.actuators[i].name);
  if (r.set_up_by && r.presence != Presence::kPresent && alive) return "is being set up";
  const bool unit = !config_.actuators[i].host.empty();
  if (unit && r.process.launch == Launch::kUnderWay) return "is being started on another host";
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

std::string RestChecker::PendingActivity() const {
  const SimulatedController* controller = robot_.leader();
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
  const bool unknown = !policy.battery && policy.level != BatteryLevel::kFree;
  if (unknown && !policy.battery_silent) return "the battery may be silent";
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

// What an actuator that publishes a false state is in, is not known.
void RestChecker::CheckStableRules(const Machine& machine,
                                   const std::vector<StableRule>& stable_rules) {
  if (machine.phase == Phase::kStopped || !context_.false_reporters.empty()) return;
  const auto state_of = [&](std::optional<ActuatorIndex> actuator) {
    if (!actuator) return machine.state;
    const ActuatorReport* report = robot_.ReportOf(*actuator, machine.actuators[*actuator].report);
    return report == nullptr ? State() : report->state;
  };
  for (const StableRule& rule : stable_rules) {
    if (rule.IsViolated(state_of)) ReportViolation(Invariant::kStableRules, rule.text);
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
