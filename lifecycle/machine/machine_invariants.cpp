#include "musher/lifecycle/machine/machine_invariants.hpp"
#include "musher/base/words.hpp"

#include <algorithm>

namespace musher {
namespace {

const char* BrokenOf(const Machine& machine, const KnownActuator& known) {
  const bool present = known.presence == Presence::kPresent;
  const bool announced = present || known.presence == Presence::kStarting;
  if (known.command && !present) return "an actuator that is not present has a command";
  if (known.command && known.command->number > machine.number) {
    return "a command has a number that was not given yet";
  }
  if (known.due && !present) return "an actuator that is not present is to be driven";
  if (known.free_by && !present) return "an actuator that is not present is awaited to be free";
  if (known.control.again && !announced) {
    return "control is taken of an actuator that has not been seen";
  }
  if (known.restart.reset_at && !present)
    return "the restart count of an actuator that is not present is about to be reset";
  if (known.process.termination && known.process.termination->pid == 0) {
    return "the termination of a process has no pid";
  }
  if (known.restart.at && present) return "an actuator that is present is to be started again";
  return nullptr;
}

// Whether each leg that is under way has its command, and each command of the switch its leg.
bool LegsHaveCommands(const Machine& machine, const Switch& s) {
  const CommandNumber number = s.driven_number();
  const std::vector<Leg>& legs = s.driven_legs();
  return std::all_of(legs.begin(), legs.end(), [&](const Leg& leg) {
    if (!machine.actuators.Has(leg.actuator)) return false;
    const auto& command = machine.actuators[leg.actuator].command;
    const bool of_switch = command && command->number == number;
    return of_switch == (leg.progress == Leg::Progress::kUnderWay);
  });
}

const char* BrokenOf(const Machine& machine, const Switch& s) {
  if (machine.waiting) return "a switch waits while another one is under way";
  if (machine.phase == Phase::kIdle || machine.phase == Phase::kStopped ||
      machine.phase == Phase::kFenced) {
    return "a switch is under way in a machine that is idle, stopped or fenced";
  }
  if (s.number > machine.last_switch || machine.last_switch > machine.number) {
    return "a switch has a number that was not given yet";
  }
  if ((s.purpose == Purpose::kStop) != (machine.phase == Phase::kStopping)) {
    return "a switch other than TearDown is under way in a machine that stops, or the reverse";
  }
  if (s.rollback.under_way && s.rollback.number <= s.number)
    return "a rollback has no number of its own";
  if (!LegsHaveCommands(machine, s)) return "a leg under way has no command, or the reverse";
  return nullptr;
}

const char* BrokenOf(const Machine& machine) {
  const bool stops = machine.phase == Phase::kStopping || machine.phase == Phase::kStopped;
  if (stops != machine.stopping.has_value() && machine.phase != Phase::kFenced) {
    return "a machine that stops has no deadlines, or the reverse";
  }
  if (machine.fallback.target && machine.phase != Phase::kRunning &&
      machine.phase != Phase::kFenced) {
    return "a machine that does not run is to fall back";
  }
  if (!machine.emergency.stop && !machine.emergency.others.empty()) {
    return "there are further emergency stops without a first one";
  }
  const auto& released = machine.emergency.released;
  const bool again =
      machine.emergency.stop &&
      std::find(released.begin(), released.end(), machine.emergency.stop->id) != released.end();
  if (again) return "a released emergency stop is engaged";
  if (machine.start_up.set_up && !machine.start_up.requests.empty())
    return "a request that awaits the set-up is not answered after it";
  if (!machine.recorded_state.empty() && machine.recorded_state != machine.state) {
    return "the state of the machine is not recorded";
  }
  if (machine.current) return BrokenOf(machine, *machine.current);
  return nullptr;
}

}  // namespace

std::string BrokenInvariant(const MachineConfig& config, const Machine& machine) {
  if (machine.actuators.size() != config.actuators.size()) {
    return "the machine has " + Counted(machine.actuators.size(), "actuator") + ", the config " +
           std::to_string(config.actuators.size());
  }
  if (const char* broken = BrokenOf(machine)) {
    return std::string(broken) + "; " + std::string(PhaseName(machine.phase)) + " in " +
           machine.state;
  }
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    const KnownActuator& known = machine.actuators[i];
    if (const char* broken = BrokenOf(machine, known)) {
      return config.actuators[i].name + ": " + broken + "; " +
             std::string(PresenceName(known.presence)) + " in " + known.state();
    }
  }
  return {};
}

}  // namespace musher
