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
  NoteLevels(controller);
  const auto rank = config_.RankOf(machine.state);
  if (waits || machine.phase != Phase::kRunning || !rank) return;
  // Without a sample, what the controller before it on this host knew last still holds.
  const Host& known = hosts_[controller.host()];
  if (!known.percent) return;
  if (!policy.battery && (context_.state_lost || !policy.battery_silent)) return;
  const auto most = MostAt(*config_.policy->battery, *known.percent, known.charging);
  if (!most || *rank <= *most) return;
  ReportViolation(Invariant::kWithinBattery,
                  "the machine is in " + machine.state + " while " +
                      (policy.battery ? BatteryText(policy)
                                      : "nothing publishes the battery, which was at " +
                                            std::to_string(*known.percent) + " %"));
}

// A level is left at `hysteresis` above its threshold; from then on only the threshold counts. A
// controller that finds no level of its predecessor begins without one.
void PolicyChecker::NoteLevels(const SimulatedController& controller) {
  const PolicyState& policy = controller.shell().machine().policy;
  if (!policy.battery) return;
  const BatteryPolicy& battery = *config_.policy->battery;
  const int percent = *policy.battery;
  Host& host = hosts_[controller.host()];
  const bool begins = !std::exchange(seen_[controller.serial()].noted_levels, true);
  if (begins && context_.state_lost) host.left = {true, true};
  const std::array levels = {battery.protected_at, battery.low_power_at};
  for (std::size_t i = 0; i < levels.size(); ++i) {
    if (percent <= levels[i]) host.left[i] = false;
    if (percent >= levels[i] + battery.hysteresis && percent > levels[i]) host.left[i] = true;
  }
  host.percent = percent;
  host.charging = policy.charging;
}

// Follows the policy's decisions by their records: a decision, and then the beginning of its
// switch. Refusals of requests that wait may be between them.
void PolicyChecker::OnRecord(const SimulatedController& controller, const action::Record& record) {
  Seen& seen = seen_[controller.serial()];
  switch (record.event) {
    case EventName::kPolicyRequested:
      power_requested_ = record.id;
      return;
    case EventName::kPowerOffStarted:
      return CheckPowerOffStarted(record);
    case EventName::kSwitchStarted:
      if (std::exchange(seen.lowering_begins, false)) {
        NoteLowering(controller, record.of_switch->state);
      }
      return;
    case EventName::kBatteryLimitsStart:  // which would have led to Active
      lowered_ = {State(kActive), TargetOf(record)};
      hosts_[controller.host()].lowered_from = State(kActive);
      return;
    case EventName::kBatterySwitchUp:
      NoteLevels(controller);  // perhaps a sample of this step has lowered it
      seen.up_to.push_back(
          {TargetOf(record), PercentOf(record).value_or(0), hosts_[controller.host()].left});
      return;
    case EventName::kBatterySwitchDown:
      seen.down_to.push_back(TargetOf(record));
      seen.lowering_begins = true;
      return;
    case EventName::kLyingStillSwitch:
      seen.down_to.push_back(TargetOf(record));
      seen.lowering_begins = false;
      lowered_.reset();
      return;
    default:
      return;
  }
}

// The battery takes the machine down from the state `from`.
void PolicyChecker::NoteLowering(const SimulatedController& controller, const State& from) {
  Seen& seen = seen_[controller.serial()];
  // The raise to `from` has ended in this step.
  if (const auto raise = TakeRaise(seen, from)) {
    CheckRaise(controller, *raise);
    seen.checked_raise = from;
  }
  if (!lowered_ || lowered_->second != from) lowered_ = {from, from};
  hosts_[controller.host()].lowered_from = lowered_->first;
  lowered_->second = seen.down_to.back();
}

bool PolicyChecker::ByPolicy(const SimulatedController& controller, const State& state) {
  const Seen& seen = seen_[controller.serial()];
  return std::ranges::count(seen.up_to, state, &Raise::target) != 0 ||
         std::ranges::count(seen.down_to, state) != 0 || seen.checked_raise == state;
}

// The last raise to that state, which has ended. An earlier one was undone.
std::optional<PolicyChecker::Raise> PolicyChecker::TakeRaise(Seen& seen, const State& target) {
  std::optional<Raise> last;
  for (const Raise& raise : seen.up_to) {
    if (raise.target == target) last = raise;
  }
  std::erase_if(seen.up_to, [&](const Raise& raise) { return raise.target == target; });
  return last;
}

void PolicyChecker::CheckPolicyChange(const SimulatedController& controller, const State& from) {
  const Machine& machine = controller.shell().machine();
  Seen& seen = seen_[controller.serial()];
  const auto before = config_.RankOf(from);
  if (!config_.policy || !before) return;  // a step of a start
  if (std::exchange(seen.checked_raise, std::nullopt) == machine.state) return;
  if (ByPolicy(controller, machine.state)) {
    const auto raise = TakeRaise(seen, machine.state);
    const bool down = std::erase(seen.down_to, machine.state) != 0;
    if (raise && !down) CheckRaise(controller, *raise);
    return ForgetEndedPolicySwitches(controller);  // several may have ended in one step
  }
  if (lowered_ && lowered_->first == machine.state) {  // it is lowered from here at once
    if (std::exchange(raise_requested_, false)) lowered_->first = State(kActive);
    return;
  }
  // A client requested this switch. The policy may raise the machine later, or has begun to: the
  // battery may have left its ceiling in the step that ended this switch.
  ForgetEndedPolicySwitches(controller);
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
  const bool resumed = record.cause == 0 && power_requested_ != 0;  // by the next controller
  if (record.cause == power_requested_ || resumed || most_empty_in_a_row_ > 1) return;
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

void PolicyChecker::ForgetEndedPolicySwitches(const SimulatedController& controller) {
  const Machine& machine = controller.shell().machine();
  Seen& seen = seen_[controller.serial()];
  const auto ended = [&](const State& target) {
    return !machine.current || machine.current->purpose != Purpose::kPolicy ||
           machine.current->target != target;
  };
  std::erase_if(seen.up_to, [&](const Raise& raise) { return ended(raise.target); });
  std::erase_if(seen.down_to, ended);
}

// By the battery when it was decided: a lower sample during the switch lowers the machine after it.
void PolicyChecker::CheckRaise(const SimulatedController& controller, const Raise& raise) {
  const auto& [raised_to, percent, levels_left] = raise;
  const Rank rank = *config_.RankOf(raised_to);
  const std::string what = "the policy has raised the machine to " + raised_to;
  // A controller of another host may have led in between, of which this one does not know.
  const Host& host = hosts_[controller.host()];
  const bool by_own = !robot_.OneHost() && host.lowered_from &&
                      rank <= config_.RankOf(*host.lowered_from).value_or(0);
  const bool back = by_own || (lowered_ && rank <= config_.RankOf(lowered_->first).value_or(0));
  if (!back && !context_.state_lost) {
    ReportViolation(Invariant::kNoFlapping, what + ", which it had not lowered from there");
  }
  const BatteryPolicy& battery = *config_.policy->battery;
  const std::tuple<std::string_view, int, bool> levels[] = {
      {kProtected, battery.protected_at, levels_left[0]},
      {kLowPower, battery.low_power_at, levels_left[1]}};
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
