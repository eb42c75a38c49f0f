#include "musher/lifecycle/machine/under_way.hpp"

namespace musher {
namespace {

// What an actuator will do by itself; empty: nothing.
std::string UnderWayOf(const ActuatorConfig& config, const Machine& machine,
                       const KnownActuator& known, bool may_come) {
  if (known.set_up_by && known.presence != Presence::kPresent && may_come) return "is being set up";
  const bool unit = !config.host.empty();
  if (unit && known.process.launch == Launch::kUnderWay) return "is being started on another host";
  if (known.exit_by) return "may have exited";
  if (known.fault && !known.command && !known.restart.at && !known.process.termination &&
      !known.restart.requested)
    return {};
  if (known.command) return "has a command to " + known.command->target;
  if (known.restart.at || known.restart.requested) return "is to be restarted";
  if (known.process.termination) return "is to be killed";
  if (known.free_by) return "is busy with the callback that it was found in";
  const bool is_starting = known.presence == Presence::kStarting;
  if (known.control.again && is_starting && may_come) return "is being attached";
  const bool waits = machine.emergency.stop || known.held || machine.phase != Phase::kRunning ||
                     known.presence != Presence::kPresent;
  return known.due && !waits ? "is to be switched to the machine's state" : "";
}

}  // namespace

std::string UnderWay(const MachineConfig& config, const Machine& machine,
                     const std::function<bool(ActuatorIndex)>& may_come) {
  if (machine.phase == Phase::kStopped) return {};
  if (machine.current) return "a switch to " + machine.current->target + " is under way";
  if (machine.waiting) return "a switch to " + machine.waiting->target + " waits";
  if (machine.emergency.release) return "the release of an emergency stop is being confirmed";
  if (machine.fallback.target) return "it is about to fall back to " + *machine.fallback.target;
  if (machine.phase != Phase::kRunning && machine.phase != Phase::kFailed) {
    return "the machine is " + std::string(PhaseName(machine.phase));
  }
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    const std::string of_it =
        UnderWayOf(config.actuators[i], machine, machine.actuators[i], may_come(i));
    if (!of_it.empty()) return config.actuators[i].name + " " + of_it;
  }
  return {};
}

}  // namespace musher
