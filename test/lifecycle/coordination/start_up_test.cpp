#include <gmock/gmock.h>

#include "musher/test/lifecycle/coordination/harness.hpp"
#include "musher/test/lifecycle/coordination/one_controller.hpp"

namespace musher::testing::start_up_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;

MachineConfig Started(int actuators) {
  MachineConfig config = MachineOf(actuators);
  for (ActuatorConfig& actuator : config.actuators) actuator.command = {"run", actuator.name};
  return config;
}

TEST(StartUp, BringsEveryActuatorThroughSetUpAndSelfCheckToActive) {
  Harness t(Started(2));
  t.Begin();
  t.Rest();
  EXPECT_TRUE(t.usable());
  EXPECT_EQ(t.machine().state, "Active");
  EXPECT_EQ(t.machine().phase, Phase::kRunning);
  EXPECT_THAT(t.log(), UnorderedElementsAre("a:SetUp", "b:SetUp", "a:SelfCheck", "b:SelfCheck",
                                            "a:Active", "b:Active"));
}

TEST(StartUp, RecordsNoErrorWhereThereIsNone) {
  Harness t(Started(2));
  t.Begin();
  t.Rest();
  ASSERT_FALSE(t.whole_records.empty());
  for (const action::Record& record : t.whole_records) {
    EXPECT_EQ(record.code, kCodeOk) << record.message;
  }
}

TEST(StartUp, WaitsForActuatorsStartedByHand) {
  Harness t(MachineOf(2));
  t.Begin();
  t.Rest();
  EXPECT_EQ(t.machine().state, "Active");
}

TEST(StartUp, StartsProcessesInTheOrderOfAfter) {
  MachineConfig config = Started(3);
  ActuatorNamed(config, "a").after = {"b"};
  ActuatorNamed(config, "b").after = {"c"};
  Harness t(config);
  t.Begin();
  t.Rest();
  EXPECT_THAT(t.log(), ElementsAre("c:SetUp", "b:SetUp", "a:SetUp", "c:SelfCheck", "b:SelfCheck",
                                   "a:SelfCheck", "c:Active", "b:Active", "a:Active"));
}

TEST(StartUp, TakesTheCriticalPathAndNotTheSum) {
  MachineConfig config = Started(3);
  ActuatorNamed(config, "b").after = {"a"};
  Harness t(config);
  t.On("c", "SetUp").takes = Milliseconds(60);  // in parallel to a, then b
  t.On("a", "SetUp").takes = Milliseconds(30);
  t.On("b", "SetUp").takes = Milliseconds(30);
  const Time begun = t.now();
  t.Begin();
  t.RunUntil([&] { return t.machine().start_up.set_up; });
  EXPECT_LT(t.now() - begun, Milliseconds(65));
}

TEST(StartUp, ContinuesDegradedWhenAnActuatorThatIsNotCriticalFailsItsSelfCheck) {
  Harness t(Started(2));
  t.On("b", "SelfCheck").code = 2109;
  t.On("b", "SelfCheck").message = "no lidar";
  t.Begin();
  t.Rest();
  EXPECT_TRUE(t.usable());
  EXPECT_EQ(t.machine().state, "Active");
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre("b"));
  EXPECT_EQ(t.RecordOf("b").fault->code, 2109);
  EXPECT_EQ(t.StateOf("b"), "SetUp") << "what failed its check is not made active";
}

TEST(StartUp, StaysInSelfCheckWithProcessesUpWhenACriticalActuatorFailsItsCheck) {
  MachineConfig config = Started(2);
  ActuatorNamed(config, "b").critical = true;
  Harness t(config);
  t.On("b", "SelfCheck").code = 3009;
  t.Begin();
  t.Rest();
  EXPECT_FALSE(t.usable());
  EXPECT_EQ(t.machine().phase, Phase::kFailed);
  EXPECT_EQ(t.machine().state, "SelfCheck");
  EXPECT_THAT(t.start_up()->message, HasSubstr("critical b: 3009"));
  EXPECT_EQ(t.RecordOf("a").presence, Presence::kPresent);
  EXPECT_EQ(t.StateOf("a"), "SelfCheck") << "no actuator is made active";
}

TEST(StartUp, CanBeFinishedByHandOnceTheCheckPasses) {
  MachineConfig config = Started(2);
  ActuatorNamed(config, "b").critical = true;
  Harness t(config);
  t.On("b", "SelfCheck").code = 3009;
  t.Begin();
  t.Rest();
  EXPECT_EQ(t.Set("Active").outcome, SwitchOutcome::kRefused);
  t.On("b", "SelfCheck").code = kCodeOk;
  EXPECT_EQ(t.Set("SelfCheck").outcome, SwitchOutcome::kDone);
  EXPECT_EQ(t.Set("Active").outcome, SwitchOutcome::kDone);
  EXPECT_EQ(t.machine().phase, Phase::kRunning);
}

TEST(StartUp, BringsTheOthersToDeActiveWhenACriticalActuatorCannotBeActivated) {
  MachineConfig config = Started(2);
  ActuatorNamed(config, "b").critical = true;
  Harness t(config);
  t.On("b", "Active").code = 3001;
  t.Begin();
  t.Rest();
  EXPECT_FALSE(t.usable());
  EXPECT_EQ(t.machine().state, "SelfCheck");
  EXPECT_EQ(t.StateOf("a"), "DeActive");
}

TEST(StartUp, NamesAnActuatorWhoseSetUpFailedAndItsCode) {
  MachineConfig config = Started(2);
  Harness t(config);
  t.On("b", "SetUp").code = 5012;
  t.On("b", "SetUp").message = "no sound card";
  t.Begin();
  t.Rest();
  EXPECT_TRUE(t.usable());
  ASSERT_TRUE(t.RecordOf("b").fault);
  EXPECT_EQ(t.RecordOf("b").fault->code, 5012);
  EXPECT_THAT(t.RecordOf("b").fault, Is(texts::SetUpFailed(5012, "no sound card")));
}

TEST(StartUp, GivesUpOnAnActuatorThatIsNotSetUpInItsTime) {
  Harness t(Started(2));
  t.On("b", "SetUp").hangs = true;
  t.Begin();
  t.Rest();
  EXPECT_TRUE(t.usable());
  EXPECT_EQ(t.RecordOf("b").fault->code, kCodeTimeout);
  EXPECT_THAT(t.RecordOf("b").fault, Is(texts::SetUpTimeout(Milliseconds(100))));
}

TEST(StartUp, FailsWhenNoActuatorIsSetUp) {
  Harness t(Started(1));
  t.On("a", "SetUp").hangs = true;
  t.Begin();
  t.Rest();
  EXPECT_FALSE(t.usable());
  EXPECT_EQ(t.machine().phase, Phase::kFailed);
}

TEST(StartUp, DoesNotStartAnActuatorThatNeedsAFailedOne) {
  MachineConfig config = Started(3);
  ActuatorNamed(config, "b").after = {"a"};
  Harness t(config);
  t.On("a", "SetUp").code = 5001;
  t.Begin();
  t.Rest();
  EXPECT_TRUE(t.usable());
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre("a", "b"));
  EXPECT_THAT(t.RecordOf("b").fault,
              Is(texts::DependencyDegraded("a", t.RecordOf("a").fault->message)));
}

TEST(StartUp, RefusesSwitchesUntilItIsSetUp) {
  Harness t(Started(1));
  t.On("a", "SetUp").hangs = true;
  t.Begin();
  const SwitchResult result = t.Set("Active");
  EXPECT_EQ(result.outcome, SwitchOutcome::kRefused);
  EXPECT_EQ(result.code, kCodeStatusError);
}

TEST(StartUpByHand, LeavesSelfCheckAndActiveToTheProgram) {
  Harness t(MachineOf(2));
  t.Begin(/*by_hand=*/true);
  t.Rest();
  EXPECT_EQ(t.machine().state, "SetUp");
  EXPECT_EQ(t.Set("Active").code, kCodeStateInvalid) << "a check comes first";
  EXPECT_TRUE(t.Set("SelfCheck").done());
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_EQ(t.machine().phase, Phase::kRunning);
}

TEST(StartUpByAManager, EndsOnceAllActuatorsAreSetUpAndTheManagerActivatesTheMachine) {
  MachineConfig config = MachineOf(2);
  config.ros2.started_by_manager = true;
  Harness t(config);
  t.Begin();
  t.Rest();
  EXPECT_EQ(t.machine().state, "SetUp");
  ASSERT_TRUE(t.start_up().has_value()) << "`musher up --detach` returns";
  EXPECT_TRUE(t.start_up()->usable);
  EXPECT_EQ(t.start_up()->message, texts::WaitingForManager({}).message);
  EXPECT_TRUE(t.Set("SelfCheck").done());
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_EQ(t.machine().phase, Phase::kRunning);
}

MachineConfig StartedByAManager(bool critical) {
  MachineConfig config = Started(2);
  config.ros2.started_by_manager = true;
  ActuatorNamed(config, "b").critical = critical;
  return config;
}

TEST(StartUpByAManager, FailsWhenACriticalActuatorIsNotSetUp) {
  Harness t(StartedByAManager(true));
  t.On("b", "SetUp").code = 5012;
  t.Begin();
  t.Rest();
  EXPECT_FALSE(t.usable());
  EXPECT_THAT(t.start_up()->message, HasSubstr("critical b: 5012"));
}

TEST(StartUpByAManager, NamesTheActuatorsThatAreNotSetUp) {
  Harness t(StartedByAManager(false));
  t.On("b", "SetUp").code = 5012;
  t.On("b", "SetUp").message = "no sound card";
  t.Begin();
  t.Rest();
  EXPECT_TRUE(t.usable());
  const RecordText failed = texts::SetUpFailed(5012, "no sound card");
  EXPECT_EQ(t.start_up()->message, texts::WaitingForManager({"b: " + failed.message}).message);
}

TEST(StartUpByAManager, FailsWhenNoActuatorIsSetUp) {
  Harness t(StartedByAManager(false));
  for (const char* name : {"a", "b"}) t.On(name, "SetUp").code = 5012;
  t.Begin();
  t.Rest();
  EXPECT_FALSE(t.usable());
}

MachineConfig TwoStages() {
  MachineConfig config = Started(3);
  ActuatorNamed(config, "c").stage = 2;
  return config;
}

TEST(LaterStages, AreStartedOnceTheRobotIsUsableAndJoinItsPresentState) {
  Harness t(TwoStages());
  t.Begin();
  t.RunUntil([&] { return t.start_up().has_value(); });
  EXPECT_EQ(t.machine().state, "Active");
  EXPECT_EQ(t.StateOf("c"), "Uninitialized");
  t.Rest();
  EXPECT_EQ(t.StateOf("c"), "Active");
  EXPECT_THAT(t.log(), ::testing::Contains("c:SelfCheck"));
  EXPECT_EQ(std::count(t.log().begin(), t.log().end(), "a:SelfCheck"), 1) << "only the new ones";
}

TEST(LaterStages, JoinTheStateThatTheMachineHasReachedMeanwhile) {
  Harness t(TwoStages());
  t.On("c", "SetUp").takes = Milliseconds(90);
  t.Begin();
  t.RunUntil([&] { return t.start_up().has_value(); });
  EXPECT_TRUE(t.Set("LowPower").done());
  t.Rest();
  EXPECT_EQ(t.StateOf("c"), "LowPower");
  EXPECT_THAT(t.log(), ::testing::Not(::testing::Contains("c:Active")));
}

TEST(LaterStages, AreActivatedInTheOrderOfAfter) {
  MachineConfig config = Started(3);
  ActuatorNamed(config, "b").stage = 2;
  ActuatorNamed(config, "c").stage = 2;
  ActuatorNamed(config, "c").after = {"b"};
  Harness t(config);
  t.On("b", "SelfCheck").takes = Milliseconds(60);
  t.Begin();
  t.Rest();
  const auto& log = t.log();
  EXPECT_LT(std::find(log.begin(), log.end(), "b:Active"),
            std::find(log.begin(), log.end(), "c:Active"));
  EXPECT_EQ(t.StateOf("c"), "Active");
}

TEST(LaterStages, ThatFailTheirCheckLeaveTheRobotUsable) {
  Harness t(TwoStages());
  t.On("c", "SelfCheck").code = 4309;
  t.Begin();
  t.Rest();
  EXPECT_EQ(t.machine().state, "Active");
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre("c"));
  EXPECT_EQ(t.StateOf("c"), "SetUp");
}

TEST(LaterStages, JoinAfterTheirCheckIsRepeatedAndPasses) {
  Harness t(TwoStages());
  t.On("c", "SelfCheck").code = 4309;
  t.Begin();
  t.Rest();
  t.On("c", "SelfCheck").code = kCodeOk;
  EXPECT_TRUE(t.Set("SelfCheck").done());
  t.Rest();
  EXPECT_EQ(t.StateOf("c"), "Active");
}

TEST(Restart, OfAnActuatorDrivesItAgainToTheMachinesState) {
  Harness t(MachineOf(2));
  t.Begin();
  t.Rest();
  EXPECT_TRUE(t.Set("Protected").done());
  t.Crash("b");
  t.Rest();
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre("b"));
  t.ClearLog();
  t.StartActuator("b");
  t.Rest();
  EXPECT_THAT(t.log(), ElementsAre("b:SetUp", "b:SelfCheck", "b:Protected"));
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre());
}

TEST(Adoption, OfRunningActuatorsDisturbsNone) {
  Harness t(MachineOf(3));
  t.Begin();
  t.Rest();
  ASSERT_TRUE(t.Set("Protected").done());
  t.ClearLog();
  t.RestartController();
  t.Rest();
  EXPECT_EQ(t.machine().state, "Protected");
  EXPECT_EQ(t.machine().phase, Phase::kRunning);
  EXPECT_THAT(t.log(), ElementsAre());
}

TEST(Adoption, TakesAHigherEpochThanTheActuatorsHaveSeen) {
  Harness t(MachineOf(2));
  t.Begin(false, 41);  // the epoch on disk
  t.Rest();
  EXPECT_EQ(t.machine().epoch, Epoch(42));
  t.RestartController(true);  // the disk is lost: it begins with 1
  t.Rest();
  EXPECT_EQ(t.machine().epoch, Epoch(43));
  EXPECT_TRUE(t.Set("Protected").done());
}

TEST(Adoption, AfterACrashDuringASwitchGoesToTheLeastActiveState) {
  Harness t(MachineOf(2));
  t.Begin();
  t.Rest();
  ASSERT_TRUE(t.Set("Protected").done());
  t.On("b", "Active").takes = Milliseconds(90);
  t.RequestSwitch("Active");
  t.RunUntil([&] { return t.StateOf("a") == "Active"; });
  t.RestartController();
  t.Rest();
  EXPECT_EQ(t.machine().state, "Protected");
  EXPECT_EQ(t.StateOf("a"), "Protected");
  EXPECT_EQ(t.StateOf("b"), "Protected") << "it ended Active late and was driven back";
}

using SetUpDeadline = OneController;

TEST_F(SetUpDeadline, IsReportedForANodeThatHasFailedBeforeAndIsBeingConfiguredAgain) {
  config_.actuators[0].protocol = Protocol::kRos2Lifecycle;
  Begin();
  ActuatorReport report = Report(0, config_.default_state);
  report.outcome_number = 2;
  report.outcome_code = 3012;
  report.busy_number = 3;
  report.target = State(kSetUp);
  Say(0, report);
  Pass(Milliseconds(200));
  ASSERT_TRUE(Of(0).fault);
  EXPECT_THAT(Of(0).fault, Is(texts::SetUpTimeout(Milliseconds(100))));
}

}  // namespace musher::testing::start_up_test
