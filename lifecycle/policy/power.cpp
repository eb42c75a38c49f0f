#include "musher/lifecycle/policy/power.hpp"

#include <algorithm>
#include <utility>

namespace musher {

void Power::Begin(bool reboot, Time tear_down_at, RecordId cause, const Requester& by) {
  PowerDown power;
  power.reboot = reboot;
  power.tear_down_at = tear_down_at;
  power.force_at = now_ + config_.policy->power.force_after;
  power.cause = RecordPolicy(kCodeOk, texts::PowerDownStarted(reboot), cause);
  power.by = by.name;
  machine_.policy.power = power;
  Store(reboot ? PowerAhead::kReboot : PowerAhead::kOff);
}

void Power::Resume(bool restarted) {
  const PowerAhead ahead = machine_.policy.stored.power;
  if (ahead == PowerAhead::kNone) return;
  if (!restarted) return Store(PowerAhead::kNone);
  Begin(ahead == PowerAhead::kReboot, now_, 0, {kThePolicy});
}

void Power::Store(PowerAhead ahead) {
  if (std::exchange(machine_.policy.stored.power, ahead) != ahead) saver_.Save(Stored::kPolicy);
}

void Power::Command(bool in_time) {
  PowerDown& power = *machine_.policy.power;
  if (std::exchange(power.commanded, true)) return;
  Store(PowerAhead::kNone);
  const PowerPolicy& policy = config_.policy->power;
  const auto& command = power.reboot ? policy.reboot_command : policy.off_command;
  RecordPolicy(in_time ? kCodeOk : kCodeTimeout,
               texts::PowerCommandGiven(power.reboot, in_time, command), power.cause);
  Do(action::RunPowerCommand{power.reboot});
}

void Power::Force() {
  const auto& power = machine_.policy.power;
  if (power && now_ >= power->force_at) Command(false);
}

std::optional<Time> NextPowerDeadline(const Machine& machine) {
  if (machine.phase == Phase::kIdle) return std::nullopt;
  const PolicyState& policy = machine.policy;
  const bool stopping = machine.phase == Phase::kStopping;
  if (!policy.power) return machine.current || stopping ? std::nullopt : policy.retry_at;
  std::optional<Time> next;
  if (!policy.power->commanded) next = policy.power->force_at;
  const bool waits = machine.current || stopping || policy.power->tear_down_at == Time::max();
  if (waits) return next;
  return next ? std::min(*next, policy.power->tear_down_at) : policy.power->tear_down_at;
}

}  // namespace musher
