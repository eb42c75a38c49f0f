#pragma once
// The lights: serves `led_execute` and shows what its arbiter decides.
//
// Threads: the loop's.

#include <memory>
#include <string>

#include "musher/messages/musher_msgs/body.hpp"
#include "musher/messages/protocol/device.hpp"
#include "musher/modules/device/dependencies.hpp"
#include "musher/modules/device/device_config.hpp"
#include "musher/modules/device/led.hpp"
#include "musher/modules/device/light_output.hpp"
#include "musher/modules/device/lights.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::device {

// A late subscriber of `world/led` gets all three lights.
inline constexpr transport::Qos kLedQos{transport::Qos::Reliability::kReliable,
                                        transport::Qos::Durability::kTransientLocal,
                                        static_cast<int>(kLedTargets.size())};

class LedDevice {
 public:
  // Without lights requests are checked and nothing is shown.
  static Result<std::unique_ptr<LedDevice>> Make(const Dependencies& dependencies,
                                                 const LedConfig& config);

  // Fails with 1109 while a light is not shown.
  Result<> Check() const;

  // The module's own requests.
  void Execute(const LightRequests& requests);

  // Blocks until all lights have been delivered, for at most a second.
  void Flush() {
    if (output_) output_->Flush();
  }

 private:
  LedDevice(const Dependencies& dependencies, const LedConfig& config)
      : dependencies_(dependencies),
        config_(config),
        endpoints_(dependencies.node, dependencies.name_space) {}
  Result<> Connect();
  std::unique_ptr<LightOutput> MakeOutput();
  Result<> Execute(const msg::LedExecute::Request& request);
  void ShowAll();

  const Dependencies dependencies_;
  const LedConfig config_;
  LedArbiter arbiter_;
  std::unique_ptr<LightOutput> output_;  // null: there are no lights
  transport::Endpoints endpoints_;       // last: its callbacks use the rest
};

}  // namespace musher::device
