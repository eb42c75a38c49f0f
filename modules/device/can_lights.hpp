#pragma once
// Lights with boards of their own on a CAN bus, as those of CyberDog: each has a command, and most
// acknowledge it. A light that is not acknowledged, or that its board has not got because the bus
// was lost, is sent again.
//
// Threads: the loop's.

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "musher/modules/device/can_link.hpp"
#include "musher/modules/device/can_protocol_toml.hpp"
#include "musher/modules/device/led_look.hpp"
#include "musher/modules/device/light_output.hpp"

namespace musher::device {

// The names that the file of a light may have.
const CanNames& LightCanNames();

// In the order of the targets; nothing: none.
using LightProtocols = std::array<std::optional<CanProtocol>, kLedTargets.size()>;

class CanLights : public LightOutput {
 public:
  static constexpr Duration kAcknowledged = std::chrono::seconds(1);  // else it is sent again

  CanLights(transport::EventLoop& loop, const CanBus::Open& open, const LightProtocols& protocols,
            const std::function<void(const std::string&)>& log);
  ~CanLights() override;

  void Show(const Lights& lights) override;
  std::string FaultOf(std::uint8_t target) const override;

 private:
  class Lamp;

  std::array<std::unique_ptr<Lamp>, kLedTargets.size()> lamps_;  // null: none
};

}  // namespace musher::device
