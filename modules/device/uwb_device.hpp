#pragma once
// The ultra-wideband radio: how far and in which direction a tag is. Its readings are published
// while the tag is connected, which is said on `uwb_connected`.
//
// Threads: the loop's.

#include <memory>

#include "musher/messages/protocol/device.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/modules/device/dependencies.hpp"
#include "musher/transport/service.hpp"

namespace musher::device {

class UwbDevice {
 public:
  // `present`: there is one; else nothing is heard, and the service refuses.
  static Result<std::unique_ptr<UwbDevice>> Make(const Dependencies& around, bool present);

  // Fails with 1609 while no radio publishes readings.
  Result<> Check() const;

 private:
  UwbDevice(const Dependencies& around, bool present) : around_(around), present_(present) {}
  Result<> Connect();
  void OnReading(const msg::UwbRaw& reading);

  const Dependencies around_;
  const bool present_;
  bool connected_ = false;  // the tag
  bool refused_ = false;    // the last reading
  std::unique_ptr<transport::Publisher<msg::UwbRaw>> raw_;
  std::unique_ptr<transport::Server<msg::GetUWBMacSessionID>> session_;
  std::unique_ptr<transport::Subscription> connections_;
  std::unique_ptr<transport::Subscription> readings_;
};

}  // namespace musher::device
