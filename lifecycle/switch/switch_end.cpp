// The end of a switch: its effect on the machine and on each actuator, and its result.

#include <algorithm>
#include <utility>

#include "musher/lifecycle/decision.hpp"

namespace musher {
namespace {

// The severity of an outcome: silence is worse than a reported failure.
int Badness(const Leg& leg, bool critical) {
  if (!leg.failed()) return 0;
  if (critical) return 4;
  if (leg.outcome == ActuatorOutcome::kLost || leg.outcome == ActuatorOutcome::kOverdue) return 3;
  return leg.outcome == ActuatorOutcome::kSkipped ? 1 : 2;
}

}  // namespace

// A self-check that fails with a code that is not critical counts as passed, and the actuator is
// degraded.
CommandResult Decision::Tolerate(std::size_t i, const PendingCommand& command,
                                 const CommandResult& end) {
  if (command.target != kSelfCheck) return end;
  Of(i).tolerated.reset();
  const auto& critical = ConfigOf(i).critical_codes;
  const bool tolerated = end.outcome == ActuatorOutcome::kFailed && critical &&
                         std::find(critical->begin(), critical->end(), end.code) == critical->end();
  if (!tolerated) return end;
  const std::string why = end.message.empty() ? "its self-check failed" : end.message;
  Of(i).tolerated = Error{end.code, why};
  return {ActuatorOutcome::kDone, end.code, "degraded: " + why, true, end.cause};
}

// The effects of a switch without rollback, or of the forward part of a switch.
void Decision::Apply(const Switch& s, bool undone) {
  const bool check = s.direction == Direction::kCheck;
  for (const Leg& leg : s.legs) {
    ActuatorRecord& record = Of(leg.actuator);
    if (leg.outcome == ActuatorOutcome::kDone) {
      if (!undone && !check) record.held = s.only.has_value() && leg.target != machine_.state;
      // An actuator that has passed late is driven to the state of the machine.
      const bool passed = check && record.checked;  // by the present process
      if (passed && machine_.phase == Phase::kRunning && !record.held &&
          record.state() != machine_.state) {
        record.due = true;
      }
      continue;
    }
    if (check) record.checked = false;
    if (undone && (!leg.ran || s.rolling_back)) continue;
    const bool reported = leg.outcome != ActuatorOutcome::kSkipped;
    Degrade(leg.actuator, leg.code, leg.message, reported ? record.cause : s.cause);
  }
  if (undone || check || s.only) return;
  DriveTheRest(s);
  for (const ActuatorResult& other : s.others) {
    const std::size_t i = *config_.IndexOf(other.name);
    const bool was_held = std::exchange(Of(i).held, false);
    const bool away = Of(i).presence == Presence::kLost || Of(i).state() == kTearDown;
    if (was_held && away) FallBack(i);  // from now on its loss counts
    if (other.outcome == ActuatorOutcome::kUnsupported) {
      Degrade(i, other.code, other.message, s.cause);
    }
  }
}

// Drives the actuators that were being driven on their own while the switch ran.
void Decision::DriveTheRest(const Switch& s) {
  for (std::size_t i = 0; i < machine_.actuators.size(); ++i) {
    ActuatorRecord& record = Of(i);
    const bool had_a_leg = std::any_of(s.legs.begin(), s.legs.end(),
                                       [&](const Leg& leg) { return leg.actuator == i; });
    if (had_a_leg || record.presence != Presence::kPresent) continue;
    if (!record.checked) {
      ReportUnchecked(i);
      continue;
    }
    if (!record.fault && record.state() != machine_.state) record.due = true;
  }
}

// The effects of a rollback.
void Decision::SettleBack(const Switch& s) {
  for (const Leg& leg : s.back) {
    ActuatorRecord& record = Of(leg.actuator);
    if (leg.outcome == ActuatorOutcome::kDone) {
      // An actuator that was degraded before is back in its state, and still not in the machine's.
      if (!s.only && !record.held && record.state() != machine_.state) record.due = true;
      continue;
    }
    const bool restarted = record.presence == Presence::kPresent && !config_.RankOf(record.state());
    if (restarted && leg.outcome == ActuatorOutcome::kSkipped) continue;  // it is driven on its own
    Degrade(leg.actuator, leg.code,
            "could not be brought back to " + (leg.target.empty() ? "rest" : leg.target) + ": " +
                leg.message,
            Of(leg.actuator).cause);
    if (!Coming(leg.actuator)) FallBack(leg.actuator);
  }
}

std::vector<ActuatorResult> Decision::Results(const Switch& s) const {
  std::vector<ActuatorResult> results;
  for (const Leg& leg : s.legs) {
    ActuatorResult result{
        ConfigOf(leg.actuator).name, leg.outcome, leg.code, leg.message, leg.duration,
        Of(leg.actuator).state()};
    if (leg.progress != Leg::Progress::kEnded) {
      result.outcome = ActuatorOutcome::kSkipped;
      result.message =
          leg.progress == Leg::Progress::kWaiting ? "nothing was sent" : "was under way";
    }
    CorrectIfAway(s, leg.actuator, result);
    for (const Leg& back : s.back) {
      if (back.actuator == leg.actuator && back.outcome == ActuatorOutcome::kDone &&
          leg.outcome == ActuatorOutcome::kDone) {
        result.outcome = ActuatorOutcome::kUndone;
        result.message = "is back in " + back.target;
      }
    }
    results.push_back(std::move(result));
  }
  for (const ActuatorResult& other : s.others) {
    const std::size_t i = *config_.IndexOf(other.name);
    results.push_back(other);
    results.back().state = Of(i).state();
    CorrectIfAway(s, i, results.back());
  }
  std::sort(results.begin(), results.end(), [&](const ActuatorResult& a, const ActuatorResult& b) {
    return config_.IndexOf(a.name) < config_.IndexOf(b.name);
  });
  return results;
}

// An actuator whose part was done, or that was in the target before, may have left it since.
void Decision::CorrectIfAway(const Switch& s, std::size_t i, ActuatorResult& result) const {
  if (result.outcome != ActuatorOutcome::kDone || s.rolling_back) return;
  const auto away = WhyAway(s, i);
  if (!away) return;
  result.outcome = ActuatorOutcome::kLost;
  result.code = away->code;
  result.message = away->message;
}

// The leg whose outcome decides the switch; null when none has failed.
const Leg* Decision::WorstLeg(const Switch& s) const {
  const Leg* worst = nullptr;
  for (const Leg& leg : s.legs) {
    if (!leg.failed()) continue;
    if (worst == nullptr ||
        Badness(leg, Critical(leg.actuator)) > Badness(*worst, Critical(worst->actuator))) {
      worst = &leg;
    }
  }
  return worst;
}

// Whether it is not in the target of a switch of the machine, with a recorded reason. A fault from
// before the switch says nothing about its state.
bool Decision::IsAway(std::size_t i, const State& target) const {
  const ActuatorRecord& record = Of(i);
  if (!record.fault) return false;
  if (record.report.busy()) return true;  // its next state is unknown
  if (record.state() == kTearDown) return target != kTearDown;
  const bool there = record.presence == Presence::kPresent || target == kTearDown;
  return !there || (target == kSelfCheck ? !record.checked : record.state() != target);
}

// The current place of an actuator whose part of the switch was done, or that was already in the
// target, and that has left the target while other actuators were still switching: it has exited,
// and may have been restarted. Empty: it is in the target, or was not expected.
std::string Decision::LeftSince(const Switch& s, std::size_t i) const {
  const ActuatorRecord& record = Of(i);
  if (record.fault || record.held || record.suspended || s.target == kTearDown) return {};
  const bool had_done = std::any_of(s.legs.begin(), s.legs.end(), [&](const Leg& leg) {
    return leg.actuator == i && leg.outcome == ActuatorOutcome::kDone;
  });
  const bool was_there = std::any_of(s.others.begin(), s.others.end(), [&](const auto& other) {
    return other.name == ConfigOf(i).name && other.outcome == ActuatorOutcome::kDone;
  });
  if (!had_done && !was_there) return {};
  if (record.presence != Presence::kPresent) return "its process has exited since; it is starting";
  const bool there = s.direction == Direction::kCheck ? record.checked : record.state() == s.target;
  return there ? "" : "it has switched to " + record.state() + " since, and is being driven back";
}

// The reason why it is not in the target of the switch; nullopt: it is, or was not expected.
std::optional<Error> Decision::WhyAway(const Switch& s, std::size_t i) const {
  if (IsAway(i, s.target)) return Of(i).fault;
  const std::string left = LeftSince(s, i);
  return left.empty() ? std::nullopt : std::optional(Error{kCodeNetError, left});
}

// The first actuator that is away; nullopt when all expected ones are in the target.
std::optional<std::size_t> Decision::FirstAway(const Switch& s) const {
  for (std::size_t i = 0; i < machine_.actuators.size(); ++i) {
    if (WhyAway(s, i)) return i;
  }
  return std::nullopt;
}

SwitchResult Decision::Conclude(const Switch& s, bool undone) const {
  SwitchResult result;
  result.number = s.number;
  result.target = s.target;
  if (s.only) result.actuator = ConfigOf(*s.only).name;
  result.state = s.only ? Of(*s.only).state() : machine_.state;
  result.degraded = Degraded(config_, machine_);
  result.actuators = Results(s);
  if (s.stopped && undone) {
    result.code = kCodeProtectedError;
    result.reason = "an emergency stop was engaged";
  } else if (const Leg* worst = WorstLeg(s)) {
    result.code = worst->code;
    result.reason = ConfigOf(worst->actuator).name + ": " +
                    std::string(OutcomeName(worst->outcome)) + " with " + CodeText(worst->code) +
                    (worst->message.empty() ? "" : ", " + worst->message);
  } else if (const auto away = FirstAway(s); away && !s.only) {
    const Error why = *WhyAway(s, *away);
    result.code = why.code;
    result.reason = ConfigOf(*away).name + ": " + why.message;
  } else if (const Leg* partial = FirstPartial(s)) {
    result.code = partial->code;
    result.reason = ConfigOf(partial->actuator).name + ": " + partial->message;
  }
  if (!undone && EndsKeep(s)) {
    result.reason += (result.reason.empty() ? "" : "; ") +
                     ("the machine is no longer kept in " + machine_.policy.keep->state);
  }
  if (undone) {
    result.outcome = SwitchOutcome::kUndone;
  } else if (result.code != kCodeOk) {
    result.outcome = SwitchOutcome::kDoneDegraded;
  }
  return result;
}

// The first leg whose check has passed as degraded; null when there is none.
const Leg* Decision::FirstPartial(const Switch& s) {
  const auto found = std::find_if(s.legs.begin(), s.legs.end(), [](const Leg& leg) {
    return leg.outcome == ActuatorOutcome::kDone && leg.code != kCodeOk;
  });
  return s.direction == Direction::kCheck && found != s.legs.end() ? &*found : nullptr;
}

// The fault of the first degraded actuator; there is one.
std::string Decision::FirstTrouble() const {
  const std::string name = Degraded(config_, machine_).front();
  return name + ": " + TroubleOf(Of(*config_.IndexOf(name)))->message;
}

void Decision::EndSwitch() {
  const Switch s = *machine_.current;
  machine_.current.reset();
  // Where the only actuator did not switch, nothing was done.
  const bool single_failed = s.only && !s.legs.empty() && s.legs.front().failed();
  const bool undone = s.rolling_back || (single_failed && s.direction != Direction::kCheck);
  if (!undone && !s.only) {
    const bool a_step = !config_.RankOf(machine_.state) || machine_.state == kError;
    if (s.direction != Direction::kCheck || a_step) machine_.state = s.target;
  }
  Apply(s, undone);
  if (undone) SettleBack(s);
  const SwitchResult result = Conclude(s, undone);
  const Leg* worst = undone ? WorstLeg(s) : nullptr;
  const std::uint64_t recorded = RecordEnd(s, result,
                                           "switch " + std::to_string(s.number) + " is " +
                                               std::string(OutcomeName(result.outcome)) +
                                               (result.reason.empty() ? "" : ": " + result.reason),
                                           worst ? Of(worst->actuator).cause : s.cause);
  if (s.purpose == Purpose::kStop) return OnTornDown(result);
  NoteEndOfSwitch(s, undone);
  Answer(s.requests, result);
  const bool torn_down = s.only && s.target == kTearDown && !undone;
  if (torn_down) Degrade(*s.only, kCodeStateInvalid, kTornDownAlone, recorded);
  if (s.purpose == Purpose::kStartUpCheck) return AfterStartUpCheck(recorded);
  if (s.purpose == Purpose::kStartUpActivate && undone) {
    return FailStartUp(result.reason, recorded);
  }
  if (s.only || undone || !config_.RankOf(machine_.state)) return;
  if (machine_.phase == Phase::kStarting || machine_.phase == Phase::kFailed) {
    BecomeRunning("the machine is " + machine_.state +
                      (result.degraded.empty() ? "" : ", degraded: " + FirstTrouble()),
                  recorded);
  }
}

}  // namespace musher
