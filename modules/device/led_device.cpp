#include "musher/modules/device/led_device.hpp"

#include <utility>

#include "musher/base/check.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/cyberdog/codes/module_codes.hpp"
#include "musher/modules/device/can_lights.hpp"
#include "musher/modules/device/gpio_lights.hpp"
#include "musher/modules/device/host_lights.hpp"

namespace musher::device {
namespace {

// On `world/led`.
class WorldLights : public LightOutput {
 public:
  explicit WorldLights(transport::Publisher<msg::LedState>* publisher) : publisher_(publisher) {}

  // All of them each time: the latched topic keeps the last three samples, and so one of each
  // light.
  void Show(const Lights& lights) override {
    for (std::size_t i = 0; i < lights.size(); ++i) {
      const auto& [client, light] = lights.at(i);
      static_cast<void>(publisher_->Publish(
          {kLedTargets.at(i), light.mode, light.effect, light.r, light.g, light.b,
           std::string(kLedClients[static_cast<std::size_t>(client)])}));
    }
  }
  std::string FaultOf(std::uint8_t) const override {
    return publisher_->MatchedReaders() > 0 ? "" : "no subscriber of world/led";
  }
  void Flush() override {
    // A subscriber that has not got it by then is lost.
    static_cast<void>(publisher_->Flush(Milliseconds(1000)));
  }

 private:
  transport::Publisher<msg::LedState>* publisher_;
};

}  // namespace

Result<std::unique_ptr<LedDevice>> LedDevice::Make(const Dependencies& dependencies,
                                                   const LedConfig& config) {
  std::unique_ptr<LedDevice> device(new LedDevice(dependencies, config));
  if (Result<> connected = device->Connect(); !connected) return connected.error();
  return device;
}

Result<> LedDevice::Connect() {
  endpoints_.Serve<msg::LedExecute>(
      "led_execute", [this](const msg::LedExecute::Request& request, auto reply) {
        const Result<> done = Execute(request);
        if (!done) {
          dependencies_.log("led_execute of " + config_toml::Quote(request.client) + ": " +
                            done.error().message);
        }
        reply({done ? kCodeOk : done.error().code});
      });
  output_ = MakeOutput();
  if (endpoints_.opened()) ShowAll();
  return endpoints_.opened();
}

std::unique_ptr<LightOutput> LedDevice::MakeOutput() {
  transport::EventLoop& loop = dependencies_.node.loop();
  switch (config_.source) {
    case LedSource::kWorld: {
      auto* const publisher = endpoints_.Advertise<msg::LedState>("world/led", kLedQos);
      if (publisher == nullptr) return nullptr;
      return std::make_unique<WorldLights>(publisher);
    }
    case LedSource::kHost:
      return std::make_unique<HostLights>(loop, config_.folder, config_.names, dependencies_.log);
    case LedSource::kCan:
      return std::make_unique<CanLights>(loop, dependencies_.open_can, config_.frames,
                                         dependencies_.log);
    case LedSource::kGpio:
      return std::make_unique<GpioLights>(loop, dependencies_.open_gpio, config_.lines,
                                          dependencies_.log);
    case LedSource::kNone:
      break;
  }
  return nullptr;
}

// A light that is not shown is kept, and the reply is 1107, as of a board of CyberDog that does not
// answer. The topic of the world needs no subscriber.
Result<> LedDevice::Execute(const msg::LedExecute::Request& request) {
  const LedArbiter before = arbiter_;
  Result<> done = arbiter_.Execute(request);
  if (arbiter_ != before) ShowAll();
  if (!done) return done;
  const bool own = config_.source != LedSource::kWorld && output_;
  const std::string fault = own ? output_->FaultOf(request.target) : "";
  if (fault.empty()) return Ok();
  return Error{MakeCode(cyberdog::module_code::kLed, KeyCode::kTimeout),
               "kept until the light works: " + fault};
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

void LedDevice::ShowAll() {
  if (!output_) return;
  LightOutput::Lights lights;
  for (std::size_t i = 0; i < lights.size(); ++i) lights.at(i) = arbiter_.Show(kLedTargets.at(i));
  output_->Show(lights);
}

Result<> LedDevice::Check() const {
  if (!output_) return Ok();
  for (const std::uint8_t target : kLedTargets) {
    if (const std::string fault = output_->FaultOf(target); !fault.empty()) {
      return Error{MakeCode(cyberdog::module_code::kLed, KeyCode::kSelfCheckFailed), fault};
    }
  }
  return Ok();
}

}  // namespace musher::device
