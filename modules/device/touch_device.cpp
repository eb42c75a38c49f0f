#include "musher/modules/device/touch_device.hpp"
#include "musher/cyberdog/codes/module_codes.hpp"
#include "musher/messages/stamp.hpp"

#include <string>
#include <utility>

namespace musher::device {

Result<std::unique_ptr<TouchDevice>> TouchDevice::Make(const Dependencies& dependencies,
                                                       bool present) {
  std::unique_ptr<TouchDevice> device(new TouchDevice(dependencies));
  if (Result<> connected = device->Connect(present); !connected) return connected.error();
  return device;
}

Result<> TouchDevice::Connect(bool present) {
  status_ = endpoints_.Advertise<msg::TouchStatus>("touch_status");
  low_power_exit_ = endpoints_.OpenClient<msg::Trigger>("low_power_exit");
  if (present) {
    touches_ = endpoints_.Subscribe<msg::Int32>(
        "world/touch", [this](const msg::Int32& touch) { OnTouch(touch.data); });
  }
  return endpoints_.opened();
}

void TouchDevice::OnTouch(std::int32_t touch_state) {
  if (!IsTouch(touch_state)) {
    return dependencies_.log("touch: refused: unknown touch " + std::to_string(touch_state));
  }
  const msg::Stamp stamp = dependencies_.stamp();
  static_cast<void>(status_->Publish(
      {{stamp, "touch"}, touch_state, static_cast<std::uint64_t>(FromStamp(stamp).count())}));
  if (double_tap_.Take(touch_state, dependencies_.clock.Now()) &&
      dependencies_.state() == kLowPower)
    WakeUp();
}

void TouchDevice::WakeUp() {
  if (waking_) return;
  waking_ = true;
  dependencies_.log("touch: double tap: leaving low power is requested");
  low_power_exit_->Call({}, kWakeTime, [this](const Result<msg::Trigger::Response>& answer) {
    waking_ = false;
    if (!answer) return dependencies_.log("touch: low_power_exit: " + answer.error().message);
    if (!answer.value().success) {
      dependencies_.log("touch: low_power_exit refused: " + answer.value().message);
    }
  });
}

Result<> TouchDevice::Check() const {
  if (!touches_ || touches_->MatchedWriters() > 0) return Ok();
  return Error{MakeCode(cyberdog::module_code::kTouch, KeyCode::kSelfCheckFailed),
               "no publisher of world/touch"};
}

}  // namespace musher::device
