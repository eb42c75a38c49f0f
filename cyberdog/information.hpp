#pragma once
// The robot's information that CyberDog's manager offers beside its state: the battery, the errors
// that modules report, and device information for an app.
//
// Threads: loop thread only.

#include <optional>
#include <string>
#include <vector>

#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/machine/machine.hpp"
#include "musher/messages/protocol/device.hpp"
#include "musher/messages/protocol/manager.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::cyberdog {

class Information {
 public:
  // All must outlive it. `serial_number` empty: unknown.
  Information(transport::Endpoints& endpoints, const MachineConfig& config, const Machine& machine,
              std::string serial_number);

 private:
  void ServeIdentity(transport::Endpoints& endpoints);
  msg::BmsInfo::Response Battery() const;
  msg::DeviceInfo::Response About(const std::vector<bool>& enables) const;

  transport::EventLoop& loop_;
  const MachineConfig& config_;
  const Machine& machine_;
  const std::string serial_number_;
  std::string uid_;  // of the account that the app has set; kept while this controller runs
  int serials_published_ = 0;  // times
  transport::LoopHandlePtr serial_timer_;
  std::optional<msg::BmsStatus> battery_;  // the last sample
  Time battery_at_{};
};

}  // namespace musher::cyberdog
