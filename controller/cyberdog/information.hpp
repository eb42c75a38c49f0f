#pragma once
// What CyberDog's manager knows of the robot beside its state: the battery, the errors that modules
// report, and what an app asks for at a glance.
//
// Threads: loop thread only.

#include <optional>
#include <string>
#include <vector>

#include "musher/lifecycle/config.hpp"
#include "musher/lifecycle/machine.hpp"
#include "musher/messages/protocol/device.hpp"
#include "musher/messages/protocol/manager.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::cyberdog {

class Information {
 public:
  // All must outlive it.
  Information(transport::Endpoints& endpoints, const MachineConfig& config, const Machine& machine);

 private:
  msg::BmsInfo::Response Battery() const;
  msg::DeviceInfo::Response About(const std::vector<bool>& enables) const;

  transport::EventLoop& loop_;
  const MachineConfig& config_;
  const Machine& machine_;
  std::optional<msg::BmsStatus> battery_;  // the last sample
  Time battery_at_{};
};

}  // namespace musher::cyberdog
