#pragma once
// The battery level from the robot's battery topic (protocol/BmsStatus), for capabilities that need
// a minimum: BatteryReading says which samples count.
//
// Threads: loop thread only.

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "musher/lifecycle/actuator/battery_reading.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/transport/node.hpp"

namespace musher::transport {

class BatteryWatch {
 public:
  // After this time without a sample the level is unknown.
  static constexpr Duration kSilent = std::chrono::seconds(10);

  // Called at every change: percent, or nullopt when the level becomes unknown. The level is
  // unknown at first. Samples above 100 % are ignored.
  using OnChange = std::function<void(std::optional<int>)>;

  static Result<std::unique_ptr<BatteryWatch>> Make(Node& node, const MachineConfig& config,
                                                    OnChange on_change);

 private:
  BatteryWatch(Node& node, Duration raise_after, OnChange on_change);
  void Set(std::optional<int> percent);

  Node& node_;
  const OnChange on_change_;
  BatteryReading reading_;
  std::optional<int> percent_;
  LoopHandlePtr silence_;
  std::unique_ptr<Subscription> samples_;
};

// The battery topic of a machine, in its namespace: of [policy.battery], else `bms_status`.
std::string BatteryTopic(const MachineConfig& config);

}  // namespace musher::transport
