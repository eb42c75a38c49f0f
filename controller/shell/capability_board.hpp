#pragma once
// Publishes what the robot can do now, and why not the rest: latched on `musher/capabilities`, at
// every change.
//
// Threads: loop thread only.

#include <memory>
#include <optional>

#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/machine/machine.hpp"
#include "musher/messages/musher_msgs/capabilities.hpp"
#include "musher/transport/node.hpp"
#include "musher/wire/battery_watch.hpp"

namespace musher {

class CapabilityBoard {
 public:
  // All must outlive it.
  static Result<std::unique_ptr<CapabilityBoard>> Make(transport::Node& node,
                                                       const MachineConfig& config,
                                                       const Machine& machine);

  // The machine may have changed: publishes soon if the capabilities change.
  void Refresh();

  msg::Capabilities Now() const;

 private:
  CapabilityBoard(transport::Node& node, const MachineConfig& config, const Machine& machine);
  Result<> Open();
  void Publish();

  transport::Node& node_;
  const MachineConfig& config_;
  const Machine& machine_;
  std::optional<int> battery_;  // %; subscribed to only if a capability needs it
  std::optional<msg::Capabilities> published_;
  Time evaluated_at_{};
  transport::LoopHandlePtr later_;
  std::unique_ptr<transport::Publisher<msg::Capabilities>> publisher_;
  std::unique_ptr<transport::BatteryWatch> battery_watch_;
};

}  // namespace musher
