#include "musher/search/rules.hpp"

#include <algorithm>

#include "musher/lifecycle/config/flow.hpp"
#include "musher/lifecycle/machine/machine_invariants.hpp"

namespace musher::search {
namespace {

bool IsRequested(const World& world, const State& target) {
  return std::any_of(world.requests.begin(), world.requests.end(),
                     [&](const Request& request) { return request.target == target; });
}

// A controller that finds no actuator past the self-check, also one that takes over, starts the
// machine.
bool IsStarting(const World& world) {
  const auto& current = world.machine.current;
  const bool checked =
      world.from == kSelfCheck || world.from == kSetUp || IsRequested(world, State(kSelfCheck));
  return checked && current && current->purpose == Purpose::kStartUpActivate;
}

// The rank that the battery permits at most; none: any.
std::optional<Rank> MostByBattery(const Model& model, const World& world) {
  if (!world.battery) return std::nullopt;
  const bool low = *world.battery <= model.config.policy->battery->low_power_at;
  return BuiltInRank(low ? kLowPower : kProtected);
}

// A start in which the battery falls leads as far up as the battery permits.
bool IsRestOfStart(const Model& model, const World& world, const State& target) {
  const auto most = MostByBattery(model, world);
  const auto rank = model.config.RankOf(target);
  return world.in_start && most && rank && *rank <= *most;
}

// Whether the result lists the actuator as degraded, lost or skipped.
bool Listed(const SwitchResult& result, const std::string& name) {
  const auto& degraded = result.degraded;
  if (std::find(degraded.begin(), degraded.end(), name) != degraded.end()) return true;
  return std::any_of(
      result.actuators.begin(), result.actuators.end(), [&](const ActuatorResult& actuator) {
        return actuator.name == name && (actuator.outcome == ActuatorOutcome::kLost ||
                                         actuator.outcome == ActuatorOutcome::kSkipped);
      });
}

// Whether the controller cannot know yet that it has ended.
bool EndIsUnknown(const SimActuator& actuator) {
  return !actuator.alive && actuator.end.has_value();
}

// Whether the machine has to go on without it: its process has exited, or it was in use and is out
// of reach. One that has never run was not lost.
bool IsLost(const Model& model, const World& world, ActuatorIndex i) {
  const SimActuator& actuator = world.actuators[i];
  if (!actuator.alive) return actuator.processes > 0 || model.host_of[i] == kHere;
  return IsOutOfReach(model, world, i) &&
         world.machine.actuators[i].presence != Presence::kPresent &&
         model.config.RankOf(actuator.core.report.state).has_value();
}

bool IsOfLaterStage(const MachineConfig& config, ActuatorIndex i) {
  return std::ranges::any_of(config.actuators, [&](const ActuatorConfig& other) {
    return other.stage < config.actuators[i].stage;
  });
}

void CheckDone(const Model& model, const World& world, const SwitchResult& result, Notes& notes) {
  if (result.target != kSelfCheck && world.machine.state != result.target) {
    notes.violations.push_back("done is reported while the machine is in " + world.machine.state);
  }
  for (const ActuatorIndex i : world.actuators.Indices()) {
    const SimActuator& actuator = world.actuators[i];
    const ActuatorReport& report = actuator.core.report;
    const std::string& name = model.config.actuators[i].name;
    // After "done" an actuator that is degraded for another reason is in the state, too.
    if ((Listed(result, name) && !result.done()) || EndIsUnknown(actuator)) continue;
    // A switch goes on without an actuator that does not list the state.
    if (!model.config.actuators[i].Lists(result.target)) continue;
    // TearDown need not wait for an actuator that is not attached to the controller.
    const bool follows = world.machine.actuators[i].presence == Presence::kPresent;
    const bool runs_on = IsOutOfReach(model, world, i) && actuator.alive &&
                         report.state != kTearDown && !Listed(result, name);
    if (result.target == kTearDown && runs_on) {
      notes.violations.push_back("TearDown is reported as done while " + name +
                                 " runs on a host out of reach");
    }
    // One of a later stage that comes up meanwhile joins the machine after the switch.
    const bool joins = IsOfLaterStage(model.config, i) && !model.config.RankOf(report.state);
    if (world.in_start && joins) continue;
    if (result.target == kTearDown && !follows) continue;
    // Error leads those that are set up; one that is being restarted is checked and then follows.
    const bool restarted = !world.machine.actuators[i].checked && report.state == kSetUp;
    if (result.target == kError && restarted) continue;
    const bool there =
        result.target == kSelfCheck
            ? actuator.alive && report.outcome_number == result.number && report.outcome_code == 0
            : (actuator.alive || result.target == kTearDown) && report.state == result.target;
    if (!there)
      notes.violations.push_back("done is reported while " + name + " is in " + report.state);
  }
}

// The most active state in which an actuator stays while the machine has no state with a rank.
State MostInStart(const Model& model, ActuatorIndex i) {
  const ActuatorConfig& actuator = model.config.actuators[i];
  const bool stays_lower = !actuator.Lists(kDeActive) && actuator.Lists(kLowPower);
  return State(stays_lower ? kLowPower : kDeActive);
}

// All actuators are back. Where the machine has no state with a rank, none is above DeActive.
void CheckUndone(const Model& model, const World& world, const SwitchResult& result, Notes& notes) {
  const bool at_rest = model.config.RankOf(world.machine.state).has_value();
  if (result.state != world.machine.state || result.state == result.target) {
    notes.violations.push_back("undone is reported with the machine in " + result.state);
  }
  for (const ActuatorIndex i : world.actuators.Indices()) {
    const SimActuator& actuator = world.actuators[i];
    const std::string& name = model.config.actuators[i].name;
    if (Listed(result, name) || !actuator.alive) continue;
    const State& state = actuator.core.report.state;
    if (at_rest && !model.config.actuators[i].Lists(world.machine.state)) continue;
    // It was restarted after its part: it is checked before it joins, as after "done".
    const KnownActuator& known = world.machine.actuators[i];
    if (at_rest && known.presence == Presence::kPresent && !known.checked) continue;
    const bool back = at_rest ? state == world.machine.state
                              : !IsHigher(model.config, state, MostInStart(model, i));
    if (!back) notes.violations.push_back("undone is reported while " + name + " is in " + state);
    if (at_rest && actuator.work != Work::kNone && actuator.core.report.target == result.target) {
      notes.violations.push_back("undone is reported while " + name + " is switching");
    }
  }
}

// The machine has fallen back to the on_lost of an actuator. What does not list that state cannot
// follow, and must not stay more active.
void CheckFallback(const Model& model, const World& world, ActuatorIndex i, Notes& notes) {
  const MachineConfig& config = model.config;
  const State& place = world.machine.state;
  const State& state = world.actuators[i].core.report.state;
  const ActuatorConfig& own = config.actuators[i];
  if (!world.actuators[i].alive || own.Lists(place) || !IsHigher(config, state, place)) return;
  if (IsRequested(world, place) || place == world.from) return;
  for (const ActuatorIndex k : world.actuators.Indices()) {
    if (!IsLost(model, world, k) || config.actuators[k].on_lost != place) continue;
    notes.violations.push_back(own.name + " stays in " + state + " while the machine is in " +
                               place + ", the on_lost of " + config.actuators[k].name +
                               ", which is lost: " + place + " is not among the states of " +
                               own.name);
  }
}

// A start in which nothing fails leads the machine to Active, and every actuator with it.
void CheckStarted(const Model& model, const World& world, Notes& notes) {
  const Machine& machine = world.machine;
  if (!world.in_start || world.faults_left < world.faults) return;
  if (machine.phase != Phase::kRunning) {
    notes.violations.push_back("nothing has failed, and the machine does not start; it is in " +
                               machine.state);
  } else if (model.config.HasState(kActive) && machine.state != kActive) {
    notes.violations.push_back("nothing has failed, and the start has left the machine in " +
                               machine.state);
  }
  for (const ActuatorIndex i : world.actuators.Indices()) {
    const KnownActuator& known = machine.actuators[i];
    const ActuatorConfig& own = model.config.actuators[i];
    const bool there = known.presence == Presence::kPresent && !known.suspended &&
                       (!own.Lists(machine.state) || !model.config.RankOf(machine.state) ||
                        known.state() == machine.state);
    if (there) continue;
    notes.violations.push_back("nothing has failed, and " + own.name +
                               " is not up after the start" +
                               (known.fault ? ": " + known.fault->message : ""));
  }
}

void CheckPlace(const Model& model, const World& world, ActuatorIndex i, Notes& notes) {
  const MachineConfig& config = model.config;
  const Machine& machine = world.machine;
  const SimActuator& actuator = world.actuators[i];
  const KnownActuator& known = machine.actuators[i];
  const ActuatorConfig& own = config.actuators[i];
  const State& state = actuator.core.report.state;
  if (known.command) notes.violations.push_back("a command to " + own.name + " has no end");
  const auto place = config.RankOf(machine.state);
  const auto rank = config.RankOf(state);
  // For the release of the stop, which drives no actuator to another state on the same level.
  const bool waits = machine.emergency.stop && (!rank || (place && *rank < *place));
  const bool later_stage =
      own.stage > machine.start_up.stage && known.presence == Presence::kAbsent;
  if (later_stage) return;
  const bool there = actuator.alive && known.presence == Presence::kPresent &&
                     (state == machine.state || !place || waits);
  if (!there && !known.held && !known.fault) {
    notes.violations.push_back("in a stable state " + own.name +
                               (actuator.alive ? " is in " : " has exited in ") + state +
                               ", the machine in " + machine.state + ", without a recorded reason");
  }
  const bool held = known.fault && known.fault->code == kCodeProtectedError;
  if (world.repeat == Repeat::kDone && held && known.presence == Presence::kPresent) {
    notes.violations.push_back("in a stable state " + own.name + " is held by a released stop, " +
                               "although the switch has been requested again");
  }
  if (actuator.alive && actuator.hung && !known.fault) {
    notes.violations.push_back("in a stable state " + own.name +
                               " hangs, without a recorded reason");
  }
  if (IsOutOfReach(model, world, i) && actuator.alive && known.presence == Presence::kPresent) {
    notes.violations.push_back("in a stable state " + own.name +
                               " is out of reach, but the controller has it as present");
  }
  const bool knows = known.state() == state && known.report.busy() == actuator.core.report.busy();
  if (actuator.alive && !known.fault && !knows) {
    notes.violations.push_back("in a stable state " + own.name + " is in " + state +
                               ", but the controller has it in " + known.state());
  }
  const bool lost = IsLost(model, world, i);
  if (!own.on_lost.empty() && lost && place && *place > *config.RankOf(own.on_lost)) {
    // A person may continue without an actuator that is not critical.
    const bool continued =
        !own.critical && world.requests.size() > 1 && IsRequested(world, machine.state);
    if (continued) return;
    notes.violations.push_back(own.name + " is lost, and the machine is in " + machine.state);
  }
  const bool gone = lost && known.presence != Presence::kPresent && place;
  const bool of_later_stage = known.presence == Presence::kAbsent && machine.emergency.stop;
  // What was torn down and has not come back was not lost.
  const bool torn_down = IsRequested(world, State(kTearDown));
  if (gone && own.on_lost.empty() && !own.command.empty() && !of_later_stage && !torn_down) {
    notes.violations.push_back(own.name + " is lost, and the machine stays in " + machine.state +
                               "; " + own.name +
                               " has no on_lost (\"Active\" if the machine may run without it)");
  }
}

// Before the machine is usable, and after its start has failed, no actuator stays more active than
// a rollback leaves it. It is degraded where its last callback has failed, or its status was lost.
void CheckPlaceInStart(const Model& model, const World& world, ActuatorIndex i, Notes& notes) {
  const Machine& machine = world.machine;
  const KnownActuator& known = machine.actuators[i];
  const SimActuator& actuator = world.actuators[i];
  const ActuatorReport& report = actuator.core.report;
  const bool in_start = machine.start_up.set_up && !model.config.RankOf(machine.state);
  const bool reachable = actuator.alive && known.presence == Presence::kPresent;
  if (!in_start || !reachable || actuator.work != Work::kNone || known.held) return;
  if (!IsHigher(model.config, report.state, MostInStart(model, i))) return;
  const ActuatorConfig& own = model.config.actuators[i];
  if (known.fault && !own.Lists(kDeActive) && !own.Lists(kLowPower)) return;
  const bool is_seen = known.state() == report.state && !known.report.busy();
  if (known.fault && (report.outcome_code != kCodeOk || !is_seen)) return;
  notes.violations.push_back("in a stable state " + model.config.actuators[i].name + " is in " +
                             report.state + ", the machine in " + machine.state);
}

// If two actuators have an order, the first gets no command while or after the second switches.
void CheckOrder(const Model& model, const World& world, const action::SendSwitch& send,
                Notes& notes) {
  const auto& current = world.machine.current;
  if (!current) return;
  const bool reversed = current->rollback.under_way || current->direction == Direction::kDown;
  const auto comes_after = [&](ActuatorIndex one, ActuatorIndex other) {
    const auto& after = model.config.actuators[one].after;
    return std::find(after.begin(), after.end(), model.config.actuators[other].name) != after.end();
  };
  for (const ActuatorIndex k : world.actuators.Indices()) {
    const ActuatorIndex first = reversed ? k : send.actuator;
    const ActuatorIndex second = reversed ? send.actuator : k;
    const bool later = comes_after(second, first);
    if (!later && !comes_after(first, second)) continue;
    const SimActuator& other = world.actuators[k];
    const ActuatorReport& report = other.core.report;
    const bool sent = std::any_of(world.outbox.begin(), world.outbox.end(), [&](const Message& m) {
      const auto* command = std::get_if<SwitchCommand>(&m.what);
      return m.to == k && command != nullptr && command->number == send.command.number;
    });
    const bool takes_part = std::any_of(current->legs.begin(), current->legs.end(),
                                        [k](const Leg& leg) { return leg.actuator == k; });
    if (!other.alive || !takes_part) continue;
    const bool runs = other.work == Work::kRunning && report.busy_number == send.command.number;
    if (sent || runs || (later && report.outcome_number == send.command.number)) {
      notes.violations.push_back(model.config.actuators[send.actuator].name + " is commanded to " +
                                 send.command.target + " out of order with " +
                                 model.config.actuators[k].name);
    }
  }
}

// Whether the actuator is lost after its command of this switch had ended done. The report of an
// exited process stays as it was, until it is restarted.
bool LostAfterItsPart(const Model& model, const World& world, const SwitchResult& result,
                      const ActuatorResult& part) {
  const auto i = model.config.IndexOf(part.name);
  if (part.outcome != ActuatorOutcome::kLost || !i) return false;
  const ActuatorReport& report = world.actuators[*i].core.report;
  return (report.outcome_number == result.number && report.outcome_code == kCodeOk) ||
         world.actuators[*i].done == result.number;
}

// An actuator that does not list the state of the machine before may have been there already.
bool IsIn(const Model& model, const World& world, const std::string& name, const State& state) {
  const auto i = model.config.IndexOf(name);
  return i && world.actuators[*i].alive && world.actuators[*i].core.report.state == state;
}

// A switch up takes all actuators or none; none was degraded before. An actuator may be lost after
// its part.
void CheckUp(const Model& model, const World& world, const action::AnswerSetState& answer,
             Notes& notes) {
  const SwitchResult& result = answer.result;
  if (answer.request != 1 || !IsHigher(model.config, result.target, world.from)) return;
  for (const ActuatorResult& actuator : result.actuators) {
    if (actuator.outcome == ActuatorOutcome::kDone) continue;
    if (LostAfterItsPart(model, world, result, actuator)) continue;
    if (IsIn(model, world, actuator.name, result.target)) continue;
    notes.violations.push_back("the machine switches up without " + actuator.name);
  }
}

// Whether a fault of one actuator can degrade another: it waits for it, or is bound to it.
bool DependOnEachOther(const MachineConfig& config) {
  return std::ranges::any_of(config.actuators, [&](const ActuatorConfig& a) {
    return !a.after.empty() || !a.binds_to.empty() || a.stage != config.actuators.back().stage;
  });
}

// Without an order among the actuators each fault makes at most one degraded, or all those of a
// host; an emergency stop all that it holds below or beside the state of the machine, until that is
// requested again.
void CheckDegraded(const Model& model, const World& world, Notes& notes) {
  const auto names = Degraded(model.config, world.machine);
  const auto degraded = std::ranges::count_if(names, [&](const std::string& name) {
    const ActuatorIndex i = *model.config.IndexOf(name);
    if (!model.config.actuators[i].Lists(world.machine.state)) return false;
    const ActuatorReport& report = world.actuators[i].core.report;
    const bool ended = report.held_by_stop && world.machine.state == world.from;
    return !ended || world.repeat != Repeat::kNotYet;
  });
  if (IsRequested(world, State(kTearDown))) return;  // an actuator that has exited counts as absent
  std::ptrdiff_t of_a_fault = 1;
  for (std::size_t host = 0; host < model.hosts.size(); ++host) {
    of_a_fault = std::max(of_a_fault, std::ranges::count(model.host_of, host));
  }
  const auto most = of_a_fault * (world.faults - world.faults_left);
  if (DependOnEachOther(model.config) || degraded <= most) return;
  notes.violations.push_back(std::to_string(degraded) +
                             " actuators are degraded, more than had a fault");
}

// The machine is no more active than the level of its battery permits, if it has such a state. An
// upgrade is not interrupted.
void CheckBattery(const Model& model, const World& world, Notes& notes) {
  const MachineConfig& config = model.config;
  const Machine& machine = world.machine;
  const auto rank = config.RankOf(machine.state);
  if (!world.battery || !rank || machine.state == kOta) return;
  const Rank most = *MostByBattery(model, world);
  const bool may_fall = std::ranges::any_of(config.states, [&](const State& state) {
    const bool has_other_purpose = state == kError || state == kOta || state == kTearDown;
    const auto of_state = config.RankOf(state);
    return !has_other_purpose && of_state && *of_state <= most;
  });
  const bool empty = *world.battery <= config.policy->battery->tear_down_at;
  if (!(empty && config.HasState(kTearDown)) && (!may_fall || *rank <= most)) return;
  notes.violations.push_back("the battery is at " + std::to_string(*world.battery) +
                             " %, and the machine stays in " + machine.state);
}

// The state that a rule of the user is about: the state of an actuator, empty where it has exited;
// without an actuator the state of the machine.
State SubjectState(const World& world, std::optional<ActuatorIndex> actuator) {
  if (!actuator) return world.machine.state;
  const SimActuator& one = world.actuators[*actuator];
  return one.alive ? one.core.report.state : State();
}

void CheckStableRules(const Model& model, const World& world, Notes& notes) {
  const auto state_of = [&](std::optional<ActuatorIndex> actuator) {
    return SubjectState(world, actuator);
  };
  for (std::size_t i = 0; i < model.stable_rules.size(); ++i) {
    const StableRule& rule = model.stable_rules[i];
    const bool violated = notes.rule_coverage == nullptr
                              ? rule.IsViolated(state_of)
                              : rule.IsViolated(state_of, (*notes.rule_coverage)[i]);
    if (violated) notes.violations.push_back("your rule: " + rule.text);
  }
}

// Their time goes on, and nothing is left to happen.
void CheckTimedRulesAtRest(const Model& model, const World& world, Notes& notes) {
  for (std::size_t i = 0; i < world.timed_checks.size(); ++i) {
    if (!world.timed_checks[i].due()) continue;
    notes.violations.push_back("your rule: " + model.timed_rules[i].text +
                               " (nothing is left to happen)");
  }
}

}  // namespace

void UpdateTimedRules(const Model& model, World& world, Notes& notes) {
  const auto goal = GoalOf(model.config, world.machine);
  world.timed_checks.resize(model.timed_rules.size());
  for (std::size_t i = 0; i < model.timed_rules.size(); ++i) {
    const TimedRule& rule = model.timed_rules[i];
    TimedRuleCheck& check = world.timed_checks[i];
    const TimedRuleCoverage before = check.coverage();
    const bool violated = check.Update(rule, goal, SubjectState(world, rule.subject), world.now);
    if (violated) notes.violations.push_back("your rule: " + rule.text);
    if (notes.timed_coverage == nullptr) continue;
    TimedRuleCoverage& coverage = (*notes.timed_coverage)[i];
    coverage.begun += check.coverage().begun - before.begun;
    coverage.met += check.coverage().met - before.met;
  }
}

bool IsHigher(const MachineConfig& config, const State& to, const State& from) {
  const auto high = config.RankOf(to);
  const auto low = config.RankOf(from);
  return high && low && *high > *low;
}

void CheckStopped(const Model& model, const World& world, ActuatorIndex i,
                  const ActuatorReport& before, Notes& notes) {
  const SimActuator& actuator = world.actuators[i];
  const ActuatorReport& report = actuator.core.report;
  const std::string& name = model.config.actuators[i].name;
  if (report.emergency_stop == 0) return;
  if (actuator.energised && actuator.work == Work::kNone) {
    notes.violations.push_back(name + " is energised during an emergency stop");
  }
  if (MaySwitchOn(model.config, before.state, report.state)) {
    notes.violations.push_back(name + " has switched to " + report.state +
                               " during an emergency stop");
  }
}

void CheckUnchanged(const Model& model, const World& world, ActuatorIndex i,
                    const ActuatorCore& before, Notes& notes) {
  if (world.actuators[i].core == before) return;
  notes.violations.push_back(model.config.actuators[i].name +
                             " is changed by a message of another machine");
}

void CheckCommand(const Model& model, const World& world, const action::SendSwitch& send,
                  Notes& notes) {
  CheckOrder(model, world, send, notes);
  const Machine& machine = world.machine;
  const State& state = machine.actuators[send.actuator].state();
  if (!IsHigher(model.config, send.command.target, state) || send.command.target == machine.state)
    return;
  const auto& current = machine.current;
  const bool wanted = current && current->target == send.command.target &&
                      !current->rollback.under_way && IsRequested(world, send.command.target);
  if (wanted || IsStarting(world) || IsRestOfStart(model, world, send.command.target)) return;
  notes.violations.push_back(model.config.actuators[send.actuator].name + " is commanded up from " +
                             state + " to " + send.command.target + ", which was not requested");
}

void CheckBegin(const Model& model, const World& world, ActuatorIndex i, const State& target,
                Epoch epoch, CommandNumber number, Notes& notes) {
  const SimActuator& actuator = world.actuators[i];
  const ActuatorReport& report = actuator.core.report;
  const std::string what = model.config.actuators[i].name + " begins " + target;
  if (report.emergency_stop != 0 && MaySwitchOn(model.config, report.state, target)) {
    notes.violations.push_back(what + " while an emergency stop is latched");
  }
  const bool requested = world.repeat != Repeat::kNotYet && target == model.target;
  if (world.released && !requested && number != 0 &&
      MaySwitchOn(model.config, report.state, target)) {
    notes.violations.push_back(what + " by the release of the emergency stop");
  }
  if (number == 0) return;
  if (epoch < actuator.epoch) {
    notes.violations.push_back(what + " by epoch " + ToString(epoch) + ", which is superseded");
  }
  if (number <= actuator.begun || number <= actuator.queried) {
    notes.violations.push_back(what + " by command " + ToString(number) + ", which is outdated");
  }
  const bool wanted = IsRequested(world, target) || target == world.machine.state ||
                      target == world.from || IsStarting(world) ||
                      IsRestOfStart(model, world, target);
  if (IsHigher(model.config, target, report.state) && !wanted) {
    notes.violations.push_back(what + " from " + report.state + ", which was not requested");
  }
}

void CheckStep(const Model& model, const World& world, const Before& before, Notes& notes) {
  const MachineConfig& config = model.config;
  const Machine& machine = world.machine;
  const std::string broken = BrokenInvariant(config, machine);
  if (!broken.empty()) notes.violations.push_back(broken);
  if (machine.phase == Phase::kFenced) {
    notes.violations.emplace_back("the controller releases control, and none has replaced it");
  }
  const auto deadline = NextDeadline(config, machine);
  if (deadline && *deadline <= world.now)
    notes.violations.emplace_back("a deadline is not in the future");
  if (world.stays_down && machine.phase == Phase::kRunning) {
    notes.violations.push_back("the machine is up in " + machine.state +
                               " after a TearDown, by no person's start");
  }
  const bool rises = IsHigher(config, machine.state, before.state);
  if (rises && !IsRequested(world, machine.state) && !IsRestOfStart(model, world, machine.state)) {
    notes.violations.push_back("the machine switches up to " + machine.state +
                               ", which was not requested");
  }
  if (rises && before.stopped && machine.emergency.stop) {
    notes.violations.push_back("the machine switches up to " + machine.state +
                               " during an emergency stop");
  }
  const bool adopts = world.generation > 0 && before.phase == Phase::kStarting &&
                      !before.starting && machine.phase == Phase::kRunning;
  for (const ActuatorIndex i : world.actuators.Indices()) {
    if (!adopts) break;
    const State& state = world.actuators[i].core.report.state;
    const bool counts = world.actuators[i].alive &&
                        machine.actuators[i].presence == Presence::kPresent &&
                        !machine.actuators[i].fault;
    if (counts && IsHigher(config, machine.state, state)) {
      notes.violations.push_back("the machine is adopted in " + machine.state +
                                 ", which is above " + config.actuators[i].name + "'s " + state);
    }
  }
}

void CheckStart(const Model& model, const World& world, ActuatorIndex i, Notes& notes) {
  if (!world.stays_down) return;
  notes.violations.push_back(model.config.actuators[i].name +
                             " is started after a TearDown, by no person");
}

void CheckAnswer(const Model& model, const World& world, const action::AnswerSetState& answer,
                 Notes& notes) {
  const SwitchResult& result = answer.result;
  const Request& request = world.requests[answer.request.value() - 1];
  if (request.abandoned)
    notes.violations.emplace_back("a reply to a request of another controller");
  if (request.replies > 0) notes.violations.emplace_back("a request gets two replies");
  if (result.target != request.target)
    notes.violations.emplace_back("a reply with the outcome of another request");
  switch (result.outcome) {
    case SwitchOutcome::kDone:
    case SwitchOutcome::kDoneDegraded:
      CheckUp(model, world, answer, notes);
      return CheckDone(model, world, result, notes);
    case SwitchOutcome::kUndone:
      return CheckUndone(model, world, result, notes);
    case SwitchOutcome::kSuperseded:
      if (!IsRequested(world, State(kError)) && !IsRequested(world, State(kTearDown)) &&
          !world.battery) {
        notes.violations.emplace_back("superseded by nothing");
      }
      return;
    case SwitchOutcome::kRefused:
      if (result.number != 0) notes.violations.emplace_back("refused, although it had a number");
      return;
  }
}

void CheckRest(const Model& model, const World& world, Notes& notes) {
  for (const Request& request : world.requests) {
    if (request.replies == 0 && !request.abandoned) {
      notes.violations.push_back(
          "nothing is left to happen, and there is no reply to the request for " + request.target);
    }
  }
  if (world.machine.current) notes.violations.emplace_back("a switch has no end");
  if (world.machine.phase == Phase::kStopping)
    notes.violations.emplace_back("the TearDown has no end");
  const bool ends =
      world.machine.phase == Phase::kStopping || world.machine.phase == Phase::kStopped;
  for (const ActuatorIndex i : world.actuators.Indices()) {
    if (!ends) CheckPlaceInStart(model, world, i, notes);
  }
  CheckStarted(model, world, notes);
  if (!ends) CheckStableRules(model, world, notes);
  CheckTimedRulesAtRest(model, world, notes);
  if (world.machine.phase != Phase::kRunning) return;
  CheckBattery(model, world, notes);
  CheckDegraded(model, world, notes);
  for (const ActuatorIndex i : world.actuators.Indices()) {
    CheckPlace(model, world, i, notes);
    CheckFallback(model, world, i, notes);
  }
}

}  // namespace musher::search
