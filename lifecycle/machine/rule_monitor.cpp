#include "musher/lifecycle/machine/rule_monitor.hpp"

#include <algorithm>
#include <utility>

#include "musher/lifecycle/machine/under_way.hpp"

namespace musher {
namespace {

using Subject = std::optional<ActuatorIndex>;  // none: the machine

// "": it has exited, or was not started. None: not known.
std::optional<State> StateOf(const Machine& machine, Subject subject) {
  if (!subject) return machine.state;
  const KnownActuator& known = machine.actuators[*subject];
  const ActuatorProcess& process = known.process;
  switch (known.presence) {
    case Presence::kPresent:
      return known.report.state;
    case Presence::kStarting:
      return std::nullopt;
    case Presence::kAbsent: {
      const bool none = process.launch == Launch::kNone || process.launch == Launch::kBlocked;
      return none && process.pid == 0 ? std::optional(State()) : std::nullopt;
    }
    case Presence::kLost:
      break;
  }
  const bool has_exited = known.report.incarnation == 0 || known.report.incarnation == process.dead;
  return has_exited && process.pid == 0 ? std::optional(State()) : std::nullopt;
}

bool IsStable(const MachineConfig& config, const Machine& machine, Time now) {
  if (machine.phase == Phase::kStopped) return false;
  const bool busy = std::ranges::any_of(machine.actuators, [](const KnownActuator& known) {
    return known.presence == Presence::kPresent && known.report.busy();
  });
  return !busy && UnderWay(config, machine, [&](ActuatorIndex i) {
                    return !IsOverdue(machine.actuators[i], now);
                  }).empty();
}

// None: the state of an actuator that it names is not known.
std::optional<bool> IsViolated(const StableRule& rule, const Machine& machine) {
  bool known = true;
  const bool violated = rule.IsViolated([&](Subject subject) {
    const auto state = StateOf(machine, subject);
    known = known && state.has_value();
    return state.value_or(State());
  });
  return known ? std::optional(violated) : std::nullopt;
}

}  // namespace

RuleMonitor::RuleMonitor(const MachineConfig& config, UserRules rules) : config_(config) {
  for (StableRule& rule : rules.stable) stable_.push_back({std::move(rule)});
  for (TimedRule& rule : rules.timed) timed_.push_back({std::move(rule)});
}

std::vector<RuleMonitor::Violation> RuleMonitor::Check(const Machine& machine, Time now) {
  std::vector<Violation> found;
  CheckStable(machine, now, found);
  CheckTimed(machine, now, found);
  return found;
}

void RuleMonitor::CheckStable(const Machine& machine, Time now, std::vector<Violation>& found) {
  const bool stable = !stable_.empty() && IsStable(config_, machine, now);
  for (Stable& checked : stable_) {
    const auto violated = stable ? IsViolated(checked.rule, machine) : std::nullopt;
    if (violated != std::optional(true)) checked.since.reset();
    const bool over = violated == std::optional(false) || machine.phase == Phase::kStopped;
    if (over) checked.violated = false;
    if (violated != std::optional(true) || checked.violated) continue;
    checked.since = checked.since.value_or(now);
    if (now - *checked.since < kViolatedFor) continue;
    checked.violated = true;
    checked.since.reset();
    found.push_back({checked.rule.text, StatesOf(checked.rule, machine)});
  }
}

void RuleMonitor::CheckTimed(const Machine& machine, Time now, std::vector<Violation>& found) {
  const auto goal = GoalOf(config_, machine);
  for (Timed& checked : timed_) {
    const TimedRule& rule = checked.rule;
    const auto state = StateOf(machine, rule.subject);
    if (!checked.check.Update(rule, goal, state, now)) continue;
    const bool comes_late = !checked.check.is_violated();
    found.push_back({rule.text, PlaceOf(rule.subject, machine) + (comes_late ? " only now" : "")});
  }
}

std::optional<Time> RuleMonitor::next_check() const {
  std::optional<Time> next;
  const auto take = [&](Time due) { next = next ? std::min(*next, due) : due; };
  for (const Stable& checked : stable_) {
    if (checked.since) take(*checked.since + kViolatedFor);
  }
  for (const Timed& checked : timed_) {
    if (const auto due = checked.check.due()) take(*due);
  }
  return next;
}

std::vector<std::string> RuleMonitor::violated() const {
  std::vector<std::string> rules;
  for (const Stable& checked : stable_) {
    if (checked.violated) rules.push_back(checked.rule.text);
  }
  for (const Timed& checked : timed_) {
    if (checked.check.is_violated()) rules.push_back(checked.rule.text);
  }
  return rules;
}

std::string RuleMonitor::PlaceOf(Subject subject, const Machine& machine) const {
  const State state = StateOf(machine, subject).value_or(State());
  const std::string name = subject ? config_.actuators[*subject].name : "the machine";
  return name + (state.empty() ? " is exited" : " is in " + state);
}

std::string RuleMonitor::StatesOf(const StableRule& rule, const Machine& machine) const {
  std::string states = PlaceOf(rule.never.actuator, machine);
  const bool same = rule.condition && rule.condition->actuator == rule.never.actuator;
  if (rule.condition && !same) states += ", " + PlaceOf(rule.condition->actuator, machine);
  return states;
}

}  // namespace musher
