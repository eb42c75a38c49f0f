#pragma once
// What every device depends on: the node, the clock, the log.

#include <functional>
#include <string>

#include "musher/lifecycle/state.hpp"
#include "musher/messages/builtin_interfaces/time.hpp"
#include "musher/modules/device/can_socket.hpp"
#include "musher/modules/device/gpio_chip.hpp"
#include "musher/modules/device/i2c_link.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/node.hpp"

namespace musher::device {

struct Dependencies {
  transport::Node& node;
  transport::Clock& clock;  // of the module's behaviour
  std::string name_space;
  std::function<msg::Stamp()> stamp;            // for headers
  std::function<void(const std::string&)> log;  // one line, without its end
  std::function<State()> state;                 // of the actuator
  std::function<Result<>()> may_power_motors;   // or why it is refused
  CanBus::Open open_can = CanSocket::Open;
  GpioLine::Open open_gpio = OpenGpioLine;
  I2cDoor i2c = I2cOfThisComputer();
};

}  // namespace musher::device
