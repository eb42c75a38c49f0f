#pragma once
// The battery: takes readings from the world, the host, a CAN or an I2C bus, publishes `bms_status`
// and serves `bms_cmd`. When the source is silent this is logged, and its last value is not
// repeated.
//
// Threads: the loop's.

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "musher/messages/protocol/device.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/modules/device/battery.hpp"
#include "musher/modules/device/can_battery.hpp"
#include "musher/modules/device/dependencies.hpp"
#include "musher/modules/device/device_config.hpp"
#include "musher/modules/device/i2c_link.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::device {

class BatteryDevice {
 public:
  static constexpr Duration kLeastPause = Milliseconds(800);  // between two messages

  // `on_status` is called for each published status.
  using OnStatus = std::function<void(const msg::BmsStatus&)>;
  static Result<std::unique_ptr<BatteryDevice>> Make(const Dependencies& dependencies,
                                                     const BatteryConfig& config,
                                                     OnStatus on_status);

  // Fails with 1409 while there is no valid reading; without a source there is nothing to check.
  Result<> Check() const;

  // The clock went back: periods measured with it start again.
  void OnTimeJumped();

 private:
  using Command = msg::BmsCmd;

  BatteryDevice(const Dependencies& dependencies, const BatteryConfig& config, OnStatus on_status);
  Result<> Connect();

  void OpenCan();
  void OpenI2c();
  void ReadHost();
  void OnReading(const BatteryReading& reading);
  void Refuse(const std::string& reason);
  void RestartSilenceTimer();
  void Lose(const std::string& why);
  void PublishWhenDue();
  void Publish();
  using Done = CanBattery::Done;
  void Execute(const Command::Request& request, const Done& done);
  void PowerMotors(bool up, const Done& done);

  const Dependencies dependencies_;
  const BatteryConfig config_;
  const OnStatus on_status_;

  BatteryFilter filter_;
  std::optional<BatteryReading> valid_;  // the last valid reading; nothing once it is too old
  std::string fault_ = "no reading received yet";  // empty: none
  bool motors_powered_ = true;
  std::optional<Time> published_;

  transport::LoopHandlePtr poll_;
  transport::LoopHandlePtr silence_;
  transport::LoopHandlePtr due_;
  transport::Publisher<msg::BmsStatus>* status_ = nullptr;
  transport::Publisher<msg::Bool>* motor_power_ = nullptr;
  transport::Subscription* readings_ = nullptr;  // null: not of the world
  std::unique_ptr<CanBattery> can_;              // null: not on a CAN bus
  std::unique_ptr<I2cLink> i2c_;                 // null: not on an I2C bus
  transport::Endpoints endpoints_;               // last: its callbacks use the rest
};

}  // namespace musher::device
