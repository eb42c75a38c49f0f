#include "musher/simulation/hold_checker.hpp"

#include <algorithm>
#include <utility>

#include "musher/lifecycle/config/flow.hpp"

namespace musher::simulation {

// The disk of a host stores the holds of its controllers, but for a boot, and a person's start
// begins the machine from the start.
void HoldChecker::OnBegin(const SimulatedController& controller, Starter starter) {
  std::erase_if(holds_, [&](const auto& one) {
    const bool stored = starter == Starter::kSupervisor && one.second.host == controller.host();
    return !stored || context_.state_lost;
  });
  for (auto& [name, hold] : holds_) hold.controller = controller.serial();
}

bool HoldChecker::Ends(const Switch& s, ActuatorIndex i, const State& in) const {
  if (s.only) return *s.only == i;
  if (s.target == kTearDown) return true;
  if (s.purpose != Purpose::kRequested) return false;
  return s.direction != Direction::kDown || !Falls(config_, s.target, in);
}

void HoldChecker::NoteSwitch(const SimulatedController& controller) {
  const Machine& machine = controller.shell().machine();
  // A client's switch that had nothing to do was never under way.
  const bool leads = machine.phase == Phase::kRunning;  // before that it takes up what it finds
  const CommandNumber seen = std::exchange(numbers_[controller.serial()], machine.number);
  if (leads && !machine.current && seen != 0 && seen < machine.number) holds_.clear();
  if (!machine.current) return;
  const Switch& s = *machine.current;
  if (!s.only && s.direction == Direction::kDown) down_[controller.serial()] = s.number;
  std::erase_if(
      holds_, [&](const auto& one) { return Ends(s, *config_.IndexOf(one.first), one.second.in); });
}

void HoldChecker::OnReply(const SimulatedController& controller, const SwitchResult& result) {
  const bool done =
      result.outcome == SwitchOutcome::kDone || result.outcome == SwitchOutcome::kDoneDegraded;
  if (!done) return;
  if (result.actuator.empty()) {
    // A switch that ended at once was not seen under way.
    if (down_[controller.serial()] != result.number) holds_.clear();
    return;
  }
  holds_.erase(result.actuator);
  const State& place = controller.shell().machine().state;
  const bool held = config_.RankOf(result.target) && result.target != kTearDown &&
                    result.target != place && !Rises(config_, place, result.target);
  if (held) holds_[result.actuator] = {result.target, controller.serial(), controller.host()};
}

void HoldChecker::OnSend(const Machine& machine, const action::SendSwitch& send) {
  CommandNumber& seen = numbers_[SerialOf(machine)];
  seen = std::max(seen, send.command.number);
  const std::string& name = config_.actuators[send.actuator].name;
  const auto found = holds_.find(name);
  if (found == holds_.end()) return;
  const Hold hold = found->second;
  const auto& s = machine.current;
  if (s && Ends(*s, send.actuator, hold.in)) {
    holds_.erase(found);
    return;
  }
  const State& target = send.command.target;
  const bool leaves = target != hold.in && config_.RankOf(target) &&
                      !Falls(config_, hold.in, target) && MaySwitchOn(config_, hold.in, target);
  if (!leaves || SerialOf(machine) != hold.controller) return;
  if (processes_.IsDuplicated(name) || context_.false_reporters.contains(name)) return;
  holds_.erase(found);
  ReportViolation(Invariant::kHoldStays,
                  name + " is led to " + target + ", and a person holds it in " + hold.in);
}

}  // namespace musher::simulation
