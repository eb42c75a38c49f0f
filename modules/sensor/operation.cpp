#include "musher/modules/sensor/operation.hpp"

#include <string>

#include "musher/cyberdog/codes/module_codes.hpp"
#include "musher/messages/protocol/sensor.hpp"

namespace musher::sensor {
namespace {

using Operation = msg::SensorOperation;

Error OutOfOrder(SensorKind kind, const std::string& why) {
  return {CodeOf(kind, KeyCode::kStateInvalid), std::string(NameOf(kind)) + " " + why};
}

}  // namespace

Result<Phase> Operate(SensorKind kind, Phase phase, std::uint8_t operation) {
  switch (operation) {
    case Operation::kOpen:
      if (phase == Phase::kStarted) return OutOfOrder(kind, "is started already");
      return Phase::kOpen;
    case Operation::kStart:
      if (phase == Phase::kClosed) return OutOfOrder(kind, "is closed: open it first");
      return Phase::kStarted;
    case Operation::kStop:
      if (phase == Phase::kClosed) return OutOfOrder(kind, "is closed: there is nothing to stop");
      return Phase::kOpen;
    case Operation::kClose:
      if (phase == Phase::kStarted) return OutOfOrder(kind, "is started: stop it first");
      return Phase::kClosed;
    default:
      return Error{MakeCode(cyberdog::module_code::kSensorManager, KeyCode::kParametersInvalid),
                   "unknown operation " + std::to_string(operation) +
                       "; 1 opens, 2 starts, 3 stops, 4 closes"};
  }
}

}  // namespace musher::sensor
