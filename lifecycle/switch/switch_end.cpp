// The end of a switch: its effect on the machine and on each actuator, and its answer.

#include "musher/lifecycle/switch/switching.hpp"

#include <algorithm>
#include <utility>

namespace musher {

SwitchResult Refusal(const State& target, const std::string& actuator, const State& state,
                     const Error& why) {
  SwitchResult result;
  result.target = target;
  result.actuator = actuator;
  result.outcome = SwitchOutcome::kRefused;
  result.code = why.code;
  result.reason = why.message;
  result.state = state;
  return result;
}

EndedSwitch Switching::End() {
  const Switch s = *machine_.current;
  machine_.current.reset();
  // Where the only actuator did not switch, nothing was done.
  const bool single_failed = s.only && !s.legs.empty() && s.legs.front().failed();
  const bool undone = s.rollback.under_way || (single_failed && s.direction != Direction::kCheck);
  if (!undone && !s.only) {
    const bool a_step = !config_.RankOf(machine_.state) || machine_.state == kError;
    if (s.direction != Direction::kCheck || a_step) machine_.state = s.target;
  }
  Apply(s, undone);
  if (undone) SettleBack(s);
  const SwitchResult result = conclusion().Conclude(s, undone);
  const Leg* worst = undone ? conclusion().WorstLeg(s) : nullptr;
  const bool stopped = undone && s.stopped;
  if (stopped && !s.only) StandStill(s);
  const RecordId recorded = RecordEnd(s, result,
                                      stopped ? machine_.emergency.cause
                                      : worst ? Of(worst->actuator).cause
                                              : s.cause);
  EndedSwitch ended{s.purpose, undone, !s.only, result, recorded};
  if (s.purpose == Purpose::kStop) return ended;  // answered when the processes have exited
  memory_.OnSwitchEnded(s, undone);
  Answer(s.requests, result);
  const bool torn_down = s.only && s.target == kTearDown && !undone;
  if (torn_down) Degrade(*s.only, kCodeStateInvalid, texts::TornDownAlone(), recorded);
  return ended;
}

// An emergency stop has undone the switch: after its release a manager may not request it again.
void Switching::StandStill(const Switch& s) {
  const auto& stop = machine_.emergency.stop;
  const std::string by = stop && !stop->by.empty() ? " of " + stop->by : "";
  machine_.standing = StandingRequest{s.from, "the emergency stop" + by, s.number};
}

// The effects of a switch without rollback, or of the forward part of a switch.
void Switching::Apply(const Switch& s, bool undone) {
  const bool check = s.direction == Direction::kCheck;
  for (const Leg& leg : s.legs) {
    ActuatorRecord& record = Of(leg.actuator);
    if (leg.outcome == ActuatorOutcome::kDone) {
      if (!undone && !check) record.held = s.only.has_value() && leg.target != machine_.state;
      // An actuator that has passed late is driven to the state of the machine. Before the machine
      // is usable, one whose rollback had failed is driven back: its fault is cleared by the check.
      const bool passed = check && record.checked;  // by the present process
      const bool runs = machine_.phase == Phase::kRunning;
      const bool away = runs ? record.state() != machine_.state : IsAbovePlace(leg.actuator);
      if (passed && away && !record.held) record.due = true;
      continue;
    }
    if (check) record.checked = false;
    if (undone && (!leg.ran || s.rollback.under_way)) continue;
    const bool reported = leg.outcome != ActuatorOutcome::kSkipped;
    Degrade(leg.actuator, leg.code, {leg.event, leg.message}, reported ? record.cause : s.cause);
  }
  if (undone || check || s.only) return;
  if (s.direction == Direction::kUp && s.purpose != Purpose::kStartUpActivate) CheckAgain();
  DriveTheRest(s);
  for (const ActuatorResult& other : s.others) {
    const ActuatorIndex i = *config_.IndexOf(other.name);
    const bool was_held = std::exchange(Of(i).held, false);
    const bool away = Of(i).presence == Presence::kLost || Of(i).state() == kTearDown;
    if (was_held && away) FallBack(i);  // from now on its loss counts
    // When the machine stops, only what becomes of its process counts.
    if (other.outcome == ActuatorOutcome::kUnsupported && s.purpose != Purpose::kStop) {
      Degrade(i, other.code, {EventName::kStateUnsupported, other.message}, s.cause);
    }
  }
}

// After a switch up those that it has left out for their failed self-check have another one.
void Switching::CheckAgain() {
  for (ActuatorRecord& record : machine_.actuators) {
    if (!record.checked && record.failed_checks.count > 0) record.failed_checks.at = now_;
  }
}

// Drives the actuators that were being driven on their own while the switch ran.
void Switching::DriveTheRest(const Switch& s) {
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    ActuatorRecord& record = Of(i);
    const bool had_a_leg = std::any_of(s.legs.begin(), s.legs.end(),
                                       [&](const Leg& leg) { return leg.actuator == i; });
    if (had_a_leg || record.presence != Presence::kPresent) continue;
    if (!record.checked) {
      commands_.ReportUnchecked(i);
      continue;
    }
    if (!record.fault && record.state() != machine_.state) record.due = true;
  }
}

// The effects of a rollback.
void Switching::SettleBack(const Switch& s) {
  for (const Leg& leg : s.rollback.legs) {
    ActuatorRecord& record = Of(leg.actuator);
    const bool present = record.presence == Presence::kPresent;
    if (leg.outcome == ActuatorOutcome::kDone) {
      // An actuator that was degraded before is back in its state, and still not in the machine's.
      const bool away = present && record.state() != machine_.state;
      if (!s.only && !record.held && away) record.due = true;
      continue;
    }
    const bool restarted = present && !config_.RankOf(record.state());
    if (restarted && leg.outcome == ActuatorOutcome::kSkipped) continue;  // it is driven on its own
    if (present && leg.outcome == ActuatorOutcome::kSkipped && leg.code == kCodeProtectedError) {
      SettleHeld(s, leg);
      continue;
    }
    Degrade(leg.actuator, leg.code, texts::RollbackFailed(leg.target, leg.message),
            Of(leg.actuator).cause);
    if (!IsComing(leg.actuator)) FallBack(leg.actuator);
  }
}

// The effect on an actuator that is not driven back during an emergency stop. It stays where it is
// also after the release, which starts no callback, until the next switch.
void Switching::SettleHeld(const Switch& s, const Leg& back) {
  const ActuatorRecord& record = Of(back.actuator);
  const auto forward = std::ranges::find(s.legs, back.actuator, &Leg::actuator);
  if (record.report.busy()) {
    Degrade(back.actuator, back.code, texts::StoppedWhileBusy(record.report.target, s.target),
            machine_.emergency.cause);
  } else if (record.state() != machine_.state && record.state() == s.target) {
    Degrade(back.actuator, back.code, texts::StoppedIn(record.state(), s.target),
            machine_.emergency.cause);
  } else if (forward->failed() && forward->code != kCodeProtectedError) {
    Degrade(back.actuator, forward->code, {forward->event, forward->message}, record.cause);
  }
}

// Ends the switch under way without rollback. Running callbacks finish; the newest command waits
// behind them at the actuator.
void Switching::Supersede(CommandNumber by, const State& target, RecordId cause) {
  const Switch& s = *machine_.current;
  SwitchResult result = conclusion().Conclude(s, false);
  result.outcome = SwitchOutcome::kSuperseded;
  result.code = kCodeTargetBusy;
  result.reason = "switch " + ToString(by) + " (to " + target + ") took over";
  RecordEnd(s, result, cause);
  for (const Leg& leg : s.driven_legs()) {
    if (leg.progress != Leg::Progress::kUnderWay) continue;
    Of(leg.actuator).command.reset();
    Of(leg.actuator).free_by = now_ + config_.TimeFor(leg.actuator, leg.target);
  }
  Answer(s.requests, result);
  memory_.OnSuperseded(s);
  machine_.current.reset();
}

void Switching::Refuse(const State& target, std::optional<ActuatorIndex> only,
                       const std::vector<RequestId>& requests, const State& state, const Error& why,
                       RecordId cause) {
  SwitchResult result = Refusal(target, only ? ConfigOf(*only).name : "", state, why);
  result.degraded = Degraded(config_, machine_);
  RecordSwitch(only, 0, why.code,
               texts::SwitchRefused(Describe(config_, target.Shortened(), only), why.message),
               cause);
  Answer(requests, result);
}

// Ends it without beginning the switch: nothing was sent for it.
void Switching::EndWaiting(const Error& why, RecordId cause) {
  if (!machine_.waiting) return;
  const WaitingSwitch waiting = *std::exchange(machine_.waiting, std::nullopt);
  const State state = waiting.only ? Of(*waiting.only).state() : machine_.state;
  Refuse(waiting.target, waiting.only, waiting.requests, state, why, cause);
}

void Switching::Answer(const std::vector<RequestId>& requests, const SwitchResult& result) {
  for (const RequestId request : requests) {
    if (std::erase(machine_.policy.calls, request) == 0) {
      Do(action::AnswerSetState{request, result});
    } else {
      Do(action::AnswerCall{request, result.done() ? Ok() : Error{result.code, result.reason}});
    }
  }
}

}  // namespace musher
