#pragma once
// The power key: held for its time (CyberDog: 3 s), it asks the machine's manager for `poweroff`,
// once until it is released. A driver that ends while the key is pressed does not call that off.
//
// Threads: the loop's.

#include <memory>

#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/modules/device/dependencies.hpp"
#include "musher/modules/device/device_config.hpp"
#include "musher/transport/service.hpp"

namespace musher::device {

class PowerKeyDevice {
 public:
  static constexpr Duration kPowerOffTime = Milliseconds(2000);  // that the manager may take
  static constexpr Duration kLate = Milliseconds(50);            // later, a timer is not believed

  // Without a key, or the right to call `poweroff`, nothing is subscribed to; the log says the
  // latter.
  static Result<std::unique_ptr<PowerKeyDevice>> Make(const Dependencies& around,
                                                      const PowerKeyConfig& config);

 private:
  PowerKeyDevice(const Dependencies& around, const PowerKeyConfig& config)
      : around_(around), config_(config) {}
  Result<> Connect();
  void OnKey(bool pressed);
  void OnHeld(Time due);
  void PowerOff();

  const Dependencies around_;
  const PowerKeyConfig config_;
  bool pressed_ = false;
  transport::LoopHandlePtr held_;  // by the steady clock: this is the real robot's end
  std::unique_ptr<transport::Client<msg::Trigger>> power_off_;
  std::unique_ptr<transport::Subscription> key_;
};

}  // namespace musher::device
