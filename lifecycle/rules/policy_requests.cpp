#include "musher/lifecycle/rules/policy_requests.hpp"

#include <utility>

#include "musher/lifecycle/policy/policy.hpp"
#include "musher/lifecycle/refusal.hpp"

namespace musher {
namespace {

// A year: no sensible keep is longer, and its end does not overflow.
constexpr std::int64_t kLongestKeep = std::int64_t{365} * 24 * 3600;

Requester RequesterOf(const event::PolicyRequested& requested) {
  return {requested.by.empty() ? "a request to the policy" : requested.by};
}

// The state that a request for a switch names; empty: it is another request.
State SwitchTargetOf(const event::PolicyRequested& requested) {
  return requested.what == PolicyRequest::kSwitch ? requested.state.Shortened() : State();
}

}  // namespace

std::string Describe(const event::PolicyRequested& requested) {
  const std::string state = requested.state.Shortened();
  switch (requested.what) {
    case PolicyRequest::kSwitch:
      return "switch to " + state;
    case PolicyRequest::kKeep:
      return state.empty() ? "end of the keep"
             : requested.ticks == 0
                 ? "switch to " + state + " or end of the keep"
                 : "keep in " + state + " for " + std::to_string(requested.ticks) + " s";
    case PolicyRequest::kOta:
      return requested.enable ? "OTA entry" : "OTA exit";
    case PolicyRequest::kLowPowerSwitch:
    case PolicyRequest::kLowPowerStore:
      return std::string("automatic LowPower when lying still: ") +
             (requested.enable ? "on" : "off") +
             (requested.what == PolicyRequest::kLowPowerStore ? ", stored," : ",");
    case PolicyRequest::kWakeUp:
      return "wake-up";
    case PolicyRequest::kPowerOff:
      return "power-off";
    case PolicyRequest::kReboot:
      break;
  }
  return "reboot";
}

void PolicyRequests::On(const event::PolicyRequested& requested) {
  const auto refuse = [&](const Error& why, RecordId request_record) {
    if (request_record != 0) {
      RecordPolicy(why.code, texts::PolicyRefused(Describe(requested), why.message),
                   request_record);
    }
    Do(action::AnswerCall{requested.request, why});
  };
  if (!config_.policy) return refuse(Refused<Refusal::kNoPolicy>(), 0);
  if (machine_.phase == Phase::kIdle) {
    return refuse(Refused<Refusal::kNotSetUp>(), 0);
  }
  const RecordId request_record = RecordPolicy(
      kCodeOk,
      texts::PolicyRequested(Describe(requested), SwitchTargetOf(requested), requested.by));
  if (const auto refusal = Handle(requested, request_record)) refuse(*refusal, request_record);
}

std::optional<Error> PolicyRequests::Handle(const Requested& requested, RecordId request_record) {
  if (machine_.phase == Phase::kStopping || machine_.phase == Phase::kStopped) {
    return Refused<Refusal::kMachineTornDown>();
  }
  switch (requested.what) {
    case PolicyRequest::kSwitch:
      machine_.policy.calls.push_back(requested.request);
      requests_.On(event::SetStateRequested{requested.request, requested.state, std::nullopt,
                                            AfterTearDown::kStaysDown, RequesterOf(requested)});
      return std::nullopt;
    case PolicyRequest::kKeep:
      return HandleKeep(requested, request_record);
    case PolicyRequest::kOta:
      return HandleOta(requested, request_record);
    case PolicyRequest::kLowPowerSwitch:
    case PolicyRequest::kLowPowerStore:
      return HandleLowPowerSwitch(requested, request_record);
    case PolicyRequest::kWakeUp:
      return HandleWakeUp(requested, request_record);
    case PolicyRequest::kPowerOff:
    case PolicyRequest::kReboot:
      break;
  }
  return HandlePower(requested, request_record);
}

std::optional<Error> PolicyRequests::HandleKeep(const Requested& requested,
                                                RecordId request_record) {
  PolicyState& policy = machine_.policy;
  if (requested.ticks < 0 || requested.ticks > kLongestKeep) {
    return Refused<Refusal::kKeepOutOfRange>(kLongestKeep, requested.ticks);
  }
  if (policy.keep && requested.ticks == 0) {
    memory_.EndKeep("cancelled");
    Do(action::AnswerCall{requested.request, Ok()});
    return std::nullopt;
  }
  if (requested.ticks == 0 && requested.state.empty()) {
    return Refused<Refusal::kNothingKept>(machine_.state);
  }
  if (auto blocker = KeptOrBusy()) return blocker;
  if (machine_.state == kOta && requested.state != kOta) {
    return Refused<Refusal::kInOta>();
  }
  if (requested.ticks > 0 && requested.state != kTearDown) {
    // Before the switch: while the machine is kept, the battery rule does not apply.
    policy.keep = Keep{requested.state, requested.ticks,
                       policy_now() + std::chrono::seconds(requested.ticks), 0};
  }
  const bool there = machine_.state == requested.state &&
                     (requested.state == kOta || requested.state == kLowPower);
  if (there) {
    Do(action::AnswerCall{requested.request, Ok()});
    return std::nullopt;
  }
  if (auto refusal = BeginRequested(requested, requested.state, request_record)) {
    policy.keep.reset();
    return refusal;
  }
  if (policy.keep) policy.keep->switch_number = machine_.last_switch;
  return std::nullopt;
}

std::optional<Error> PolicyRequests::HandleOta(const Requested& requested,
                                               RecordId request_record) {
  if (auto blocker = KeptOrBusy()) return blocker;
  const bool inside = machine_.state == kOta;
  if (requested.enable && inside) {
    Do(action::AnswerCall{requested.request, Ok()});
    return std::nullopt;
  }
  if (requested.enable) return BeginRequested(requested, State(kOta), request_record);
  if (inside) return BeginUp(requested, request_record);
  return Refused<Refusal::kNotInOta>(machine_.state);
}

std::optional<Error> PolicyRequests::HandleLowPowerSwitch(const Requested& requested,
                                                          RecordId request_record) {
  PolicyState& policy = machine_.policy;
  if (!config_.policy->low_power) {
    return Refused<Refusal::kNoLowPowerPolicy>();
  }
  const bool off = !requested.enable;
  const bool going_down = machine_.current && machine_.current->target == kLowPower;
  if (off && going_down) return KeptOrBusy();
  policy.low_power = requested.enable;
  if (requested.what == PolicyRequest::kLowPowerStore) {
    policy.stored.low_power = requested.enable;
    saver_.Save(Stored::kPolicy);
  }
  // Off also wakes up a machine that is in LowPower for another reason than the battery.
  const bool wakes = off && machine_.state == kLowPower && !policy.stored.lowering &&
                     policy.level < BatteryLevel::kLowPower && !KeptOrBusy();
  if (wakes && !BeginUp(requested, request_record)) return std::nullopt;
  Do(action::AnswerCall{requested.request, Ok()});
  return std::nullopt;
}

std::optional<Error> PolicyRequests::HandleWakeUp(const Requested& requested,
                                                  RecordId request_record) {
  if (auto blocker = KeptOrBusy()) return blocker;
  if (!InLowPower()) {
    return Refused<Refusal::kNotInLowPower>(machine_.state);
  }
  if (machine_.policy.level >= BatteryLevel::kLowPower) {
    return AboveCeiling(config_, machine_.policy, machine_.policy.level);
  }
  return BeginUp(requested, request_record);
}

// Answered at once: later the robot is off. If the command was given already and the robot still
// runs, the command has failed, or takes long: it is given again.
std::optional<Error> PolicyRequests::HandlePower(const Requested& requested,
                                                 RecordId request_record) {
  const bool reboot = requested.what == PolicyRequest::kReboot;
  auto& power = machine_.policy.power;
  if (power && power->reboot != reboot && !power->commanded) {
    return Error{kCodeTargetBusy, AboutToEnd(*power).message};
  }
  if (machine_.policy.keep) return KeptOrBusy();
  const bool updating =
      machine_.state == kOta || (machine_.current && machine_.current->target == kOta);
  if (updating) return Refused<Refusal::kInOta>();
  if (!power) {
    power_.Begin(reboot, now_ + config_.policy->power.delay, request_record,
                 RequesterOf(requested));
  }
  Do(action::AnswerCall{requested.request, Ok()});
  if (std::exchange(power->commanded, false)) {
    power->reboot = reboot;
    power_.Command(false);
  }
  return std::nullopt;
}

// What blocks most requests: a keep, or a switch under way.
std::optional<Error> PolicyRequests::KeptOrBusy() const {
  if (const auto& keep = machine_.policy.keep) {
    const auto left = std::chrono::ceil<std::chrono::seconds>(keep->until - policy_now()).count();
    return Refused<Refusal::kKept>(keep->state, left);
  }
  if (!machine_.current) return std::nullopt;
  return Refused<Refusal::kSwitchUnderWay>(machine_.current->number,
                                           "to " + machine_.current->target);
}

std::optional<Error> PolicyRequests::BeginRequested(const Requested& requested, const State& target,
                                                    RecordId request_record) {
  const Plan plan = MakePlan(config_, machine_, target);
  if (plan.refusal) return plan.refusal;
  machine_.policy.calls.push_back(requested.request);
  if (target == kTearDown) {
    tear_down_.Begin(plan, {requested.request}, request_record, AfterTearDown::kStaysDown,
                     RequesterOf(requested));
  } else {
    switches_.Begin(plan, Purpose::kRequested, {requested.request}, request_record,
                    RequesterOf(requested));
  }
  return std::nullopt;
}

// To Active, or as far as the battery allows; the rest follows when the battery allows it.
std::optional<Error> PolicyRequests::BeginUp(const Requested& requested, RecordId request_record) {
  const State most = CeilingState(config_, BatteryLevel::kFree);
  const State target = rules_.UpTo(most);
  if (auto refusal = BeginRequested(requested, target, request_record)) return refusal;
  if (target != most) machine_.policy.withheld = BatteryFallback{most, target, 0};
  return std::nullopt;
}

bool PolicyRequests::InLowPower() const {
  return machine_.state == kLowPower ||
         machine_.state == CeilingState(config_, BatteryLevel::kLowPower);
}

}  // namespace musher
