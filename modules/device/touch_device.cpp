#include "musher/modules/device/touch_device.hpp"
#include "musher/cyberdog/codes/module_codes.hpp"
#include "musher/messages/stamp.hpp"

#include <chrono>
#include <string>
#include <utility>
#include <vector>

namespace musher::device {

Result<std::unique_ptr<TouchDevice>> TouchDevice::Make(const Dependencies& dependencies,
                                                       const TouchConfig& config) {
  std::unique_ptr<TouchDevice> device(new TouchDevice(dependencies, config));
  if (Result<> connected = device->Connect(); !connected) return connected.error();
  return device;
}

Result<> TouchDevice::Connect() {
  status_ = endpoints_.Advertise<msg::TouchStatus>("touch_status");
  low_power_exit_ = endpoints_.OpenClient<msg::Trigger>("low_power_exit");
  if (config_.source == KeySource::kWorld) {
    touches_ = endpoints_.Subscribe<msg::Int32>(
        "world/touch", [this](const msg::Int32& touch) { OnTouch(touch.data); });
  }
  if (Result<> opened = endpoints_.opened(); !opened) return opened;
  if (config_.source == KeySource::kInput) OpenInput();
  if (config_.source == KeySource::kGpio) OpenLine();
  return Ok();
}

void TouchDevice::OpenInput() {
  std::vector<std::uint16_t> codes;
  const auto& [tap, single, double_tap, hold] = config_.codes;
  for (const std::uint16_t code : {tap, single, double_tap, hold}) {
    if (code != 0) codes.push_back(code);
  }
  InputDevice::Events events;
  events.on_key = [this](std::uint16_t code, bool pressed) { OnKey(code, pressed); };
  events.on_gap = [this] { ForgetTaps(); };
  events.log = [this](const std::string& line) { dependencies_.log("touch: " + line); };
  input_ = std::make_unique<InputDevice>(dependencies_.node.loop(), config_.input, std::move(codes),
                                         std::move(events));
}

// As a pad that reports only that it is touched.
void TouchDevice::OpenLine() {
  GpioInput::Events events;
  events.on_level = [this](bool touched) { OnPad(touched); };
  events.on_gap = [this] { ForgetTaps(); };
  events.on_lost = [] {};
  events.log = [this](const std::string& line) { dependencies_.log("touch: " + line); };
  line_ = std::make_unique<GpioInput>(dependencies_.node.loop(), dependencies_.open_gpio,
                                      config_.line, std::move(events));
}

void TouchDevice::ForgetTaps() {
  taps_.Forget();
  tap_time_.reset();
}

void TouchDevice::OnPad(bool touched) {
  if (const auto touch = taps_.OnTouch(touched, dependencies_.node.loop().Now())) OnTouch(*touch);
  ArmTaps();
}

void TouchDevice::OnKey(std::uint16_t code, bool pressed) {
  const TouchCodes& codes = config_.codes;
  if (code == codes.tap) return OnPad(pressed);
  const bool begins = pressed ? pressed_.insert(code).second : (pressed_.erase(code), false);
  if (!begins) return;
  if (code == codes.single) OnTouch(msg::TouchStatus::kSingle);
  if (code == codes.double_tap) OnTouch(msg::TouchStatus::kDoubleTouch);
  if (code == codes.hold) OnTouch(msg::TouchStatus::kHold);
}

void TouchDevice::ArmTaps() {
  tap_time_.reset();
  const auto due = taps_.NextDeadline();
  if (!due) return;
  tap_time_ = dependencies_.node.loop().At(*due, [this, at = *due] { OnTapTime(at); });
}

// A process that was suspended runs its timers first: the key may be released since.
void TouchDevice::OnTapTime(Time due) {
  transport::EventLoop& loop = dependencies_.node.loop();
  const Time now = loop.Now();
  if (now > due + kLate) {
    const Time again = now + kLate;
    tap_time_ = loop.At(again, [this, again] { OnTapTime(again); });
    return;
  }
  if (const auto touch = taps_.OnTime(now)) OnTouch(*touch);
  ArmTaps();
}

void TouchDevice::OnTouch(std::int32_t touch_state) {
  if (!IsTouch(touch_state)) {
    return dependencies_.log("touch: refused: unknown touch " + std::to_string(touch_state));
  }
  const msg::Stamp stamp = dependencies_.stamp();
  static_cast<void>(status_->Publish(
      {{stamp, "touch"}, touch_state, static_cast<std::uint64_t>(FromStamp(stamp).count())}));
  const bool counts = double_tap_.Take(touch_state, dependencies_.clock.Now());
  if (!counts || dependencies_.state() != kLowPower) return;
  if (const auto could_not_run = breaks_.Recent()) {
    return dependencies_.log("touch: a double tap is ignored: this process could not run for " +
                             std::to_string(ToMilliseconds(*could_not_run) / 1000) +
                             " s, and it may be as old; tap again");
  }
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
  const auto failed = [](const std::string& why) {
    return Error{MakeCode(cyberdog::module_code::kTouch, KeyCode::kSelfCheckFailed), why};
  };
  if (input_ && !input_->fault().empty()) return failed("the input device: " + input_->fault());
  if (line_ && !line_->fault().empty()) return failed("the line: " + line_->fault());
  if (touches_ && touches_->MatchedWriters() == 0) return failed("no publisher of world/touch");
  return Ok();
}

}  // namespace musher::device
