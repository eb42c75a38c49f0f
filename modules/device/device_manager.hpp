#pragma once
// The actuator `device_manager`: battery, lights and touch of a robot. See README.md in this
// folder.
//
// Threads: state callbacks on the actuator's worker, the devices on the loop of its node.

#include <memory>
#include <string>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/modules/device/device_config.hpp"
#include "musher/modules/device/devices.hpp"
#include "musher/transport/clock.hpp"

namespace musher::device {

class DeviceManager : public MachineActuator {
 public:
  DeviceManager(const std::string& actuator_name, DeviceConfig config);
  ~DeviceManager() override;

 private:
  Result<> Run(const State& state);
  Result<> SetUp();
  Result<> SelfCheck();
  Result<> MakeDevices();

  const DeviceConfig config_;
  std::shared_ptr<transport::NodeThread> node_;  // from SetUp on
  std::unique_ptr<transport::Clock> clock_;
  std::unique_ptr<Devices> devices_;
};

}  // namespace musher::device
