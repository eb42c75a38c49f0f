#include "musher/controller/shell/policy_inputs.hpp"

#include <algorithm>
#include <utility>

#include "musher/wire/lifecycle_wire.hpp"

namespace musher {
namespace {

// motion_status is published ten times a second.
constexpr Duration kMotionTimeout = std::chrono::seconds(2);
// How exactly the time before a jump of /clock is known.
constexpr Duration kTimeNoted = Milliseconds(100);

}  // namespace

PolicyInputs::PolicyInputs(const MachineConfig& config, Emit emit)
    : config_(config), policy_(*config.policy), emit_(std::move(emit)) {
  battery_input_.input = PolicyInput::kBattery;
  motion_input_.input = PolicyInput::kMotion;
  motion_input_.timeout = kMotionTimeout;
}

Result<std::unique_ptr<PolicyInputs>> PolicyInputs::Make(transport::Node& node,
                                                         const MachineConfig& config, Emit emit) {
  if (!config.policy) return std::unique_ptr<PolicyInputs>();
  if (config.policy->low_power && config.policy->low_power->motion_ids.empty()) {
    return Error{kCodeParametersInvalid,
                 "policy.low_power: motion_ids is missing: the motions of a robot that lies; an "
                 "extension with a manager, such as cyberdog::Extension(), has a default"};
  }
  std::unique_ptr<PolicyInputs> inputs(new PolicyInputs(config, std::move(emit)));
  if (auto opened = inputs->Open(node); !opened) return opened.error();
  return inputs;
}

Result<> PolicyInputs::Open(transport::Node& node) {
  by_topic_ = config_.clock == ClockSource::kTopic;
  auto clock = transport::Clock::Of(config_.clock, node, [this] { OnTimeJumped(); });
  if (!clock) return clock.error();
  clock_ = std::move(clock).value();
  if (by_topic_) {
    first_time_ = clock_->At(Time{}, [this] { EmitTime(); });
    time_noted_ = clock_->Every(kTimeNoted, [this] { noted_time_ = clock_->Now(); });
  }
  const auto topic = [this](const std::string& name) {
    return config_.name_space.empty() ? name : config_.name_space + "/" + name;
  };
  if (policy_.battery) {
    battery_input_.timeout = policy_.battery->silent;
    auto battery = transport::MakeSubscription<msg::BmsStatus>(
        node, topic(policy_.battery->topic),
        [this](const msg::BmsStatus& status, const transport::SampleInfo& info) {
          OnBattery(status, info.writer);
        },
        transport::kSensorDataQos);
    if (!battery) return battery.error();
    battery_input_.subscription = std::move(battery).value();
  }
  if (policy_.low_power) {
    auto motion = transport::MakeSubscription<msg::MotionStatus>(
        node, topic(policy_.low_power->topic),
        [this](const msg::MotionStatus& status, const transport::SampleInfo&) { OnMotion(status); },
        transport::kSensorDataQos);
    if (!motion) return motion.error();
    motion_input_.subscription = std::move(motion).value();
  }
  return Ok();
}

// What has passed before the jump counts, whatever was emitted of it.
void PolicyInputs::OnTimeJumped() {
  const Time now = clock_->Now();
  const Time before = std::exchange(noted_time_, now);
  battery_input_.received = motion_input_.received = now;
  for (auto& [writer, source] : batteries_) source.received = now;
  if (!begun_) return;
  const auto emitted = std::exchange(emitted_time_, now);
  if (emitted && before > *emitted) emit_(event::ClockReceived{before});
  emit_(event::ClockReceived{now, true});
}

void PolicyInputs::Begin() {
  begun_ = true;
  EmitTime();
  for (auto& [writer, source] : batteries_) {
    source.emitted = 1;
    EmitOnceBegun(source.last);
  }
  if (motion_) EmitOnceBegun(*motion_);
  for (Input* input : {&battery_input_, &motion_input_}) {
    if (!input->subscription) continue;
    input->received = clock_->Now();
    WatchForTimeout(*input);
  }
}

void PolicyInputs::WakeAt(std::optional<Time> when) {
  if (!by_topic_ || when == wake_at_) return;
  wake_at_ = when;
  wake_ = nullptr;
  if (!when) return;
  wake_ = clock_->At(*when, [this] {
    wake_at_.reset();
    EmitTime();
  });
}

void PolicyInputs::EmitTime() {
  const Time now = clock_->Now();
  if (!by_topic_ || !begun_ || now == emitted_time_) return;
  emitted_time_ = now;
  emit_(event::ClockReceived{now});
}

void PolicyInputs::EmitOnceBegun(const Event& event) {
  if (!begun_) return;
  EmitTime();
  emit_(event);
}

// Emits a sample that differs from the one before, and those after it that confirm it.
void PolicyInputs::OnBattery(const msg::BmsStatus& status, transport::EndpointId writer) {
  OnSample(battery_input_);
  const auto [at, is_new] = batteries_.try_emplace(writer);
  BatterySource& source = at->second;
  if (is_new) {
    source.last.source = next_source_++;
    ConfirmAgain();
  }
  source.received = clock_->Now();
  ForgetSilentSources();
  const event::BatterySeen seen{status.batt_soc, status.power_wired_charging, source.last.source};
  if (seen != source.last) source.emitted = 0;
  source.last = seen;
  if (source.emitted == kConfirmingSamples) return;
  ++source.emitted;
  EmitOnceBegun(seen);
}

// Only while another publisher sends: otherwise the battery is silent.
void PolicyInputs::ForgetSilentSources() {
  for (auto at = batteries_.begin(); at != batteries_.end();) {
    const BatterySource& source = at->second;
    if (clock_->Now() < source.received + battery_input_.timeout) {
      ++at;
      continue;
    }
    const std::uint32_t silent = source.last.source;
    at = batteries_.erase(at);
    ConfirmAgain();
    EmitOnceBegun(event::BatterySourceSilent{silent});
  }
}

// The publishers have changed: the next samples of all are emitted, equal or not.
void PolicyInputs::ConfirmAgain() {
  for (auto& [writer, source] : batteries_) source.emitted = 0;
}

void PolicyInputs::OnMotion(const msg::MotionStatus& status) {
  const bool was_silent = motion_input_.silent;
  OnSample(motion_input_);
  const bool same = motion_ && IsStill(motion_->motion) == IsStill(status.motion_id);
  if (same && !was_silent) return;
  motion_ = event::MotionSeen{status.motion_id};
  EmitOnceBegun(*motion_);
}

bool PolicyInputs::IsStill(std::int32_t motion) const {
  const std::vector<std::int32_t>& still = policy_.low_power->motion_ids;
  return std::find(still.begin(), still.end(), motion) != still.end();
}

void PolicyInputs::OnSample(Input& input) {
  input.received = clock_->Now();
  if (std::exchange(input.silent, false) && begun_) WatchForTimeout(input);
}

// One timer for many samples: when it fires, it checks the time of the last one.
void PolicyInputs::WatchForTimeout(Input& input) {
  input.timer = clock_->At(input.received + input.timeout, [this, &input] {
    if (clock_->Now() < input.received + input.timeout) return WatchForTimeout(input);
    input.silent = true;
    if (input.input == PolicyInput::kBattery) batteries_.clear();
    EmitOnceBegun(event::InputSilent{input.input});
  });
}

}  // namespace musher
