#include "musher/lifecycle/rules/policy_rules.hpp"

#include <algorithm>
#include <utility>

#include "musher/lifecycle/policy/policy.hpp"

namespace musher {
namespace {

constexpr int kFullBattery = 100;
// In percent, between two samples of one publisher: no battery changes so fast.
constexpr int kMostChange = 10;
// More publishers than a robot has. Of more, those with the lowest charge count.
constexpr std::size_t kMostSources = 8;

bool ReportsEmpty(const BatteryPolicy& policy, const BatterySource& source) {
  return source.percent <= policy.tear_down_at && !source.charging;
}

}  // namespace

void PolicyRules::Begin(const event::Begin& begin) {
  if (!config_.policy) return;
  const StoredPolicy& stored = begin.policy;
  PolicyState& policy = machine_.policy;
  policy.stored = stored;
  power_.Resume(begin.restarted && !begin.at_boot);
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
    policy.batteries.clear();
    RecordPolicy(kCodeOk, texts::BatteryResumed());
  }
  NoteSource(seen);
  Combine();
  CountSample();
  Confirm();
}

void PolicyRules::On(const event::BatterySourceSilent& silent) {
  std::vector<BatterySource>& batteries = machine_.policy.batteries;
  if (batteries.size() < 2) return;  // the last value stays in effect
  std::erase_if(batteries, [&](const BatterySource& b) { return b.source == silent.source; });
  machine_.policy.doubled_recorded &= batteries.size() > 1;
  Combine();
}

// Records what no battery reports: a jump, and a second publisher. A publisher that has reported
// between two samples of another one is not its successor.
void PolicyRules::NoteSource(const event::BatterySeen& seen) {
  PolicyState& policy = machine_.policy;
  std::vector<BatterySource>& batteries = policy.batteries;
  const auto known = std::ranges::find(batteries, seen.source, &BatterySource::source);
  if (known != batteries.end()) {
    const bool jumps = std::abs(known->percent - seen.percent) > kMostChange;
    if (jumps && !std::exchange(policy.jump_recorded, true)) {
      RecordPolicy(kCodeParametersInvalid, texts::BatteryJumped(known->percent, seen.percent));
    }
    const bool last = std::next(known) == batteries.end();
    batteries.erase(known);
    batteries.push_back({seen.source, seen.percent, seen.charging});
    if (last || std::exchange(policy.doubled_recorded, true)) return;
    const auto [low, high] = std::ranges::minmax(batteries, {}, &BatterySource::percent);
    RecordPolicy(kCodeParametersInvalid, texts::BatteryDoubled(config_.policy->battery->topic,
                                                               static_cast<int>(batteries.size()),
                                                               low.percent, high.percent));
    return;
  }
  if (batteries.size() == kMostSources) {
    batteries.erase(std::ranges::max_element(batteries, {}, &BatterySource::percent));
  }
  batteries.push_back({seen.source, seen.percent, seen.charging});
}

// The lowest publisher counts, and it is charged where all report it.
void PolicyRules::Combine() {
  PolicyState& policy = machine_.policy;
  const std::vector<BatterySource>& batteries = policy.batteries;
  const bool charging = std::ranges::all_of(batteries, &BatterySource::charging);
  const bool changed = policy.battery && policy.charging != charging;
  policy.battery = std::ranges::min(batteries, {}, &BatterySource::percent).percent;
  policy.charging = charging;
  EvaluateLevel(changed ? std::optional(charging) : std::nullopt);
  const BatteryPolicy& battery = *config_.policy->battery;
  const bool empty = std::ranges::all_of(
      batteries, [&](const BatterySource& one) { return ReportsEmpty(battery, one); });
  if (!empty) {
    policy.emptying.reset();
    policy.empty = false;
  } else if (!policy.emptying) {
    policy.emptying = LevelRun{BatteryLevel::kEmpty, now_};
  }
}

// A lower level is in effect at once; a higher one once it is confirmed.
void PolicyRules::EvaluateLevel(std::optional<bool> charger) {
  PolicyState& policy = machine_.policy;
  const BatteryLevel level = LevelAt(*config_.policy->battery, *policy.battery, policy.level);
  if (level >= policy.level) {
    policy.lifting.reset();
    return SetLevel(level, charger);
  }
  if (!policy.lifting) policy.lifting = LevelRun{level, now_};
  policy.lifting->level = std::max(policy.lifting->level, level);
  SetLevel(policy.level, charger);
}

void PolicyRules::CountSample() {
  PolicyState& policy = machine_.policy;
  if (policy.emptying) ++policy.emptying->samples;
  if (!policy.lifting) return;
  LevelRun& run = *policy.lifting;
  const BatteryLevel level = LevelAt(*config_.policy->battery, *policy.battery, policy.level);
  ++run.samples;
  run.higher = level < run.level ? run.higher + 1 : 0;
}

// What samples in a row have confirmed by now.
void PolicyRules::Confirm() {
  if (!config_.policy->battery) return;
  const BatteryPolicy& battery = *config_.policy->battery;
  PolicyState& policy = machine_.policy;
  const auto reached = [&](const std::optional<LevelRun>& run, Duration after) {
    const auto at = ConfirmedAt(run, after);
    return at && now_ >= *at;
  };
  policy.empty |= reached(policy.emptying, battery.tear_down_after);
  if (!reached(policy.lifting, battery.raise_after)) return;
  const LevelRun run = *std::exchange(policy.lifting, std::nullopt);
  SetLevel(run.level, std::nullopt);
  EvaluateLevel(std::nullopt);  // the last samples may lift it further
  if (policy.lifting) policy.lifting->samples = run.higher;
}

// Records a change of the ceiling; the record is the cause of what follows.
void PolicyRules::SetLevel(BatteryLevel level, std::optional<bool> charger) {
  PolicyState& policy = machine_.policy;
  const BatteryLevel before = policy.level;
  memory_.SetLevel(level);
  if (policy.level > before) policy.retry_at.reset();
  if (policy.level == before && !charger) return;
  using Limit = texts::BatteryLimit;
  const bool kept_up = TakingDownLevel(config_, policy) != policy.level;
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
                 texts::BatterySilent(config_.policy->battery->silent, policy.battery,
                                      policy.level != BatteryLevel::kFree));
  }
}

// The clock of a restarted world, or of one received for the first time, has another zero. Of the
// time that a recording has skipped, nothing was seen.
void PolicyRules::On(const event::ClockReceived& received) {
  if (!config_.policy || config_.clock != ClockSource::kTopic) return;
  PolicyState& policy = machine_.policy;
  if (policy.clock == Time{} || received.clock < policy.clock || received.jumped) {
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
  Confirm();
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
  const bool known = policy.battery || policy.battery_silent;
  return loading || !known || policy.keep || machine_.state == kOta;
}

bool PolicyRules::ApplyBatteryRule() {
  if (!config_.policy->battery || BatteryRulesWait()) return false;
  const BatteryLevel level = TakingDownLevel(config_, machine_.policy);
  if (machine_.policy.empty) {
    power_.Begin(false, now_ + config_.policy->empty_battery_delay, machine_.policy.level_cause,
                 {kThePolicy});
    if (TearDownForPower()) return true;
    power_.Force();  // its time may be zero
    return false;
  }
  if (machine_.phase != Phase::kRunning) return false;
  return TakeDown(level) || (machine_.policy.battery && BringBack());
}

bool PolicyRules::TakeDown(BatteryLevel level) {
  const auto most = CeilingRank(level);
  const auto rank = config_.RankOf(machine_.state);
  const State target = CeilingState(config_, level);
  if (!most || !rank || *rank <= *most || target.empty()) return false;
  const auto& before = machine_.policy.stored.lowering;
  const State from = before && before->to == machine_.state ? before->from : machine_.state;
  if (!BeginByPolicy(
          MakeSafetyPlan(config_, machine_, target),
          texts::BatterySwitchDown(machine_.policy.battery, machine_.policy.charging, target),
          machine_.policy.level_cause)) {
    return false;
  }
  memory_.Lower(BatteryFallback{from, target, 0});
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
  const bool must_be_set =
      std::any_of(machine_.actuators.begin(), machine_.actuators.end(),
                  [this](const KnownActuator& known) { return MustBeSetAgain(machine_, known); });
  if (must_be_set) return false;  // a release switches nothing on, nor does the battery after it
  return BeginByPolicy(
      MakePolicyPlan(config_, machine_, target),
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
  return BeginByPolicy(MakePolicyPlan(config_, machine_, State(kLowPower)),
                       texts::LyingStill(limit), 0);
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
  switches_.Begin(plan, Purpose::kPolicy, {}, RecordPolicy(kCodeOk, why, cause));
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
  tear_down_.Begin(plan, {}, power.cause, AfterTearDown::kStaysDown, {power.by});
  return true;
}

}  // namespace musher
