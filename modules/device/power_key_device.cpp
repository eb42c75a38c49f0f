#include "musher/modules/device/power_key_device.hpp"

#include <string>
#include <utility>
#include <vector>

namespace musher::device {

Result<std::unique_ptr<PowerKeyDevice>> PowerKeyDevice::Make(const Dependencies& dependencies,
                                                             const PowerKeyConfig& config) {
  std::unique_ptr<PowerKeyDevice> device(new PowerKeyDevice(dependencies, config));
  if (config.source == KeySource::kNone) return device;
  // On a secured machine power-off may be reserved for an operator: the module starts all the
  // same.
  if (Result<> connected = device->Connect(); !connected) {
    dependencies.log("power key: disabled: " + connected.error().message);
  }
  return device;
}

Result<> PowerKeyDevice::Connect() {
  power_off_ = endpoints_.OpenClient<msg::Trigger>("poweroff");
  if (power_off_ == nullptr) return endpoints_.opened();  // disabled: no key is received
  if (config_.source == KeySource::kInput) OpenInput();
  if (config_.source == KeySource::kGpio) OpenLine();
  if (config_.source != KeySource::kWorld) return endpoints_.opened();
  static_cast<void>(key_.OnState(false));  // its topic has presses and releases only
  transport::SubscriptionEvents events;
  events.on_writer_lost = [this](transport::EndpointId) {
    static_cast<void>(key_.OnState(false));  // the next press counts
  };
  endpoints_.Subscribe<msg::Bool>(
      "world/power_key", [this](const msg::Bool& pressed) { Follow(key_.OnState(pressed.data)); },
      transport::kDefaultQos, std::move(events));
  return endpoints_.opened();
}

void PowerKeyDevice::OpenInput() {
  InputDevice::Events events;
  events.on_key = [this](std::uint16_t, bool pressed) { Follow(key_.OnState(pressed)); };
  events.on_gap = [this] { OnGap(key_.OnGap()); };
  events.log = [this](const std::string& line) { dependencies_.log("power key: " + line); };
  events.on_open = [this] { Follow(key_.OnUnseen()); };
  input_ =
      std::make_unique<InputDevice>(dependencies_.node.loop(), InputSource{config_.device, ""},
                                    std::vector<std::uint16_t>{config_.code}, std::move(events));
}

void PowerKeyDevice::OpenLine() {
  GpioInput::Events events;
  events.on_level = [this](bool pressed) { Follow(key_.OnState(pressed)); };
  events.on_gap = [this] { OnGap(key_.OnUnseen()); };
  events.on_lost = [] {};
  events.log = [this](const std::string& line) { dependencies_.log("power key: " + line); };
  line_ = std::make_unique<GpioInput>(dependencies_.node.loop(), dependencies_.open_gpio,
                                      config_.line, std::move(events));
}

void PowerKeyDevice::OnGap(PowerKey::Effect effect) {
  if (effect == PowerKey::Effect::kEnds) {
    dependencies_.log(
        "power key: events are missing while it is pressed: the time so far does not count");
  }
  Follow(effect);
}

void PowerKeyDevice::Follow(PowerKey::Effect effect) {
  if (effect == PowerKey::Effect::kNone) return;
  if (effect == PowerKey::Effect::kIgnored) {
    return dependencies_.log(
        std::string("power key: pressed at the start: it counts once it was released; if it is not "
                    "pressed, ") +
        (config_.source == KeySource::kGpio ? "change active_low, or look at its line"
                                            : "it is stuck, or another key is meant"));
  }
  held_ = nullptr;
  if (effect == PowerKey::Effect::kEnds) return;
  transport::EventLoop& loop = dependencies_.node.loop();
  const Time due = loop.Now() + config_.hold;
  held_ = loop.At(due, [this, due] { OnHeld(due); });
}

// A process that was suspended runs its timers first: the release may be queued.
void PowerKeyDevice::OnHeld(Time due) {
  transport::EventLoop& loop = dependencies_.node.loop();
  const Time now = loop.Now();
  if (now <= due + kLate) return PowerOff();
  const Time again = now + kLate;
  held_ = loop.At(again, [this, again] { OnHeld(again); });
}

void PowerKeyDevice::PowerOff() {
  dependencies_.log("power key: held for " + std::to_string(ToMilliseconds(config_.hold)) +
                    " ms: power-off requested");
  power_off_->Call({}, kPowerOffTime, [this](const Result<msg::Trigger::Response>& answer) {
    if (!answer) return dependencies_.log("power key: poweroff: " + answer.error().message);
    if (!answer.value().success) {
      dependencies_.log("power key: poweroff refused: " + answer.value().message);
    }
  });
}

}  // namespace musher::device
