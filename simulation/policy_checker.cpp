#include "musher/simulation/policy_checker.hpp"

#include <algorithm>
#include <string>
#include <string_view>
#include <tuple>

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

std::optional<int> PercentOf(const action::Record& record) {
  const Argument* percent = FindArgument(record.arguments, "percent");
  if (percent == nullptr) return std::nullopt;
  return static_cast<int>(std::get<std::int64_t>(percent->value));
}

}  // namespace

void PolicyChecker::CheckCeiling(const SimulatedController& controller, bool at_rest) {
  const Machine& machine = controller.shell().machine();
  const PolicyState& policy = machine.policy;
  const bool waits = machine.current || machine.fallback.target || policy.keep || policy.power ||
                     machine.state == kOta || (!at_rest && !policy.loaded);
  if (!config_.policy || !config_.policy->battery) return;
  if (policy.battery) {
    NoteLevels(*config_.policy->battery, *policy.battery);
    level_on_[controller.host()] = {*policy.battery, policy.charging};
  }
  const auto rank = config_.RankOf(machine.state);
  if (waits || machine.phase != Phase::kRunning || !rank) return;
  // Without a sample, what the controller before it on this host knew last still holds.
  const auto known = level_on_.find(controller.host());
  if (known == level_on_.end()) return;
  if (!policy.battery && (context_.state_lost || !policy.battery_silent)) return;
  const Level& level = known->second;
  const auto most = MostAt(*config_.policy->battery, level.percent, level.charging);
  if (!most || *rank <= *most) return;
  ReportViolation(Invariant::kWithinBattery,
                  "the machine is in " + machine.state + " while " +
                      (policy.battery ? BatteryText(policy)
                                      : "nothing publishes the battery, which was at " +
                                            std::to_string(level.percent) + " %"));
}

// A level is left at `hysteresis` above its threshold; from then on only the threshold counts.
void PolicyChecker::NoteLevels(const BatteryPolicy& policy, int percent) {
  const std::array begins = {policy.protected_at, policy.low_power_at};
  for (std::size_t i = 0; i < begins.size(); ++i) {
    if (percent <= begins[i]) left_[i] = false;
    if (percent >= begins[i] + policy.hysteresis && percent > begins[i]) left_[i] = true;
  }
}

// Follows the policy's decisions by their records: a decision, and then the beginning of its
// switch. Refusals of requests that wait may be between them.
void PolicyChecker::OnRecord(const action::Record& record) {
  switch (record.event) {
    case EventName::kPolicyRequested:
      power_requested_ = record.id;
      return;
    case EventName::kPowerOffStarted:
      return CheckPowerOffStarted(record);
    case EventName::kSwitchStarted:
      if (std::exchange(lowering_begins_, false)) NoteLowering(record.of_switch->state);
      return;
    case EventName::kBatteryLimitsStart:  // which would have led to Active
      lowered_ = {State(kActive), TargetOf(record)};
      lowered_on_[recording_host_] = State(kActive);
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
void PolicyChecker::NoteLowering(const State& from) {
  // The raise to `from` has ended in this step.
  if (std::erase(policy_up_to_, from) != 0) {
    CheckRaise(from, raised_at_.value_or(0));
    checked_raise_ = from;
  }
  if (!lowered_ || lowered_->second != from) lowered_ = {from, from};
  lowered_on_[recording_host_] = lowered_->first;
  lowered_->second = policy_down_to_.back();
}

bool PolicyChecker::ByPolicy(const State& state) const {
  const auto has = [&](const std::vector<State>& all) {
    return std::find(all.begin(), all.end(), state) != all.end();
  };
  return has(policy_up_to_) || has(policy_down_to_) || checked_raise_ == state;
}

void PolicyChecker::CheckPolicyChange(const Machine& machine, const State& from) {
  const auto before = config_.RankOf(from);
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

void PolicyChecker::OnBattery(int percent, bool charging) {
  const auto& battery = config_.policy ? config_.policy->battery : std::nullopt;
  if (battery && percent <= battery->tear_down_at && !charging) {
    most_empty_in_a_row_ = std::max(most_empty_in_a_row_, ++empty_in_a_row_);
    return;
  }
  // A controller that does not receive this sample takes the next empty one for the second.
  const SimulatedController* leading = robot_.leader();
  const bool well = !context_.link_faults_until ||
                    *context_.link_faults_until < robot_.network().now() - kReceivedAfter;
  const bool received = leading != nullptr && !leading->frozen && well;
  if (received) empty_in_a_row_ = 0;
}

// By a request, or because the battery is empty.
void PolicyChecker::CheckPowerOffStarted(const action::Record& record) {
  if (record.cause == power_requested_ || most_empty_in_a_row_ > 1) return;
  ReportViolation(Invariant::kNotOffByOneSample, "the robot is powered off after " +
                                                     std::to_string(most_empty_in_a_row_) +
                                                     " samples in a row of an empty battery");
}

// By the samples that the controller knows, not by the level that it derives from them.
void PolicyChecker::CheckQuiet(const SimulatedController& controller) {
  if (!config_.policy || !config_.policy->battery) return;
  const BatteryPolicy& battery = *config_.policy->battery;
  const Machine& machine = controller.shell().machine();
  Seen& seen = seen_[controller.serial()];
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

void PolicyChecker::ForgetEndedPolicySwitches(const Machine& machine) {
  const auto ended = [&](const State& target) {
    return !machine.current || machine.current->purpose != Purpose::kPolicy ||
           machine.current->target != target;
  };
  std::erase_if(policy_up_to_, ended);
  std::erase_if(policy_down_to_, ended);
}

void PolicyChecker::CheckRaise(const State& raised_to, int percent) {
  const Rank rank = *config_.RankOf(raised_to);
  const std::string what = "the policy has raised the machine to " + raised_to;
  // A controller of another host may have led in between, of which this one does not know.
  const auto own = lowered_on_.find(recording_host_);
  const bool by_own = !robot_.OneHost() && own != lowered_on_.end() &&
                      rank <= config_.RankOf(own->second).value_or(0);
  const bool back = by_own || (lowered_ && rank <= config_.RankOf(lowered_->first).value_or(0));
  if (!back && !context_.state_lost) {
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

void PolicyChecker::OnAccepted(const event::PolicyRequested& requested) {
  const bool alone = robot_.controller(1) == nullptr;
  if (requested.what == PolicyRequest::kPowerOff && !power_due_ && alone) {
    power_due_ = robot_.network().now() + config_.policy->power.force_after + kPowerSlack;
  }
}

void PolicyChecker::CheckPowerOff() {
  if (!power_due_ || robot_.network().now() <= *power_due_) return;
  ReportViolation(Invariant::kPowerOffInTime, "the accepted power-off has not happened in time");
}

}  // namespace musher::simulation
