#include "musher/modules/device/device_manager.hpp"

#include <algorithm>
#include <utility>

#include "musher/actuator/program/await.hpp"
#include "musher/cyberdog/codes/module_codes.hpp"

namespace musher::device {

DeviceManager::DeviceManager(const std::string& actuator_name, DeviceConfig config)
    : MachineActuator(actuator_name), config_(std::move(config)) {
  RegisterStateCallback([this](const State& state) { return Run(state); });
}

DeviceManager::~DeviceManager() {
  if (!node_) return;
  node_->RunOnLoop([this] {
    if (devices_) devices_->Flush();
    devices_.reset();
    clock_.reset();
  });
}

Result<> DeviceManager::Run(const State& state) {
  if (state == kSetUp) return SetUp();
  if (state == kSelfCheck) return SelfCheck();
  node_->RunOnLoop([&] { devices_->Enter(state); });
  return Ok();
}

Result<> DeviceManager::SetUp() {
  node_ = node();
  Result<> made;
  node_->RunOnLoop([&] {
    if (!devices_) made = MakeDevices();
  });
  return made;
}

Result<> DeviceManager::MakeDevices() {
  auto clock = transport::Clock::Of(machine_config().clock, node_->node(), [this] {
    if (devices_) devices_->OnTimeJumped();
  });
  if (!clock) return clock.error();
  clock_ = std::move(clock).value();
  const Dependencies dependencies = {
      node_->node(),
      *clock_,
      machine_config().name_space,
      [this] { return clock_->Stamp(); },
      [this](const std::string& line) { Log(line); },
      [this] { return CurrentState(); },
      [this] { return Allowed("motor_power", cyberdog::module_code::kBms); }};
  auto devices = Devices::Make(dependencies, config_);
  if (!devices) return devices.error();
  devices_ = std::move(devices).value();
  return Ok();
}

// Devices may need a moment after a start: failed checks are repeated until the timeout.
Result<> DeviceManager::SelfCheck() {
  SelfCheckVerdict verdict;
  const auto check = [&]() -> Result<> {
    verdict = EvaluateSelfCheck(devices_->Check(), config_.critical);
    return verdict.well() || !verdict.result ? verdict.result : Result<>(verdict.degraded);
  };
  static_cast<void>(program::AwaitOnLoop(*node_, config_.self_check_time, check,
                                         [this] { return StopRequested(); }));
  if (verdict.degraded.code != kCodeOk) {
    ReportDegraded(verdict.degraded);
    Log({verdict.degraded.code, "self-check, degraded: " + verdict.degraded.message});
  }
  return verdict.result;
}

}  // namespace musher::device
