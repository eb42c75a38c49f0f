#pragma once
// What people do with a sensor by `sensor_operation`. Plain decisions, no IO.
//
//          open          start
//   Closed ----> Open ---------> Started
//          <----      <---------
//          close         stop
//
// What leads to where the sensor is already is obeyed and changes nothing, so that a request may be
// sent again. Any other order is refused.

#include <cstdint>

#include "musher/lifecycle/result.hpp"
#include "musher/modules/sensor/sensor_kind.hpp"

namespace musher::sensor {

enum class Phase : std::uint8_t { kClosed, kOpen, kStarted };

// The phase after the operation (SensorOperation's number). Fails with the sensor's StateInvalid
// where it is out of order, with the manager's ParametersInvalid where there is no such operation.
Result<Phase> Operate(SensorKind kind, Phase phase, std::uint8_t operation);

}  // namespace musher::sensor
