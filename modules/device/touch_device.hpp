#pragma once
// The touch pad: publishes `touch_status`, and wakes the robot by a double tap in LowPower. A lost
// input device leaves no half double tap. A double tap that waited while this process could not run
// wakes nothing.
//
// Threads: the loop's.

#include <cstdint>
#include <memory>
#include <set>

#include "musher/messages/protocol/device.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/modules/device/dependencies.hpp"
#include "musher/modules/device/device_config.hpp"
#include "musher/modules/device/gpio_input.hpp"
#include "musher/modules/device/input_device.hpp"
#include "musher/modules/device/touch.hpp"
#include "musher/transport/endpoints.hpp"
#include "musher/transport/loop_breaks.hpp"

namespace musher::device {

class TouchDevice {
 public:
  static constexpr Duration kWakeTime = Milliseconds(13'000);  // that the manager may take

  static constexpr Duration kLate = Milliseconds(50);  // a timer later than this is ignored

  // Without one, nothing is subscribed to.
  static Result<std::unique_ptr<TouchDevice>> Make(const Dependencies& dependencies,
                                                   const TouchConfig& config);

  // Fails with 1509 while nothing publishes touches, or the input device or the line cannot be
  // read.
  Result<> Check() const;

  void OnTimeJumped() { double_tap_.Forget(); }

 private:
  TouchDevice(const Dependencies& dependencies, const TouchConfig& config)
      : dependencies_(dependencies),
        config_(config),
        breaks_(dependencies.node.loop()),
        endpoints_(dependencies.node, dependencies.name_space) {}
  Result<> Connect();
  void OpenInput();
  void OpenLine();
  void ForgetTaps();
  void OnPad(bool touched);
  void OnKey(std::uint16_t code, bool pressed);
  void ArmTaps();
  void OnTapTime(Time due);
  void OnTouch(std::int32_t touch_state);
  void WakeUp();

  const Dependencies dependencies_;
  const TouchConfig config_;
  DoubleTap double_tap_;
  Taps taps_;
  std::set<std::uint16_t> pressed_;    // of the keys that are touches
  transport::LoopHandlePtr tap_time_;  // by the steady clock
  bool waking_ = false;
  transport::LoopBreaks breaks_;
  transport::Publisher<msg::TouchStatus>* status_ = nullptr;
  transport::Client<msg::Trigger>* low_power_exit_ = nullptr;
  transport::Subscription* touches_ = nullptr;  // null: there is none
  std::unique_ptr<InputDevice> input_;
  std::unique_ptr<GpioInput> line_;
  transport::Endpoints endpoints_;  // last: its callbacks use the rest
};

}  // namespace musher::device
