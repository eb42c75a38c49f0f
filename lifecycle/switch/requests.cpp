#include "musher/lifecycle/switch/requests.hpp"

#include <algorithm>
#include <utility>

#include "musher/lifecycle/config/flow.hpp"
#include "musher/lifecycle/refusal.hpp"
#include "musher/lifecycle/step/emergency_stops.hpp"

namespace musher {
namespace {

// After its deadline an actuator is queried for the outcome: by then that is known.
constexpr Duration kAnswered = kQueryTimeout * kQueryAttempts + Milliseconds(100);
// A request does not move the robot long after it was made.
constexpr Duration kLeadsWithin = Milliseconds(10'000);

// TearDown before Error before the rest.
int Urgency(const State& target) {
  if (target == kTearDown) return 2;
  return target == kError ? 1 : 0;
}

// Whether a requested switch is more urgent than another one. A switch of one actuator keeps
// neither Error nor TearDown of the machine waiting.
bool TakesOver(const State& target, const std::optional<ActuatorIndex>& only, const State& other,
               const std::optional<ActuatorIndex>& other_only) {
  const int urgency = Urgency(target);
  return urgency > Urgency(other) || (urgency > 0 && !only && other_only);
}

}  // namespace

std::optional<Error> RefusalOfManager(const MachineConfig& config, const Machine& machine,
                                      const State& target) {
  const auto& standing = machine.standing;
  const auto wanted = config.RankOf(target);
  const bool above_standing = standing && wanted && wanted > config.RankOf(standing->target) &&
                              wanted > config.RankOf(machine.state);
  if (above_standing) {
    const std::string which =
        standing->number == 0 ? "" : " (switch " + ToString(standing->number) + ")";
    return Refused<Refusal::kRequestedByAnother>(
        standing->target, standing->by.empty() ? "a client without a name" : standing->by, which,
        target);
  }
  const EmergencyStopState& emergency = machine.emergency;
  const bool switches_on =
      MaySwitchOn(config, machine.state, target) || SwitchesOnAgain(config, machine.state, target);
  if (!switches_on) return std::nullopt;
  if (emergency.awaits_request) return Refused<Refusal::kStopAwaitsPerson>(target);
  if (const UnreadFolder* unread = emergency.Unanswered()) {
    return Refused<Refusal::kStopsUnread>(unread->folder, WhyUnread(*unread), target);
  }
  return std::nullopt;
}

void Requests::On(const event::SetStateRequested& requested) {
  std::optional<ActuatorIndex> only;
  if (requested.actuator) {
    only = config_.IndexOf(*requested.actuator);
    if (!only) {
      // An unknown actuator has no state.
      return switches_.Answer({requested.request},
                              RefusedSwitch(requested.target, *requested.actuator, "",
                                            UnknownActuator(*requested.actuator, config_)));
    }
  }
  const State target = requested.target.Shortened();
  const RecordId request_record = RecordSwitch(
      only, 0, kCodeOk,
      texts::SwitchRequested(Describe(config_, target, only), target, requested.by.name));
  if (const auto overridden = Overridden(requested.by, only, target)) {
    return switches_.Refuse(requested.target, only, {requested.request}, machine_.state,
                            *overridden, request_record);
  }
  if (JoinOrRefuse(requested, only, request_record) || JoinWaiting(requested, only, request_record))
    return;
  Plan plan = MakePlan(config_, machine_, requested.target, only);
  if (CheckDegraded(plan)) plan = MakePlan(config_, machine_, requested.target, only);
  if (plan.free_by) return Await(plan, *plan.free_by + kAnswered, requested, request_record);
  const bool may_come_later = config_.HasState(target) && (target != kTearDown || only);
  if (plan.refusal && may_come_later && IsAboutToLead()) {
    return Await(plan, now_ + kLeadsWithin, requested, request_record);
  }
  if (plan.refusal) {
    return switches_.Refuse(requested.target, only, {requested.request}, plan.from, *plan.refusal,
                            request_record);
  }
  if (requested.target == kTearDown && !only) {
    return tear_down_.Begin(plan, {requested.request}, request_record, requested.after,
                            requested.by);
  }
  if (machine_.current) switches_.Supersede(machine_.number + 1, requested.target, request_record);
  switches_.Begin(plan, Purpose::kRequested, {requested.request}, request_record, requested.by);
}

std::optional<Error> Requests::Overridden(const Requester& by, std::optional<ActuatorIndex> only,
                                          const State& target) const {
  return by.manager && !only ? RefusalOfManager(config_, machine_, target) : std::nullopt;
}

// One switch at a time: the same request joins the switch under way. A more urgent one may take
// over, unless it is of one actuator and would leave the others unfinished. Any other is refused.
// Returns whether the request is handled.
bool Requests::JoinOrRefuse(const event::SetStateRequested& requested,
                            std::optional<ActuatorIndex> only, RecordId request_record) {
  if (!machine_.current) {
    if (machine_.phase != Phase::kStopping || requested.target != kTearDown) return false;
    tear_down_.Join(requested);
    return true;
  }
  Switch& s = *machine_.current;
  if (s.target == requested.target && s.only == only && !s.rollback.under_way) {
    if (machine_.stopping) {
      tear_down_.Join(requested);
    } else {
      s.requests.push_back(requested.request);
      switches_.PermitSwitchingOn(s);
      if (!requested.by.manager) switches_.NoteRequester(s, requested.by);
    }
    return true;
  }
  if ((!only || s.only) && TakesOver(requested.target, only, s.target, s.only)) return false;
  switches_.Refuse(requested.target, only, {requested.request}, machine_.state,
                   Refused<Refusal::kSwitchUnderWay>(s.number, Describe(config_, s.target, s.only)),
                   request_record);
  return true;
}

// As with a switch under way: the same request joins the waiting one, a more urgent one goes on to
// take over, any other is refused. Returns whether the request is handled.
bool Requests::JoinWaiting(const event::SetStateRequested& requested,
                           std::optional<ActuatorIndex> only, RecordId request_record) {
  if (!machine_.waiting) return false;
  WaitingSwitch& waiting = *machine_.waiting;
  if (waiting.target == requested.target && waiting.only == only) {
    waiting.requests.push_back(requested.request);
    if (!requested.by.manager) waiting.by = requested.by;
    return true;
  }
  if (!only && TakesOver(requested.target, only, waiting.target, waiting.only)) return false;
  switches_.Refuse(requested.target, only, {requested.request}, machine_.state,
                   Refused<Refusal::kSwitchWaiting>(Describe(config_, waiting.target, waiting.only),
                                                    ToMilliseconds(waiting.until - now_)),
                   request_record);
  return true;
}

// Before a switch up out of a state of rest, actuators whose last self-check has passed as degraded
// are checked again; the switch waits for that. Returns whether any is checked.
bool Requests::CheckDegraded(const Plan& plan) {
  const bool up = !plan.refusal && !plan.only && plan.direction == Direction::kUp;
  if (!up || machine_.current || machine_.phase != Phase::kRunning) return false;
  bool any = false;
  for (const PlanStep& step : plan.steps) {
    if (!step.driven() || !IsCheckDue(step.actuator)) continue;
    commands_.Issue(step.actuator, machine_.number + 1, State(kSelfCheck),
                    config_.TimeFor(step.actuator, kSelfCheck));
    any = true;
  }
  return any;
}

// Whether this start leads on what an earlier controller has left, and is not there yet: after a
// fail-over it waits a while for the host that is gone. During an emergency stop no request waits:
// it would be from before the release. Nor in a start that a program drives: its requests are the
// steps of the start.
bool Requests::IsAboutToLead() const {
  const StartUpState& start_up = machine_.start_up;
  if (machine_.phase != Phase::kStarting || start_up.set_up || start_up.finishing) return false;
  if (start_up.by_hand) return false;
  if (machine_.emergency.stop) return false;
  return std::ranges::any_of(machine_.actuators, [this](const KnownActuator& known) {
    const bool is_found = known.process.launch == Launch::kFoundRunning;
    return is_found && (known.report.incarnation == 0 || config_.RankOf(known.report.state));
  });
}

void Requests::Await(const Plan& plan, Time until, const event::SetStateRequested& requested,
                     RecordId request_record) {
  switches_.EndWaiting(Refused<Refusal::kSwitchWaiting>(Describe(config_, plan.target, plan.only),
                                                        ToMilliseconds(until - now_)),
                       request_record);
  machine_.waiting = WaitingSwitch{plan.target,         plan.only,      until,
                                   {requested.request}, request_record, requested.by};
  machine_.waiting->cause =
      RecordSwitch(plan.only, 0, kCodeOk,
                   texts::SwitchWaiting(Describe(config_, plan.target, plan.only), until - now_,
                                        plan.refusal->message),
                   request_record);
}

bool Requests::BeginWaiting() {
  if (!machine_.waiting) return false;
  const Plan plan = MakePlan(config_, machine_, machine_.waiting->target, machine_.waiting->only);
  if ((plan.free_by || IsAboutToLead()) && now_ < machine_.waiting->until) return false;
  // Only now it may be known from where this controller leads on.
  const auto overridden = Overridden(machine_.waiting->by, plan.only, plan.target);
  if (plan.refusal || overridden) {
    switches_.EndWaiting(plan.refusal ? *plan.refusal : *overridden, machine_.waiting->cause);
    return true;
  }
  const WaitingSwitch waiting = *std::exchange(machine_.waiting, std::nullopt);
  switches_.Begin(plan, Purpose::kRequested, waiting.requests, waiting.cause, waiting.by);
  return true;
}

}  // namespace musher
