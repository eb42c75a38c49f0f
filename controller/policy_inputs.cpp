#include "musher/controller/policy_inputs.hpp"

#include <algorithm>
#include <utility>

#include "musher/transport/lifecycle_wire.hpp"

namespace musher {
namespace {

// motion_status comes ten times a second.
constexpr Duration kMotionPatience = std::chrono::seconds(2);

}  // namespace

PolicyInputs::PolicyInputs(const MachineConfig& config, Tell tell)
    : config_(config), policy_(*config.policy), tell_(std::move(tell)) {
  battery_ear_.input = PolicyInput::kBattery;
  motion_ear_.input = PolicyInput::kMotion;
  motion_ear_.patience = kMotionPatience;
}

Result<std::unique_ptr<PolicyInputs>> PolicyInputs::Make(transport::Node& node,
                                                         const MachineConfig& config, Tell tell) {
  if (!config.policy) return std::unique_ptr<PolicyInputs>();
  std::unique_ptr<PolicyInputs> inputs(new PolicyInputs(config, std::move(tell)));
  if (auto opened = inputs->Open(node); !opened) return opened.error();
  return inputs;
}

Result<> PolicyInputs::Open(transport::Node& node) {
  by_topic_ = config_.clock == ClockSource::kTopic;
  auto clock = transport::Clock::Of(config_, node, [this] { OnWorldRestarted(); });
  if (!clock) return clock.error();
  clock_ = std::move(clock).value();
  if (by_topic_) first_time_ = clock_->At(Time{}, [this] { TellTime(); });
  const auto topic = [this](const std::string& name) {
    return config_.name_space.empty() ? name : config_.name_space + "/" + name;
  };
  if (policy_.battery) {
    battery_ear_.patience = policy_.battery->silent;
    auto battery = transport::MakeSubscription<msg::BmsStatus>(
        node, topic(policy_.battery->topic),
        [this](const msg::BmsStatus& status, const transport::SampleInfo&) { OnBattery(status); },
        transport::kSensorDataQos);
    if (!battery) return battery.error();
    battery_ear_.subscription = std::move(battery).value();
  }
  if (policy_.low_power) {
    auto motion = transport::MakeSubscription<msg::MotionStatus>(
        node, topic(policy_.low_power->topic),
        [this](const msg::MotionStatus& status, const transport::SampleInfo&) { OnMotion(status); },
        transport::kSensorDataQos);
    if (!motion) return motion.error();
    motion_ear_.subscription = std::move(motion).value();
  }
  return Ok();
}

void PolicyInputs::OnWorldRestarted() {
  battery_ear_.heard = motion_ear_.heard = clock_->Now();
  TellTime();
}

void PolicyInputs::Begin() {
  begun_ = true;
  TellTime();
  if (battery_) Pass(*battery_);
  if (motion_) Pass(*motion_);
  for (Ear* ear : {&battery_ear_, &motion_ear_}) {
    if (!ear->subscription) continue;
    ear->heard = clock_->Now();
    WatchFor(*ear);
  }
}

void PolicyInputs::WakeAt(std::optional<Time> when) {
  if (!by_topic_ || when == wake_at_) return;
  wake_at_ = when;
  wake_ = nullptr;
  if (!when) return;
  wake_ = clock_->At(*when, [this] {
    wake_at_.reset();
    TellTime();
  });
}

void PolicyInputs::TellTime() {
  const Time now = clock_->Now();
  if (!by_topic_ || !begun_ || now == told_) return;
  told_ = now;
  tell_(event::ClockHeard{now});
}

void PolicyInputs::Pass(const Event& event) {
  if (!begun_) return;
  TellTime();
  tell_(event);
}

void PolicyInputs::OnBattery(const msg::BmsStatus& status) {
  const event::BatterySeen seen{status.batt_soc, status.power_wired_charging};
  const bool again = battery_ear_.silent;
  Heard(battery_ear_);
  if (seen == battery_ && !again) return;
  battery_ = seen;
  Pass(seen);
}

void PolicyInputs::OnMotion(const msg::MotionStatus& status) {
  const bool again = motion_ear_.silent;
  Heard(motion_ear_);
  const bool same = motion_ && IsStill(motion_->motion) == IsStill(status.motion_id);
  if (same && !again) return;
  motion_ = event::MotionSeen{status.motion_id};
  Pass(*motion_);
}

bool PolicyInputs::IsStill(std::int32_t motion) const {
  const std::vector<std::int32_t>& still = policy_.low_power->motion_ids;
  return std::find(still.begin(), still.end(), motion) != still.end();
}

void PolicyInputs::Heard(Ear& ear) {
  ear.heard = clock_->Now();
  if (std::exchange(ear.silent, false) && begun_) WatchFor(ear);
}

// One timer for many samples: it looks when the last one came.
void PolicyInputs::WatchFor(Ear& ear) {
  ear.timer = clock_->At(ear.heard + ear.patience, [this, &ear] {
    if (clock_->Now() < ear.heard + ear.patience) return WatchFor(ear);
    ear.silent = true;
    Pass(event::InputSilent{ear.input});
  });
}

}  // namespace musher
