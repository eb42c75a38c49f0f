// Drives one actuator on its own to the state of the machine: actuators of late stages, restarted
// ones, and those that were overdue. Switches go first; joining waits for them.

#include <algorithm>

#include "musher/lifecycle/decision.hpp"

namespace musher {

bool Decision::DriveLateOnes() {
  if (machine_.phase != Phase::kRunning || machine_.current || machine_.waiting) return false;
  bool changed = false;
  for (std::size_t i = 0; i < machine_.actuators.size(); ++i) {
    const ActuatorRecord& record = Of(i);
    const bool free = record.presence == Presence::kPresent && !record.command &&
                      !record.report.busy() && record.health != Health::kHung && !record.given_up &&
                      !record.restart_requested;
    const bool unchecked = !record.checked && !record.join_tried && !config_.RankOf(record.state());
    if (!free || record.held) continue;
    if (!record.due && !unchecked) {
      const bool had_a_fault = record.fault.has_value();
      ReportUnchecked(i);
      changed |= !had_a_fault && record.fault;
      continue;
    }
    std::string blocker;
    if (!MayJoin(i, blocker)) {
      if (blocker.empty()) continue;
      changed |= !record.fault;  // the actuators after it are evaluated in turn
      Degrade(i, kCodeStatusError, blocker, CauseOfBlocker(i));
      continue;
    }
    Join(i);
    changed = true;
  }
  return changed;
}

// Whether it may be in the state of the machine: it has passed its check, or is present without
// one, in Error.
bool Decision::Fits(std::size_t i) const {
  return Of(i).checked || Of(i).state() == machine_.state;
}

// Whether it may be driven to the state of the machine: down always, up only after its check.
bool Decision::MayFollow(std::size_t i) const {
  const auto own = config_.RankOf(Of(i).state());
  const auto machine = config_.RankOf(machine_.state);
  return Of(i).checked || (own && machine && *own > *machine);
}

// An actuator that was found in Error, or reached its state otherwise without a check, or whose
// check was superseded, is not driven up without a request.
void Decision::ReportUnchecked(std::size_t i) {
  const ActuatorRecord& record = Of(i);
  if (record.command || record.report.busy() || record.free_by) return;  // perhaps with its check
  const bool passes_by_itself = !config_.RankOf(record.state()) && !record.join_tried;
  if (record.state() == machine_.state || passes_by_itself || record.checked || record.fault)
    return;
  Degrade(i, kCodeStatusError,
          "it is in " + record.state() +
              " and has not passed its self-check; run `musher set SelfCheck`");
}

// Whether the actuators in its `after` are present, for a self-check, or up, for going up itself.
bool Decision::MayJoin(std::size_t i, std::string& blocker) const {
  const ActuatorRecord& record = Of(i);
  const auto own = config_.RankOf(record.state());
  const auto target = config_.RankOf(PlaceOf(i));
  const bool goes_up = record.due && target && (!own || *own < *target);
  if (record.due && !goes_up) return true;
  if (goes_up && machine_.emergency_stop && machine_.state != kError) return false;
  if (!NeedsMet(i, blocker)) {
    if (blocker.empty()) blocker = WaitsForSuspended(i);
    return false;
  }
  return !goes_up || std::all_of(ConfigOf(i).after.begin(), ConfigOf(i).after.end(),
                                 [this](const std::string& name) {
                                   const ActuatorRecord& needed = Of(*config_.IndexOf(name));
                                   return needed.held || needed.state() == machine_.state;
                                 });
}

// The suspended actuator in its `after` that it waits for; empty: none.
std::string Decision::WaitsForSuspended(std::size_t i) const {
  for (const std::string& name : ConfigOf(i).after) {
    if (Of(*config_.IndexOf(name)).suspended) return "waits for " + name + ", which is suspended";
  }
  return {};
}

void Decision::Join(std::size_t i) {
  ActuatorRecord& record = Of(i);
  if (!record.due) {
    return Issue(i, machine_.number + 1, State(kSelfCheck), config_.TimeFor(i, kSelfCheck));
  }
  record.due = false;
  const State place = PlaceOf(i);
  if (record.state() == place) {
    if (record.checked && !record.suspended) record.fault.reset();
  } else if (!config_.RankOf(place)) {
    return;  // the machine is between states; the next switch includes this actuator
  } else if (!ConfigOf(i).Lists(place)) {
    Degrade(i, kCodeUnSupport, "has no state '" + place + "'", record.cause);
  } else {
    Issue(i, machine_.number + 1, place, config_.TimeFor(i, place));
  }
}

// The end of a command that was not part of a switch.
void Decision::EndJoin(std::size_t i, const PendingCommand& command, const CommandResult& end) {
  ActuatorRecord& record = Of(i);
  if (record.restart_requested) return EndTornDown(i, end);
  if (end.outcome == ActuatorOutcome::kDone) {
    record.due = command.target == kSelfCheck || record.state() != PlaceOf(i);
    return;
  }
  if (end.outcome == ActuatorOutcome::kLost) return;  // what follows depends on how it was lost
  Degrade(i, end.code,
          command.target + " " + std::string(OutcomeName(end.outcome)) + ": " + end.message,
          record.cause);
  FallBack(i);
}

// Its TearDown before a restart has ended. A process of Musher's protocol exits by itself after
// that, and gets SIGTERM only if it does not; a program of another protocol waits for SIGTERM.
void Decision::EndTornDown(std::size_t i, const CommandResult& end) {
  ActuatorRecord& record = Of(i);
  const bool ends_itself =
      end.outcome == ActuatorOutcome::kDone && ConfigOf(i).protocol == Protocol::kMusher;
  const Duration grace = ends_itself ? kExitGrace : Duration::zero();
  Terminate(i, ProcessOf(i), grace + kEndTime);
  if (record.terminating == 0) return;
  if (ends_itself) {
    record.terminate_at = now_ + grace;
  } else {
    Do(action::SignalProcess{i, record.terminating, false});
  }
}

// An actuator is unavailable: the machine goes down to its on_lost, if it has one, as soon as no
// switch is under way. Of several the least active counts.
void Decision::FallBack(std::size_t i) {
  const State& on_lost = ConfigOf(i).on_lost;
  if (on_lost.empty() || machine_.phase != Phase::kRunning) return;
  if (!machine_.fallback || *config_.RankOf(on_lost) < *config_.RankOf(*machine_.fallback)) {
    machine_.fallback = on_lost;
    machine_.fallback_cause = Of(i).cause;
  }
}

bool Decision::BeginFallback() {
  if (!machine_.fallback || machine_.current || machine_.phase != Phase::kRunning) return false;
  const State target = *std::exchange(machine_.fallback, std::nullopt);
  LowerAtMostTo(target);
  const auto rank = config_.RankOf(machine_.state);
  if (!rank || *config_.RankOf(target) >= *rank) return false;  // it is that safe already
  const Plan plan = MakeSafetyPlan(config_, machine_, target);
  if (plan.refusal) {  // not of a running machine with a valid config
    RecordMachine(plan.refusal->code,
                  "cannot fall back to " + target + ": " + plan.refusal->message,
                  machine_.fallback_cause);
    return false;
  }
  const std::uint64_t recorded = RecordMachine(
      kCodeOk, "an actuator is lost; falling back to " + target, machine_.fallback_cause);
  Begin(plan, Purpose::kFallback, {}, recorded);
  return true;
}

}  // namespace musher
