// musher-device-manager as a controller drives it: the real program over DDS.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/messages/musher_msgs/body.hpp"
#include "musher/messages/protocol/device.hpp"
#include "musher/messages/sensor_msgs/battery_state.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/modules/device/led_device.hpp"
#include "musher/test/modules/module_process.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::device::device_process_test {

using msg::ActuatorCommand;
using msg::LedExecute;
using ::testing::HasSubstr;

constexpr const char* kFile = R"(
critical = ["bms"]
self_check_ms = 5000
[battery]
source = "world"
[touch]
source = "world"
[led]
source = "world"
)";

// The world that has the devices, and the program.
class DeviceManagerProcess : public test::ModuleProcess {
 protected:
  DeviceManagerProcess() : ModuleProcess("device_manager", "musher-device-manager") {}

  // Makes the world; a reading of 55 % every 50 ms.
  void MakeWorld() {
    battery_ = Publisher<msg::BatteryState>("world/battery");
    touch_ = Publisher<msg::Int32>("world/touch");
    Subscribe<msg::LedState>(
        "world/led", [this](const msg::LedState& state) { shown_.push_back(state); }, kLedQos);
    Listen("bms_status", received_);
    ticker_ = peer_.node().loop().Every(Milliseconds(50), [this] {
      msg::BatteryState state;
      state.present = true;
      state.percentage = 0.55F;
      static_cast<void>(battery_->Publish(state));
    });
  }
  bool Shows(std::uint8_t target, std::uint8_t effect, const std::string& client) {
    return peer_.Until([&] {
      for (const msg::LedState& state : shown_) {
        if (state.target == target && state.effect == effect && state.client == client) return true;
      }
      return false;
    });
  }

  std::optional<msg::BmsStatus> received_;
  std::vector<msg::LedState> shown_;
  std::unique_ptr<transport::Publisher<msg::BatteryState>> battery_;
  std::unique_ptr<transport::Publisher<msg::Int32>> touch_;
  transport::LoopHandlePtr ticker_;
};

TEST_F(DeviceManagerProcess, RunsThroughAllStatesWithItsDevices) {
  MakeWorld();
  Start(kFile);
  ASSERT_TRUE(peer_.Until([&] { return received_.has_value(); })) << peer_.Output();
  EXPECT_EQ(received_->batt_soc, 55);
  for (const BuiltInState state : {kSelfCheck, kActive, kDeActive, kProtected, kOta, kError}) {
    const auto done = peer_.Switch(state);
    ASSERT_TRUE(done);
    EXPECT_EQ(done.value().verdict, ActuatorCommand::kVerdictDone) << state << peer_.Output();
    EXPECT_EQ(done.value().status.state, state);
  }
  ExpectDone(kLowPower);
  EXPECT_TRUE(Shows(LedExecute::kTail, LedExecute::kRgbOff, "lowpower"));
  ExpectTornDown();
  EXPECT_TRUE(Shows(LedExecute::kHead, LedExecute::kRedBlinkFast, "lowpower"));
}

TEST_F(DeviceManagerProcess, FailsItsSelfCheckWithTheCriticalCodeAndNamesAllThatFail) {
  std::string file = kFile;
  file.replace(file.find("5000"), 4, "300");
  Start(file);
  EXPECT_EQ(Failure(kSelfCheck),
            "1409 bms (critical): no publisher of world/battery, 1409; "
            "touch: no publisher of world/touch, 1509; led: no subscriber of world/led, 1109");
}

TEST_F(DeviceManagerProcess, StartsWithoutItsCanBusAndSaysWhatIsMissing) {
  Start("critical = [\"bms\"]\nself_check_ms = 300\n[battery]\nsource = \"can\"\nframes = \"" +
        SourceDir() + "/config/device/can/battery.toml\"\n");
  const std::string failure = Failure(kSelfCheck);
  EXPECT_THAT(failure, ::testing::StartsWith("1409 bms (critical): "));
  EXPECT_THAT(failure, ::testing::AnyOf(HasSubstr("'can0'"), HasSubstr("can0: ")));
}

TEST_F(DeviceManagerProcess, AnswersItsServicesByTheRulesAndWakesTheRobotByADoubleTap) {
  MakeWorld();
  int calls = 0;
  const auto manager = transport::MakeServer<msg::Trigger>(peer_.node(), "low_power_exit",
                                                           [&calls](const auto&, auto reply) {
                                                             ++calls;
                                                             reply({true, ""});
                                                           })
                           .value();
  Start(kFile);
  const auto lit = Call<LedExecute>(
      "led_execute", {true, "vp", LedExecute::kMini, LedExecute::kUserColor, 0x09, 0, 0, 0});
  EXPECT_EQ(lit.code, 1124);
  EXPECT_TRUE(AwaitOutput("led_execute of \"vp\": target 3 has no effect 9")) << peer_.Output();
  EXPECT_EQ(Call<msg::BmsCmd>("bms_cmd", {msg::BmsCmd::kMotorsUp, 0}),
            (msg::BmsCmd::Response{false, 1403}))
      << "in SetUp";
  EXPECT_TRUE(peer_.Switch("LowPower"));
  EXPECT_TRUE(peer_.Until([&] { return touch_->MatchedReaders() > 0; }));
  ASSERT_TRUE(touch_->Publish({msg::TouchStatus::kDoubleTouch}));
  EXPECT_TRUE(peer_.Until([&] { return calls == 1; })) << peer_.Output();
}

}  // namespace musher::device::device_process_test
