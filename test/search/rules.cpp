#include "musher/test/search/rules.hpp"

#include <algorithm>

#include "musher/lifecycle/flow.hpp"

namespace musher::search {
namespace {

bool AskedFor(const World& world, const State& target) {
  return std::any_of(world.requests.begin(), world.requests.end(),
                     [&](const Request& request) { return request.target == target; });
}

// A controller that finds nobody past the check, by whomever that was led, starts the machine.
bool IsStarting(const World& world) {
  const auto& current = world.machine.current;
  const bool checked =
      world.from == kSelfCheck || world.from == kSetUp || AskedFor(world, State(kSelfCheck));
  return checked && world.generation > 0 && current &&
         current->purpose == Purpose::kStartUpActivate;
}

// Whether the result names it as degraded, or as one that was not to be had.
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
bool EndIsUnheardOf(const Actor& actor) {
  return !actor.alive && actor.end.has_value();
}

void CheckDone(const Model& model, const World& world, const SwitchResult& result, Notes& notes) {
  if (result.target != kSelfCheck && world.machine.state != result.target) {
    notes.wrong.push_back("done is told while the machine is in " + world.machine.state);
  }
  for (std::size_t i = 0; i < kActuators; ++i) {
    const Actor& actor = world.actors[i];
    const ActuatorReport& report = actor.core.report;
    const std::string& name = model.config.actuators[i].name;
    // One that is degraded for another reason is there none the less where the switch is done.
    if ((Listed(result, name) && !result.done()) || EndIsUnheardOf(actor)) continue;
    // What does not follow the controller cannot be left behind by its end.
    const bool follows = world.machine.actuators[i].presence == Presence::kPresent;
    if (result.target == kTearDown && !follows) continue;
    const bool there =
        result.target == kSelfCheck
            ? actor.alive && report.outcome_number == result.number && report.outcome_code == 0
            : (actor.alive || result.target == kTearDown) && report.state == result.target;
    if (!there) notes.wrong.push_back("done is told while " + name + " is in " + report.state);
  }
}

// All are back. Where the machine is between states, nobody may be above rest.
void CheckUndone(const Model& model, const World& world, const SwitchResult& result, Notes& notes) {
  const bool at_rest = model.config.RankOf(world.machine.state).has_value();
  if (result.state != world.machine.state || result.state == result.target) {
    notes.wrong.push_back("undone is told, and that the machine is in " + result.state);
  }
  for (std::size_t i = 0; i < kActuators; ++i) {
    const Actor& actor = world.actors[i];
    const std::string& name = model.config.actuators[i].name;
    if (Listed(result, name) || !actor.alive) continue;
    const State& state = actor.core.report.state;
    const bool back =
        at_rest ? state == world.machine.state : !IsHigher(model.config, state, State(kDeActive));
    if (!back) notes.wrong.push_back("undone is told while " + name + " is in " + state);
    if (at_rest && actor.work != Work::kNone && actor.core.report.target == result.target) {
      notes.wrong.push_back("undone is told while " + name + " is on its way");
    }
  }
}

void CheckPlace(const Model& model, const World& world, std::size_t i, Notes& notes) {
  const MachineConfig& config = model.config;
  const Machine& machine = world.machine;
  const Actor& actor = world.actors[i];
  const ActuatorRecord& record = machine.actuators[i];
  const ActuatorConfig& own = config.actuators[i];
  const State& state = actor.core.report.state;
  if (record.order) notes.wrong.push_back("an order to " + own.name + " has no end");
  const auto place = config.RankOf(machine.state);
  const auto rank = config.RankOf(state);
  const bool stopped_below = machine.emergency_stop && (!rank || (place && *rank < *place));
  const bool there = actor.alive && record.presence == Presence::kPresent &&
                     (state == machine.state || !place || stopped_below);
  if (!there && !record.held && !record.fault) {
    notes.wrong.push_back("at rest " + own.name + (actor.alive ? " is in " : " is dead in ") +
                          state + ", the machine in " + machine.state +
                          ", and nothing is on record");
  }
  const bool knows = record.state() == state && record.report.busy() == actor.core.report.busy();
  if (actor.alive && !record.fault && !knows) {
    notes.wrong.push_back("at rest " + own.name + " is in " + state +
                          ", and the controller takes it to be in " + record.state());
  }
  if (!own.on_lost.empty() && !actor.alive && place && *place > *config.RankOf(own.on_lost)) {
    notes.wrong.push_back(own.name + " is not there, and the machine is in " + machine.state);
  }
}

// Of two in order the one is not sent anything while the other is on its way, nor after it.
void CheckOrder(const Model& model, const World& world, const action::SendSwitch& send,
                Notes& notes) {
  const auto& current = world.machine.current;
  if (!current) return;
  const bool reversed = current->rolling_back || current->direction == Direction::kDown;
  const auto comes_after = [&](std::size_t one, std::size_t other) {
    const auto& after = model.config.actuators[one].after;
    return std::find(after.begin(), after.end(), model.config.actuators[other].name) != after.end();
  };
  for (std::size_t k = 0; k < kActuators; ++k) {
    const std::size_t first = reversed ? k : send.actuator;
    const std::size_t second = reversed ? send.actuator : k;
    const bool later = comes_after(second, first);
    if (!later && !comes_after(first, second)) continue;
    const Actor& other = world.actors[k];
    const ActuatorReport& report = other.core.report;
    const bool sent = std::any_of(world.outbox.begin(), world.outbox.end(), [&](const Message& m) {
      const auto* command = std::get_if<SwitchCommand>(&m.what);
      return m.to == k && command != nullptr && command->number == send.number;
    });
    const bool takes_part = std::any_of(current->legs.begin(), current->legs.end(),
                                        [k](const Leg& leg) { return leg.actuator == k; });
    if (!other.alive || !takes_part) continue;
    const bool runs = other.work == Work::kRunning && report.busy_number == send.number;
    if (sent || runs || (later && report.outcome_number == send.number)) {
      notes.wrong.push_back(model.config.actuators[send.actuator].name + " is sent to " +
                            send.target + " out of order with " + model.config.actuators[k].name);
    }
  }
}

// On the way up it is all or nobody, and nobody was degraded before.
void CheckUp(const Model& model, const World& world, const action::AnswerSetState& answer,
             Notes& notes) {
  const SwitchResult& result = answer.result;
  if (answer.request != 1 || !IsHigher(model.config, result.target, world.from)) return;
  for (const ActuatorResult& actuator : result.actuators) {
    if (actuator.outcome == ActuatorOutcome::kDone) continue;
    notes.wrong.push_back("the machine goes up without " + actuator.name);
  }
}

// Without an order among them a fault costs no more than one.
void CheckDegraded(const Model& model, const World& world, Notes& notes) {
  const auto& actuators = model.config.actuators;
  const bool in_order = std::any_of(actuators.begin(), actuators.end(),
                                    [](const ActuatorConfig& a) { return !a.after.empty(); });
  const auto degraded = Degraded(model.config, world.machine).size();
  if (AskedFor(world, State(kTearDown)))
    return;  // who has gone cannot be told from who is not there
  if (in_order || degraded <= static_cast<std::size_t>(world.faults - world.faults_left)) return;
  notes.wrong.push_back(std::to_string(degraded) + " are degraded, which is more than had a fault");
}

}  // namespace

bool IsHigher(const MachineConfig& config, const State& to, const State& from) {
  const auto high = config.RankOf(to);
  const auto low = config.RankOf(from);
  return high && low && *high > *low;
}

void CheckStopped(const Model& model, const World& world, std::size_t i,
                  const ActuatorReport& before, Notes& notes) {
  const Actor& actor = world.actors[i];
  const ActuatorReport& report = actor.core.report;
  const std::string& name = model.config.actuators[i].name;
  if (report.emergency_stop == 0) return;
  if (actor.energised && actor.work == Work::kNone) {
    notes.wrong.push_back(name + " is energised under an emergency stop");
  }
  if (Rises(model.config, before.state, report.state)) {
    notes.wrong.push_back(name + " has gone up to " + report.state + " under an emergency stop");
  }
}

void CheckCommand(const Model& model, const World& world, const action::SendSwitch& send,
                  Notes& notes) {
  CheckOrder(model, world, send, notes);
  const Machine& machine = world.machine;
  const State& state = machine.actuators[send.actuator].state();
  if (!IsHigher(model.config, send.target, state) || send.target == machine.state) return;
  const auto& current = machine.current;
  const bool wanted = current && current->target == send.target && !current->rolling_back &&
                      AskedFor(world, send.target);
  if (wanted || IsStarting(world)) return;
  notes.wrong.push_back(model.config.actuators[send.actuator].name + " is sent up from " + state +
                        " to " + send.target + ", which nobody asked for");
}

void CheckBeginning(const Model& model, const World& world, std::size_t i, const State& target,
                    std::uint64_t epoch, std::uint64_t number, Notes& notes) {
  const Actor& actor = world.actors[i];
  const ActuatorReport& report = actor.core.report;
  const std::string what = model.config.actuators[i].name + " begins " + target;
  if (report.emergency_stop != 0 && Rises(model.config, report.state, target)) {
    notes.wrong.push_back(what + " while an emergency stop is latched");
  }
  if (number == 0) return;
  if (epoch < actor.epoch) {
    notes.wrong.push_back(what + " by epoch " + std::to_string(epoch) + ", which is over");
  }
  if (number <= actor.begun || number <= actor.asked) {
    notes.wrong.push_back(what + " by command " + std::to_string(number) +
                          ", which is of the past");
  }
  const bool wanted = AskedFor(world, target) || target == world.machine.state ||
                      target == world.from || IsStarting(world);
  if (IsHigher(model.config, target, report.state) && !wanted) {
    notes.wrong.push_back(what + " from " + report.state + ", which nobody asked for");
  }
}

void CheckStep(const Model& model, const World& world, const Before& before, Notes& notes) {
  const MachineConfig& config = model.config;
  const Machine& machine = world.machine;
  const auto deadline = NextDeadline(config, machine);
  if (deadline && *deadline <= world.now)
    notes.wrong.emplace_back("a deadline is not in the future");
  const bool rises = IsHigher(config, machine.state, before.state);
  if (rises && !AskedFor(world, machine.state)) {
    notes.wrong.push_back("the machine rises to " + machine.state + ", which nobody asked for");
  }
  if (rises && before.stopped && machine.emergency_stop) {
    notes.wrong.push_back("the machine rises to " + machine.state + " in an emergency stop");
  }
  const bool adopts = world.generation > 0 && before.phase == Phase::kStarting &&
                      !before.starting && machine.phase == Phase::kRunning;
  for (std::size_t i = 0; i < kActuators && adopts; ++i) {
    const State& state = world.actors[i].core.report.state;
    const bool counts = world.actors[i].alive &&
                        machine.actuators[i].presence == Presence::kPresent &&
                        !machine.actuators[i].fault;
    if (counts && IsHigher(config, machine.state, state)) {
      notes.wrong.push_back("the machine is adopted in " + machine.state + ", which is above " +
                            config.actuators[i].name + "'s " + state);
    }
  }
}

void CheckAnswer(const Model& model, const World& world, const action::AnswerSetState& answer,
                 Notes& notes) {
  const SwitchResult& result = answer.result;
  const Request& request = world.requests[answer.request - 1];
  if (request.gone) notes.wrong.emplace_back("somebody is told who had asked another controller");
  if (request.answers > 0) notes.wrong.emplace_back("the same request is told twice");
  if (result.target != request.target) notes.wrong.emplace_back("another's outcome is told");
  switch (result.outcome) {
    case SwitchOutcome::kDone:
    case SwitchOutcome::kDoneDegraded:
      CheckUp(model, world, answer, notes);
      return CheckDone(model, world, result, notes);
    case SwitchOutcome::kUndone:
      return CheckUndone(model, world, result, notes);
    case SwitchOutcome::kSuperseded:
      if (!AskedFor(world, State(kError)) && !AskedFor(world, State(kTearDown))) {
        notes.wrong.emplace_back("superseded by nothing");
      }
      return;
    case SwitchOutcome::kRefused:
      if (result.number != 0) notes.wrong.emplace_back("refused, though it had a number");
      return;
  }
}

void CheckRest(const Model& model, const World& world, Notes& notes) {
  for (const Request& request : world.requests) {
    if (request.answers == 0 && !request.gone) {
      notes.wrong.push_back("nothing is left to happen, and nobody was told what became of " +
                            request.target);
    }
  }
  if (world.machine.current) notes.wrong.emplace_back("a switch has no end");
  if (world.machine.phase == Phase::kStopping) notes.wrong.emplace_back("the end has no end");
  if (world.machine.phase != Phase::kRunning) return;
  CheckDegraded(model, world, notes);
  for (std::size_t i = 0; i < kActuators; ++i) CheckPlace(model, world, i, notes);
}

}  // namespace musher::search
