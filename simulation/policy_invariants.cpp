// The invariants of the policy. They go by the samples of the battery alone, not by the level that
// the controller derives from them.

#include <algorithm>
#include <utility>

#include "musher/simulation/checker.hpp"

#include "musher/lifecycle/policy/policy.hpp"

namespace musher::simulation {
namespace {

// For the event loop and the network.
constexpr Duration kPowerSlack = std::chrono::seconds(1);

// The highest rank that the battery permits, without hysteresis.
std::optional<Rank> MostAt(const BatteryPolicy& policy, int percent, bool charging) {
  if (percent <= policy.low_power_at && !charging) return BuiltInRank(kLowPower);
  if (percent <= policy.protected_at) return BuiltInRank(kProtected);
  return std::nullopt;
}

State TargetOf(const action::Record& record) {
  return State(ArgumentOf(record.arguments, "target"));
}

std::optional<int> PercentOf(const action::Record& record) {
  const Argument* percent = FindArgument(record.arguments, "percent");
  if (percent == nullptr) return std::nullopt;
  return static_cast<int>(std::get<std::int64_t>(percent->value));
}

}  // namespace

// Checked as soon as nothing else is under way. `at_rest`: the stored policy must be loaded by
// then.
void Checker::CheckCeiling(const Machine& machine, bool at_rest) {
  const PolicyState& policy = machine.policy;
  const bool waits = machine.current || machine.fallback.target || policy.keep || policy.power ||
                     machine.state == kOta || (!at_rest && !policy.loaded);
  if (!config_.policy || !config_.policy->battery || !policy.battery) return;
  NoteLevels(*config_.policy->battery, *policy.battery);
  const auto rank = config_.RankOf(machine.state);
  if (waits || machine.phase != Phase::kRunning || !rank) return;
  const auto most = MostAt(*config_.policy->battery, *policy.battery, policy.charging);
  if (!most || *rank <= *most) return;
  ReportViolation(Invariant::kWithinBattery,
                  "the machine is in " + machine.state + " while " + BatteryText(policy));
}

// A level is left at `hysteresis` above its threshold; from then on only the threshold counts.
void Checker::NoteLevels(const BatteryPolicy& policy, int percent) {
  const std::array begins = {policy.protected_at, policy.low_power_at};
  for (std::size_t i = 0; i < begins.size(); ++i) {
    if (percent <= begins[i]) left_[i] = false;
    if (percent >= begins[i] + policy.hysteresis && percent > begins[i]) left_[i] = true;
  }
}

// Follows the policy's decisions by their records: a decision, and then the beginning of its
// switch. Refusals of requests that wait may be between them.
void Checker::OnRecord(const action::Record& record) {
  switch (record.event) {
    case EventName::kRestartRequested:
      config_errors_.erase(config_.actuators[*record.actuator].name);
      return;
    case EventName::kPolicyRequested:
    case EventName::kSwitchRequested:
      // A request that ends in the same step never shows as the switch under way.
      if (!record.actuator && !TargetOf(record).empty()) just_replied_.insert(TargetOf(record));
      if (record.event == EventName::kPolicyRequested) power_requested_ = record.id;
      return;
    case EventName::kPowerOffStarted:
      return CheckPowerOffStarted(record);
    case EventName::kSwitchStarted:
      if (std::exchange(lowering_begins_, false)) NoteLowering(record.of_switch->state);
      return;
    case EventName::kBatterySwitchUp:
      policy_up_to_.push_back(TargetOf(record));
      raised_at_ = PercentOf(record);
      return;
    case EventName::kBatterySwitchDown:
      policy_down_to_.push_back(TargetOf(record));
      lowering_begins_ = true;
      return;
    case EventName::kLyingStillSwitch:
      policy_down_to_.push_back(TargetOf(record));
      lowering_begins_ = false;
      lowered_.reset();
      return;
    default:
      return;
  }
}

// The battery takes the machine down from the state `from`.
void Checker::NoteLowering(const State& from) {
  // The raise to `from` has ended in this step.
  if (std::erase(policy_up_to_, from) != 0) {
    CheckRaise(from, raised_at_.value_or(0));
    checked_raise_ = from;
  }
  lowered_on_[recording_host_] = from;
  if (!lowered_ || lowered_->second != from) lowered_ = {from, from};
  lowered_->second = policy_down_to_.back();
}

bool Checker::ByPolicy(const State& state) const {
  const auto has = [&](const std::vector<State>& all) {
    return std::find(all.begin(), all.end(), state) != all.end();
  };
  return has(policy_up_to_) || has(policy_down_to_) || checked_raise_ == state;
}

// The machine's state has changed.
void Checker::CheckPolicyChange(const Machine& machine, const Seen& seen) {
  const auto before = config_.RankOf(seen.state);
  if (!config_.policy || !before) return;  // a step of a start
  if (std::exchange(checked_raise_, std::nullopt) == machine.state) return;
  if (ByPolicy(machine.state)) {
    const bool up = std::erase(policy_up_to_, machine.state) != 0;
    const bool down = std::erase(policy_down_to_, machine.state) != 0;
    // The battery may have fallen during the switch.
    const int percent = raised_at_.value_or(machine.policy.battery.value_or(0));
    if (up && !down) CheckRaise(machine.state, percent);
    return ForgetEndedPolicySwitches(machine);  // several may have ended in one step
  }
  if (lowered_ && lowered_->first == machine.state) {  // it is lowered from here at once
    if (std::exchange(raise_requested_, false)) lowered_->first = State(kActive);
    return;
  }
  // A client requested this switch. The policy may raise the machine later, or has begun to: the
  // battery may have left its ceiling in the step that ended this switch.
  ForgetEndedPolicySwitches(machine);
  lowered_.reset();
  if (std::exchange(raise_requested_, false)) lowered_ = {State(kActive), machine.state};
}

void Checker::OnBattery(int percent, bool charging) {
  const auto& battery = config_.policy ? config_.policy->battery : std::nullopt;
  if (battery && percent <= battery->tear_down_at && !charging) ++empty_samples_;
}

// By a request, or because the battery is empty.
void Checker::CheckPowerOffStarted(const action::Record& record) {
  if (record.cause == power_requested_ || empty_samples_ > 1) return;
  ReportViolation(Invariant::kNotOffByOneSample, "the robot is powered off after " +
                                                     std::to_string(empty_samples_) +
                                                     " samples of an empty battery");
}

// By the samples that the controller knows, not by the level that it derives from them.
void Checker::CheckQuiet(const Machine& machine, Seen& seen) {
  if (!config_.policy || !config_.policy->battery) return;
  const BatteryPolicy& battery = *config_.policy->battery;
  const Time now = robot_.network().now();
  for (const BatterySource& source : machine.policy.batteries) {
    const auto most = MostAt(battery, source.percent, source.charging);
    if (!most) continue;
    seen.protected_at = now;
    if (*most < *BuiltInRank(kProtected)) seen.low_power_at = now;
  }
  const auto& s = machine.current;
  const bool raises = s && s->purpose == Purpose::kPolicy && s->direction == Direction::kUp;
  if (!raises || std::exchange(seen.raise, s->number) == s->number) return;
  const auto rank = config_.RankOf(s->target);
  const auto check = [&](const std::optional<Time>& lower_at, std::string_view most) {
    if (!lower_at || now >= *lower_at + battery.raise_after || *rank <= *BuiltInRank(most)) return;
    ReportViolation(Invariant::kRaisedAfterQuiet,
                    "the policy raises the machine to " + s->target + ' ' +
                        std::to_string(ToMilliseconds(now - *lower_at)) +
                        " ms after a sample that permits " + std::string(most));
  };
  check(seen.low_power_at, kLowPower);
  check(seen.protected_at, kProtected);
}

void Checker::ForgetEndedPolicySwitches(const Machine& machine) {
  const auto ended = [&](const State& target) {
    return !machine.current || machine.current->purpose != Purpose::kPolicy ||
           machine.current->target != target;
  };
  std::erase_if(policy_up_to_, ended);
  std::erase_if(policy_down_to_, ended);
}

void Checker::CheckRaise(const State& raised_to, int percent) {
  const Rank rank = *config_.RankOf(raised_to);
  const std::string what = "the policy has raised the machine to " + raised_to;
  // A controller of another host may have led in between, of which this one does not know.
  const auto own = lowered_on_.find(recording_host_);
  const bool by_own = !robot_.OneHost() && own != lowered_on_.end() &&
                      rank <= config_.RankOf(own->second).value_or(0);
  const bool back = by_own || (lowered_ && rank <= config_.RankOf(lowered_->first).value_or(0));
  if (!back && !state_lost_) {
    ReportViolation(Invariant::kNoFlapping, what + ", which it had not lowered from there");
  }
  const BatteryPolicy& battery = *config_.policy->battery;
  const std::tuple<std::string_view, int, bool> levels[] = {
      {kProtected, battery.protected_at, left_[0]}, {kLowPower, battery.low_power_at, left_[1]}};
  for (const auto& [state, at, left] : levels) {
    // It may have been left before: a raise is retried after one that was undone.
    const bool still_left = left && percent > at;
    if (rank <= *BuiltInRank(state) || percent >= at + battery.hysteresis || still_left) continue;
    ReportViolation(Invariant::kNoFlapping, what + " at " + std::to_string(percent) + " %");
  }
  if (!lowered_) return;
  lowered_->second = raised_to;
  if (lowered_->first == raised_to) lowered_.reset();
}

std::uint64_t Checker::OnPolicyRequest(const ControllerProcess& controller,
                                       const event::PolicyRequested& requested) {
  const bool up = requested.what == PolicyRequest::kWakeUp ||
                  (requested.what == PolicyRequest::kOta && !requested.enable) ||
                  (requested.what == PolicyRequest::kLowPowerSwitch && !requested.enable);
  raise_requested_ |= up;
  return OnRequest(controller,
                   requested.what == PolicyRequest::kKeep ? requested.state : State(kActive));
}

void Checker::OnPolicyReply(std::uint64_t request, const event::PolicyRequested& requested,
                            const Result<>& reply) {
  ++checks_;
  if (open_requests_.erase(request) == 0) {
    return ReportViolation(Invariant::kOneReplyPerRequest,
                           "a request to the policy got two replies");
  }
  just_replied_.insert(requested.what == PolicyRequest::kKeep ? requested.state : State(kActive));
  if (!reply) return;
  const bool alone = robot_.controller(1) == nullptr;
  if (requested.what == PolicyRequest::kPowerOff && !power_due_ && alone) {
    power_due_ = robot_.network().now() + config_.policy->power.force_after + kPowerSlack;
  }
}

void Checker::OnControllersBlocked(bool state_lost) {
  power_due_.reset();
  state_lost_ |= state_lost;
}

void Checker::CheckPowerOff() {
  if (!power_due_ || robot_.network().now() <= *power_due_) return;
  ReportViolation(Invariant::kPowerOffInTime, "the accepted power-off has not happened in time");
}

}  // namespace musher::simulation
