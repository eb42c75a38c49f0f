#pragma once
// One sensor of the robot: its sources, its phase by `sensor_operation`, and whether it sleeps in
// the robot's state. It is subscribed to only while it is started and awake.
//
// Threads: the loop's.

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "musher/modules/sensor/operation.hpp"
#include "musher/modules/sensor/sensor_config.hpp"
#include "musher/modules/sensor/source.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::sensor {

class Sensor {
 public:
  using Sources = std::vector<std::unique_ptr<Source>>;

  // Its sources, and callbacks that drop what was received. Without sources there is no such
  // sensor.
  struct Parts {
    Sources sources;
    std::vector<std::function<void()>> forget;
  };

  // Started, and asleep.
  Sensor(SensorKind kind, Parts parts) : kind_(kind), parts_(std::move(parts)) {}

  SensorKind kind() const { return kind_; }
  bool exists() const { return !parts_.sources.empty(); }
  Phase phase() const { return phase_; }
  bool started() const { return exists() && phase_ == Phase::kStarted; }

  // The phase that an operation leads to; UnSupport when there is no such sensor.
  Result<Phase> PhaseAfter(std::uint8_t operation) const;
  Result<> SetPhase(Phase phase);
  Result<> SetAsleep(bool asleep);

  // Its fault while it is subscribed to, with the sensor's code of that key.
  Result<> Check(KeyCode key) const;

  void OnTimeJumped();

 private:
  Result<> Apply();
  void Forget();

  const SensorKind kind_;
  Phase phase_ = Phase::kStarted;
  bool asleep_ = true;
  Parts parts_;
};

// Publishes valid readings: `scan`, `ultrasonic_payload`, `head_tof_payload` and
// `rear_tof_payload`, `gps_payload`. `endpoints` keeps what it publishes with, and has the error if
// one could not be opened.
std::unique_ptr<Sensor> MakeSensor(SensorKind kind, transport::Endpoints& endpoints,
                                   const Dependencies& dependencies, const ManagerConfig& config);

}  // namespace musher::sensor
