#include "musher/modules/device/power_key_device.hpp"

#include <string>
#include <utility>

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
  if (config_.source == KeySource::kInput) {
    input_ = std::make_unique<InputKey>(
        dependencies_.node.loop(), config_.device, config_.code,
        [this](bool pressed) { OnKey(pressed); }, dependencies_.log);
    return endpoints_.opened();
  }
  if (config_.source == KeySource::kGpio) {
    OpenLine();
    return endpoints_.opened();
  }
  transport::SubscriptionEvents events;
  events.on_writer_lost = [this](transport::EndpointId) {
    pressed_ = false;
  };  // the next press counts
  endpoints_.Subscribe<msg::Bool>(
      "world/power_key", [this](const msg::Bool& pressed) { OnKey(pressed.data); },
      transport::kDefaultQos, std::move(events));
  return endpoints_.opened();
}

void PowerKeyDevice::OpenLine() {
  GpioInput::Events events;
  events.on_level = [this](bool pressed) { OnLine(pressed); };
  events.on_gap = [this] {
    was_released_ = false;
    OnKey(false);  // it may not have been held all the time
  };
  events.on_lost = [] {};
  events.log = [this](const std::string& line) { dependencies_.log("power key: " + line); };
  line_ = std::make_unique<GpioInput>(dependencies_.node.loop(), dependencies_.open_gpio,
                                      config_.line, std::move(events));
}

// One that is pressed from the start, or after a gap, may be none: its line has a short circuit, or
// is active at the other voltage.
void PowerKeyDevice::OnLine(bool pressed) {
  if (!pressed) was_released_ = true;
  if (was_released_) return OnKey(pressed);
  dependencies_.log(
      "power key: pressed at the start: it counts once it was released; if it is not pressed, "
      "change active_low, or look at its line");
}

void PowerKeyDevice::OnKey(bool pressed) {
  if (std::exchange(pressed_, pressed) == pressed) return;
  held_ = nullptr;
  if (!pressed) return;
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
