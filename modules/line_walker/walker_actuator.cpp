#include "musher/modules/line_walker/walker_actuator.hpp"

#include <utility>

#include "musher/actuator/program/await.hpp"
#include "musher/application/refusal.hpp"
#include "musher/cyberdog/codes/module_codes.hpp"

namespace musher::line_walker {

WalkerActuator::WalkerActuator(const std::string& actuator_name, WalkerConfig config)
    : MachineActuator(actuator_name), config_(std::move(config)) {
  RegisterStateCallback([this](const State& state) { return Run(state); });
}

WalkerActuator::~WalkerActuator() {
  if (!node_) return;
  node_->RunOnLoop([this] {
    topics_.reset();
    clock_.reset();
  });
}

void WalkerActuator::OnEmergencyStop() {
  if (topics_) topics_->Permit(false, "an emergency stop holds it");
}

Result<> WalkerActuator::Run(const State& state) {
  if (state == kSetUp) return SetUp();
  if (state == kSelfCheck) return SelfCheck();
  return Enter(state);
}

Result<> WalkerActuator::SetUp() {
  node_ = node();
  if (!node_) {
    return Error{MakeCode(cyberdog::module_code::kFollow, KeyCode::kUninitialized),
                 "there is no node to walk from"};
  }
  Result<> made;
  node_->RunOnLoop([&] {
    if (!topics_) made = MakeTopics();
  });
  return made;
}

// On the loop.
Result<> WalkerActuator::MakeTopics() {
  auto clock = transport::Clock::Of(machine_config().clock, node_->node(), [this] {
    if (topics_) topics_->OnTimeJump(clock_->JumpText());
  });
  if (!clock) return clock.error();
  clock_ = std::move(clock).value();
  auto topics =
      WalkerTopics::Make({node_->node(), *clock_, machine_config().name_space,
                          [this](LogLevel level, const std::string& line) { Log(level, line); }},
                         config_);
  if (!topics) return topics.error();
  topics_ = std::move(topics).value();
  return Ok();
}

Result<> WalkerActuator::Enter(const State& state) {
  Result<> entered;
  node_->RunOnLoop([&] {
    if (state != kActive) return topics_->Permit(false, "it is in " + state);
    if (!EmergencyStopped()) return topics_->Permit(true, "");
    entered = RefusedWith<ApplicationRefusal::kStoppedMeanwhile>(
        MakeCode(cyberdog::module_code::kFollow, KeyCode::kStateInvalid));
  });
  return entered;
}

Result<> WalkerActuator::SelfCheck() {
  Result<> result;
  node_->RunOnLoop([&] {
    topics_->Permit(false, "it is in SelfCheck");
    result = topics_->SetChecked(true);
  });
  if (result) {
    result = program::AwaitOnLoop(
        *node_, config_.self_check_time, [this] { return topics_->Check(); },
        [this] { return StopRequested(); });
  }
  node_->RunOnLoop([&] { static_cast<void>(topics_->SetChecked(false)); });
  return result;
}

}  // namespace musher::line_walker
