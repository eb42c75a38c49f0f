// musher-device-manager as a controller drives it: the real program over DDS.

#include <gmock/gmock.h>

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
#include "musher/test/modules/actuator_peer.hpp"

namespace musher::device::device_process_test {

using msg::ActuatorCommand;
using msg::LedExecute;
using ::testing::HasSubstr;

const std::vector<std::string> kAllStates = {"SetUp",    "TearDown", "SelfCheck",
                                             "Active",   "DeActive", "Protected",
                                             "LowPower", "OTA",      "Error"};

constexpr const char* kFile = R"(
critical = ["bms"]
self_check_ms = 300
[battery]
source = "world"
[touch]
source = "world"
[led]
source = "world"
)";

// The world that has the devices, and the program.
class DeviceManagerProcess : public ::testing::Test {
 protected:
  void Start() {
    peer_.Start(kFile);
    ASSERT_TRUE(peer_.AwaitVisible()) << peer_.Output();
  }
  // Makes the world; a reading of 55 % every 50 ms.
  void MakeWorld() {
    transport::Node& node = peer_.node();
    battery_ = transport::MakePublisher<msg::BatteryState>(node, "world/battery").value();
    touch_ = transport::MakePublisher<msg::Int32>(node, "world/touch").value();
    led_ =
        transport::MakeSubscription<msg::LedState>(
            node, "world/led",
            [this](const msg::LedState& state, const auto&) { shown_.push_back(state); }, kLedQos)
            .value();
    status_ = transport::MakeSubscription<msg::BmsStatus>(
                  node, "bms_status",
                  [this](const msg::BmsStatus& status, const auto&) { received_ = status; })
                  .value();
    ticker_ = node.loop().Every(Milliseconds(50), [this] {
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

  test::ActuatorPeer peer_{"device_manager", kAllStates, "musher-device-manager"};
  std::optional<msg::BmsStatus> received_;
  std::vector<msg::LedState> shown_;
  std::unique_ptr<transport::Publisher<msg::BatteryState>> battery_;
  std::unique_ptr<transport::Publisher<msg::Int32>> touch_;
  std::unique_ptr<transport::Subscription> led_;
  std::unique_ptr<transport::Subscription> status_;
  transport::LoopHandlePtr ticker_;
};

TEST_F(DeviceManagerProcess, RunsThroughAllStatesWithItsDevices) {
  MakeWorld();
  Start();
  ASSERT_TRUE(peer_.Until([&] { return received_.has_value(); })) << peer_.Output();
  EXPECT_EQ(received_->batt_soc, 55);
  for (const BuiltInState state : {kSelfCheck, kActive, kDeActive, kProtected, kOta, kError}) {
    const auto done = peer_.Switch(state);
    ASSERT_TRUE(done);
    EXPECT_EQ(done.value().verdict, ActuatorCommand::kVerdictDone) << state << peer_.Output();
    EXPECT_EQ(done.value().status.state, state);
  }
  EXPECT_EQ(peer_.Switch("LowPower").value().verdict, ActuatorCommand::kVerdictDone);
  EXPECT_TRUE(Shows(LedExecute::kTail, LedExecute::kRgbOff, "lowpower"));
  EXPECT_EQ(peer_.Switch("TearDown").value().verdict, ActuatorCommand::kVerdictDone);
  EXPECT_TRUE(Shows(LedExecute::kHead, LedExecute::kRedBlinkFast, "lowpower"));
  EXPECT_EQ(peer_.AwaitExit(), 0) << peer_.Output();
}

TEST_F(DeviceManagerProcess, FailsItsSelfCheckWithTheCriticalCodeAndNamesAllThatFail) {
  Start();
  const auto checked = peer_.Switch("SelfCheck");
  ASSERT_TRUE(checked);
  EXPECT_EQ(checked.value().verdict, ActuatorCommand::kVerdictFailed);
  EXPECT_EQ(checked.value().code, 1409);
  EXPECT_EQ(checked.value().message,
            "bms (critical): no publisher of world/battery, 1409; "
            "touch: no publisher of world/touch, 1509; led: no subscriber of world/led, 1109");
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
  Start();
  const auto leds = transport::MakeClient<LedExecute>(peer_.node(), "led_execute").value();
  std::optional<Result<LedExecute::Response>> answer;
  leds->Call({true, "vp", LedExecute::kMini, LedExecute::kUserColor, 0x09, 0, 0, 0},
             Milliseconds(10'000), [&](auto reply) { answer = reply; });
  ASSERT_TRUE(peer_.Until([&] { return answer.has_value(); }));
  ASSERT_TRUE(*answer);
  EXPECT_EQ(answer->value().code, 1124);
  EXPECT_THAT(peer_.Output(), HasSubstr("led_execute of \"vp\": target 3 has no effect 9"));

  const auto power = transport::MakeClient<msg::BmsCmd>(peer_.node(), "bms_cmd").value();
  std::optional<Result<msg::BmsCmd::Response>> powered;
  power->Call({msg::BmsCmd::kMotorsUp, 0}, Milliseconds(10'000),
              [&](auto reply) { powered = reply; });
  ASSERT_TRUE(peer_.Until([&] { return powered.has_value(); }));
  ASSERT_TRUE(*powered);
  EXPECT_EQ(powered->value(), (msg::BmsCmd::Response{false, 1403})) << "in SetUp";

  EXPECT_TRUE(peer_.Switch("LowPower"));
  EXPECT_TRUE(peer_.Until([&] { return touch_->MatchedReaders() > 0; }));
  ASSERT_TRUE(touch_->Publish({msg::TouchStatus::kDoubleTouch}));
  EXPECT_TRUE(peer_.Until([&] { return calls == 1; })) << peer_.Output();
}

TEST_F(DeviceManagerProcess, ReportsAnInvalidFileAndExitsWithTwo) {
  peer_.Start("[battery]\nsource = \"bucket\"\n");
  EXPECT_EQ(peer_.AwaitExit(), 2);
  EXPECT_THAT(peer_.Output(), HasSubstr("device_manager.toml:2:10: error: battery.source"));
}

}  // namespace musher::device::device_process_test
