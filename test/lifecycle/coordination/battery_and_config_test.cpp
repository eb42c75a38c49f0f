// The battery's ceiling beside a start, a fallback and configs without some of the states.

#include <gtest/gtest.h>

#include <algorithm>

#include "musher/lifecycle/policy/policy.hpp"
#include "musher/lifecycle/switch/plan.hpp"
#include "musher/test/lifecycle/coordination/policy.hpp"

namespace musher::testing::battery_and_config_test {

using ::testing::Contains;

TEST_F(Rules, BatteryRulesWaitWhileLaterStagesLoad) {
  MachineConfig config = WithPolicy();
  ActuatorNamed(config, "b").stage = 2;
  ActuatorNamed(config, "b").command = {"run", "b"};
  Harness t(config);
  t.On("b", "SetUp").takes = Milliseconds(90);
  t.Begin();
  t.RunUntil([&] { return t.machine().state == "Active"; });
  t.Feed(event::BatterySeen{3, false});
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_FALSE(t.machine().policy.loaded);
  EXPECT_EQ(t.machine().state, "Active");
  EXPECT_FALSE(t.machine().current);
  t.RunFor(std::chrono::seconds(5));
  EXPECT_EQ(t.machine().state, "LowPower");
  EXPECT_EQ(t.StateOf("b"), "LowPower");
}

TEST_F(Rules, BatteryRulesWaitWhileLaterStagesLoadAfterAStartThatAnEmergencyStopEnded) {
  MachineConfig config = WithPolicy();
  ActuatorNamed(config, "b").stage = 2;
  ActuatorNamed(config, "b").command = {"run", "b"};
  Harness t(config);
  t.On("b", "SetUp").takes = Milliseconds(90);
  t.disk().stops.engaged = {{7, "a panel", ""}};
  t.Begin();
  t.Rest();
  ASSERT_EQ(t.machine().phase, Phase::kFailed);
  t.Release();
  t.RunFor(Milliseconds(10));
  EXPECT_TRUE(t.Set("SelfCheck").done());
  EXPECT_TRUE(t.Set("Active").done());
  t.Feed(event::BatterySeen{3, false});
  EXPECT_FALSE(t.machine().current);
  t.RunFor(std::chrono::seconds(5));
  EXPECT_EQ(t.StateOf("b"), "LowPower");
}

// The controller has crashed before the first command of its switch down.
TEST_F(Rules, AStoredLevelDoesNotLowerTheMachineBeforeTheFirstSample) {
  Robot();
  robot().disk().policy.lowering = BatteryFallback{"Active", "Protected", robot().machine().epoch};
  robot().RestartController();
  robot().RunFor(std::chrono::seconds(2));
  EXPECT_EQ(state(), "Active");
  Battery(90);
  EXPECT_EQ(state(), "Active");
  EXPECT_FALSE(policy().stored.lowering);
}

TEST_F(Rules, TheMachineIsBroughtBackToItsOwnStateOfTheAllowedRank) {
  MachineConfig config = WithPolicy();
  config.states.emplace_back("Guarding");
  config.ranks["Guarding"] = *BuiltInRank(kProtected);
  ListAllStates(config);
  for (const BuiltInState state : {kActive, kLowPower}) config.flow.push_back({state, "Guarding"});
  Robot("Guarding", config);
  Battery(3);
  EXPECT_EQ(state(), "LowPower");
  Battery(10);
  EXPECT_EQ(state(), "Guarding");
}

TEST_F(Rules, WithoutACriticalActuatorTheBatteryDoesNotRaiseTheMachine) {
  MachineConfig config = OursWithCriticalB();
  ActuatorNamed(config, "b").restart.policy = RestartPolicy::kNo;
  config.policy = WithPolicy().policy;
  Robot("Active", config);
  Battery(10);
  robot().Crash("b");
  robot().RunFor(std::chrono::seconds(5));
  Battery(90);
  EXPECT_EQ(state(), "Protected") << "it is its on_lost now";
}

TEST_F(Rules, AfterAFallbackTheBatteryDoesNotRaiseTheMachineToAStateOfAnEarlierConfig) {
  MachineConfig config = WithPolicy();
  ActuatorNamed(config, "b").critical = true;
  ActuatorNamed(config, "b").on_lost = "Protected";
  Robot("Active", config);
  Battery(3);
  robot().disk().policy.lowering.value().from = "Dancing";
  robot().RestartController();
  robot().RunFor(std::chrono::seconds(5));
  robot().Crash("b");
  robot().RunFor(std::chrono::seconds(1));
  robot().StartActuator("b");
  robot().RunFor(std::chrono::seconds(5));
  Battery(90);
  EXPECT_EQ(state(), "Protected");
}

// A machine that has Sitting, a state of its own, in the place of LowPower.
MachineConfig WithSittingForLowPower() {
  MachineConfig config = WithPolicy();
  std::erase(config.states, "LowPower");
  config.states.emplace_back("Sitting");
  config.ranks["Sitting"] = 3;
  config.flow = DefaultFlow(config.states);
  for (const BuiltInState state : {kActive, kProtected}) {
    config.flow.push_back({state, "Sitting"});
    config.flow.push_back({"Sitting", state});
  }
  ListAllStates(config);
  config.policy->low_power.reset();
  return config;
}

TEST_F(Rules, AMachineWithoutLowPowerGoesDownAsFarAsItCan) {
  Robot("Active", WithSittingForLowPower());
  Battery(3);
  EXPECT_EQ(state(), "Sitting");
}

TEST_F(Rules, TheFlowOfTheConfigForbidsNoCeilingOfTheBattery) {
  MachineConfig config = WithPolicy();
  std::erase_if(config.flow, [](const FlowEdge& edge) { return edge.to == "Protected"; });
  Robot("Active", config);
  Battery(10);
  EXPECT_EQ(state(), "Protected");
}

TEST_F(Rules, ARefusedSwitchDownIsRecordedOnceAndNotRetriedInALoop) {
  MachineConfig config = WithPolicy();
  std::erase_if(config.flow, [](const FlowEdge& edge) { return edge.to == "LowPower"; });
  Robot("Active", config);
  int steps = 0;
  robot().after_step = [&] { ++steps; };
  RequestPolicy(PolicyRequest::kLowPowerSwitch, true);
  Motion(0);  // it lies down
  robot().RunFor(std::chrono::minutes(10));
  EXPECT_LT(steps, 40);
  const Plan refused = MakePlan(robot().config(), robot().machine(), State("LowPower"));
  EXPECT_EQ(refused.refusal.value().code, kCodeStateInvalid) << "not in the flow";
  EXPECT_THAT(robot().records.back(),
              Is(texts::PolicySwitchRefused(texts::LyingStill(std::chrono::seconds(30)),
                                            refused.refusal.value().message)));
  EXPECT_THAT(robot().records, Contains(Is(EventName::kPolicySwitchRefused)).Times(1));
}

TEST_F(Rules, ABatterySampleBeforeTheStartIsIgnored) {
  Harness t(WithPolicy());
  t.Feed(event::BatterySeen{3, false});
  EXPECT_FALSE(t.machine().policy.battery);
  EXPECT_TRUE(t.records.empty());
}

TEST_F(Rules, ABatterySampleIsIgnoredWhereThePolicyHasNoBatteryRule) {
  MachineConfig config = WithPolicy();
  config.policy->battery.reset();
  Robot("Active", config);
  Battery(3);
  EXPECT_FALSE(policy().battery);
  EXPECT_EQ(state(), "Active");
}

TEST_F(Rules, AnEmptyBatteryIsRecordedAsAChangeOfTheLevel) {
  Robot();
  Battery(0);
  EXPECT_THAT(RecordWith(EventName::kBatteryLevelChanged),
              Is(texts::BatteryChanged(0, false, {}, texts::BatteryLimit::kEmpty, {})));
}

TEST_F(Rules, TheLevelOfARestartedControllerIsLeftAsLateAsThatOfTheOneBefore) {
  Robot();
  Battery(3);
  ASSERT_EQ(state(), "LowPower");
  robot().RestartController();
  robot().RunFor(std::chrono::seconds(2));
  Battery(6);
  EXPECT_EQ(state(), "LowPower") << "it is left at 7 %";
}

TEST_F(Rules, AFallbackToWhereTheBatteryTookTheMachineEndsTheLowering) {
  MachineConfig config = OursWithCriticalB();
  ActuatorNamed(config, "b").restart.policy = RestartPolicy::kNo;
  config.policy = WithPolicy().policy;
  Robot("Active", config);
  Battery(10);
  ASSERT_EQ(state(), "Protected");
  ASSERT_TRUE(policy().stored.lowering);
  robot().Crash("b");
  robot().RunFor(std::chrono::seconds(5));
  EXPECT_FALSE(policy().stored.lowering);
}

TEST_F(Rules, AMachineWhoseStartHasFailedIsPoweredOffWhenTheBatteryIsEmpty) {
  Harness t(WithPolicy());
  t.disk().stops.engaged = {{7, "a panel", ""}};
  t.Begin();
  t.Rest();
  ASSERT_EQ(t.machine().phase, Phase::kFailed);
  for (int i = 0; i < kConfirmingSamples; ++i) t.Feed(event::BatterySeen{0, false});
  t.RunFor(std::chrono::seconds(20));
  EXPECT_EQ(t.power.size(), 1U);
}

TEST_F(Rules, AMachineWithoutLowPowerWakesUpFromTheStateInItsPlace) {
  Robot("Sitting", WithSittingForLowPower());
  EXPECT_EQ(RequestAndWait(PolicyRequest::kWakeUp), "ok");
  EXPECT_EQ(state(), "Active");
}

TEST_F(Rules, AMachineWithNoStateBelowTheCeilingIsNotSwitched) {
  MachineConfig config = WithPolicy();
  for (const BuiltInState state : {kProtected, kLowPower, kDeActive}) {
    std::erase(config.states, State(state));
  }
  config.flow = DefaultFlow(config.states);
  ListAllStates(config);
  config.policy->low_power.reset();
  Robot("Active", config);
  Battery(3);
  EXPECT_EQ(state(), "Active");
  EXPECT_FALSE(IsRecorded(EventName::kBatterySwitchDown)) << "there is none to go down to";
  EXPECT_FALSE(IsRecorded(EventName::kPolicySwitchRefused));
}

}  // namespace musher::testing::battery_and_config_test
