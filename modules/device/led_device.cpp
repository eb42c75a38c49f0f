#include "musher/modules/device/led_device.hpp"

#include <string>
#include <utility>

#include "musher/base/check.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/cyberdog/codes/module_codes.hpp"

namespace musher::device {

Result<std::unique_ptr<LedDevice>> LedDevice::Make(const Dependencies& dependencies, bool present) {
  std::unique_ptr<LedDevice> device(new LedDevice(dependencies, present));
  if (Result<> connected = device->Connect(); !connected) return connected.error();
  return device;
}

Result<> LedDevice::Connect() {
  lights_ = endpoints_.Advertise<msg::LedState>("world/led", kLedQos);
  endpoints_.Serve<msg::LedExecute>(
      "led_execute", [this](const msg::LedExecute::Request& request, auto reply) {
        const LedArbiter before = arbiter_;
        const Result<> done = arbiter_.Execute(request);
        if (!done) {
          dependencies_.log("led_execute of " + config_toml::Quote(request.client) + ": " +
                            done.error().message);
        }
        if (arbiter_ != before) ShowAll();
        reply({done ? kCodeOk : done.error().code});
      });
  if (endpoints_.opened()) ShowAll();
  return endpoints_.opened();
}

void LedDevice::Execute(const LightRequests& requests) {
  const LedArbiter before = arbiter_;
  for (const auto& request : requests) {
    const Result<> done = arbiter_.Execute(request);
    MUSHER_CHECK(done || done.error().code == LedCode(LedKey::kStored));
    static_cast<void>(done);
  }
  if (arbiter_ != before) ShowAll();
}

// All of them each time: the latched topic keeps the last three samples, and so one of each light.
void LedDevice::ShowAll() {
  if (!present_) return;
  for (const std::uint8_t target : kLedTargets) {
    const auto [client, light] = arbiter_.Show(target);
    static_cast<void>(
        lights_->Publish({target, light.mode, light.effect, light.r, light.g, light.b,
                          std::string(kLedClients[static_cast<std::size_t>(client)])}));
  }
}

void LedDevice::Flush() {
  static_cast<void>(
      lights_->Flush(Milliseconds(1000)));  // a subscriber that has not got it by then is lost
}

Result<> LedDevice::Check() const {
  if (!present_ || lights_->MatchedReaders() > 0) return Ok();
  return Error{MakeCode(cyberdog::module_code::kLed, KeyCode::kSelfCheckFailed),
               "no subscriber of world/led"};
}

}  // namespace musher::device
