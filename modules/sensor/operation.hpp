#pragma once
// The operations of `sensor_operation` on a sensor. Plain decisions, no IO.
//
//          open          start
//   Closed ----> Open ---------> Started
//          <----      <---------
//          close         stop
//
// An operation that leads to the sensor's present phase succeeds and changes nothing, so that a
// request can be repeated. Any other operation out of order is refused.

#include <cstdint>

#include "musher/base/result.hpp"
#include "musher/modules/sensor/sensor_kind.hpp"

namespace musher::sensor {

enum class Phase : std::uint8_t { kClosed, kOpen, kStarted };

// The phase after the operation (SensorOperation's number). Fails with the sensor's StateInvalid
// when it is out of order, with the manager's ParametersInvalid when there is no such operation.
Result<Phase> Operate(SensorKind kind, Phase phase, std::uint8_t operation);

}  // namespace musher::sensor
