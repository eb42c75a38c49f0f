#include "musher/modules/device/touch_device.hpp"
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
  auto status = transport::MakePublisher<msg::TouchStatus>(dependencies_.node,
                                                           dependencies_.Name("touch_status"));
  if (!status) return status.error();
  status_ = std::move(status).value();
  auto client =
      transport::MakeClient<msg::Trigger>(dependencies_.node, dependencies_.Name("low_power_exit"));
  if (!client) return client.error();
  low_power_exit_ = std::move(client).value();
  if (!present) return Ok();
  auto touches = transport::MakeSubscription<msg::Int32>(
      dependencies_.node, dependencies_.Name("world/touch"),
      [this](const msg::Int32& touch, const auto&) { OnTouch(touch.data); });
  if (!touches) return touches.error();
  touches_ = std::move(touches).value();
  return Ok();
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
  return Error{MakeCode(ModuleCode::kTouch, KeyCode::kSelfCheckFailed),
               "no publisher of world/touch"};
}

}  // namespace musher::device
