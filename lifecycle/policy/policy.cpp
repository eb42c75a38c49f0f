#include "musher/lifecycle/policy/policy.hpp"

#include <algorithm>

#include "musher/base/decimal.hpp"
#include "musher/lifecycle/config/flow.hpp"
#include "musher/lifecycle/record/texts.hpp"
#include "musher/lifecycle/refusal.hpp"

namespace musher {
namespace {

// The percentage at which a level is left, upwards.
int LeftAt(const BatteryPolicy& policy, BatteryLevel level) {
  const int at = level == BatteryLevel::kProtected ? policy.protected_at : policy.low_power_at;
  return at + policy.hysteresis;
}

}  // namespace

BatteryLevel LevelAt(const BatteryPolicy& policy, int percent, BatteryLevel before) {
  if (percent <= policy.tear_down_at) return BatteryLevel::kEmpty;
  const auto in = [&](BatteryLevel level, int at) {
    return percent <= at || (before >= level && percent < LeftAt(policy, level));
  };
  if (in(BatteryLevel::kLowPower, policy.low_power_at)) return BatteryLevel::kLowPower;
  if (in(BatteryLevel::kProtected, policy.protected_at)) return BatteryLevel::kProtected;
  return BatteryLevel::kFree;
}

std::optional<Rank> CeilingRank(BatteryLevel level) {
  if (level == BatteryLevel::kFree) return std::nullopt;
  return BuiltInRank(level == BatteryLevel::kProtected ? kProtected : kLowPower);
}

State CeilingState(const MachineConfig& config, BatteryLevel level) {
  const Rank most = CeilingRank(level).value_or(*BuiltInRank(kActive));
  State best;
  Rank best_rank = *BuiltInRank(kTearDown);
  for (const State& state : config.states) {
    const auto rank = config.RankOf(state);
    if (!rank || *rank > most || state == kError || state == kOta) continue;
    // If several states have the same rank, the built-in one is better.
    const bool better = *rank > best_rank || (*rank == best_rank && IsBuiltInState(state));
    if (state == kTearDown || !better) continue;
    best = state;
    best_rank = *rank;
  }
  return best;
}

BatteryLevel TakingDownLevel(const MachineConfig& config, const PolicyState& policy) {
  if (!policy.battery) return policy.battery_silent ? policy.level : BatteryLevel::kFree;
  const BatteryLevel level = LevelAt(*config.policy->battery, *policy.battery, policy.level);
  return policy.charging ? std::min(level, BatteryLevel::kProtected) : level;
}

std::optional<Time> ConfirmedAt(const std::optional<LevelRun>& run, Duration after) {
  if (!run || run->samples < kConfirmingSamples) return std::nullopt;
  return run->since + after;
}

std::string BatteryText(const PolicyState& policy) {
  return texts::BatteryText(policy.battery, policy.charging);
}

Error AboveCeiling(const MachineConfig& config, const PolicyState& policy, BatteryLevel level) {
  const State most = CeilingState(config, level);
  const BatteryPolicy& battery = *config.policy->battery;
  const int left_at = LeftAt(battery, level);
  const std::string percent = std::to_string(left_at) + " %";
  const bool lifting = policy.battery && *policy.battery >= left_at;
  return Refused<Refusal::kAboveCeiling>(
      BatteryText(policy), most.empty() ? State(kLowPower) : most,
      lifting ? "no sample has been below " + percent + " for " +
                    Decimal(ToSeconds(battery.raise_after), 1) + " s"
              : "it is charged to " + percent);
}

Error AboutToEnd(const PowerDown& power) {
  return power.reboot ? Refused<Refusal::kRebootAhead>() : Refused<Refusal::kPowerOffAhead>();
}

std::optional<Error> RefusalByPolicy(const MachineConfig& config, const Machine& machine,
                                     const State& target) {
  const PolicyState& policy = machine.policy;
  const auto rank = config.RankOf(target);
  const bool rises = Rises(config, machine.state, target);
  if (!config.policy || !rank || (!rises && target != machine.state)) return std::nullopt;
  if (policy.power && rises) {
    return AboutToEnd(*policy.power);
  }
  const bool loading =
      machine.phase == Phase::kStarting || (machine.phase == Phase::kRunning && !policy.loaded);
  const bool kept = policy.keep && policy.keep->state == target;
  if (!config.policy->battery || kept || (loading && !rises)) return std::nullopt;
  // Charging keeps the machine in its state; it does not raise the ceiling.
  const BatteryLevel level = rises ? policy.level : TakingDownLevel(config, policy);
  const auto most = CeilingRank(level);
  if (!most || *rank <= *most) return std::nullopt;
  return AboveCeiling(config, policy, level);
}

}  // namespace musher
