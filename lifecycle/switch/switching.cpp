#include "musher/lifecycle/switch/switching.hpp"

#include <algorithm>
#include <utility>

#include "musher/lifecycle/config/flow.hpp"
#include "musher/lifecycle/switch/tear_down_share.hpp"

namespace musher {
namespace {

// With less time left a TearDown is not commanded: it would be overdue on arrival.
constexpr Duration kShortestTearDown = Milliseconds(10);

// Of a switch that the controller begins by itself.
Requester RequesterOf(Purpose purpose) {
  switch (purpose) {
    case Purpose::kStartUpCheck:
    case Purpose::kStartUpActivate:
      return {"the start of the machine"};
    case Purpose::kFallback:
      return {"the loss of a critical actuator"};
    case Purpose::kPolicy:
      return {"the policy"};
    case Purpose::kRequested:
    case Purpose::kStop:
      break;
  }
  return {};
}

void Explain(Leg& leg, const RecordText& text) {
  leg.message = text.message;
  leg.event = text.event;
}

}  // namespace

std::string Describe(const MachineConfig& config, const State& target,
                     std::optional<ActuatorIndex> only) {
  return (only ? "of " + config.actuators[*only].name + " to " : "to ") + target;
}

CommandNumber Switching::Begin(const Plan& plan, Purpose purpose, std::vector<RequestId> requests,
                               RecordId cause, const Requester& by) {
  Switch s;
  static_cast<SwitchGoal&>(s) = plan;
  s.number = machine_.last_switch = ++machine_.number;
  s.purpose = purpose;
  s.requests = std::move(requests);
  s.cause = cause;
  EndWaiting({kCodeTargetBusy, "switch " + ToString(s.number) + " (" +
                                   Describe(config_, s.target, s.only) + ") started before it"},
             cause);
  for (const PlanStep& step : plan.steps) AddLeg(s, step);
  if (purpose == Purpose::kRequested) PermitSwitchingOn(s);
  RecordBegin(s, cause);
  NoteRequester(s, purpose == Purpose::kRequested || !by.name.empty() ? by : RequesterOf(purpose));
  const bool starts = purpose == Purpose::kStartUpCheck || purpose == Purpose::kStartUpActivate;
  if (starts) machine_.requested_by.clear();  // the usual case needs no name in the status
  machine_.current = std::move(s);
  return machine_.current->number;
}

void Switching::NoteRequester(const Switch& s, const Requester& by) {
  if (s.only) return;
  machine_.requested_by = by.name;
  // A check changes no state, and a TearDown cannot be switched up from.
  const bool stays = config_.RankOf(s.target).has_value();
  if (stays && !by.manager) machine_.standing = StandingRequest{s.target, by.name, s.number};
}

void Switching::AddLeg(Switch& s, const PlanStep& step) {
  if (step.driven()) {
    Leg leg;
    static_cast<ActuatorGoal&>(leg) = step;
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

void Switching::PermitSwitchingOn(const Switch& s) {
  if (machine_.emergency.stop) return;
  for (const Leg& leg : s.legs) {
    if (SwitchesOnAgain(config_, leg.from, leg.target)) Of(leg.actuator).set_again = true;
  }
}

Switching::Progress Switching::Advance() {
  if (!machine_.current) return {};
  Switch& s = *machine_.current;
  std::vector<Leg>& legs = s.driven_legs();
  while (StartLegs(legs)) {
  }
  const bool ended = std::all_of(legs.begin(), legs.end(), [](const Leg& leg) {
    return leg.progress == Leg::Progress::kEnded;
  });
  if (!ended) return {};
  if (s.rollback.under_way || !Failed(s)) return {true, End()};
  BeginRollback(s);
  return {true};
}

// Begins the legs whose needs have ended. Returns whether anything changed without an event.
bool Switching::StartLegs(std::vector<Leg>& legs) {
  Switch& s = *machine_.current;
  const bool give_up = !s.rollback.under_way && Failed(s);
  const bool strict = !s.rollback.under_way && s.direction == Direction::kUp;
  bool changed = false;
  PerActuator<Duration> chains;  // of TearDown, once they are needed
  for (Leg& leg : legs) {
    if (leg.progress != Leg::Progress::kWaiting) continue;
    if (const auto unfit = FindUnfit(leg)) {
      EndLeg(leg, *unfit, now_);
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
      const Duration left = machine_.stopping->tear_down_by - now_;
      if (left < kShortestTearDown) {
        EndLeg(leg, {ActuatorOutcome::kSkipped, kCodeTimeout, texts::BudgetUsedUp(), false}, now_);
        leg.duration = {};
        changed = true;
        continue;
      }
      if (chains.empty()) chains = ChainTimes(config_, legs);
      budget = std::max(ShareOf(left, budget, chains[leg.actuator]), Duration(1));
    }
    leg.progress = Leg::Progress::kUnderWay;
    leg.started = now_;
    const bool detached =
        s.only.has_value() && !s.rollback.under_way && leg.target != machine_.state;
    commands_.Issue(leg.actuator, s.driven_number(), leg.target, budget, detached);
  }
  return changed;
}

// Why nothing can be sent for `leg` any more: its actuator was present when the switch was planned,
// and was lost or restarted meanwhile, or stopped.
std::optional<CommandResult> Switching::FindUnfit(const Leg& leg) const {
  const ActuatorRecord& record = Of(leg.actuator);
  if (record.presence != Presence::kPresent) {
    return CommandResult{ActuatorOutcome::kLost, kCodeNetError, texts::NoLongerAvailable(), false};
  }
  // Modules of other protocols do not receive the stop. A switch up is undone as a whole.
  const Switch& s = *machine_.current;
  const bool level = !s.rollback.under_way && s.direction != Direction::kUp;
  if (s.stopped && level && SwitchesOnAgain(config_, leg.from, leg.target) &&
      RunsCallback(config_, leg.actuator, leg.from, leg.target)) {
    return CommandResult{ActuatorOutcome::kRefused, kCodeProtectedError,
                         texts::RefusedByEmergencyStop(), false};
  }
  const bool a_step = leg.target == kSelfCheck || leg.target == kTearDown;
  // Its check that is under way ends first; the plan has included it.
  const bool in_check =
      leg.target == kError && record.command && record.command->target == kSelfCheck;
  if (a_step || in_check || record.checked || config_.RankOf(record.state())) return std::nullopt;
  // The leg configures such a node first.
  if (IsUnconfigured(config_, leg.actuator, record)) return std::nullopt;
  return CommandResult{ActuatorOutcome::kSkipped, kCodeSelfCheckFailed, texts::RestartedUnchecked(),
                       false};
}

// A leg that `leg` needs and that has ended otherwise than done; null when there is none.
const Leg* Switching::FindBlocker(const Leg& leg, const std::vector<Leg>& legs) const {
  const auto found = std::find_if(legs.begin(), legs.end(), [&](const Leg& other) {
    return other.failed() &&
           std::find(leg.needs.begin(), leg.needs.end(), other.actuator) != leg.needs.end();
  });
  return found == legs.end() ? nullptr : &*found;
}

// Nothing is sent for `leg`. The leg that has failed decides whether the switch is undone, unless
// this one is critical.
void Switching::SkipLeg(Leg& leg, const Leg* blocker) {
  leg.progress = Leg::Progress::kEnded;
  leg.outcome = ActuatorOutcome::kSkipped;
  leg.code = kCodeStatusError;
  Explain(leg, blocker == nullptr ? texts::AnotherFailedFirst()
                                  : texts::NeededOneFailed(ConfigOf(blocker->actuator).name));
  leg.may_fail = !Critical(leg.actuator);
}

// Whether an emergency stop has ended a switch of the machine to another state that is as active:
// it would switch on again what the stop has switched off.
bool Switching::StoppedOnTheLevel(const Switch& s) const {
  const bool level = s.direction == Direction::kLevel && s.from != s.target && !s.only;
  return s.stopped && level && SwitchesOnAgain(config_, s.from, s.target);
}

// Whether the switch has to be undone: on the way up, all actuators or none. During start-up, only
// critical ones count.
bool Switching::Failed(const Switch& s) const {
  const bool starting = s.purpose == Purpose::kStartUpActivate;
  if (StoppedOnTheLevel(s)) return true;
  if (s.direction != Direction::kUp) return false;
  if (s.stopped) return true;
  return std::any_of(s.legs.begin(), s.legs.end(), [&](const Leg& leg) {
    return leg.failed() && !leg.may_fail && (!starting || Critical(leg.actuator));
  });
}

void Switching::BeginRollback(Switch& s) {
  s.rollback.under_way = true;
  s.rollback.number = ++machine_.number;
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
      Explain(back, texts::NoStateToGoBackTo());
    } else if (StoppedOnTheLevel(s) && SwitchesOnAgain(config_, back.from, back.target) &&
               RunsCallback(config_, back.actuator, back.from, back.target)) {
      back.progress = Leg::Progress::kEnded;  // the way back may switch on, too
      back.outcome = ActuatorOutcome::kSkipped;
      back.code = kCodeProtectedError;
      Explain(back, texts::NotDrivenBack());
    }
    for (const Leg& other : s.legs) {  // the reverse order
      if (std::find(other.needs.begin(), other.needs.end(), leg.actuator) == other.needs.end())
        continue;
      back.needs.push_back(other.actuator);
    }
    s.rollback.legs.push_back(back);
  }
  const auto driven = std::ranges::count(s.rollback.legs, Leg::Progress::kWaiting, &Leg::progress);
  const Leg* worst = conclusion().WorstLeg(s);
  RecordSwitch(
      s.only, s.number, kCodeOk,
      texts::RollbackStarted(s.number, s.rollback.number, static_cast<std::size_t>(driven)),
      s.stopped || worst == nullptr ? machine_.emergency.cause : Of(worst->actuator).cause);
}

// The state to which a leg is rolled back: its state before; from a step of a start, where an
// actuator cannot stay, the state of the machine, or the nearest of DeActive and LowPower. Empty
// when there is none. An actuator that was above the machine does not go up again; nor does one
// that was above its target while the machine was in a step of a start.
State Switching::WayBack(const Leg& leg) const {
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

}  // namespace musher
