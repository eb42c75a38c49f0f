#pragma once
// All sensors of the robot together: the service for people, and what the robot's states mean for
// them. Runs on any transport.
//
// In LowPower and OTA lidar, ToF and ultrasonic sleep: nobody hears them, so that nobody has to
// measure. In every other state all are awake. What a person has stopped or closed stays so.
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
#include "musher/transport/service.hpp"

namespace musher::sensor {

class Sensors {
 public:
  static Result<std::unique_ptr<Sensors>> Make(const Dependencies& around,
                                               const ManagerConfig& config);

  // The robot goes to that state, or is there again. Fails when a sensor cannot be heard.
  Result<> Enter(std::string_view state);

  // Of each in the order of the self-check, but for those that the config skips. One that a person
  // has stopped has nothing to fail.
  std::vector<SensorFinding> Check() const;
  // Fails with the first critical one that is started and not heard yet.
  Result<> CheckStarted() const;

  // `sensor_operation`. Of all sensors: all or none.
  Result<> Operate(const msg::SensorOperation::Request& request);

  // The clock went back.
  void OnTimeJumped();

 private:
  Sensors(const Dependencies& around, const ManagerConfig& config)
      : around_(around), config_(config) {}
  Result<> Connect();
  Sensor& Of(SensorKind kind) { return *sensors_.at(static_cast<std::size_t>(kind)); }
  const Sensor& Of(SensorKind kind) const { return *sensors_.at(static_cast<std::size_t>(kind)); }

  const Dependencies around_;
  const ManagerConfig config_;
  std::array<std::unique_ptr<Sensor>, kSensorKinds.size()> sensors_;
  std::unique_ptr<transport::Server<msg::SensorOperation>> operations_;
};

}  // namespace musher::sensor
