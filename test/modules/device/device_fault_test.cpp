// The device manager under injected faults: motors are powered up in Active only, and never during
// an emergency stop; the tail light is off in LowPower.

#include <map>

#include "musher/messages/sensor_msgs/battery_state.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/modules/device/device_manager.hpp"
#include "musher/test/modules/module_fault_test.hpp"
#include "musher/transport/service.hpp"

namespace musher::device::device_fault_test {

// The robot's lights and motors, and a client that powers them.
class Desk {
 public:
  explicit Desk(transport::Node& desk)
      : lights_(transport::MakeSubscription<msg::LedState>(
                    desk, "world/led",
                    [this](const msg::LedState& light, const auto&) {
                      shown[light.target] = light.effect;
                    },
                    kLedQos)
                    .value()),
        motors_(transport::MakeSubscription<msg::Bool>(
                    desk, "world/motor_power",
                    [this](const msg::Bool& power, const auto&) { powered = power.data; },
                    transport::kLatchedQos)
                    .value()),
        client_(transport::MakeClient<msg::BmsCmd>(desk, "bms_cmd").value()) {}

  // The motors are off, and a client powers them up.
  void PowerMotors() {
    answered = powered = false;
    msg::BmsCmd::Request request;
    request.electric_machine_command = msg::BmsCmd::kMotorsUp;
    client_->Call(request, Milliseconds(900), [this](const auto&) { answered = true; });
  }

  std::map<std::uint8_t, std::uint8_t> shown;  // effects
  bool powered = false;
  bool answered = false;

 private:
  std::unique_ptr<transport::Subscription> lights_;
  std::unique_ptr<transport::Subscription> motors_;
  std::unique_ptr<transport::Client<msg::BmsCmd>> client_;
};

TEST(TheDeviceManager, PowersMotorsInActiveOnlyAndNeverInAnEmergencyUnderInjectedFaults) {
  testing::ModuleFaultTest<DeviceManager, Desk> test;
  test.make = [] {
    DeviceConfig config;
    config.led.source = LedSource::kWorld;
    config.critical = {"led"};
    return std::make_unique<DeviceManager>("device_manager", config);
  };
  const auto power = [&test] {
    test.Pass(Milliseconds(300));  // discovery
    test.peers->PowerMotors();
    EXPECT_TRUE(test.Await([&] { return test.peers->answered; }));
    test.Pass(Milliseconds(50));
    return test.peers->powered;
  };
  int powered = 0;
  int dark = 0;
  test.always = [&](const DeviceManager&, const ActuatorReport& report) {
    const bool permitted = report.state == kActive && report.emergency_stop == 0;
    const bool up = power();
    if (up) ++powered;
    EXPECT_TRUE(permitted || !up) << "motors are powered up in " << report.state;
    const bool off = test.peers->shown[msg::LedExecute::kTail] == msg::LedExecute::kRgbOff;
    if (off) ++dark;
    EXPECT_TRUE(off || report.state != kLowPower) << "the tail light is on in LowPower";
  };
  test.after_emergency_stop = [&](const DeviceManager&, const ActuatorReport& report) {
    if (report.state == kUninitialized) return;  // it has no services yet
    EXPECT_FALSE(power()) << "motors are powered up during a stop";
  };
  test.Run();
  EXPECT_GT(powered, 100) << "or nothing has been tried";
  EXPECT_GT(dark, 50) << "or nothing has been tried";
}

}  // namespace musher::device::device_fault_test
