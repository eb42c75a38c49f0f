#pragma once
// The ultra-wideband radio: distance and direction of a tag. Its readings are published while the
// tag is connected, as `uwb_connected` reports.
//
// Threads: the loop's.

#include <memory>

#include "musher/messages/protocol/device.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/modules/device/dependencies.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::device {

class UwbDevice {
 public:
  // `present`: there is one; else nothing is subscribed to, and the service refuses.
  static Result<std::unique_ptr<UwbDevice>> Make(const Dependencies& dependencies, bool present);

  // Fails with 1609 while no publisher of readings.
  Result<> Check() const;

 private:
  UwbDevice(const Dependencies& dependencies, bool present)
      : dependencies_(dependencies),
        present_(present),
        endpoints_(dependencies.node, dependencies.name_space) {}
  Result<> Connect();
  void OnReading(const msg::UwbRaw& reading);

  const Dependencies dependencies_;
  const bool present_;
  bool connected_ = false;  // the tag is connected
  bool refused_ = false;    // the last reading was refused

  transport::Publisher<msg::UwbRaw>* raw_ = nullptr;  // null: there is none
  transport::Subscription* readings_ = nullptr;       // the same
  transport::Endpoints endpoints_;                    // last: its callbacks use the rest
};

}  // namespace musher::device
