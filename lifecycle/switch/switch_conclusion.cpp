#include "musher/lifecycle/switch/switch_conclusion.hpp"

#include <algorithm>
#include <utility>

#include "musher/lifecycle/config/flow.hpp"
#include "musher/lifecycle/record/texts.hpp"

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

SwitchResult SwitchConclusion::Conclude(const Switch& s, bool undone) const {
  SwitchResult result;
  result.number = s.number;
  result.target = s.target;
  if (s.only) result.actuator = ConfigOf(*s.only).name;
  result.state = s.only ? Of(*s.only).state() : view_.state;
  result.degraded = Degraded(config_, view_);
  result.actuators = Results(s);
  if (s.stopped && undone) {
    result.code = kCodeProtectedError;
    result.reason = "an emergency stop was engaged";
  } else if (const Leg* worst = WorstLeg(s)) {
    result.code = worst->code;
    result.reason = ConfigOf(worst->actuator).name + ": " +
                    std::string(OutcomeName(worst->outcome)) + " with " + CodeText(worst->code) +
                    (worst->message.empty() ? "" : ", " + worst->message);
  } else if (const auto away = FirstAway(s)) {
    const Error why = *WhyAway(s, *away);
    result.code = why.code;
    result.reason = ConfigOf(*away).name + ": " + why.message;
  } else if (const Leg* partial = FirstPartial(s)) {
    result.code = partial->code;
    result.reason = ConfigOf(partial->actuator).name + ": " + partial->message;
  }
  if (!undone && EndsKeep(s)) {
    result.reason += (result.reason.empty() ? "" : "; ") +
                     ("the machine is no longer kept in " + view_.policy.keep->state);
  }
  if (undone) {
    result.outcome = SwitchOutcome::kUndone;
  } else if (result.code != kCodeOk) {
    result.outcome = SwitchOutcome::kDoneDegraded;
  }
  return result;
}

std::vector<ActuatorResult> SwitchConclusion::Results(const Switch& s) const {
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
    for (const Leg& back : s.rollback.legs) {
      if (back.actuator != leg.actuator || leg.outcome != ActuatorOutcome::kDone) continue;
      if (back.outcome == ActuatorOutcome::kDone) {
        result.outcome = ActuatorOutcome::kUndone;
        result.message = "is back in " + back.target;
      } else if (back.outcome != ActuatorOutcome::kSkipped) {
        result.outcome = back.outcome;
        result.code = back.code;
        result.message = texts::RollbackFailed(back.target, back.message).message;
      } else if (back.code == kCodeProtectedError) {
        result.message = back.message;
      } else {
        result.message = texts::RollbackFailed(back.target, back.message).message;
      }
    }
    results.push_back(std::move(result));
  }
  for (const ActuatorResult& other : s.others) {
    const ActuatorIndex i = *config_.IndexOf(other.name);
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
void SwitchConclusion::CorrectIfAway(const Switch& s, ActuatorIndex i,
                                     ActuatorResult& result) const {
  if (result.outcome != ActuatorOutcome::kDone || s.rollback.under_way) return;
  const auto away = WhyAway(s, i);
  if (!away) return;
  result.outcome = SecondAbove(s, i) ? ActuatorOutcome::kFailed : ActuatorOutcome::kLost;
  result.code = away->code;
  result.message = away->message;
}

const Leg* SwitchConclusion::WorstLeg(const Switch& s) const {
  const Leg* worst = nullptr;
  for (const Leg& leg : s.legs) {
    if (!leg.failed()) continue;
    if (worst == nullptr || Badness(leg, ConfigOf(leg.actuator).critical) >
                                Badness(*worst, ConfigOf(worst->actuator).critical)) {
      worst = &leg;
    }
  }
  return worst;
}

// The first leg whose check has passed as degraded; null when there is none. No leg has failed.
const Leg* SwitchConclusion::FirstPartial(const Switch& s) {
  const auto found = std::find_if(s.legs.begin(), s.legs.end(),
                                  [](const Leg& leg) { return leg.code != kCodeOk; });
  return s.direction == Direction::kCheck && found != s.legs.end() ? &*found : nullptr;
}

// A second process of it, on another host, is more active than the target: the switch has led only
// the one in use down.
std::optional<Error> SwitchConclusion::SecondAbove(const Switch& s, ActuatorIndex i) const {
  const auto& other = Of(i).other;
  if (!other || (s.only && *s.only != i) || s.direction == Direction::kCheck) return std::nullopt;
  const bool above = s.target == kTearDown || Rises(config_, s.target, other->state) ||
                     (other->busy() && Rises(config_, s.target, other->target));
  return above ? SecondProcessOf(Of(i)) : std::nullopt;
}

// The reason why it is not in the target of the switch; nullopt: it is, or was not expected.
std::optional<Error> SwitchConclusion::WhyAway(const Switch& s, ActuatorIndex i) const {
  if (auto second = SecondAbove(s, i)) return second;
  if (IsAway(i, s.target)) return Of(i).fault;
  const std::string left = LeftSince(s, i);
  return left.empty() ? std::nullopt : std::optional(Error{kCodeNetError, left});
}

// The first actuator that is away; nullopt when all expected ones are in the target. Of a switch of
// one actuator its leg has said whether it is.
std::optional<ActuatorIndex> SwitchConclusion::FirstAway(const Switch& s) const {
  for (const ActuatorIndex i : view_.actuators.Indices()) {
    if (s.only ? SecondAbove(s, i) : WhyAway(s, i)) return i;
  }
  return std::nullopt;
}

// Whether it is not in the target of a switch of the machine, with a recorded reason. A fault from
// before the switch says nothing about its state.
bool SwitchConclusion::IsAway(ActuatorIndex i, const State& target) const {
  const KnownActuator& known = Of(i);
  if (!known.fault) return false;
  if (known.report.busy()) return true;  // its next state is unknown
  if (known.state() == kTearDown) return target != kTearDown;
  const bool there = known.presence == Presence::kPresent || target == kTearDown;
  return !there || (target == kSelfCheck ? !known.checked : known.state() != target);
}

// The current place of an actuator whose part of the switch was done, or that was already in the
// target, and that has left the target while other actuators were still switching: it has exited,
// and may have been restarted. Or the state of an actuator that was lost when the switch began, and
// is back. Empty: it is in the target, or was not expected.
std::string SwitchConclusion::LeftSince(const Switch& s, ActuatorIndex i) const {
  const KnownActuator& known = Of(i);
  if (known.fault || known.held || known.suspended || s.target == kTearDown) return {};
  const bool had_done = std::any_of(s.legs.begin(), s.legs.end(), [&](const Leg& leg) {
    return leg.actuator == i && leg.outcome == ActuatorOutcome::kDone;
  });
  const bool was_there = std::any_of(s.others.begin(), s.others.end(), [&](const auto& other) {
    return other.name == ConfigOf(i).name && other.outcome == ActuatorOutcome::kDone;
  });
  if (!had_done && !was_there) {
    const bool is_back = known.due && known.presence == Presence::kPresent &&
                         !known.restart.requested && s.direction != Direction::kCheck &&
                         known.state() != s.target && ConfigOf(i).Lists(s.target);
    return is_back ? "it is back since, in " + known.state() + ", and follows" : "";
  }
  if (known.presence != Presence::kPresent) return "its process has exited since; it is starting";
  const bool there = s.direction == Direction::kCheck ? known.checked : known.state() == s.target;
  return there ? "" : "it has switched to " + known.state() + " since, and is being driven back";
}

}  // namespace musher
