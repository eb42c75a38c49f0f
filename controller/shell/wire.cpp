#include "musher/controller/shell/wire.hpp"

#include "musher/lifecycle/policy/policy.hpp"
#include "musher/wire/lifecycle_wire.hpp"

#include <chrono>

namespace musher {
namespace {

msg::PolicyInfo PolicyOf(const MachineConfig& config, const PolicyState& policy) {
  msg::PolicyInfo info;
  if (!config.policy) return info;
  info.active = true;
  info.battery = policy.battery.value_or(-1);
  info.charging = policy.charging;
  info.battery_silent = policy.battery_silent;
  if (config.policy && config.policy->battery && policy.level != BatteryLevel::kFree) {
    info.ceiling = CeilingState(config, policy.level);
    info.ceiling_reason = AboveCeiling(config, policy, policy.level).message;
  }
  if (policy.keep) {
    info.kept = policy.keep->state;
    info.keep_s = policy.keep->seconds;
  }
  info.low_power_switch = policy.low_power;
  if (policy.power) info.power = policy.power->reboot ? "reboot" : "power-off";
  return info;
}

}  // namespace

msg::SetState::Response ToMessage(const SwitchResult& result) {
  msg::SetState::Response response;
  response.switch_number = result.number.value();
  response.target = result.target;
  response.actuator = result.actuator;
  response.outcome = OutcomeName(result.outcome);
  response.code = result.code;
  response.reason = result.reason;
  response.state = result.state;
  response.degraded = result.degraded;
  for (const ActuatorResult& actuator : result.actuators) {
    const double duration_ms = std::chrono::duration<double, std::milli>(actuator.duration).count();
    response.actuators.push_back({actuator.name, std::string(OutcomeName(actuator.outcome)),
                                  actuator.code, actuator.message, duration_ms, actuator.state});
  }
  return response;
}

msg::GetPlan::Response ToMessage(const MachineConfig& config, const Plan& plan) {
  msg::GetPlan::Response response;
  response.target = plan.target;
  if (plan.only) response.actuator = config.actuators[*plan.only].name;
  response.allowed = !plan.refusal || plan.free_by;
  if (plan.refusal) response.reason = plan.refusal->message;
  if (!response.allowed) response.code = plan.refusal->code;
  response.direction = DirectionName(plan.direction);
  response.state = plan.from;
  for (const PlanStep& step : plan.steps) {
    const bool there =
        step.part == PlanStep::Part::kInTarget || step.part == PlanStep::Part::kHeldInTarget;
    response.steps.push_back({config.actuators[step.actuator].name, step.wave, step.from,
                              step.target, step.driven() ? ToMilliseconds(step.deadline) : 0,
                              there ? "is already in the target state" : step.note});
  }
  return response;
}

msg::MachineStatus ToMessage(const MachineConfig& config, const Machine& machine) {
  msg::MachineStatus status;
  status.machine = config.name;
  status.name_space = config.name_space;
  status.phase = PhaseName(machine.phase);
  status.state = machine.state;
  status.epoch = machine.epoch.value();
  if (machine.current && !machine.current->only) status.target = machine.current->target;
  status.switch_number = machine.last_switch.value();
  status.requested_by = machine.requested_by;
  status.permit_ns = config.permit.value_or(Duration()).count();
  status.config_file = config.file;
  status.config_hash = config.hash;
  status.emergency_stop = machine.emergency.stop.has_value();
  if (machine.emergency.stop) {
    status.emergency_stop_by = machine.emergency.stop->by;
    status.emergency_stop_reason = machine.emergency.stop->reason;
  }
  for (const EmergencyStop& stop : StopsOf(machine).engaged) {
    status.stop_ids.push_back(transport::StopIdText(stop.id));
  }
  status.degraded = Degraded(config, machine);
  for (const ActuatorIndex i : config.actuators.Indices()) {
    const KnownActuator& known = machine.actuators[i];
    msg::ActuatorInfo info;
    info.name = config.actuators[i].name;
    // A process that ends before it is set up leaves on what its predecessor had switched on.
    const bool is_away = known.presence == Presence::kLost || known.presence == Presence::kAbsent;
    const bool is_lost = is_away && !known.lost_in.empty();
    info.state = is_lost ? known.lost_in : known.state();
    info.target = known.command ? known.command->target : known.report.target;
    info.presence = PresenceName(is_lost ? Presence::kLost : known.presence);
    // A lost actuator has a pid, too, unless its process is known to have ended.
    const bool may_run =
        known.presence != Presence::kAbsent && known.process.dead != known.report.incarnation;
    info.pid = known.process.pid != 0 ? known.process.pid : may_run ? known.report.pid : 0;
    // If the actuator was out of reach before this controller began: the host on the disk.
    info.host = known.report.host.empty() ? known.elsewhere.value_or("") : known.report.host;
    if (!known.process.host.empty()) info.host = known.process.host;  // the host of the pid
    info.stage = config.actuators[i].stage;
    info.critical = config.actuators[i].critical;
    info.held = known.held;
    if (const auto trouble = TroubleOf(known)) {
      info.degraded = true;
      info.code = trouble->code;
      info.message = trouble->message;
    }
    if (known.presence == Presence::kPresent && known.report.held_by_stop) {
      status.held_by_stop.push_back(info.name);
    }
    info.protocol = ProtocolName(config.actuators[i].protocol);
    info.health = HealthName(known.health);
    info.restarts = known.restart.count;
    info.restarting = known.restart.at || known.restart.requested ||
                      (known.restart.count > 0 && known.presence == Presence::kStarting);
    status.actuators.push_back(std::move(info));
  }
  status.policy = PolicyOf(config, machine.policy);
  return status;
}

msg::HistoryEntry ToMessage(const JournalEntry& entry) {
  return {entry.id.value(),    entry.wall_ns,  entry.epoch.value(), entry.switch_number.value(),
          entry.kind,          entry.actuator, entry.code,          entry.message,
          entry.cause.value(), entry.state,    entry.data};
}

msg::GetHistory::Response ToMessage(const std::vector<JournalEntry>& entries) {
  msg::GetHistory::Response history;
  for (const JournalEntry& entry : entries) {
    history.entries.push_back(ToMessage(entry));
    history.events.push_back(entry.event);
    history.steady_ns.push_back(entry.steady_ns);
  }
  return history;
}

}  // namespace musher
