// The three results of a self-check: passed, degraded with reasons, failed.

#include <gmock/gmock.h>

#include "musher/test/lifecycle/coordination/one_controller.hpp"
#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::self_check_test {

using ::testing::ElementsAre;

class SelfChecked : public ::testing::Test {
 protected:
  SelfChecked() : t(OursWithCriticalB()) {}

  void DegradeB() {
    t.On("b", "SelfCheck").degraded_code = 1109;
    t.On("b", "SelfCheck").degraded_reason = "led: silent, 1109";
  }
  void Start() {
    t.Begin();
    t.Rest();
  }

  Harness t;
};

TEST_F(SelfChecked, ADegradedCriticalActuatorReachesActiveAndIsListedWithItsReason) {
  DegradeB();
  Start();
  EXPECT_TRUE(t.usable());
  EXPECT_EQ(t.machine().state, "Active");
  EXPECT_EQ(t.StateOf("b"), "Active");
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre("b"));
  EXPECT_EQ(TroubleOf(t.RecordOf("b")), (Error{1109, "led: silent, 1109"}));
  EXPECT_EQ(t.start_up()->message, texts::MachineUsable("Active", "b: led: silent, 1109").message);
}

TEST_F(SelfChecked, AFailedCriticalActuatorBlocksTheStart) {
  t.On("b", "SelfCheck").code = 1409;
  Start();
  EXPECT_FALSE(t.usable());
  EXPECT_EQ(t.machine().phase, Phase::kFailed);
}

TEST_F(SelfChecked, ACheckReportsWhatIsDegradedAndASwitchDependsOnTheStates) {
  DegradeB();
  Start();
  const SwitchResult check = t.Set("SelfCheck");
  EXPECT_EQ(check.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_EQ(check.code, 1109);
  EXPECT_EQ(check.reason, "b: degraded: led: silent, 1109");
  EXPECT_TRUE(t.Set("LowPower").done());
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_TRUE(t.Set("TearDown").done());
}

TEST_F(SelfChecked, TheNextCheckThatPassesClearsIt) {
  DegradeB();
  Start();
  t.On("b", "SelfCheck") = {};
  EXPECT_TRUE(t.Set("SelfCheck").done());
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre());
}

TEST_F(SelfChecked, ANewControllerFindsWhatIsDegraded) {
  DegradeB();
  Start();
  t.RestartController();
  t.Rest();
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre("b"));
}

TEST_F(SelfChecked, ARestartedActuatorIsEvaluatedByItsOwnCheck) {
  DegradeB();
  Start();
  t.On("b", "SelfCheck") = {};
  t.Crash("b");
  t.Rest();
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre());
}

TEST_F(SelfChecked, ACheckThatFailsAfterItsDeadlineIsListedWithItsOwnReason) {
  Start();
  t.On("c", "SelfCheck").takes = Milliseconds(150);
  t.On("c", "SelfCheck").code = 1409;
  EXPECT_EQ(t.Set("SelfCheck").code, kCodeTimeout);
  t.Rest();
  ASSERT_TRUE(TroubleOf(t.RecordOf("c")));
  EXPECT_EQ(TroubleOf(t.RecordOf("c"))->code, 1409);
}

TEST_F(SelfChecked, AFailedCheckIsRepeatedAndOneThatPassesBringsTheActuatorUp) {
  t.On("c", "SelfCheck").code = 2109;
  t.Begin();
  t.RunFor(std::chrono::seconds(1));
  ASSERT_TRUE(t.usable());
  EXPECT_NE(t.StateOf("c"), "Active");
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre("c"));
  t.On("c", "SelfCheck") = {};
  t.RunFor(std::chrono::seconds(11));
  EXPECT_EQ(t.StateOf("c"), "Active");
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre());
}

TEST_F(SelfChecked, AFailedCheckIsRepeatedLessAndLessOften) {
  t.On("c", "SelfCheck").code = 2109;
  t.Begin();
  t.RunFor(std::chrono::seconds(1));
  t.ClearLog();
  t.RunFor(std::chrono::minutes(10));
  const auto checks = std::count(t.log().begin(), t.log().end(), "c:SelfCheck");
  EXPECT_GE(checks, 4);
  EXPECT_LE(checks, 7);
}

TEST_F(SelfChecked, ARepeatedCheckThatFailsAgainDoesNotTakeTheMachineDownAgain) {
  MachineConfig config = OursWithCriticalB();
  ActuatorNamed(config, "c").on_lost = "DeActive";
  Harness other(config);
  other.Begin();
  other.Rest();
  other.On("c", "SelfCheck").code = 2109;
  other.Crash("c");
  other.RunFor(std::chrono::seconds(5));
  EXPECT_EQ(other.machine().state, "DeActive");
  EXPECT_EQ(other.Set("Active").outcome, SwitchOutcome::kDoneDegraded);
  other.RunFor(std::chrono::minutes(1));
  EXPECT_EQ(other.machine().state, "Active");
}

TEST_F(SelfChecked, ARepeatedCheckThatIsUnderWayDoesNotKeepItsActuatorOutOfError) {
  t.On("c", "SelfCheck").code = 2109;
  t.Begin();
  t.RunFor(std::chrono::seconds(1));
  t.On("c", "SelfCheck").takes = Milliseconds(50);
  ASSERT_TRUE(t.RunUntil([this] {
    const auto& command = t.RecordOf("c").command;
    return command && command->target == kSelfCheck;
  }));
  EXPECT_TRUE(t.Set("Error").done());
  EXPECT_EQ(t.StateOf("c"), "Error");
}

TEST_F(SelfChecked, AFailedCheckIsRepeatedAtTheNextSwitchUp) {
  Start();
  t.On("c", "SelfCheck").code = 2109;
  t.Set("SelfCheck");
  t.On("c", "SelfCheck") = {};
  t.RunFor(std::chrono::minutes(10));
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre("c"))
      << "an actuator at work is not checked by itself";
  EXPECT_TRUE(t.Set("LowPower").done());
  EXPECT_EQ(t.Set("Active").outcome, SwitchOutcome::kDoneDegraded);
  t.RunFor(std::chrono::seconds(1));
  EXPECT_EQ(t.StateOf("c"), "Active");
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre());
}

// A check that has passed as degraded is repeated as well, where it disturbs no work.

TEST_F(SelfChecked, ADegradedCheckIsRepeatedAtRestAndNotAtWork) {
  DegradeB();
  Start();
  t.On("b", "SelfCheck") = {};
  t.ClearLog();
  t.RunFor(std::chrono::minutes(10));
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre("b"));
  EXPECT_THAT(t.log(), ElementsAre()) << "an actuator at work is not checked by itself";
  EXPECT_TRUE(t.Set("DeActive").done());
  t.RunFor(std::chrono::seconds(1));
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre());
  EXPECT_EQ(t.StateOf("b"), "DeActive");
}

TEST_F(SelfChecked, ADegradedCheckIsRepeatedLessAndLessOften) {
  DegradeB();
  Start();
  EXPECT_TRUE(t.Set("DeActive").done());
  t.ClearLog();
  t.RunFor(std::chrono::minutes(10));
  const auto checks = std::count(t.log().begin(), t.log().end(), "b:SelfCheck");
  EXPECT_GE(checks, 4);
  EXPECT_LE(checks, 7);
}

TEST_F(SelfChecked, ADegradedCheckIsRepeatedBeforeTheNextSwitchUpWhichWaitsForIt) {
  DegradeB();
  Start();
  EXPECT_TRUE(t.Set("LowPower").done());
  t.On("b", "SelfCheck") = {};
  t.ClearLog();
  t.RunFor(std::chrono::minutes(1));
  EXPECT_THAT(t.log(), ElementsAre()) << "a robot that sleeps is not checked by itself";
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_EQ(t.log().front(), "b:SelfCheck");
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre());
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Active");
}

TEST_F(SelfChecked, ASwitchUpIsNotDelayedByACheckThatIsNotDueAgain) {
  DegradeB();
  t.Begin();
  t.RunFor(std::chrono::seconds(1));
  EXPECT_TRUE(t.Set("LowPower").done());
  t.ClearLog();
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_EQ(std::count(t.log().begin(), t.log().end(), "b:SelfCheck"), 0);
}

TEST_F(SelfChecked, ADegradedActuatorWhoseRepeatedCheckFailsStaysDown) {
  DegradeB();
  Start();
  t.RunFor(std::chrono::minutes(1));
  t.On("b", "SelfCheck") = {};
  t.On("b", "SelfCheck").code = 1409;
  EXPECT_TRUE(t.Set("DeActive").done());
  t.RunFor(std::chrono::seconds(1));
  EXPECT_EQ(TroubleOf(t.RecordOf("b"))->code, 1409);
  EXPECT_EQ(t.Set("Active").outcome, SwitchOutcome::kRefused) << "it is critical";
}

TEST_F(SelfChecked, ADegradedActuatorIsNotCheckedDuringAnEmergencyStop) {
  DegradeB();
  Start();
  EXPECT_TRUE(t.Set("DeActive").done());
  t.RunFor(std::chrono::seconds(1));  // it is checked, and again in 20 s
  t.StopAll(7);
  t.ClearLog();
  t.RunFor(std::chrono::minutes(1));
  EXPECT_THAT(t.log(), ElementsAre());
}

// For modules that return only a code, the config lists the critical codes.

class CriticalCodes : public ::testing::Test {
 protected:
  static MachineConfig Config() {
    MachineConfig config = OursWithCriticalB();
    ActuatorNamed(config, "b").critical_codes = {1409, 1509};
    return config;
  }
};

TEST_F(CriticalCodes, AFailureWithAnotherCodeIsPassedDegraded) {
  Harness t(Config());
  t.On("b", "SelfCheck").code = 1109;
  t.On("b", "SelfCheck").message = "led: silent";
  t.Begin();
  t.Rest();
  EXPECT_TRUE(t.usable());
  EXPECT_EQ(t.StateOf("b"), "Active");
  EXPECT_EQ(TroubleOf(t.RecordOf("b")), (Error{1109, "led: silent"}));
  EXPECT_EQ(t.Set("SelfCheck").code, 1109);
  t.On("b", "SelfCheck") = {};
  EXPECT_TRUE(t.Set("SelfCheck").done());
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre());
}

TEST_F(CriticalCodes, AToleratedFailureIsCheckedAgainBeforeTheNextSwitchUp) {
  Harness t(Config());
  t.On("b", "SelfCheck").code = 1109;
  t.Begin();
  t.Rest();
  t.RunFor(std::chrono::minutes(1));
  t.On("b", "SelfCheck") = {};
  EXPECT_TRUE(t.Set("LowPower").done());
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre("b"));
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre());
}

TEST_F(CriticalCodes, AFailureWithOneOfThemBlocksTheStart) {
  Harness t(Config());
  t.On("b", "SelfCheck").code = 1409;
  t.Begin();
  t.Rest();
  EXPECT_EQ(t.machine().phase, Phase::kFailed);
}

TEST_F(CriticalCodes, SilenceIsAFailureWhateverTheCodes) {
  Harness t(Config());
  t.On("b", "SelfCheck").hangs = true;
  t.Begin();
  t.Rest();
  EXPECT_FALSE(t.usable());
}

TEST_F(CriticalCodes, AnActuatorThatJoinsLateIsPassedDegradedToo) {
  Harness t(Config());
  t.Begin();
  t.Rest();
  t.On("b", "SelfCheck").code = 1109;
  t.Crash("b");
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Active");
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre("b"));
}

using SupersededSelfCheck = OneController;

// The actuator has not reported yet that it is busy with its check.
TEST_F(SupersededSelfCheck, IsMissingOnlyWhenItsTimeHasPassed) {
  StartUp();
  Of(0).checked = false;
  Of(0).report.state = State(kLowPower);
  Of(0).free_by = now_ + Milliseconds(50);
  Do(event::TimePassed{});
  EXPECT_FALSE(Of(0).fault) << "its check may pass yet";
  Pass(Milliseconds(50));
  ASSERT_TRUE(Of(0).fault);
  EXPECT_EQ(Of(0).fault->code, kCodeStatusError);
}

}  // namespace musher::testing::self_check_test
