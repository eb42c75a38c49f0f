// What people, applications and the robot's own buttons ask of the policy. Everything is answered,
// and a refusal says why and what would help.

#include <algorithm>

#include "musher/lifecycle/decision.hpp"

namespace musher {
namespace {

// A year: nothing sensible is kept for longer, and the end of it can be computed with.
constexpr std::int64_t kLongestKeep = std::int64_t{365} * 24 * 3600;

std::string Describe(const event::PolicyRequested& requested) {
  const std::string state = requested.state.substr(0, 64);
  switch (requested.what) {
    case PolicyRequest::kSwitch:
      return "a switch to " + state;
    case PolicyRequest::kKeep:
      return state.empty() ? "the end of a keep"
             : requested.ticks == 0
                 ? "a switch to " + state + ", or the end of a keep"
                 : "to keep " + state + " for " + std::to_string(requested.ticks) + " s";
    case PolicyRequest::kOta:
      return requested.enable ? "to enter OTA" : "to leave OTA";
    case PolicyRequest::kLowPowerSwitch:
    case PolicyRequest::kLowPowerStore:
      return std::string("LowPower by lying still ") + (requested.enable ? "on" : "off") +
             (requested.what == PolicyRequest::kLowPowerStore ? ", for ever" : "");
    case PolicyRequest::kWakeUp:
      return "a wake-up";
    case PolicyRequest::kPowerOff:
      return "power-off";
    case PolicyRequest::kReboot:
      break;
  }
  return "a reboot";
}

}  // namespace

void Decision::On(const event::PolicyRequested& requested) {
  const auto refuse = [&](const Error& why, std::uint64_t asked) {
    if (asked != 0) {
      RecordPolicy(why.code, Describe(requested) + " is refused: " + why.message, asked);
    }
    Do(action::AnswerCall{requested.request, why});
  };
  if (!config_.policy) return refuse({kCodeUnSupport, "the config has no [policy]"}, 0);
  if (machine_.phase == Phase::kIdle) {
    return refuse({kCodeStatusError, "the machine is not set up yet"}, 0);
  }
  const std::uint64_t asked = RecordPolicy(kCodeOk, Describe(requested) + " is asked for");
  if (const auto refusal = Handle(requested, asked)) refuse(*refusal, asked);
}

std::optional<Error> Decision::Handle(const Requested& requested, std::uint64_t asked) {
  if (machine_.phase == Phase::kStopping || machine_.phase == Phase::kStopped) {
    return Error{kCodeStateInvalid, "the machine is torn down; only a new start brings it back"};
  }
  switch (requested.what) {
    case PolicyRequest::kSwitch:
      machine_.policy.calls.push_back(requested.request);
      On(event::SetStateRequested{requested.request, requested.state, std::nullopt});
      return std::nullopt;
    case PolicyRequest::kKeep:
      return HandleKeep(requested, asked);
    case PolicyRequest::kOta:
      return HandleOta(requested, asked);
    case PolicyRequest::kLowPowerSwitch:
    case PolicyRequest::kLowPowerStore:
      return HandleLowPowerSwitch(requested, asked);
    case PolicyRequest::kWakeUp:
      return HandleWakeUp(requested, asked);
    case PolicyRequest::kPowerOff:
    case PolicyRequest::kReboot:
      break;
  }
  return HandlePower(requested, asked);
}

// What most requests wait for the end of.
std::optional<Error> Decision::KeptOrBusy() const {
  if (const auto& keep = machine_.policy.keep) {
    const auto left = std::chrono::ceil<std::chrono::seconds>(keep->until - policy_now()).count();
    return Error{kCodeStateInvalid, "the machine is kept in " + keep->state + " for another " +
                                        std::to_string(left) +
                                        " s; `musher keep --end` ends that before"};
  }
  if (!machine_.current) return std::nullopt;
  return Error{kCodeTargetBusy, "switch " + std::to_string(machine_.current->number) + " (to " +
                                    machine_.current->target + ") is under way"};
}

std::optional<Error> Decision::BeginAsked(const Requested& requested, const State& target,
                                          std::uint64_t asked) {
  const Plan plan = MakePlan(config_, machine_, target);
  if (plan.refusal) return plan.refusal;
  machine_.policy.calls.push_back(requested.request);
  if (target == kTearDown) {
    Stop(plan, {requested.request}, asked);
  } else {
    Begin(plan, Purpose::kRequested, {requested.request}, asked);
  }
  return std::nullopt;
}

// To Active, or as far as the battery allows; the rest comes with the battery.
std::optional<Error> Decision::BeginUp(const Requested& requested, std::uint64_t asked) {
  const State most = CeilingState(config_, BatteryLevel::kFree);
  const State target = UpTo(most);
  if (auto refusal = BeginAsked(requested, target, asked)) return refusal;
  if (target != most) machine_.policy.withheld = Lowering{most, target, 0};
  return std::nullopt;
}

std::optional<Error> Decision::HandleKeep(const Requested& requested, std::uint64_t asked) {
  PolicyState& policy = machine_.policy;
  if (requested.ticks < 0 || requested.ticks > kLongestKeep) {
    return Error{kCodeParametersInvalid, "a keep lasts 0 to " + std::to_string(kLongestKeep) +
                                             " s, not " + std::to_string(requested.ticks) + " s"};
  }
  if (policy.keep && requested.ticks == 0) {
    EndKeep("it is called off");
    Do(action::AnswerCall{requested.request, Ok()});
    return std::nullopt;
  }
  if (requested.ticks == 0 && requested.state.empty()) {
    return Error{kCodeStateInvalid, "nothing keeps the machine in " + machine_.state};
  }
  if (auto blocker = KeptOrBusy()) return blocker;
  if (machine_.state == kOta && requested.state != kOta) {
    return Error{kCodeStateInvalid, "the machine is in OTA; it has to leave that first"};
  }
  if (requested.ticks > 0 && requested.state != kTearDown) {
    // Before the switch: while it is kept, the battery has no say.
    policy.keep = Keep{requested.state, requested.ticks,
                       policy_now() + std::chrono::seconds(requested.ticks), 0};
  }
  const bool there = machine_.state == requested.state &&
                     (requested.state == kOta || requested.state == kLowPower);
  if (there) {
    Do(action::AnswerCall{requested.request, Ok()});
    return std::nullopt;
  }
  if (auto refusal = BeginAsked(requested, requested.state, asked)) {
    policy.keep.reset();
    return refusal;
  }
  if (policy.keep) policy.keep->switch_number = machine_.last_switch;
  return std::nullopt;
}

std::optional<Error> Decision::HandleOta(const Requested& requested, std::uint64_t asked) {
  if (auto blocker = KeptOrBusy()) return blocker;
  const bool inside = machine_.state == kOta;
  if (requested.enable && inside) {
    Do(action::AnswerCall{requested.request, Ok()});
    return std::nullopt;
  }
  if (requested.enable) return BeginAsked(requested, State(kOta), asked);
  if (inside) return BeginUp(requested, asked);
  return Error{kCodeStateInvalid, "the machine is not in OTA, it is in " + machine_.state};
}

bool Decision::InLowPower() const {
  return machine_.state == kLowPower ||
         machine_.state == CeilingState(config_, BatteryLevel::kLowPower);
}

std::optional<Error> Decision::HandleLowPowerSwitch(const Requested& requested,
                                                    std::uint64_t asked) {
  PolicyState& policy = machine_.policy;
  if (!config_.policy->low_power) {
    return Error{kCodeUnSupport, "the config has no [policy.low_power]"};
  }
  const bool off = !requested.enable;
  const bool going_down = machine_.current && machine_.current->target == kLowPower;
  if (off && going_down) return KeptOrBusy();
  policy.low_power = requested.enable;
  if (requested.what == PolicyRequest::kLowPowerStore) {
    policy.stored.low_power = requested.enable;
    Save(Stored::kPolicy);
  }
  // Off also wakes up who rests for another reason than the battery.
  const bool wakes = off && machine_.state == kLowPower && !policy.stored.lowering &&
                     policy.level < BatteryLevel::kLowPower && !KeptOrBusy();
  if (wakes && !BeginUp(requested, asked)) return std::nullopt;
  Do(action::AnswerCall{requested.request, Ok()});
  return std::nullopt;
}

std::optional<Error> Decision::HandleWakeUp(const Requested& requested, std::uint64_t asked) {
  if (auto blocker = KeptOrBusy()) return blocker;
  if (!InLowPower()) {
    return Error{kCodeStateInvalid, "the machine is not in LowPower, it is in " + machine_.state};
  }
  if (machine_.policy.level >= BatteryLevel::kLowPower) {
    return AboveCeiling(config_, machine_.policy, machine_.policy.level);
  }
  return BeginUp(requested, asked);
}

// Answered at once: the robot will not be there to do it later.
std::optional<Error> Decision::HandlePower(const Requested& requested, std::uint64_t asked) {
  const bool reboot = requested.what == PolicyRequest::kReboot;
  const auto& power = machine_.policy.power;
  if (power && power->reboot != reboot) {
    return Error{kCodeTargetBusy, power->reboot ? "the robot is about to reboot"
                                                : "the robot is about to be powered off"};
  }
  if (machine_.policy.keep) return KeptOrBusy();
  const bool updating =
      machine_.state == kOta || (machine_.current && machine_.current->target == kOta);
  if (updating)
    return Error{kCodeStateInvalid, "the machine is in OTA; it has to leave that first"};
  if (!power) BeginPowerDown(reboot, now_ + config_.policy->power.delay, asked);
  Do(action::AnswerCall{requested.request, Ok()});
  return std::nullopt;
}

}  // namespace musher
