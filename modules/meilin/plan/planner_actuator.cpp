#include "musher/modules/meilin/plan/planner_actuator.hpp"

#include <utility>

#include "musher/application/refusal.hpp"
#include "musher/cyberdog/codes/module_codes.hpp"

namespace musher::meilin {

PlannerActuator::PlannerActuator(const std::string& actuator_name, PlannerConfig config)
    : MachineActuator(actuator_name), config_(std::move(config)) {
  RegisterStateCallback([this](const State& state) { return Run(state); });
}

PlannerActuator::~PlannerActuator() {
  if (!node_) return;
  node_->RunOnLoop([this] {
    endpoint_.reset();
    clock_.reset();
  });
}

void PlannerActuator::OnEmergencyStop() {
  if (endpoint_) endpoint_->Permit(false, "an emergency stop holds it");
}

Result<> PlannerActuator::Run(const State& state) {
  if (state == kSetUp) return SetUp();
  Result<> entered;
  node_->RunOnLoop([&] {
    if (state != kActive) return endpoint_->Permit(false, "it is in " + state);
    if (!EmergencyStopped()) return endpoint_->Permit(true, "");
    entered = RefusedWith<ApplicationRefusal::kStoppedMeanwhile>(
        MakeCode(cyberdog::module_code::kApp, KeyCode::kStateInvalid));
  });
  return entered;
}

Result<> PlannerActuator::SetUp() {
  node_ = node();
  if (!node_) {
    return Error{MakeCode(cyberdog::module_code::kApp, KeyCode::kUninitialized),
                 "there is no node for its topics"};
  }
  Result<> opened;
  node_->RunOnLoop([&] {
    if (!endpoint_) opened = Open();
  });
  return opened;
}

// On the loop.
Result<> PlannerActuator::Open() {
  auto clock = transport::Clock::Of(machine_config().clock, node_->node());
  if (!clock) return clock.error();
  clock_ = std::move(clock).value();
  auto endpoint =
      PlannerEndpoint::Make({node_->node(), *clock_, machine_config().name_space,
                             [this](LogLevel level, const std::string& line) { Log(level, line); }},
                            config_);
  if (!endpoint) return endpoint.error();
  endpoint_ = std::move(endpoint).value();
  return Ok();
}

}  // namespace musher::meilin
