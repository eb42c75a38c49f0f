#pragma once
// The lights: serves `led_execute` and publishes what its arbiter decides on `world/led`.
//
// Threads: the loop's.

#include <memory>

#include "musher/messages/musher_msgs/body.hpp"
#include "musher/messages/protocol/device.hpp"
#include "musher/modules/device/dependencies.hpp"
#include "musher/modules/device/led.hpp"
#include "musher/modules/device/lights.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::device {

// A late subscriber gets all three lights.
inline constexpr transport::Qos kLedQos{transport::Qos::Reliability::kReliable,
                                        transport::Qos::Durability::kTransientLocal,
                                        static_cast<int>(kLedTargets.size())};

class LedDevice {
 public:
  // `present`: there are lights; else requests are checked and nothing is published.
  static Result<std::unique_ptr<LedDevice>> Make(const Dependencies& dependencies, bool present);

  // Fails with 1109 while `world/led` has no subscriber.
  Result<> Check() const;

  // The module's own requests.
  void Execute(const LightRequests& requests);

  // Blocks until all published lights have been delivered, for at most a second.
  void Flush();

 private:
  LedDevice(const Dependencies& dependencies, bool present)
      : dependencies_(dependencies),
        present_(present),
        endpoints_(dependencies.node, dependencies.name_space) {}
  Result<> Connect();
  void ShowAll();

  const Dependencies dependencies_;
  const bool present_;
  LedArbiter arbiter_;
  transport::Publisher<msg::LedState>* lights_ = nullptr;
  transport::Endpoints endpoints_;  // last: its callbacks use the rest
};

}  // namespace musher::device
