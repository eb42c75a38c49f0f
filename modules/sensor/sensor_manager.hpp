#pragma once
// The actuator `sensor_manager`: range sensors and GPS of a robot. See README.md in this folder.
//
// Threads: state callbacks on the actuator's worker, the sensors on the loop of its node.

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/messages/protocol/manager.hpp"
#include "musher/modules/sensor/sensor_config.hpp"
#include "musher/modules/sensor/sensors.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::sensor {

class SensorManager : public MachineActuator {
 public:
  SensorManager(const std::string& actuator_name, ManagerConfig config);
  ~SensorManager() override;

 private:
  Result<> Run(const State& state);
  Result<> SetUp();
  Result<> SelfCheck();
  Result<> Activate();
  Result<> MakeSensors();
  // On the loop.
  Result<> Enter(std::string_view state);
  // Calls `check` on the loop until it succeeds, or `time` is over.
  Result<> Await(Duration time, const std::function<Result<>()>& check);

  const ManagerConfig config_;
  std::shared_ptr<transport::NodeThread> node_;  // from SetUp on
  std::unique_ptr<transport::Clock> clock_;
  std::unique_ptr<transport::Endpoints> endpoints_;
  std::unique_ptr<Sensors> sensors_;
};

}  // namespace musher::sensor
