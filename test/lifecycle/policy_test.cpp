#include "musher/lifecycle/policy/policy.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "musher/test/lifecycle/coordination/policy.hpp"

namespace musher::testing::policy_test {

using enum BatteryLevel;

BatteryLevel At(int percent, BatteryLevel before = kFree) {
  return LevelAt(BatteryPolicy{}, percent, before);
}

TEST(BatteryLevels, BeginAtTheirPercentage) {
  EXPECT_EQ(At(100), kFree);
  EXPECT_EQ(At(21), kFree);
  EXPECT_EQ(At(20), kProtected);
  EXPECT_EQ(At(6), kProtected);
  EXPECT_EQ(At(5), kLowPower);
  EXPECT_EQ(At(1), kLowPower);
  EXPECT_EQ(At(0), kEmpty);
}

TEST(BatteryLevels, AreLeftTwoPercentAbove) {
  EXPECT_EQ(At(21, kProtected), kProtected);
  EXPECT_EQ(At(22, kProtected), kFree);
  EXPECT_EQ(At(6, kLowPower), kLowPower);
  EXPECT_EQ(At(7, kLowPower), kProtected);
  EXPECT_EQ(At(21, kLowPower), kProtected) << "a jump leaves the lower and is held by the upper";
  EXPECT_EQ(At(22, kLowPower), kFree);
}

TEST(BatteryLevels, AnEmptyBatteryIsNotEmptyAtOnePercent) {
  EXPECT_EQ(At(1, kEmpty), kLowPower);
}

RC_GTEST_PROP(BatteryLevels, DoNotDependOnTheHistoryBeyondTheirHysteresis, ()) {
  BatteryPolicy policy;
  policy.protected_at = *rc::gen::inRange(2, 99);
  policy.low_power_at = *rc::gen::inRange(1, policy.protected_at);
  policy.hysteresis = *rc::gen::inRange(0, policy.protected_at - policy.low_power_at + 1);
  const int percent = *rc::gen::inRange(0, 101);
  const auto before = static_cast<BatteryLevel>(*rc::gen::inRange(0, 4));
  const BatteryLevel level = LevelAt(policy, percent, before);
  const BatteryLevel fresh = LevelAt(policy, percent, kFree);
  RC_ASSERT(level >= fresh);  // never higher than the percentage allows
  const bool held =
      (percent > policy.protected_at && percent < policy.protected_at + policy.hysteresis) ||
      (percent > policy.low_power_at && percent < policy.low_power_at + policy.hysteresis);
  if (!held) RC_ASSERT(level == fresh);
}

TEST(PolicyRequests, AreKnownByTheirNamesOnTheWire) {
  for (int i = 0; i <= static_cast<int>(PolicyRequest::kReboot); ++i) {
    const auto request = static_cast<PolicyRequest>(i);
    EXPECT_EQ(RequestOf(RequestName(request)), request);
  }
  EXPECT_EQ(RequestOf("power-off"), PolicyRequest::kPowerOff);
  EXPECT_FALSE(RequestOf("dance"));
  EXPECT_FALSE(RequestOf(""));
}

TEST(Ceiling, IsTheMostActiveStateThatTheMachineHas) {
  MachineConfig config = WithPolicy();
  EXPECT_EQ(CeilingState(config, kFree), "Active");
  EXPECT_EQ(CeilingState(config, kProtected), "Protected");
  EXPECT_EQ(CeilingState(config, kLowPower), "LowPower");
  EXPECT_EQ(CeilingState(config, kEmpty), "LowPower");
  std::erase(config.states, "Protected");
  EXPECT_EQ(CeilingState(config, kProtected), "DeActive");
  std::erase(config.states, "LowPower");
  EXPECT_EQ(CeilingState(config, kLowPower), "") << "neither OTA nor Error is a place to rest";
}

TEST(Ceiling, CountsStatesOfYourOwnByTheirRank) {
  MachineConfig config = WithPolicy();
  std::erase(config.states, "LowPower");
  config.states.emplace_back("Sitting");
  config.ranks["Sitting"] = 3;
  EXPECT_EQ(CeilingState(config, kLowPower), "Sitting");
  config.states.emplace_back("LowPower");
  EXPECT_EQ(CeilingState(config, kLowPower), "LowPower") << "of two the built-in state";
}

}  // namespace musher::testing::policy_test
