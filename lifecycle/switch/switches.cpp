#include "musher/lifecycle/switch/switches.hpp"

#include <algorithm>
#include <utility>

#include "musher/lifecycle/config/flow.hpp"
#include "musher/lifecycle/refusal.hpp"

namespace musher {
namespace {

// With less time left a TearDown is not commanded: it would be overdue on arrival.
constexpr Duration kShortestTearDown = Milliseconds(10);

// The requester of a switch that the controller begins by itself.
Requester RequesterOf(Purpose purpose) {
  switch (purpose) {
    case Purpose::kStartUpCheck:
    case Purpose::kStartUpActivate:
      return {"the start of the machine"};
    case Purpose::kFallback:
      return {"the loss of a critical actuator"};
    case Purpose::kPolicy:
      return {kThePolicy};
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

// The legs, sorted so that a leg stands before each leg that it needs.
class Order {
 public:
  Order(const MachineConfig& config, const std::vector<Leg>& legs)
      : legs_(config.actuators.size(), nullptr), seen_(config.actuators.size(), false) {
    for (const Leg& leg : legs) legs_[leg.actuator] = &leg;
    for (const Leg& leg : legs) Visit(leg);
    std::reverse(sorted_.begin(), sorted_.end());
  }

  const std::vector<const Leg*>& sorted() const { return sorted_; }

 private:
  void Visit(const Leg& leg) {
    if (seen_[leg.actuator]) return;
    seen_[leg.actuator] = true;
    for (const ActuatorIndex needed : leg.needs) {
      if (legs_[needed] != nullptr) Visit(*legs_[needed]);
    }
    sorted_.push_back(&leg);
  }

  PerActuator<const Leg*> legs_;
  PerActuator<bool> seen_;
  std::vector<const Leg*> sorted_;
};

// How the actuators of a TearDown share its time. Where their times do not fit into what is left,
// actuators that are torn down one after another each get a part in proportion to their time: an
// actuator that hangs does not use up the time of its successors. Where the times fit, each
// actuator has its whole time.

// For each actuator with a leg: the time of the longest chain of legs that begins with it. In a
// chain each leg waits for the leg before it.
PerActuator<Duration> ChainTimes(const MachineConfig& config, const std::vector<Leg>& legs) {
  PerActuator<Duration> chains(config.actuators.size(), Duration{});
  const Order order(config, legs);
  for (const Leg* leg : order.sorted()) {
    // So far the longest chain behind this leg: the legs that wait for it were handled before.
    Duration& chain = chains[leg->actuator];
    chain += config.TimeFor(leg->actuator, leg->target);
    for (const ActuatorIndex needed : leg->needs) {
      chains[needed] = std::max(chains[needed], chain);
    }
  }
  return chains;
}

// The part of `left` for an actuator that may take `time`, in a chain that may take `chain`.
Duration ShareOf(Duration left, Duration time, Duration chain) {
  if (chain <= left) return time;
  const double part = static_cast<double>(time.count()) / static_cast<double>(chain.count());
  return Duration(static_cast<Duration::rep>(static_cast<double>(left.count()) * part));
}

}  // namespace

std::string Describe(const MachineConfig& config, const State& target,
                     std::optional<ActuatorIndex> only) {
  return (only ? "of " + config.actuators[*only].name + " to " : "to ") + target;
}

CommandNumber Switches::Begin(const Plan& plan, Purpose purpose, std::vector<RequestId> requests,
                              RecordId cause, const Requester& by) {
  Switch s;
  static_cast<SwitchGoal&>(s) = plan;
  s.number = machine_.last_switch = ++machine_.number;
  s.purpose = purpose;
  s.requests = std::move(requests);
  s.cause = cause;
  // What the stop refuses in this switch stays refused after its release.
  s.stopped = machine_.emergency.stop.has_value() && s.direction == Direction::kDown;
  EndWaiting(Refused<Refusal::kSwitchStartedFirst>(s.number, Describe(config_, s.target, s.only)),
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

void Switches::NoteRequester(const Switch& s, const Requester& by) {
  if (s.only) return;
  machine_.requested_by = by.name;
  // A check changes no state, and a TearDown cannot be switched up from.
  const bool stays = config_.RankOf(s.target).has_value();
  if (stays && !by.manager) machine_.standing = StandingRequest{s.target, by.name, s.number};
}

void Switches::AddLeg(Switch& s, const PlanStep& step) {
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
    case PlanStep::Part::kStaysHeld:
      other.outcome = ActuatorOutcome::kSkipped;
      break;
    case PlanStep::Part::kHeldInTarget:
    case PlanStep::Part::kInTarget:
    case PlanStep::Part::kDriven:
      other.message = "was already in that state";
      break;
  }
  s.others.push_back(other);
}

void Switches::PermitSwitchingOn(const Switch& s) {
  if (machine_.emergency.stop) return;
  // A switch of the machine is also for the actuators that it has not reached.
  if (!s.only && SwitchesOnAgain(config_, s.from, s.target)) {
    for (KnownActuator& known : machine_.actuators) known.set_again = true;
  }
  for (const Leg& leg : s.legs) {
    if (SwitchesOnAgain(config_, leg.from, leg.target)) Of(leg.actuator).set_again = true;
  }
}

Switches::Progress Switches::Advance() {
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
bool Switches::StartLegs(std::vector<Leg>& legs) {
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
    const auto needs_one = [&](const auto& is_so) {
      return std::any_of(legs.begin(), legs.end(), [&](const Leg& other) {
        return is_so(other) &&
               std::find(leg.needs.begin(), leg.needs.end(), other.actuator) != leg.needs.end();
      });
    };
    // The legs that this leg needs are skipped first, so that its reason names the failed one.
    const bool waits_to_be_skipped =
        give_up && blocker == nullptr &&
        needs_one([](const Leg& other) { return other.progress == Leg::Progress::kWaiting; });
    if (waits_to_be_skipped) continue;
    if (give_up || blocker != nullptr) {
      SkipLeg(leg, blocker);
      changed = true;
      continue;
    }
    if (needs_one([](const Leg& other) { return other.progress != Leg::Progress::kEnded; }))
      continue;
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
    const bool stays_held = s.rollback.under_way && Of(leg.actuator).held;
    const bool detached =
        stays_held || (s.only.has_value() && !s.rollback.under_way && leg.target != machine_.state);
    commands_.Issue(leg.actuator, s.driven_number(), leg.target, budget, detached);
  }
  return changed;
}

// Why nothing can be sent for `leg` any more: its actuator was present when the switch was planned,
// and was lost or restarted meanwhile, or stopped.
std::optional<CommandResult> Switches::FindUnfit(const Leg& leg) const {
  const KnownActuator& known = Of(leg.actuator);
  if (known.presence != Presence::kPresent) {
    return CommandResult{ActuatorOutcome::kLost, kCodeNetError, texts::NoLongerAvailable(), false};
  }
  // Modules of other protocols do not receive the stop. A switch up is undone as a whole.
  const Switch& s = *machine_.current;
  const bool level = !s.rollback.under_way && s.direction != Direction::kUp;
  // What an emergency stop has switched off waits for a request, also where the machine goes down
  // by itself to the actuator's state or to a higher one. The actuator may begin in a state that
  // a command before this one leads to.
  const bool by_itself = s.purpose == Purpose::kFallback || s.purpose == Purpose::kPolicy;
  const bool held = s.stopped || (by_itself && MustBeSetAgain(machine_, known));
  const auto may_switch_on = [&](const State& from) {
    return MaySwitchOn(config_, from, leg.target);
  };
  const bool switches_on = may_switch_on(leg.from) ||
                           SwitchesOnAgain(config_, leg.from, leg.target) ||
                           std::ranges::any_of(known.BeforeNext(), may_switch_on);
  if (held && level && switches_on && RunsCallback(config_, leg.actuator, leg.from, leg.target)) {
    return CommandResult{ActuatorOutcome::kRefused, kCodeProtectedError,
                         texts::RefusedByEmergencyStop(), false};
  }
  const bool a_step = leg.target == kSelfCheck || leg.target == kTearDown;
  // Its check that is under way ends first; the plan has included it.
  const bool in_check =
      leg.target == kError && known.command && known.command->target == kSelfCheck;
  if (a_step || in_check || known.checked || config_.RankOf(known.state())) return std::nullopt;
  // The leg configures such a node first.
  if (IsUnconfigured(config_, leg.actuator, known)) return std::nullopt;
  return CommandResult{ActuatorOutcome::kSkipped, kCodeSelfCheckFailed, texts::RestartedUnchecked(),
                       false};
}

// The failed leg that `leg` needs, directly or through a skipped leg; null when there is none.
const Leg* Switches::FindBlocker(const Leg& leg, const std::vector<Leg>& legs) const {
  const auto found = std::find_if(legs.begin(), legs.end(), [&](const Leg& other) {
    return other.failed() &&
           std::find(leg.needs.begin(), leg.needs.end(), other.actuator) != leg.needs.end();
  });
  if (found == legs.end()) return nullptr;
  const Leg* cause =
      found->outcome == ActuatorOutcome::kSkipped ? FindBlocker(*found, legs) : nullptr;
  return cause != nullptr ? cause : &*found;
}

// Nothing is sent for `leg`. The failed leg alone decides whether the switch is undone, unless
// `leg` is critical.
void Switches::SkipLeg(Leg& leg, const Leg* blocker) {
  leg.progress = Leg::Progress::kEnded;
  leg.outcome = ActuatorOutcome::kSkipped;
  leg.code = kCodeStatusError;
  Explain(leg, blocker == nullptr ? texts::AnotherFailedFirst()
                                  : texts::NeededOneFailed(ConfigOf(blocker->actuator).name));
  leg.may_fail = !Critical(leg.actuator);
}

// Whether an emergency stop has ended a switch of the machine to another state that is as active:
// it would switch on again what the stop has switched off.
bool Switches::StoppedOnTheLevel(const Switch& s) const {
  const bool level = s.direction == Direction::kLevel && s.from != s.target && !s.only;
  return s.stopped && level && SwitchesOnAgain(config_, s.from, s.target);
}

// Whether the switch has to be undone: on the way up, all actuators or none. During start-up, only
// critical ones count.
bool Switches::Failed(const Switch& s) const {
  const bool starting = s.purpose == Purpose::kStartUpActivate;
  if (StoppedOnTheLevel(s)) return true;
  if (s.direction != Direction::kUp) return false;
  if (s.stopped) return true;
  return std::any_of(s.legs.begin(), s.legs.end(), [&](const Leg& leg) {
    return leg.failed() && !leg.may_fail && (!starting || Critical(leg.actuator));
  });
}

void Switches::BeginRollback(Switch& s) {
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
    } else if (s.stopped && SwitchesOnAgain(config_, back.from, back.target) &&
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

// The state to which a leg is rolled back: its state before. A step of a start is no state to stay
// in: then it is the state of the machine, else DeActive or LowPower. Empty when there is none. An
// actuator that was above the machine does not go up again, nor does an actuator that was above its
// target while the machine was in a step of a start.
State Switches::WayBack(const Leg& leg) const {
  const auto from = config_.RankOf(leg.from);
  const auto place = config_.RankOf(machine_.state);
  const auto target = config_.RankOf(leg.target);
  const bool above = from && (place ? *from > *place : target && *from > *target);
  if (above) {
    const bool lists = place && ConfigOf(leg.actuator).Lists(machine_.state);
    if (lists) return machine_.state;
    return target && *target < *from ? leg.target : leg.from;
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

// --- the end of a switch: its effect on the machine and on each actuator, and its answer ---

EndedSwitch Switches::End() {
  const Switch s = *machine_.current;
  machine_.current.reset();
  // Where the only actuator did not switch, nothing was done.
  const bool failed = s.only && !s.legs.empty() && s.legs.front().failed();
  const bool down = s.only && s.target == kTearDown && Of(*s.only).state() == kTearDown;
  const bool single_failed = failed && !down;
  const bool undone = s.rollback.under_way || (single_failed && s.direction != Direction::kCheck);
  if (!undone && !s.only) {
    const bool a_step = !config_.RankOf(machine_.state) || machine_.state == kError;
    if (s.direction != Direction::kCheck || a_step) machine_.state = s.target;
  }
  Apply(s, undone);
  if (undone) NoteRolledBack(s);
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
  const bool torn_down = down && !failed;
  if (torn_down) Of(*s.only).down_requested = true;
  if (torn_down) Degrade(*s.only, kCodeStateInvalid, texts::TornDownAlone(), recorded);
  return ended;
}

// An emergency stop has undone the switch: after its release a manager may not request it again.
void Switches::StandStill(const Switch& s) {
  const auto& stop = machine_.emergency.stop;
  const std::string by = stop && !stop->by.empty() ? " of " + stop->by : "";
  machine_.standing = StandingRequest{s.from, "the emergency stop" + by, s.number};
}

// The effects of a switch without rollback, or of the forward part of a switch.
void Switches::Apply(const Switch& s, bool undone) {
  const bool check = s.direction == Direction::kCheck;
  for (const Leg& leg : s.legs) {
    KnownActuator& known = Of(leg.actuator);
    if (leg.outcome == ActuatorOutcome::kDone) {
      if (!undone && !check) Hold(s, leg);
      // A person leads it out of Error by a self-check of the machine.
      const bool leads_out = check && !s.only && s.purpose == Purpose::kRequested;
      if (leads_out && known.kept_in == kError) {
        known.kept_in = {};
        known.held = false;
      }
      // An actuator that has passed late is driven to the state of the machine. Before the machine
      // is usable, an actuator after a failed rollback is driven back: the check clears its fault.
      const bool passed = check && known.checked;  // by the present process
      const bool runs = machine_.phase == Phase::kRunning;
      const bool away = runs ? known.state() != machine_.state : IsAbovePlace(leg.actuator);
      if (passed && away && !known.held) known.due = true;
      continue;
    }
    if (check) known.checked = false;
    if (undone && (!leg.ran || s.rollback.under_way)) continue;
    // It was lost while the others switched, is back already, and follows by itself.
    const bool follows = leg.outcome == ActuatorOutcome::kLost && !check && known.due &&
                         known.presence == Presence::kPresent;
    if (follows) continue;
    const bool reported = leg.outcome != ActuatorOutcome::kSkipped;
    Degrade(leg.actuator, leg.code, {leg.event, leg.message}, reported ? known.cause : s.cause);
  }
  if (undone || check || s.only) return;
  if (s.direction == Direction::kUp && s.purpose != Purpose::kStartUpActivate) CheckAgain();
  DriveTheRest(s);
  const bool raises = s.purpose == Purpose::kRequested && s.direction != Direction::kDown;
  for (const ActuatorResult& other : s.others) {
    const ActuatorIndex i = *config_.IndexOf(other.name);
    if (IsKeptBelow(i) && !raises) continue;
    if (!EndsHolds(s) && !Of(i).kept_in.empty()) continue;
    Of(i).kept_in = {};
    const bool was_held = std::exchange(Of(i).held, false);
    const bool away = Of(i).presence == Presence::kLost || Of(i).state() == kTearDown;
    if (was_held && away) FallBack(i);  // from now on its loss counts
    // When the machine stops, only the end of the process counts.
    if (other.outcome == ActuatorOutcome::kUnsupported && s.purpose != Purpose::kStop) {
      Degrade(i, other.code, {EventName::kStateUnsupported, other.message}, s.cause);
    }
  }
}

// What a person holds is led down with the machine by the policy and a fallback, and up by no
// switch of theirs: its hold lasts.
bool Switches::EndsHolds(const Switch& s) {
  return s.purpose != Purpose::kPolicy && s.purpose != Purpose::kFallback;
}

// It has reached the state of the leg, alone or with the machine.
void Switches::Hold(const Switch& s, const Leg& leg) {
  KnownActuator& known = Of(leg.actuator);
  known.held = s.only && leg.target != machine_.state;
  if (known.held) known.due = false;  // as before its check: after the hold it may not be checked
  if (known.held || EndsHolds(s)) {
    known.kept_in = known.held && IsPlace(leg.target) ? leg.target : State();
  }
}

// Checks again each actuator that a switch up has left out because its self-check had failed.
void Switches::CheckAgain() {
  for (KnownActuator& known : machine_.actuators) {
    if (!known.checked && known.failed_checks.count > 0) known.failed_checks.at = now_;
  }
}

// Drives the actuators that were being driven on their own while the switch ran.
void Switches::DriveTheRest(const Switch& s) {
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    KnownActuator& known = Of(i);
    const bool had_a_leg = std::any_of(s.legs.begin(), s.legs.end(),
                                       [&](const Leg& leg) { return leg.actuator == i; });
    if (had_a_leg || known.presence != Presence::kPresent) continue;
    if (!known.checked) {
      commands_.ReportUnchecked(i);
      continue;
    }
    if (!known.fault && known.state() != machine_.state) known.due = true;
  }
}

// The effects of a rollback.
void Switches::NoteRolledBack(const Switch& s) {
  for (const Leg& leg : s.rollback.legs) {
    KnownActuator& known = Of(leg.actuator);
    const bool present = known.presence == Presence::kPresent;
    if (leg.outcome == ActuatorOutcome::kDone) {
      // An actuator that was degraded before is back in its state, and still not in the machine's.
      const bool away = present && known.state() != machine_.state;
      if (!s.only && !known.held && away) known.due = true;
      continue;
    }
    const bool restarted = present && !config_.RankOf(known.state());
    if (restarted && leg.outcome == ActuatorOutcome::kSkipped) continue;  // it is driven on its own
    if (present && leg.outcome == ActuatorOutcome::kSkipped && leg.code == kCodeProtectedError) {
      NoteHeldAfterRollback(s, leg);
      continue;
    }
    Degrade(leg.actuator, leg.code, texts::RollbackFailed(leg.target, leg.message),
            Of(leg.actuator).cause);
    if (!IsComing(leg.actuator)) FallBack(leg.actuator);
  }
}

// The effect on an actuator that is not driven back during an emergency stop. It stays where it is
// also after the release, which starts no callback, until the next switch.
void Switches::NoteHeldAfterRollback(const Switch& s, const Leg& back) {
  const KnownActuator& known = Of(back.actuator);
  const auto forward = std::ranges::find(s.legs, back.actuator, &Leg::actuator);
  if (known.report.busy()) {
    Degrade(back.actuator, back.code, texts::StoppedWhileBusy(known.report.target, s.target),
            machine_.emergency.cause);
  } else if (known.state() != machine_.state && known.state() == s.target) {
    Degrade(back.actuator, back.code, texts::StoppedIn(known.state(), s.target),
            machine_.emergency.cause);
  } else if (forward->failed() && forward->code != kCodeProtectedError) {
    Degrade(back.actuator, forward->code, {forward->event, forward->message}, known.cause);
  }
}

// Ends the switch under way without rollback. Running callbacks finish; the newest command waits
// behind them at the actuator.
void Switches::Supersede(CommandNumber by, const State& target, RecordId cause) {
  const Switch& s = *machine_.current;
  SwitchResult result = conclusion().Conclude(s, false);
  result.outcome = SwitchOutcome::kSuperseded;
  result.code = kCodeTargetBusy;
  result.reason = "switch " + ToString(by) + " (to " + target + ") took over";
  RecordEnd(s, result, cause);
  for (const Leg& leg : s.driven_legs()) {
    if (leg.progress != Leg::Progress::kUnderWay) continue;
    KnownActuator& known = Of(leg.actuator);
    known.Supersede();
    known.free_by = now_ + config_.TimeFor(leg.actuator, leg.target);
  }
  Answer(s.requests, result);
  memory_.OnSuperseded(s);
  machine_.current.reset();
}

void Switches::Refuse(const State& target, std::optional<ActuatorIndex> only,
                      const std::vector<RequestId>& requests, const State& state, const Error& why,
                      RecordId cause) {
  SwitchResult result = RefusedSwitch(target, only ? ConfigOf(*only).name : "", state, why);
  result.degraded = Degraded(config_, machine_);
  RecordSwitch(only, 0, why.code,
               texts::SwitchRefused(Describe(config_, target.Shortened(), only), why.message),
               cause);
  Answer(requests, result);
}

// Ends it without beginning the switch: nothing was sent for it.
void Switches::EndWaiting(const Error& why, RecordId cause) {
  if (!machine_.waiting) return;
  const WaitingSwitch waiting = *std::exchange(machine_.waiting, std::nullopt);
  const State state = waiting.only ? Of(*waiting.only).state() : machine_.state;
  Refuse(waiting.target, waiting.only, waiting.requests, state, why, cause);
}

void Switches::Answer(const std::vector<RequestId>& requests, const SwitchResult& result) {
  for (const RequestId request : requests) {
    if (std::erase(machine_.policy.calls, request) == 0) {
      Do(action::AnswerSetState{request, result});
    } else {
      Do(action::AnswerCall{request, result.done() ? Ok() : Error{result.code, result.reason}});
    }
  }
}

}  // namespace musher
