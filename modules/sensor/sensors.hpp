#pragma once
// All sensors of the robot together: the service `sensor_operation`, and what the robot's states
// mean for them. Runs on any transport.
//
// In LowPower and OTA lidar, ToF and ultrasonic sleep: their topics are unsubscribed, so that
// their drivers need not measure. In every other state all are awake. A sensor that an operator
// has stopped or closed stays so.
//
// Threads: the loop's.

#include <array>
#include <memory>
#include <string_view>
#include <vector>

#include "musher/lifecycle/state.hpp"
#include "musher/messages/protocol/sensor.hpp"
#include "musher/modules/sensor/self_check.hpp"
#include "musher/modules/sensor/sensor.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::sensor {

class Sensors {
 public:
  static Result<std::unique_ptr<Sensors>> Make(const Dependencies& dependencies,
                                               const ManagerConfig& config);

  // The robot enters that state or is driven to it again. Fails when a topic cannot be subscribed
  // to.
  Result<> Enter(std::string_view state);

  // Of each in the order of the self-check, except those that the config skips. A sensor that an
  // operator has stopped cannot fail.
  std::vector<SensorResult> Check() const;
  // Fails with the first critical sensor that is started and has no reading yet.
  Result<> CheckStarted() const;

  // `sensor_operation`. For all sensors: all or none.
  Result<> Operate(const msg::SensorOperation::Request& request);

  // The clock went back.
  void OnTimeJumped();

 private:
  Sensors(const Dependencies& dependencies, const ManagerConfig& config)
      : dependencies_(dependencies),
        config_(config),
        endpoints_(dependencies.node, dependencies.name_space) {}
  Result<> Connect();
  Sensor& Of(SensorKind kind) { return *sensors_.at(static_cast<std::size_t>(kind)); }
  const Sensor& Of(SensorKind kind) const { return *sensors_.at(static_cast<std::size_t>(kind)); }

  const Dependencies dependencies_;
  const ManagerConfig config_;
  std::array<std::unique_ptr<Sensor>, kSensorKinds.size()> sensors_;
  transport::Endpoints endpoints_;  // last: its callbacks use the rest
};

}  // namespace musher::sensor
