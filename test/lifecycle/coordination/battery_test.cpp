// The battery sets a ceiling: a level, not a crossing.

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "musher/lifecycle/policy/policy.hpp"
#include "musher/test/lifecycle/coordination/policy.hpp"

namespace musher::testing::battery_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::StartsWith;

class BatteryRule : public Rules {
 protected:
  void SetUp() override { Robot(); }
  // From 100 % to 0 in steps.
  void Drain(int step) {
    for (int percent = 100; percent > 0; percent -= step) Battery(percent);
    Battery(0);
    robot().RunFor(std::chrono::seconds(20));
  }
};

TEST_F(BatteryRule, FallingInOnePercentStepsVisitsEveryLevelInOrder) {
  Drain(1);
  EXPECT_THAT(states(), ElementsAre("Active", "Protected", "LowPower", "TearDown"));
  EXPECT_EQ(robot().power.size(), 1U);
}

TEST_F(BatteryRule, FallingInThirtyPercentStepsMeetsTheRightLevels) {
  Drain(30);  // 100, 70, 40, 10, 0
  EXPECT_THAT(states(), ElementsAre("Active", "Protected", "LowPower", "TearDown"));
  EXPECT_EQ(robot().power.size(), 1U);
}

// A held arm was raised on the way down, and switched on by the way up, without a person.
TEST_F(BatteryRule, ABatteryThatFallsAndRisesMovesNoActuatorThatAPersonHolds) {
  ASSERT_TRUE(robot().Set("LowPower", "b").done());
  robot().ClearLog();
  Battery(18);
  ASSERT_EQ(state(), "Protected");
  Battery(60);
  ASSERT_EQ(state(), "Active");
  EXPECT_EQ(robot().StateOf("b"), "LowPower");
  EXPECT_TRUE(robot().RecordOf("b").held);
  EXPECT_THAT(robot().log(), ElementsAre("a:Protected", "a:Active"));
}

TEST_F(BatteryRule, OneEmptySampleLowersTheMachineAndNeitherTearsItDownNorPowersItOff) {
  Battery(80);
  robot().Feed(event::BatterySeen{0, false});
  robot().RunFor(Milliseconds(200));
  EXPECT_EQ(state(), "LowPower");
  Battery(80);
  robot().RunFor(std::chrono::seconds(60));
  EXPECT_THAT(states(), ElementsAre("Active", "LowPower", "Active"));
  EXPECT_TRUE(robot().power.empty());
  EXPECT_THAT(robot().records, Contains(Is(EventName::kBatteryJumped)).Times(1));
}

TEST_F(BatteryRule, AnEmptySampleBeforeSilenceNeitherTearsTheMachineDownNorPowersItOff) {
  Battery(80);
  robot().Feed(event::BatterySeen{0, false});
  robot().RunFor(std::chrono::seconds(10));
  robot().Feed(event::InputSilent{PolicyInput::kBattery});
  robot().RunFor(std::chrono::minutes(10));
  EXPECT_EQ(state(), "LowPower");
  EXPECT_TRUE(robot().power.empty());
}

TEST_F(BatteryRule, EmptySamplesOfLessThanTheTimePowerNothingOff) {
  MachineConfig config = WithPolicy();
  config.policy->battery->tear_down_after = std::chrono::seconds(3);
  Robot("Active", config);
  for (int i = 0; i < 10; ++i) {
    Battery(0);
    robot().Feed(event::BatterySeen{1, false});
  }
  EXPECT_EQ(state(), "LowPower");
  Battery(0);
  Battery(0);
  EXPECT_EQ(state(), "TearDown");
}

TEST_F(BatteryRule, OfTwoPublishersTheLowestCountsAndTheDoublingIsRecorded) {
  for (int i = 0; i < 12; ++i) {
    robot().Feed(event::BatterySeen{80, false, 0});
    robot().RunFor(Milliseconds(500));
    robot().Feed(event::BatterySeen{15, false, 1});
    robot().RunFor(Milliseconds(500));
  }
  EXPECT_THAT(states(), ElementsAre("Active", "Protected"));
  EXPECT_EQ(policy().battery, 15);
  EXPECT_TRUE(IsRecorded(texts::BatteryDoubled("bms_status", 2, 15, 80)));
  EXPECT_THAT(robot().records, Contains(Is(EventName::kBatteryDoubled)).Times(1));
  robot().Feed(event::BatterySourceSilent{1});
  robot().Feed(event::BatterySeen{80, false, 0});
  EXPECT_EQ(state(), "Protected");
  Battery(80);
  EXPECT_EQ(state(), "Active");
}

TEST_F(BatteryRule, APublisherThatReportsItEmptyDoesNotPowerTheRobotOffWhileAnotherDoesNot) {
  for (int i = 0; i < 30; ++i) {
    robot().Feed(event::BatterySeen{80, false, 0});
    robot().RunFor(Milliseconds(500));
    robot().Feed(event::BatterySeen{0, false, 1});
    robot().RunFor(Milliseconds(500));
  }
  EXPECT_THAT(states(), ElementsAre("Active", "LowPower"));
  EXPECT_TRUE(robot().power.empty());
}

TEST_F(BatteryRule, ARestartedDriverIsNoSecondPublisher) {
  Battery(80, false, 0);
  Battery(79, false, 1);
  robot().Feed(event::BatterySourceSilent{0});
  Battery(79, false, 1);
  EXPECT_FALSE(IsRecorded(EventName::kBatteryDoubled));
}

TEST_F(BatteryRule, ACeilingIsLiftedOnlyAfterATimeWithoutALowerSample) {
  MachineConfig config = WithPolicy();
  config.policy->battery->raise_after = std::chrono::seconds(5);
  Robot("Active", config);
  Battery(15);
  for (int i = 0; i < 10; ++i) {
    Battery(80);
    Battery(80);
    robot().Feed(event::BatterySeen{15, false});
  }
  EXPECT_THAT(states(), ElementsAre("Active", "Protected"));
  Battery(80);
  Battery(80);
  EXPECT_EQ(robot().Set("Active").reason,
            "the battery is at 80 %: the machine is limited to Protected until no sample has been "
            "below 22 % for 5.0 s");
  Battery(80);
  EXPECT_EQ(state(), "Active");
}

TEST_F(BatteryRule, OneHigherSampleBeforeSilenceRaisesNothing) {
  Battery(15);
  robot().Feed(event::BatterySeen{80, false});
  robot().RunFor(std::chrono::minutes(10));
  EXPECT_EQ(state(), "Protected");
}

TEST_F(BatteryRule, ACeilingThatIsLiftedInPartIsLiftedFurtherByTheSamplesAtTheEnd) {
  Battery(3);
  robot().Feed(event::BatterySeen{10, false});
  for (int i = 0; i < 3; ++i) robot().Feed(event::BatterySeen{80, false});
  robot().RunFor(Milliseconds(1500));
  EXPECT_EQ(state(), "Protected");
  robot().RunFor(Milliseconds(1500));
  EXPECT_EQ(state(), "Active");
}

TEST_F(BatteryRule, ACeilingThatIsLiftedInPartIsLiftedNoFurtherByOneSample) {
  Battery(3);
  for (int i = 0; i < 3; ++i) robot().Feed(event::BatterySeen{10, false});
  robot().Feed(event::BatterySeen{80, false});
  robot().RunFor(std::chrono::minutes(1));
  EXPECT_EQ(state(), "Protected");
}

TEST_F(BatteryRule, TheLevelOutlivesTheControllerAndIsTheCeilingWithoutASample) {
  EXPECT_TRUE(robot().Set("DeActive").done());
  Battery(15);
  EXPECT_EQ(state(), "DeActive");
  robot().RestartController();
  robot().RunFor(std::chrono::seconds(5));
  EXPECT_EQ(
      robot().Set("Active").reason,
      "the battery was low, and has sent no sample since: the machine is limited to Protected "
      "until it is charged to 22 %");
  EXPECT_TRUE(robot().Set("Protected").done());
  Battery(80);
  EXPECT_TRUE(robot().Set("Active").done());
}

TEST_F(BatteryRule, AStoredLowLevelDoesNotLowerAChargedRobot) {
  robot().disk().policy.level = BatteryLevel::kLowPower;
  robot().RestartController();
  robot().RunFor(std::chrono::seconds(5));
  Battery(80);
  EXPECT_EQ(state(), "Active");
  EXPECT_THAT(states(), ::testing::Not(Contains("LowPower")));
}

// A robot that is adopted in Active, or starts: the battery was low, and nothing says that it is
// not.
TEST_F(BatteryRule, AStoredLowLevelLowersARobotWhoseBatteryIsSilent) {
  robot().disk().policy.level = BatteryLevel::kLowPower;
  robot().RestartController();
  robot().RunFor(std::chrono::seconds(5));
  EXPECT_EQ(state(), "Active") << "a sample may be on its way";
  robot().Feed(event::InputSilent{PolicyInput::kBattery});
  robot().RunFor(std::chrono::seconds(1));
  EXPECT_EQ(state(), "LowPower");
  EXPECT_TRUE(IsRecorded(texts::BatterySilent(std::chrono::seconds(10), std::nullopt, true)));
  EXPECT_TRUE(IsRecorded(texts::BatterySwitchDown(std::nullopt, false, "LowPower")));
  robot().RunFor(std::chrono::minutes(1));
  EXPECT_EQ(state(), "LowPower");
  Battery(80);
  EXPECT_EQ(state(), "Active") << "it is brought back to where it was lowered from";
}

TEST_F(BatteryRule, AJumpOverALevelMissesNothing) {
  Battery(100);
  Battery(3);
  EXPECT_THAT(states(), ElementsAre("Active", "LowPower"));
}

TEST_F(BatteryRule, AtTwentyPercentTheMachineIsProtectedNotOnlyBelow) {
  Battery(21);
  EXPECT_EQ(state(), "Active");
  Battery(20);
  EXPECT_EQ(state(), "Protected");
}

TEST_F(BatteryRule, AtFivePercentTheMachineIsInLowPowerNotOnlyBelow) {
  Battery(6);
  EXPECT_EQ(state(), "Protected");
  Battery(5);
  EXPECT_EQ(state(), "LowPower");
}

TEST_F(BatteryRule, ChargingBringsTheMachineBackLevelByLevel) {
  Battery(3);
  for (int percent = 3; percent <= 25; ++percent) Battery(percent, true);
  EXPECT_THAT(states(), ElementsAre("Active", "LowPower", "Protected", "Active"));
}

// The replaced code checked its threshold only between 5 and 20 %.
TEST_F(BatteryRule, LowPowerIsLeftWhenTheChargeJumpsFromBelowFiveToBeyondTwenty) {
  Battery(3);
  EXPECT_EQ(state(), "LowPower");
  Battery(60);
  EXPECT_THAT(states(), ElementsAre("Active", "LowPower", "Active"));
}

TEST_F(BatteryRule, JitterAroundALevelDoesNotFlap) {
  for (int i = 0; i < 20; ++i) Battery(i % 2 == 0 ? 20 : 21);
  EXPECT_THAT(states(), ElementsAre("Active", "Protected"));
}

TEST_F(BatteryRule, ChargingDoesNotLiftProtected) {
  Battery(10, true);
  EXPECT_EQ(state(), "Protected") << "no back flips on the cable";
}

TEST_F(BatteryRule, AMachineBeingChargedIsNotTakenBelowProtected) {
  Battery(4, true);
  EXPECT_EQ(state(), "Protected");
  Battery(0, true);
  EXPECT_EQ(state(), "Protected");
  EXPECT_TRUE(robot().power.empty());
}

TEST_F(BatteryRule, DisconnectingTheChargerAtThreePercentLeadsToLowPower) {
  Battery(3, true);
  Battery(3, false);
  EXPECT_THAT(states(), ElementsAre("Active", "Protected", "LowPower"));
  EXPECT_THAT(Why(EventName::kSwitchDone),
              Are(texts::SwitchEnded(4, SwitchOutcome::kDone, ""),
                  texts::BatterySwitchDown(3, false, "LowPower"),
                  texts::BatteryChanged(3, false, false, texts::BatteryLimit::kAsBefore, {})));
}

TEST_F(BatteryRule, ConnectingTheChargerDoesNotRaiseAMachineInLowPower) {
  Battery(3, false);
  Battery(3, true);
  Battery(6, true);
  EXPECT_EQ(state(), "LowPower");
  EXPECT_THAT(RequestAndWait(PolicyRequest::kWakeUp), StartsWith("113: "));
}

TEST_F(BatteryRule, AnEmptyBatteryTearsTheMachineDownOnceAndPowersItOff) {
  Battery(0);
  robot().RunFor(std::chrono::seconds(30));
  EXPECT_EQ(robot().machine().phase, Phase::kStopped);
  EXPECT_EQ(robot().power.size(), 1U);
  EXPECT_TRUE(IsRecorded(texts::SwitchStarted(4, "", "LowPower", "TearDown", 2)));
  for (const action::Record& record : robot().records) {
    EXPECT_LE(record.switch_number, CommandNumber(4)) << "the replaced code commanded it twice";
  }
}

TEST_F(BatteryRule, ARequestAboveTheCeilingIsRefusedWithNumbersAndWhatToDo) {
  Battery(15);
  const SwitchResult result = robot().Set("Active");
  EXPECT_EQ(result.outcome, SwitchOutcome::kRefused);
  EXPECT_EQ(result.code, kCodeProtectedError);
  EXPECT_EQ(result.reason,
            "the battery is at 15 %: the machine is limited to Protected until it is charged to "
            "22 %");
  EXPECT_EQ(state(), "Protected");
}

TEST_F(BatteryRule, ARequestBelowTheCeilingIsAllowed) {
  Battery(15);
  EXPECT_TRUE(robot().Set("DeActive").done());
  EXPECT_TRUE(robot().Set("Protected").done());
}

TEST_F(BatteryRule, ErrorAndTearDownAreNeverBlocked) {
  Battery(3);
  EXPECT_TRUE(robot().Set("Error").done());
  EXPECT_TRUE(robot().Set("TearDown").done());
  EXPECT_TRUE(robot().power.empty());
}

TEST_F(BatteryRule, APersonsProtectedIsNotRaised) {
  EXPECT_TRUE(robot().Set("Protected").done());
  Battery(10);
  Battery(90);
  EXPECT_EQ(state(), "Protected");
}

TEST_F(BatteryRule, AMachineThatAPersonSwitchedElsewhereStaysThere) {
  Battery(10);
  EXPECT_TRUE(robot().Set("DeActive").done());
  EXPECT_TRUE(robot().Set("Protected").done());
  Battery(90);
  EXPECT_EQ(state(), "Protected");
}

// An actuator of it fails in TearDown, and the next controller finds it running.
TEST_F(BatteryRule, AMachineThatAPersonHasTornDownIsNotRaised) {
  Robot("Active", WithPolicy(1));
  Battery(10);
  EXPECT_EQ(state(), "Protected");
  robot().On("a", "TearDown").code = kCodeFailed;
  EXPECT_EQ(robot().Set("TearDown").outcome, SwitchOutcome::kDoneDegraded);
  robot().RestartController();
  robot().RunFor(std::chrono::seconds(5));
  EXPECT_EQ(state(), "Protected");
  Battery(90);
  EXPECT_EQ(state(), "Protected");
}

TEST_F(BatteryRule, APersonsLowPowerStaysWhenTheBatteryIsCharged) {
  EXPECT_TRUE(robot().Set("LowPower").done());
  Battery(3);
  Battery(90);
  EXPECT_EQ(state(), "LowPower");
  EXPECT_EQ(RequestAndWait(PolicyRequest::kWakeUp), "ok");
  EXPECT_EQ(state(), "Active");
}

TEST_F(BatteryRule, AMachineTakenDownFromDeActiveIsBroughtBackToIt) {
  EXPECT_TRUE(robot().Set("DeActive").done());
  Battery(3);
  Battery(90);
  EXPECT_THAT(states(), ElementsAre("Active", "DeActive", "LowPower", "DeActive"));
}

TEST_F(BatteryRule, ASwitchUnderWayIsNotSuperseded) {
  EXPECT_TRUE(robot().Set("DeActive").done());
  robot().On("a", "Active").takes = Milliseconds(90);
  const RequestId request = robot().RequestSwitch("Active");
  Battery(3);
  EXPECT_TRUE(robot().answers.at(request).done());
  EXPECT_THAT(states(), ElementsAre("Active", "DeActive", "Active", "LowPower"));
}

TEST_F(BatteryRule, AFailedSwitchBackIsRetriedAndNotInALoop) {
  Battery(10);
  robot().On("a", "Active").code = 3009;
  const std::size_t before = robot().log().size();
  Battery(90);
  robot().RunFor(std::chrono::seconds(60));
  EXPECT_LT(robot().log().size(), before + 30);
  EXPECT_EQ(state(), "Protected");
  robot().On("a", "Active").code = kCodeOk;
  robot().RunFor(std::chrono::seconds(120));
  EXPECT_EQ(state(), "Active");
}

// The delay before the next attempt to raise delayed the lowering, up to a minute.
TEST_F(BatteryRule, AFailedSwitchPartOfTheWayBackIsRetriedAndNotInALoop) {
  Battery(3);
  robot().On("a", "Protected").code = 3009;
  robot().ClearLog();
  Battery(10);  // for two seconds
  EXPECT_EQ(state(), "LowPower");
  EXPECT_THAT(std::count(robot().log().begin(), robot().log().end(), "a:Protected"),
              ::testing::AllOf(::testing::Ge(1), ::testing::Le(3)));
}

TEST_F(BatteryRule, ThatFallsDuringAFailingSwitchBackTakesTheMachineDownAtOnce) {
  Battery(10);
  robot().On("a", "Active").code = 3009;
  robot().On("b", "Active").takes = Milliseconds(90);
  for (int i = 0; i < kConfirmingSamples; ++i) robot().Feed(event::BatterySeen{90, false});
  ASSERT_TRUE(robot().RunUntil([&] { return robot().machine().current.has_value(); }));
  robot().Feed(event::BatterySeen{3, false});
  robot().RunFor(Milliseconds(200));
  EXPECT_EQ(state(), "LowPower");
}

TEST_F(BatteryRule, ValuesOutOfRangeAreIgnoredAndRecordedOnce) {
  for (const int percent : {-1, 101, 255}) Battery(percent);
  EXPECT_EQ(state(), "Active");
  EXPECT_FALSE(policy().battery);
  EXPECT_TRUE(policy().batteries.empty());
  EXPECT_THAT(robot().records, Contains(Is(EventName::kBatterySampleInvalid)).Times(1));
}

TEST_F(BatteryRule, ASilentBatteryIsRecordedAndItsLastLevelStaysInEffect) {
  Battery(10);
  robot().Feed(event::InputSilent{PolicyInput::kBattery});
  EXPECT_TRUE(IsRecorded(texts::BatterySilent(std::chrono::seconds(10), 10)));
  EXPECT_EQ(robot().Set("Active").code, kCodeProtectedError);
  Battery(10);
  EXPECT_TRUE(IsRecorded(EventName::kBatteryResumed));
}

TEST_F(BatteryRule, TheJournalRecordsWhyTheMachineIsInLowPower) {
  Battery(4);
  EXPECT_THAT(Why(EventName::kSwitchDone),
              Are(texts::SwitchEnded(3, SwitchOutcome::kDone, ""),
                  texts::BatterySwitchDown(4, false, "LowPower"),
                  texts::BatteryChanged(4, false, {}, texts::BatteryLimit::kLimited, "LowPower")));
}

TEST_F(BatteryRule, RulesWaitInOtaAndApplyAfterIt) {
  EXPECT_EQ(RequestAndWait(PolicyRequest::kOta, true), "ok");
  Battery(10);
  Battery(0);
  EXPECT_EQ(state(), "OTA");
  Battery(10);
  EXPECT_EQ(RequestAndWait(PolicyRequest::kOta, false), "ok");
  EXPECT_EQ(state(), "Protected");
  Battery(50);
  EXPECT_EQ(state(), "Active") << "what the battery had withheld";
}

TEST_F(BatteryRule, AnEmergencyStopKeepsTheMachineDown) {
  Battery(10);
  robot().StopAll(7);
  Battery(90);
  EXPECT_EQ(state(), "Protected");
  robot().Release();
  robot().RunFor(std::chrono::seconds(5));
  EXPECT_EQ(state(), "Protected") << "a release switches nothing on";
  EXPECT_TRUE(robot().Set("Active").done());
}

TEST_F(BatteryRule, ARestartedControllerReportsWhyTheMachineWasTakenDown) {
  Battery(10);
  EXPECT_EQ(state(), "Protected");
  robot().RestartController();
  robot().RunFor(std::chrono::seconds(5));
  EXPECT_EQ(state(), "Protected");
  Battery(90);
  EXPECT_EQ(state(), "Active");
}

TEST_F(BatteryRule, ARestartedControllerWhoseConfigHasLostTheLowerStateBeginsWithTheUpperLevel) {
  Battery(10);
  robot().disk().policy.lowering.value().to = "Sleeping";
  robot().RestartController();
  robot().RunFor(std::chrono::seconds(5));
  Battery(6);
  EXPECT_EQ(state(), "Protected");
}

// For every sequence of battery samples: after each, the machine is not above its level, and not
// below the lowest state that its hysteresis and the machine's history allow.
RC_GTEST_FIXTURE_PROP(Rules, AnySequenceOfLevelsMeetsTheRightStates, ()) {
  Robot();
  BatteryLevel level = BatteryLevel::kFree;
  const auto percents = *rc::gen::container<std::vector<int>>(rc::gen::inRange(1, 101));
  for (const int percent : percents) {
    Battery(percent);
    level = LevelAt(BatteryPolicy{}, percent, level);
    RC_ASSERT(state() == CeilingState(robot().config(), level));
  }
  RC_ASSERT(robot().power.empty());
}

}  // namespace musher::testing::battery_test
