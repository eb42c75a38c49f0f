#pragma once
// The touch pad: publishes `touch_status`, and wakes the robot by a double tap in LowPower.
//
// Threads: the loop's.

#include <memory>

#include "musher/messages/protocol/device.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/modules/device/dependencies.hpp"
#include "musher/modules/device/touch.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::device {

class TouchDevice {
 public:
  static constexpr Duration kWakeTime = Milliseconds(13'000);  // that the manager may take

  // `present`: there is one; else nothing is subscribed to.
  static Result<std::unique_ptr<TouchDevice>> Make(const Dependencies& dependencies, bool present);

  // Fails with 1509 while nothing publishes touches.
  Result<> Check() const;

  void OnTimeJumped() { double_tap_.Forget(); }

 private:
  explicit TouchDevice(const Dependencies& dependencies)
      : dependencies_(dependencies), endpoints_(dependencies.node, dependencies.name_space) {}
  Result<> Connect(bool present);
  void OnTouch(std::int32_t touch_state);
  void WakeUp();

  const Dependencies dependencies_;
  DoubleTap double_tap_;
  bool waking_ = false;
  transport::Publisher<msg::TouchStatus>* status_ = nullptr;
  transport::Client<msg::Trigger>* low_power_exit_ = nullptr;
  transport::Subscription* touches_ = nullptr;  // null: there is none
  transport::Endpoints endpoints_;              // last: its callbacks use the rest
};

}  // namespace musher::device
