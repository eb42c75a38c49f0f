#pragma once
// What the battery has, as the robot's battery topic (protocol/BmsStatus) tells it: for those who
// refuse what needs more.
//
// Threads: loop thread only.

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "musher/lifecycle/config.hpp"
#include "musher/transport/node.hpp"

namespace musher::transport {

class BatteryWatch {
 public:
  // Without a sample for so long the level is not known any more.
  static constexpr Duration kSilent = std::chrono::seconds(10);

  // Hears of every change: percent, or nullopt when it is not known any more. Not known is also
  // where it begins. Samples above 100 % are no levels and do not count.
  using OnChange = std::function<void(std::optional<int>)>;

  static Result<std::unique_ptr<BatteryWatch>> Make(Node& node, const std::string& topic,
                                                    OnChange on_change);

 private:
  BatteryWatch(Node& node, OnChange on_change);
  void Tell(std::optional<int> percent);

  Node& node_;
  const OnChange on_change_;
  std::optional<int> told_;
  LoopHandlePtr silence_;
  std::unique_ptr<Subscription> samples_;
};

// The topic on which a machine's battery is told of, in its namespace: that of the policy, else
// `bms_status`.
std::string BatteryTopic(const MachineConfig& config);

}  // namespace musher::transport
