// A switch: the legs of its plan, each begun when the legs it needs have ended; on the way up a
// rollback when one fails; a result with the outcome of every actuator.

#include <algorithm>
#include <set>

#include "musher/base/suggest.hpp"
#include "musher/lifecycle/decision.hpp"

namespace musher {

int Urgency(const State& target) {
  if (target == kTearDown) return 2;
  return target == kError ? 1 : 0;
}

std::string Describe(const MachineConfig& config, const State& target,
                     std::optional<std::size_t> only) {
  return (only ? "of " + config.actuators[*only].name + " to " : "to ") + target;
}

namespace {

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

}  // namespace

void Decision::On(const event::SetStateRequested& requested) {
  std::optional<std::size_t> only;
  if (requested.actuator) {
    only = config_.IndexOf(*requested.actuator);
    if (!only) {
      const Error unknown{kCodeParametersInvalid, NoSuchActuator(*requested.actuator, config_)};
      // An unknown actuator has no state.
      return Answer({requested.request},
                    Refusal(requested.target, *requested.actuator, "", unknown));
    }
  }
  const std::uint64_t request_record =
      Record({"switch", only, 0, kCodeOk,
              "switch " + Describe(config_, requested.target.substr(0, 64), only) + " requested"});
  if (JoinOrRefuse(requested, only, request_record) || JoinWaiting(requested, only, request_record))
    return;
  const Plan plan = MakePlan(config_, machine_, requested.target, only);
  if (plan.free_by) return Await(plan, requested.request, request_record);
  if (plan.refusal) {
    return Refuse(requested.target, only, {requested.request}, plan.from, *plan.refusal,
                  request_record);
  }
  if (requested.target == kTearDown && !only) {
    return Stop(plan, {requested.request}, request_record, requested.after);
  }
  if (machine_.current) Supersede(machine_.number + 1, requested.target, request_record);
  Begin(plan, Purpose::kRequested, {requested.request}, request_record);
}

void Decision::Refuse(const State& target, std::optional<std::size_t> only,
                      const std::vector<RequestId>& requests, const State& state, const Error& why,
                      std::uint64_t cause) {
  SwitchResult result = Refusal(target, only ? ConfigOf(*only).name : "", state, why);
  result.degraded = Degraded(config_, machine_);
  Record({"switch",
          only,
          0,
          why.code,
          "switch " + Describe(config_, target.substr(0, 64), only) + " refused: " + why.message,
          0,
          cause,
          {}});
  Answer(requests, result);
}

// One switch at a time: the same request joins the switch under way. A more urgent one may take
// over, unless it is of one actuator and would leave the others unfinished. Any other is refused.
// Returns whether the request is handled.
bool Decision::JoinOrRefuse(const event::SetStateRequested& requested,
                            std::optional<std::size_t> only, std::uint64_t request_record) {
  if (!machine_.current) {
    if (machine_.phase != Phase::kStopping || requested.target != kTearDown) return false;
    JoinStop(requested);
    return true;
  }
  Switch& s = *machine_.current;
  if (s.target == requested.target && s.only == only && !s.rolling_back) {
    if (machine_.stopping) {
      JoinStop(requested);
    } else {
      s.requests.push_back(requested.request);
    }
    return true;
  }
  const bool concerns_all = !only || s.only;
  if (concerns_all && Urgency(requested.target) > Urgency(s.target)) return false;
  const Error busy{kCodeTargetBusy, "switch " + std::to_string(s.number) + " (" +
                                        Describe(config_, s.target, s.only) + ") is under way"};
  Refuse(requested.target, only, {requested.request}, machine_.state, busy, request_record);
  return true;
}

// Ends the switch under way without rollback. Running callbacks finish; the newest command waits
// behind them at the actuator.
void Decision::Supersede(std::uint64_t by, const State& target, std::uint64_t cause) {
  const Switch& s = *machine_.current;
  SwitchResult result = Conclude(s, false);
  result.outcome = SwitchOutcome::kSuperseded;
  result.code = kCodeTargetBusy;
  result.reason = "switch " + std::to_string(by) + " (to " + target + ") took over";
  RecordEnd(s, result, "switch " + std::to_string(s.number) + " is superseded: " + result.reason,
            cause);
  for (const Leg& leg : s.rolling_back ? s.back : s.legs) {
    if (leg.progress != Leg::Progress::kUnderWay) continue;
    Of(leg.actuator).command.reset();
    Of(leg.actuator).free_by = now_ + config_.TimeFor(leg.actuator, leg.target);
  }
  Answer(s.requests, result);
  NoteSuperseded(s);
  machine_.current.reset();
}

void Decision::AddLeg(Switch& s, const PlanStep& step) {
  if (step.driven()) {
    Leg leg;
    leg.actuator = step.actuator;
    leg.from = step.from;
    leg.target = s.target;
    leg.needs = step.needs;
    leg.may_fail = Of(step.actuator).fault.has_value() && !Critical(step.actuator);
    s.legs.push_back(leg);
    return;
  }
  ActuatorResult other{
      ConfigOf(step.actuator).name, ActuatorOutcome::kDone, kCodeOk, step.note, {}, {}};
  switch (step.part) {
    case PlanStep::Part::kUnsupported:
      other.outcome = ActuatorOutcome::kUnsupported;
      other.code = kCodeUnSupport;
      break;
    case PlanStep::Part::kLeftOut:
      other.outcome = Of(step.actuator).presence == Presence::kLost ? ActuatorOutcome::kLost
                                                                    : ActuatorOutcome::kSkipped;
      if (Of(step.actuator).fault) other.code = Of(step.actuator).fault->code;
      break;
    case PlanStep::Part::kHeldInTarget:
    case PlanStep::Part::kInTarget:
    case PlanStep::Part::kDriven:
      other.message = "was already in that state";
      break;
  }
  s.others.push_back(other);
}

std::uint64_t Decision::Begin(const Plan& plan, Purpose purpose, std::vector<RequestId> requests,
                              std::uint64_t cause) {
  Switch s;
  s.number = machine_.last_switch = ++machine_.number;
  s.from = plan.from;
  s.target = plan.target;
  s.only = plan.only;
  s.direction = plan.direction;
  s.purpose = purpose;
  s.requests = std::move(requests);
  s.cause = cause;
  EndWaiting({kCodeTargetBusy, "switch " + std::to_string(s.number) + " (" +
                                   Describe(config_, s.target, s.only) + ") started before it"},
             cause);
  for (const PlanStep& step : plan.steps) AddLeg(s, step);
  action::Record begins{"switch",
                        s.only,
                        s.number,
                        kCodeOk,
                        "switch " + std::to_string(s.number) + ": " +
                            (s.only ? ConfigOf(*s.only).name + " " : "") + s.from + " → " +
                            s.target + ", " + std::to_string(s.legs.size()) +
                            (s.legs.size() == 1 ? " actuator" : " actuators"),
                        0,
                        cause,
                        {}};
  begins.of_switch = {s.target, std::nullopt, s.from};
  Record(begins);
  machine_.current = std::move(s);
  return machine_.current->number;
}

// Whether the switch has to be undone: on the way up, all actuators or none. During start-up, only
// critical ones count.
bool Decision::Failed(const Switch& s) const {
  const bool starting = s.purpose == Purpose::kStartUpActivate;
  if (s.direction != Direction::kUp) return false;
  if (s.stopped) return true;
  return std::any_of(s.legs.begin(), s.legs.end(), [&](const Leg& leg) {
    return leg.failed() && !leg.may_fail && (!starting || Critical(leg.actuator));
  });
}

// A leg that `leg` needs and that has ended otherwise than done; null when there is none.
const Leg* Decision::FindBlocker(const Leg& leg, const std::vector<Leg>& legs) const {
  const auto found = std::find_if(legs.begin(), legs.end(), [&](const Leg& other) {
    return other.failed() &&
           std::find(leg.needs.begin(), leg.needs.end(), other.actuator) != leg.needs.end();
  });
  return found == legs.end() ? nullptr : &*found;
}

// Nothing is sent for `leg`. A leg that is blocked by one that may fail may fail, too.
void Decision::SkipLeg(Leg& leg, const Leg* blocker) {
  leg.progress = Leg::Progress::kEnded;
  leg.outcome = ActuatorOutcome::kSkipped;
  leg.code = kCodeStatusError;
  leg.message = blocker == nullptr ? "another actuator failed first"
                                   : "needs " + ConfigOf(blocker->actuator).name + ", which failed";
  if (blocker != nullptr && blocker->may_fail && !Critical(leg.actuator)) leg.may_fail = true;
}

// Why nothing can be sent for `leg` any more: its actuator was present when the switch was planned,
// and was lost or restarted meanwhile.
std::optional<CommandResult> Decision::FindUnfit(const Leg& leg) const {
  const ActuatorRecord& record = Of(leg.actuator);
  if (record.presence != Presence::kPresent) {
    return CommandResult{ActuatorOutcome::kLost, kCodeNetError, "is no longer available", false};
  }
  const bool a_step = leg.target == kSelfCheck || leg.target == kTearDown;
  if (a_step || record.checked || config_.RankOf(record.state())) return std::nullopt;
  // The leg configures such a node first.
  if (IsUnconfigured(config_, leg.actuator, record)) return std::nullopt;
  return CommandResult{ActuatorOutcome::kSkipped, kCodeSelfCheckFailed,
                       "was restarted and has not passed its self-check", false};
}

// The remaining time for TearDown, in equal parts for the remaining stages: an actuator that hangs
// does not use the time of those that are torn down after it.
Duration Decision::TearDownShare(const Leg& leg) const {
  std::set<int> stages = {ConfigOf(leg.actuator).stage};
  for (const Leg& other : machine_.current->legs) {
    const int stage = ConfigOf(other.actuator).stage;
    if (stage < ConfigOf(leg.actuator).stage) stages.insert(stage);
  }
  return (machine_.stopping->tear_down_by - now_) / static_cast<int>(stages.size());
}

// Begins the legs whose needs have ended. Returns whether anything changed without an event.
bool Decision::StartLegs(std::vector<Leg>& legs) {
  Switch& s = *machine_.current;
  const bool give_up = !s.rolling_back && Failed(s);
  const bool strict = !s.rolling_back && s.direction == Direction::kUp;
  bool changed = false;
  for (Leg& leg : legs) {
    if (leg.progress != Leg::Progress::kWaiting) continue;
    if (const auto unfit = FindUnfit(leg)) {
      EndLeg(leg, *unfit);
      leg.duration = {};
      changed = true;
      continue;
    }
    const Leg* blocker = strict ? FindBlocker(leg, legs) : nullptr;
    if (give_up || blocker != nullptr) {
      SkipLeg(leg, blocker);
      changed = true;
      continue;
    }
    const bool ready = std::all_of(legs.begin(), legs.end(), [&](const Leg& other) {
      return other.progress == Leg::Progress::kEnded ||
             std::find(leg.needs.begin(), leg.needs.end(), other.actuator) == leg.needs.end();
    });
    if (!ready) continue;
    Duration budget = config_.TimeFor(leg.actuator, leg.target);
    if (machine_.stopping) {
      budget = std::clamp(TearDownShare(leg), Duration(1), std::max(budget, Duration(1)));
    }
    leg.progress = Leg::Progress::kUnderWay;
    leg.started = now_;
    const bool apart = s.only.has_value() && !s.rolling_back && leg.target != machine_.state;
    Issue(leg.actuator, s.rolling_back ? s.back_number : s.number, leg.target, budget, apart);
  }
  return changed;
}

// Returns whether a change may let other actuators proceed.
bool Decision::AdvanceSwitch() {
  if (!machine_.current) return false;
  if (WaitsForIntent()) return false;
  Switch& s = *machine_.current;
  std::vector<Leg>& legs = s.rolling_back ? s.back : s.legs;
  while (StartLegs(legs)) {
  }
  const bool ended = std::all_of(legs.begin(), legs.end(), [](const Leg& leg) {
    return leg.progress == Leg::Progress::kEnded;
  });
  if (!ended) return false;
  if (!s.rolling_back && Failed(s)) {
    BeginRollback(s);
  } else {
    EndSwitch();
  }
  return true;
}

void Decision::EndLeg(Leg& leg, const CommandResult& end) {
  leg.progress = Leg::Progress::kEnded;
  leg.outcome = end.outcome;
  leg.code = end.code;
  leg.message = end.message;
  leg.ran = end.ran;
  leg.duration = now_ - leg.started;
}

// The state to which a leg is rolled back: its state before; from a step of a start, where an
// actuator cannot stay, the state of the machine, or the nearest of DeActive and LowPower. Empty
// when there is none. An actuator that was above the machine does not go up again; nor does one
// that was above its target while the machine was in a step of a start.
State Decision::WayBack(const Leg& leg) const {
  const auto from = config_.RankOf(leg.from);
  const auto place = config_.RankOf(machine_.state);
  const auto target = config_.RankOf(leg.target);
  const bool above = from && (place ? *from > *place : target && *from > *target);
  if (above) {
    const bool lists = place && ConfigOf(leg.actuator).Lists(machine_.state);
    return lists ? machine_.state : leg.target;
  }
  if (from) return leg.from;
  const bool to_machine = config_.RankOf(machine_.state) && machine_.state != kError;
  if (to_machine && ConfigOf(leg.actuator).Lists(machine_.state)) return machine_.state;
  for (const std::string_view rest : {kDeActive, kLowPower}) {
    const bool higher = target && *config_.RankOf(rest) > *target;
    if (!higher && ConfigOf(leg.actuator).Lists(rest)) return State(rest);
  }
  return {};
}

void Decision::BeginRollback(Switch& s) {
  s.rolling_back = true;
  s.back_number = ++machine_.number;
  for (const Leg& leg : s.legs) {
    if (!leg.ran || Of(leg.actuator).presence != Presence::kPresent) continue;
    // It was unconfigured before the switch.
    if (leg.failed() && leg.from == config_.default_state &&
        IsUnconfigured(config_, leg.actuator, Of(leg.actuator))) {
      continue;
    }
    Leg back;
    back.actuator = leg.actuator;
    back.from = leg.target;
    back.target = WayBack(leg);
    if (back.target.empty()) {
      back.progress = Leg::Progress::kEnded;
      back.outcome = ActuatorOutcome::kUnsupported;
      back.code = kCodeUnSupport;
      back.message = "has no state to go back to";
    }
    for (const Leg& other : s.legs) {  // the reverse order
      if (std::find(other.needs.begin(), other.needs.end(), leg.actuator) == other.needs.end())
        continue;
      back.needs.push_back(other.actuator);
    }
    s.back.push_back(back);
  }
  const Leg* worst = WorstLeg(s);
  RecordSwitch(s, kCodeOk,
               "switch " + std::to_string(s.number) + ": rolling back with command " +
                   std::to_string(s.back_number) + ", " + std::to_string(s.back.size()) +
                   (s.back.size() == 1 ? " actuator" : " actuators"),
               s.stopped || worst == nullptr ? machine_.stop_cause : Of(worst->actuator).cause);
}

void Decision::Answer(const std::vector<RequestId>& requests, const SwitchResult& result) {
  for (const RequestId request : requests) {
    if (std::erase(machine_.policy.calls, request) == 0) {
      Do(action::AnswerSetState{request, result});
    } else {
      Do(action::AnswerCall{request, result.done() ? Ok() : Error{result.code, result.reason}});
    }
  }
}

}  // namespace musher
