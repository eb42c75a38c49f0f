#pragma once
// The power key: held for its time (CyberDog: 3 s), it requests `poweroff` from the machine's
// manager, once until it is released. A driver that exits while the key is pressed does not cancel
// the request; an input device that is unplugged does, and so does a line that is lost. A key that
// is pressed already when its device or its line is opened counts once it was released.
//
// Threads: the loop's.

#include <memory>

#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/modules/device/dependencies.hpp"
#include "musher/modules/device/device_config.hpp"
#include "musher/modules/device/gpio_input.hpp"
#include "musher/modules/device/input_device.hpp"
#include "musher/modules/device/power_key.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::device {

class PowerKeyDevice {
 public:
  static constexpr Duration kPowerOffTime = Milliseconds(2000);  // that the manager may take
  static constexpr Duration kLate = Milliseconds(50);  // a timer later than this is ignored

  // Without a key, or without permission to call `poweroff`, nothing is subscribed to; the log
  // reports the latter.
  static Result<std::unique_ptr<PowerKeyDevice>> Make(const Dependencies& dependencies,
                                                      const PowerKeyConfig& config);

 private:
  PowerKeyDevice(const Dependencies& dependencies, const PowerKeyConfig& config)
      : dependencies_(dependencies),
        config_(config),
        endpoints_(dependencies.node, dependencies.name_space) {}
  Result<> Connect();
  void OpenInput();
  void OpenLine();
  void OnGap(PowerKey::Effect effect);
  void Follow(PowerKey::Effect effect);
  void OnHeld(Time due);
  void PowerOff();

  const Dependencies dependencies_;
  const PowerKeyConfig config_;
  PowerKey key_;
  std::unique_ptr<InputDevice> input_;
  std::unique_ptr<GpioInput> line_;
  transport::LoopHandlePtr held_;  // by the steady clock: it powers off the real robot
  transport::Client<msg::Trigger>* power_off_ = nullptr;
  transport::Endpoints endpoints_;  // last: its callbacks use the rest
};

}  // namespace musher::device
