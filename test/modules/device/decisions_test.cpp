// The small decisions: battery lights, touches and the outcome of the self-check.

#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "musher/modules/device/led.hpp"
#include "musher/modules/device/lights.hpp"
#include "musher/modules/device/self_check.hpp"
#include "musher/modules/device/touch.hpp"

namespace musher::device::decisions_test {

using msg::LedExecute;
using Shown = LedArbiter::Shown;
using ::testing::HasSubstr;

// An arbiter after these requests.
LedArbiter After(const std::vector<LightRequests>& all) {
  LedArbiter arbiter;
  for (const LightRequests& requests : all) {
    for (const auto& request : requests) {
      const Result<> done = arbiter.Execute(request);
      EXPECT_TRUE(done || done.error().code == 1125) << done.error().message;
    }
  }
  return arbiter;
}

Light Color(std::uint8_t effect, std::uint8_t r, std::uint8_t g, std::uint8_t b) {
  return {LedExecute::kUserColor, effect, r, g, b};
}

TEST(BatteryLights, FollowTheCharge) {
  const auto head = [](int percent, bool charging) {
    return After({BatteryLights(percent, charging)}).Show(LedExecute::kHead);
  };
  EXPECT_EQ(head(20, false), (Shown{LedClient::kBms, Color(9, 0xFF, 0x32, 0x32)}));
  EXPECT_EQ(head(20, true), (Shown{LedClient::kBms, Color(6, 0xFF, 0x32, 0x32)}));
  EXPECT_EQ(head(21, false), (Shown{LedClient::kSystem, Color(9, 0x75, 0xFC, 0xF6)}));
  EXPECT_EQ(head(79, true), (Shown{LedClient::kBms, Color(6, 0x75, 0xFC, 0xF6)}));
  EXPECT_EQ(head(80, false), (Shown{LedClient::kSystem, Color(9, 0x06, 0x21, 0xE2)}));
  EXPECT_EQ(head(100, true), (Shown{LedClient::kBms, Color(6, 0x06, 0x21, 0xE2)}));
}

TEST(BatteryLights, WarnOnTheMiniLightOnlyWhenLowAndNotCharging) {
  const Shown ground = LedArbiter().Show(LedExecute::kMini);
  EXPECT_EQ(After({BatteryLights(20, false)}).Show(LedExecute::kMini),
            (Shown{LedClient::kBms, Color(0x30, 0xFF, 0, 0)}));
  EXPECT_EQ(After({BatteryLights(20, false), BatteryLights(20, true)}).Show(LedExecute::kMini),
            ground);
  EXPECT_EQ(After({BatteryLights(20, false), BatteryLights(21, false)}).Show(LedExecute::kMini),
            ground);
}

TEST(BatteryLights, HideNoOtherClientWhileTheBatteryIsOk) {
  const LightRequests tracking = {
      {true, "tracking", LedExecute::kHead, LedExecute::kUserColor, 1, 0, 0, 0}};
  EXPECT_EQ(After({tracking, BatteryLights(50, false)}).Show(LedExecute::kHead).client,
            LedClient::kTracking);
  EXPECT_EQ(After({tracking, BatteryLights(5, false)}).Show(LedExecute::kHead).client,
            LedClient::kBms);
}

TEST(LowPowerLights, TurnTheTailOffAndGiveItBack) {
  const LedArbiter off = After({BatteryLights(10, false), LowPowerLights(true)});
  EXPECT_EQ(off.Show(LedExecute::kTail),
            (Shown{LedClient::kLowPower, {LedExecute::kPredefined, 0xA0, 0, 0, 0}}));
  EXPECT_EQ(off.Show(LedExecute::kHead).client, LedClient::kBms);
  EXPECT_EQ(After({BatteryLights(10, false), LowPowerLights(true), LowPowerLights(false)}),
            After({BatteryLights(10, false)}));
}

TEST(LowPowerLights, BreatheOnTheTailWhenLowPowerIsLeft) {
  const LedArbiter left =
      After({BatteryLights(50, false), LowPowerLights(true), LeavingLowPowerLights()});
  EXPECT_EQ(left.Show(LedExecute::kTail), (Shown{LedClient::kSystem, Color(4, 0x06, 0x21, 0xE2)}));
  EXPECT_EQ(left.Show(LedExecute::kHead),
            After({BatteryLights(50, false)}).Show(LedExecute::kHead));
}

TEST(ShutdownLights, AreHiddenByNoOtherClient) {
  const LedArbiter arbiter = After({ShutdownLights(), BatteryLights(0, false)});
  EXPECT_EQ(arbiter.Show(LedExecute::kHead).light, (Light{LedExecute::kPredefined, 0xA3, 0, 0, 0}));
  EXPECT_EQ(arbiter.Show(LedExecute::kTail).light, (Light{LedExecute::kPredefined, 0xA3, 0, 0, 0}));
  EXPECT_EQ(arbiter.Show(LedExecute::kMini).light, Color(0x31, 0xFF, 0, 0));
}

TEST(Touch, ReadsTheCodesOfThePad) {
  for (const int known : {1, 3, 7, 8, 9, 0x11}) EXPECT_TRUE(IsTouch(known)) << known;
  for (const int unknown : {-1, 0, 2, 4, 6, 0x12, 1000}) EXPECT_FALSE(IsTouch(unknown)) << unknown;
}

TEST(DoubleTap, CountsAtLeastTwoSecondsAfterTheLastThatDid) {
  DoubleTap taps;
  const Time start;
  EXPECT_TRUE(taps.Take(3, start));
  EXPECT_FALSE(taps.Take(3, start + Milliseconds(1999)));
  EXPECT_TRUE(taps.Take(3, start + Milliseconds(2000)));
  EXPECT_FALSE(taps.Take(1, start + Milliseconds(9000)));
}

TEST(DoubleTap, CountsAgainAfterTheClockWentBack) {
  DoubleTap taps;
  EXPECT_TRUE(taps.Take(3, Time(Milliseconds(60'000))));
  EXPECT_FALSE(taps.Take(3, Time(Milliseconds(100))));
  taps.Forget();
  EXPECT_TRUE(taps.Take(3, Time(Milliseconds(100))));
}

std::optional<std::int32_t> Tap(Taps& taps, Time at) {
  const auto first = taps.OnTouch(true, at);
  const auto second = taps.OnTouch(false, at + Milliseconds(50));
  return second ? second : first;
}

TEST(Taps, AreSingleOnceNoSecondOneFollows) {
  Taps taps;
  const Time start;
  EXPECT_EQ(Tap(taps, start), std::nullopt);
  EXPECT_EQ(taps.NextDeadline(), start + Milliseconds(350));
  EXPECT_EQ(taps.OnTime(start + Milliseconds(349)), std::nullopt);
  EXPECT_EQ(taps.OnTime(start + Milliseconds(350)), 1);
  EXPECT_EQ(taps.NextDeadline(), std::nullopt);
}

TEST(Taps, AreDoubleWhenTheSecondOneFollowsWithin300ms) {
  Taps taps;
  const Time start;
  Tap(taps, start);
  EXPECT_EQ(Tap(taps, start + Milliseconds(340)), 3);
  EXPECT_EQ(taps.NextDeadline(), std::nullopt);
  Tap(taps, start + Milliseconds(1000));
  EXPECT_EQ(Tap(taps, start + Milliseconds(1400)), 1) << "too late: the first one was single";
}

TEST(Taps, ThatLastAreAHold) {
  Taps taps;
  const Time start;
  EXPECT_EQ(taps.OnTouch(true, start), std::nullopt);
  EXPECT_EQ(taps.OnTouch(true, start), std::nullopt) << "the same once more";
  EXPECT_EQ(taps.OnTime(start + Milliseconds(800)), 7);
  EXPECT_EQ(taps.OnTouch(false, start + Milliseconds(900)), std::nullopt);
  EXPECT_EQ(taps.OnTouch(true, start + Milliseconds(2000)), std::nullopt);
  EXPECT_EQ(taps.OnTouch(false, start + Milliseconds(3000)), 7) << "its timer came late";
}

DeviceResult Well(const std::string& device) {
  return {device, Ok()};
}
DeviceResult Failing(const std::string& device, std::int32_t code) {
  return {device, Error{code, "silent"}};
}

TEST(DeviceSelfCheck, PassesWhenAllAreOk) {
  EXPECT_TRUE(EvaluateSelfCheck({Well("bms"), Well("led")}, {"bms"}).well());
  EXPECT_TRUE(EvaluateSelfCheck({}, {}).well());
}

TEST(DeviceSelfCheck, IsPassedDegradedWithoutDevicesThatAreNotCritical) {
  const SelfCheckVerdict verdict =
      EvaluateSelfCheck({Well("bms"), Failing("touch", 1509), Failing("led", 1109)}, {"bms"});
  EXPECT_TRUE(verdict.result) << "a dead light does not keep the robot from its work";
  EXPECT_EQ(verdict.degraded.code, 1509);
  EXPECT_EQ(verdict.degraded.message, "touch: silent, 1509; led: silent, 1109");
}

TEST(DeviceSelfCheck, GivesTheCodeOfACriticalDeviceBeforeAllOthers) {
  const Result<> result =
      EvaluateSelfCheck({Failing("bms", 1409), Failing("touch", 1509), Failing("led", 1109)},
                        {"led"})
          .result;
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, 1109);
  EXPECT_THAT(result.error().message, HasSubstr("led (critical): silent, 1109"));
}

// The sum of these codes is a multiple of 256, which CyberDog's manager treats as "ok".
TEST(DeviceSelfCheck, IsNotPassedByFailuresWhoseCodesAddUpToNothing) {
  EXPECT_FALSE(EvaluateSelfCheck({Failing("bms", 1151), Failing("led", 1153)}, {}).well());
  EXPECT_FALSE(EvaluateSelfCheck({Failing("bms", 1151), Failing("led", 1153)}, {"led"}).result);
}

}  // namespace musher::device::decisions_test
