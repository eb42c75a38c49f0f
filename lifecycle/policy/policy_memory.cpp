#include "musher/lifecycle/policy/policy_memory.hpp"

#include <algorithm>
#include <utility>

#include "musher/lifecycle/policy/policy.hpp"

namespace musher {
namespace {

// The delay before a retry of a failed switch; doubled each time.
constexpr Duration kFirstRetry = std::chrono::seconds(1);
constexpr int kMostDoublings = 6;  // about a minute

}  // namespace

// Restores what an earlier controller stored about the battery: its level, and if none has led
// since, and the config still has the rule, the lowering. The level was at least as low then; so
// its hysteresis applies.
void PolicyMemory::ResumeLowering() {
  PolicyState& policy = machine_.policy;
  auto lowering = policy.stored.lowering;
  if (config_.policy->battery) policy.level = policy.stored.level;
  if (!lowering) return;
  if (lowering->epoch + 1 != machine_.epoch || !config_.policy->battery) return Lower(std::nullopt);
  const auto to = config_.RankOf(lowering->to);
  policy.level =
      std::max(policy.level, to && to <= BuiltInRank(kLowPower) ? BatteryLevel::kLowPower
                                                                : BatteryLevel::kProtected);
  Lower(lowering);
}

void PolicyMemory::SetLevel(BatteryLevel level) {
  PolicyState& policy = machine_.policy;
  policy.level = level;
  const BatteryLevel kept = std::min(level, BatteryLevel::kLowPower);  // powers nothing off
  if (std::exchange(policy.stored.level, kept) != kept) saver_.Save(Stored::kPolicy);
}

void PolicyMemory::Lower(std::optional<BatteryFallback> lowering) {
  StoredPolicy& stored = machine_.policy.stored;
  if (lowering) lowering->epoch = machine_.epoch;
  if (stored.lowering == lowering) return;
  stored.lowering = lowering;
  saver_.Save(Stored::kPolicy);
}

void PolicyMemory::LowerAtMostTo(const State& most) {
  auto lowering = machine_.policy.stored.lowering;
  if (!lowering) return;
  const auto limit = config_.RankOf(most);
  const auto from = config_.RankOf(lowering->from);
  if (from && from <= limit) return;  // a state of an earlier config may have been higher
  lowering->from = most;
  Lower(limit > config_.RankOf(lowering->to) ? lowering : std::nullopt);
}

void PolicyMemory::EndKeep(const std::string& why) {
  const Keep keep = *std::exchange(machine_.policy.keep, std::nullopt);
  RecordPolicy(kCodeOk, texts::KeepEnded(keep.state, why));
}

void PolicyMemory::BackOff() {
  PolicyState& policy = machine_.policy;
  policy.retry_at = now_ + kFirstRetry * (1 << std::min(policy.failures, kMostDoublings));
  ++policy.failures;
}

void PolicyMemory::OnSwitchEnded(const Switch& s, bool undone) {
  if (!config_.policy) return;
  PolicyState& policy = machine_.policy;
  const auto withheld = std::exchange(policy.withheld, std::nullopt);
  if (undone && policy.keep && policy.keep->switch_number == s.number) {
    EndKeep("the switch to it was undone");
  }
  if (!undone && EndsKeep(s)) EndKeep("the machine is in " + s.target + " now");
  if (s.only || s.direction == Direction::kCheck) return;
  if (s.purpose == Purpose::kPolicy && undone) {
    // The battery may have fallen during a raise that has failed: lowering does not wait for the
    // next attempt to raise.
    const BatteryLevel level = TakingDownLevel(config_, policy);
    const auto rank = config_.RankOf(machine_.state);
    const auto most = CeilingRank(level);
    const bool lowers = level == BatteryLevel::kEmpty || (rank && most && *rank > *most);
    if (!lowers) BackOff();
    return;
  }
  if (undone) return;
  if (s.purpose != Purpose::kPolicy) {
    policy.failures = 0;  // what was tried before was from another state
    policy.retry_at.reset();
    return Lower(withheld && withheld->to == machine_.state ? withheld : std::nullopt);
  }
  policy.failures = 0;
  auto lowering = policy.stored.lowering;
  if (!lowering) return;
  lowering->to = machine_.state;
  Lower(lowering->from == machine_.state ? std::nullopt : lowering);
}

void PolicyMemory::OnSuperseded(const Switch& s) {
  PolicyState& policy = machine_.policy;
  policy.withheld.reset();
  if (policy.keep && policy.keep->switch_number == s.number) {
    EndKeep("the switch to it was superseded");
  }
}

}  // namespace musher
