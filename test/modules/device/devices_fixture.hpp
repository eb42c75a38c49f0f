#pragma once
// The devices on a simulated network, in virtual time, with their peers on a node of its own: the
// world that has battery, lights and pad, and the clients of the services.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/modules/device/devices.hpp"
#include "musher/test/modules/module_on_network.hpp"

namespace musher::device {

class DevicesOnANetwork : public test::ModuleOnNetwork {
 protected:
  DevicesOnANetwork() {
    config_.battery.source = BatterySource::kWorld;
    config_.touch.source = KeySource::kWorld;
    config_.led.source = LedSource::kWorld;
  }

  void Start() {
    devices_ = test::Must(Devices::Make(Around(), config_));
    Run(Milliseconds(500));  // discovery
  }
  Dependencies Around() {
    return {*robot_,
            *clock_,
            "dog1",
            [this] { return msg::ToStamp(clock_->Now().time_since_epoch()); },
            [this](const std::string& line) { log_.push_back(line); },
            [this] { return state_; },
            [this] { return may_power_; }};
  }

  // The failing devices of the check.
  std::vector<std::int32_t> Failures() const {
    std::vector<std::int32_t> codes;
    for (const DeviceResult& finding : devices_->Check()) {
      if (!finding.result) codes.push_back(finding.result.error().code);
    }
    return codes;
  }

  DeviceConfig config_;
  std::vector<std::string> log_;
  State state_ = "Active";
  Result<> may_power_;
  std::unique_ptr<Devices> devices_;
};

}  // namespace musher::device
