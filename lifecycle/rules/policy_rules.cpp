#include "musher/lifecycle/rules/policy_rules.hpp"

#include <algorithm>
#include <utility>

#include "musher/lifecycle/policy/policy.hpp"

namespace musher {
namespace {

constexpr int kFullBattery = 100;

}  // namespace

void PolicyRules::Begin(const StoredPolicy& stored) {
  if (!config_.policy) return;
  PolicyState& policy = machine_.policy;
  policy.stored = stored;
  memory_.ResumeLowering();
  const auto& rule = config_.policy->low_power;
  policy.low_power = rule && stored.low_power.value_or(rule->enabled);
}

void PolicyRules::On(const event::BatterySeen& seen) {
  if (!config_.policy || !config_.policy->battery || machine_.phase == Phase::kIdle) return;
  PolicyState& policy = machine_.policy;
  if (seen.percent < 0 || seen.percent > kFullBattery) {
    if (std::exchange(policy.invalid_recorded, true)) return;
    RecordPolicy(kCodeParametersInvalid, texts::BatterySampleInvalid(seen.percent));
    return;
  }
  if (std::exchange(policy.battery_silent, false)) {
    RecordPolicy(kCodeOk, texts::BatteryResumed());
  }
  const bool cable = policy.battery && policy.charging != seen.charging;
  policy.battery = seen.percent;
  policy.charging = seen.charging;
  EvaluateLevel(cable ? std::optional(seen.charging) : std::nullopt);
}

// Records a change of the ceiling; the record is the cause of what follows.
void PolicyRules::EvaluateLevel(std::optional<bool> charger) {
  PolicyState& policy = machine_.policy;
  const BatteryLevel before = policy.level;
  policy.level = LevelAt(*config_.policy->battery, *policy.battery, before);
  if (policy.level > before) policy.retry_at.reset();
  if (policy.level == before && !charger) return;
  using Limit = texts::BatteryLimit;
  const bool kept_up = TakingDownLevel(policy) != policy.level;
  const Limit limit = policy.level == before                 ? Limit::kAsBefore
                      : policy.level == BatteryLevel::kFree  ? Limit::kLifted
                      : kept_up                              ? Limit::kNoSwitchAbove
                      : policy.level == BatteryLevel::kEmpty ? Limit::kEmpty
                                                             : Limit::kLimited;
  policy.level_cause =
      RecordPolicy(kCodeOk, texts::BatteryChanged(*policy.battery, policy.charging, charger, limit,
                                                  CeilingState(config_, policy.level)));
}

void PolicyRules::On(const event::MotionSeen& seen) {
  if (!config_.policy || !config_.policy->low_power) return;
  const std::vector<std::int32_t>& still = config_.policy->low_power->motion_ids;
  machine_.policy.still = std::find(still.begin(), still.end(), seen.motion) != still.end();
}

void PolicyRules::On(const event::InputSilent& silent) {
  if (!config_.policy || machine_.phase == Phase::kIdle) return;
  PolicyState& policy = machine_.policy;
  if (silent.input == PolicyInput::kMotion) {
    policy.still = false;  // nothing reports that it lies still
  } else if (config_.policy->battery && !std::exchange(policy.battery_silent, true)) {
    RecordPolicy(kCodeNetError,
                 texts::BatterySilent(config_.policy->battery->silent, policy.battery));
  }
}

// The clock of a restarted world, or of one received for the first time, has another zero.
void PolicyRules::On(const event::ClockReceived& received) {
  if (!config_.policy || config_.clock != ClockSource::kTopic) return;
  PolicyState& policy = machine_.policy;
  if (policy.clock == Time{} || received.clock < policy.clock) {
    const Duration jump = received.clock - policy.clock;
    if (policy.still_since) *policy.still_since += jump;
    if (policy.keep) policy.keep->until += jump;
  }
  policy.clock = received.clock;
}

bool PolicyRules::Advance() {
  if (!config_.policy) return false;
  PolicyState& policy = machine_.policy;
  // During an emergency stop no actuator goes up; the battery rule does not wait for that.
  const bool settled = machine_.emergency.stop || (machine_.start_up.stage >= LastStage(config_) &&
                                                   StageIsSettled(machine_.start_up.stage));
  policy.loaded |= machine_.phase == Phase::kRunning && settled;
  if (policy.keep && policy_now() >= policy.keep->until) memory_.EndKeep("time expired");
  CountStillness();
  power_.Force();
  if (machine_.current) return false;
  if (policy.power) return TearDownForPower();
  if (policy.retry_at && now_ < *policy.retry_at) return false;
  policy.retry_at.reset();
  return ApplyBatteryRule() || LowPowerWhenStill();
}

bool PolicyRules::BatteryRulesWait() const {
  const PolicyState& policy = machine_.policy;
  const bool loading =
      machine_.phase == Phase::kStarting || (machine_.phase == Phase::kRunning && !policy.loaded);
  return loading || !policy.battery || policy.keep || machine_.state == kOta;
}

bool PolicyRules::ApplyBatteryRule() {
  if (!config_.policy->battery || BatteryRulesWait()) return false;
  const BatteryLevel level = TakingDownLevel(machine_.policy);
  if (level == BatteryLevel::kEmpty) {
    power_.Begin(false, now_ + config_.policy->empty_battery_delay, machine_.policy.level_cause);
    if (TearDownForPower()) return true;
    power_.Force();  // its time may be zero
    return false;
  }
  if (machine_.phase != Phase::kRunning) return false;
  return TakeDown(level) || BringBack();
}

bool PolicyRules::TakeDown(BatteryLevel level) {
  const auto most = CeilingRank(level);
  const auto rank = config_.RankOf(machine_.state);
  const State target = CeilingState(config_, level);
  if (!most || !rank || *rank <= *most || target.empty()) return false;
  const auto& before = machine_.policy.stored.lowering;
  const State from = before && before->to == machine_.state ? before->from : machine_.state;
  if (!BeginByPolicy(MakeSafetyPlan(config_, machine_, target),
                     texts::BatterySwitchDown(machine_.policy.battery.value_or(0),
                                              machine_.policy.charging, target),
                     machine_.policy.level_cause)) {
    return false;
  }
  memory_.Lower(Lowering{from, target, 0});
  return true;
}

// Back to the state before the battery rule took the machine down, as far as the battery allows.
bool PolicyRules::BringBack() {
  const auto lowering = machine_.policy.stored.lowering;
  if (!lowering) return false;
  if (machine_.state != lowering->to) {
    memory_.Lower(std::nullopt);  // another request has changed its state
    return false;
  }
  const State target = UpTo(lowering->from);
  const auto rank = config_.RankOf(target);
  if (!rank || *rank <= *config_.RankOf(machine_.state) || machine_.emergency.stop) return false;
  return BeginByPolicy(
      MakePlan(config_, machine_, target),
      texts::BatterySwitchUp(machine_.policy.battery.value_or(0), machine_.policy.charging, target),
      machine_.policy.level_cause);
}

State PolicyRules::UpTo(const State& wanted) const {
  const auto most = CeilingRank(machine_.policy.level);
  const auto rank = config_.RankOf(wanted);
  const bool allowed = config_.HasState(wanted) && rank && (!most || *rank <= *most);
  return allowed ? wanted : CeilingState(config_, machine_.policy.level);
}

void PolicyRules::CountStillness() {
  PolicyState& policy = machine_.policy;
  const bool awake = machine_.state == kActive || machine_.state == kProtected;
  const bool counts = policy.low_power && policy.still && policy.loaded && !policy.keep && awake;
  if (!counts) {
    policy.still_since.reset();
  } else if (!policy.still_since) {
    policy.still_since = policy_now();
  }
}

bool PolicyRules::LowPowerWhenStill() {
  const auto since = machine_.policy.still_since;
  if (!since || machine_.phase != Phase::kRunning) return false;
  const Duration limit = config_.policy->low_power->lying_still;
  if (policy_now() < *since + limit) return false;
  memory_.Lower(std::nullopt);  // from now on it is in LowPower for another reason
  return BeginByPolicy(MakePlan(config_, machine_, State(kLowPower)), texts::LyingStill(limit), 0);
}

bool PolicyRules::BeginByPolicy(const Plan& plan, const RecordText& why, RecordId cause) {
  if (plan.refusal) {
    if (machine_.policy.failures == 0) {
      RecordPolicy(plan.refusal->code, texts::PolicySwitchRefused(why, plan.refusal->message),
                   cause);
    }
    memory_.BackOff();
    return false;
  }
  switching_.Begin(plan, Purpose::kPolicy, {}, RecordPolicy(kCodeOk, why, cause));
  return true;
}

// As soon as no switch is under way.
bool PolicyRules::TearDownForPower() {
  PowerDown& power = *machine_.policy.power;
  if (now_ < power.tear_down_at) return false;
  const Plan plan = MakePlan(config_, machine_, State(kTearDown));
  if (plan.refusal) {
    power.tear_down_at = Time::max();  // the command comes in time, regardless
    RecordPolicy(plan.refusal->code, texts::PowerTearDownRefused(plan.refusal->message),
                 power.cause);
    return false;
  }
  tear_down_.Begin(plan, {}, power.cause);
  return true;
}

}  // namespace musher
