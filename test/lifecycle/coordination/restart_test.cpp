// Restarts during a start, a switch or the end, and restarts by request.

#include <gmock/gmock.h>

#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::restart_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// While the machine starts

TEST(RestartWhileStarting, TheStageWaitsForARestart) {
  Harness t(OursWithCriticalB());
  t.On("b", "SetUp").code = 3012;
  t.Begin();
  t.RunFor(Milliseconds(250));
  EXPECT_FALSE(t.start_up()) << "its second restart is to come";
  t.On("b", "SetUp").code = kCodeOk;
  t.Rest();
  EXPECT_TRUE(t.usable());
  EXPECT_EQ(t.StateOf("b"), "Active");
  EXPECT_EQ(t.RecordOf("b").restart.count, 0) << "it has run for long enough since";
}

TEST(RestartWhileStarting, TheActuatorsAfterItWaitToo) {
  MachineConfig config = Ours(2);
  ActuatorNamed(config, "a").after = {"b"};
  Harness t(config);
  t.On("b", "SetUp").code = 3012;
  t.Begin();
  t.RunFor(Milliseconds(50));
  t.On("b", "SetUp").code = kCodeOk;
  t.Rest();
  EXPECT_THAT(Degraded(t.config(), t.machine()), IsEmpty());
}

TEST(RestartWhileStarting, ACriticalActuatorOutOfRestartsFailsTheStart) {
  Harness t(OursWithCriticalB());
  t.On("b", "SetUp").code = 3012;
  t.Begin();
  t.Rest();
  ASSERT_TRUE(t.start_up());
  EXPECT_FALSE(t.usable());
  EXPECT_THAT(t.start_up()->message, HasSubstr("critical b"));
  EXPECT_THAT(t.start_up()->message,
              HasSubstr(texts::GivenUp("b", 3, texts::SetUpFailed(3012, "").message).message));
}

TEST(RestartWhileStarting, AFailedStartIsFinishedByHandOnceTheCriticalActuatorIsRestarted) {
  Harness t(OursWithCriticalB());
  t.On("b", "SetUp").code = 3012;
  t.Begin();
  t.Rest();
  t.On("b", "SetUp").code = kCodeOk;
  const RequestId call = t.Restart("b");
  t.Rest();
  ASSERT_EQ(t.calls.count(call), 1U);
  EXPECT_TRUE(t.calls.at(call));
  EXPECT_TRUE(t.Set("SelfCheck").done());
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_EQ(t.machine().phase, Phase::kRunning);
}

TEST(RestartWhileStarting, AnActuatorThatCrashesAfterItsCheckIsCheckedAgain) {
  Harness t(Ours(3));
  t.On("a", "SelfCheck").takes = Milliseconds(90);
  t.Begin();
  ASSERT_TRUE(t.RunUntil([&] { return t.StateOf("b") == "SelfCheck"; }));
  t.Crash("b");
  t.Rest();
  EXPECT_TRUE(t.usable());
  EXPECT_EQ(t.StateOf("b"), "Active");
  EXPECT_EQ(std::count(t.log().begin(), t.log().end(), "b:SelfCheck"), 2);
}

TEST(RestartWhileStarting, ACriticalActuatorThatIsGivenUpAfterItsActivationTakesTheMachineDown) {
  MachineConfig config = OursWithCriticalB();
  ActuatorNamed(config, "b").restart.limit = 0;
  Harness t(config);
  t.On("a", "Active").takes = Milliseconds(90);
  t.Begin();
  ASSERT_TRUE(t.RunUntil([&] { return t.StateOf("b") == "Active"; }));
  t.RunFor(Milliseconds(1));
  t.Crash("b");
  t.Rest();
  EXPECT_EQ(t.machine().state, "Protected");
}

// While the machine switches, and when it ends

class RestartAcross : public Switching {};

TEST_F(RestartAcross, ASwitchUpIsUndoneAndTheRestartedActuatorFollows) {
  Harness& t = In("Protected", Ours(3));
  t.On("b", "Active").takes = Milliseconds(80);
  const RequestId request = t.RequestSwitch("Active");
  t.RunFor(Milliseconds(30));
  t.Crash("b");
  t.Rest();
  EXPECT_EQ(t.answers.at(request).outcome, SwitchOutcome::kUndone);
  for (const char* name : {"a", "b", "c"}) EXPECT_EQ(t.StateOf(name), "Protected");
}

TEST_F(RestartAcross, ASwitchDownContinuesAndTheRestartedActuatorFollows) {
  Harness& t = In("Active", Ours(3));
  t.On("b", "LowPower").takes = Milliseconds(80);
  const RequestId request = t.RequestSwitch("LowPower");
  t.RunFor(Milliseconds(30));
  t.Crash("b");
  t.Rest();
  EXPECT_EQ(t.answers.at(request).outcome, SwitchOutcome::kDoneDegraded);
  for (const char* name : {"a", "b", "c"}) EXPECT_EQ(t.StateOf(name), "LowPower");
  EXPECT_THAT(Degraded(t.config(), t.machine()), IsEmpty());
}

TEST_F(RestartAcross, AnActuatorRestartedBeforeItsTurnIsNotActivatedUnchecked) {
  MachineConfig config = Ours(3);
  ActuatorNamed(config, "b").after = {"a"};
  ActuatorNamed(config, "b").restart.delay = {};
  Harness& t = In("Protected", config);
  t.On("a", "Active").takes = Milliseconds(90);
  const RequestId request = t.RequestSwitch("Active");
  t.RunFor(Milliseconds(10));
  t.Crash("b");
  t.RunUntil([&] { return t.answers.count(request) > 0; });
  EXPECT_EQ(t.answers.at(request).outcome, SwitchOutcome::kUndone);
  t.Rest();
  EXPECT_THAT(t.log(), ::testing::Not(::testing::Contains("b:Active")));
  EXPECT_EQ(t.StateOf("b"), "Protected");
}

TEST_F(RestartAcross, NoActuatorIsRestartedWhileTheMachineEnds) {
  Harness& t = In("Active", Ours(3));
  t.On("a", "TearDown").takes = Milliseconds(90);
  t.Crash("c");
  t.RunFor(Milliseconds(50));
  const RequestId request = t.RequestSwitch("TearDown");
  t.RunFor(Milliseconds(20));
  t.Crash("b");
  t.Rest();
  EXPECT_EQ(t.answers.count(request), 1U);
  EXPECT_TRUE(t.stopped());
  for (const char* name : {"a", "b", "c"}) EXPECT_FALSE(t.IsAlive(name));
}

TEST_F(RestartAcross, AdoptedProcessesAreRestartedAndEndWithTheMachine) {
  Harness& t = In("Active", Ours(2));
  t.RestartController();
  t.Rest();
  t.Crash("b");
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Active");
  t.On("a", "TearDown").code = 3001;
  t.Set("TearDown");
  EXPECT_TRUE(t.stopped());
  EXPECT_FALSE(t.IsAlive("a")) << "an adopted process is ended like our own";
}

// By request

class RestartByHand : public Switching {
 protected:
  static Result<> Do(Harness& t, const std::string& name) {
    const RequestId call = t.Restart(name);
    EXPECT_TRUE(t.RunUntil([&] { return t.calls.count(call) > 0; })) << "no answer";
    return t.calls.at(call);
  }
};

TEST_F(RestartByHand, TearsItDownStartsItAndAnswersWhenItIsBack) {
  Harness& t = In("Active", Ours(2));
  EXPECT_TRUE(Do(t, "b"));
  EXPECT_THAT(t.log(), ElementsAre("b:TearDown", "b:SetUp", "b:SelfCheck", "b:Active"));
  EXPECT_EQ(t.StateOf("b"), "Active");
  EXPECT_THAT(t.signals, IsEmpty());
}

TEST_F(RestartByHand, OfAProcessThatDoesNotExitEscalates) {
  Harness& t = In("Active", Ours(2));
  t.On("b", "TearDown").hangs = true;
  t.On("b", "TERM").hangs = true;
  EXPECT_TRUE(Do(t, "b"));
  EXPECT_THAT(t.signals, ElementsAre("b:TERM", "b:KILL"));
  EXPECT_EQ(t.StateOf("b"), "Active");
}

// After its TearDown the process should exit by itself; here it also hosts another actuator.
TEST_F(RestartByHand, OfATornDownProcessThatDoesNotExitSendsSigtermBeforeSigkill) {
  for (const bool hangs : {false, true}) {
    Harness& t = In("Active", Ours(2));
    t.shared.insert("b");
    t.On("b", "TERM").hangs = hangs;
    EXPECT_TRUE(Do(t, "b"));
    if (hangs) {
      EXPECT_THAT(t.signals, ElementsAre("b:TERM", "b:KILL"));
    } else {
      EXPECT_THAT(t.signals, ElementsAre("b:TERM"));
    }
    EXPECT_EQ(t.StateOf("b"), "Active");
  }
}

TEST_F(RestartByHand, OfAProcessThatIgnoresSigtermAndReconnectsStillEnds) {
  Harness& t = In("Active", Ours(2));
  t.On("b", "TERM").hangs = true;
  t.Find("b", Health::kPartitioned, true);
  const RequestId call = t.Restart("b");
  t.RunFor(Milliseconds(10));
  t.Find("b", Health::kWell);
  t.Rest();
  EXPECT_THAT(t.signals, ElementsAre("b:TERM", "b:KILL"));
  EXPECT_TRUE(t.calls.at(call));
}

TEST_F(RestartByHand, BringsBackAnActuatorThatWasGivenUp) {
  Harness& t = In("Active", Ours(2));
  t.On("b", "SetUp").code = 5012;
  t.Crash("b");
  t.Rest();
  ASSERT_TRUE(t.RecordOf("b").restart.given_up);
  t.On("b", "SetUp").code = kCodeOk;
  EXPECT_TRUE(Do(t, "b"));
  EXPECT_FALSE(t.RecordOf("b").restart.given_up);
  EXPECT_EQ(t.StateOf("b"), "Active");
}

TEST_F(RestartByHand, OfAHungActuatorDoesNotWaitForItsTearDown) {
  MachineConfig config = Ours(2);
  config.actuators[1].restart.policy = RestartPolicy::kNo;
  Harness& t = In("Active", config);
  t.Find("b", Health::kHung);
  EXPECT_TRUE(Do(t, "b"));
  EXPECT_THAT(t.log(), ElementsAre("b:SetUp", "b:SelfCheck", "b:Active"));
}

TEST_F(RestartByHand, AnswersWhyItDoesNotComeBack) {
  MachineConfig config = Ours(2);
  config.actuators[1].restart.policy = RestartPolicy::kNo;
  Harness& t = In("Active", config);
  t.On("b", "SelfCheck").code = 5009;
  t.On("b", "SelfCheck").message = "no microphone";
  const Result<> answer = Do(t, "b");
  ASSERT_FALSE(answer);
  EXPECT_EQ(answer.error().code, 5009);
  EXPECT_THAT(answer.error().message, HasSubstr("no microphone"));
  t.On("b", "exec").code = kCodeFailed;
  t.On("b", "exec").message = "no such file";
  EXPECT_THAT(Do(t, "b").error().message, HasSubstr("no such file"));
}

TEST_F(RestartByHand, RequestedTwiceIsOneRestartAndBothAreAnswered) {
  Harness& t = In("Active", Ours(2));
  const RequestId first = t.Restart("b");
  const RequestId second = t.Restart("b");
  t.Rest();
  EXPECT_TRUE(t.calls.at(first));
  EXPECT_TRUE(t.calls.at(second));
  EXPECT_EQ(std::count(t.log().begin(), t.log().end(), "b:SetUp"), 1);
}

TEST_F(RestartByHand, IsRefusedWhereItCannotBe) {
  MachineConfig config = Ours(2);
  config.actuators[1].command.clear();
  Harness& t = In("Active", config);
  EXPECT_THAT(Do(t, "aa").error().message, HasSubstr("did you mean 'a'?"));
  EXPECT_EQ(Do(t, "b").error().code, kCodeUnSupport);
  t.Set("TearDown");
  EXPECT_EQ(Do(t, "a").error().code, kCodeStatusError);
}

TEST_F(RestartByHand, IsAnsweredAlsoWhenTheMachineEndsMeanwhile) {
  Harness& t = In("Active", Ours(2));
  t.On("b", "TearDown").takes = Milliseconds(80);
  const RequestId call = t.Restart("b");
  t.RunFor(Milliseconds(20));
  t.Set("TearDown");
  ASSERT_EQ(t.calls.count(call), 1U);
  EXPECT_THAT(t.calls.at(call).error().message, HasSubstr("torn down"));
}

TEST_F(RestartByHand, ARestartingActuatorBlocksNoSwitch) {
  Harness& t = In("Protected", OursWithCriticalB());
  t.On("b", "TearDown").takes = Milliseconds(80);
  const RequestId call = t.Restart("b");
  t.RunFor(Milliseconds(20));
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_EQ(t.Set("LowPower", "b").code, kCodeTargetBusy);
  t.Rest();
  EXPECT_TRUE(t.calls.at(call));
  EXPECT_EQ(t.StateOf("b"), "Active");
}

TEST_F(RestartByHand, IsAnsweredAlsoWhileAnEmergencyStopKeepsItDown) {
  Harness& t = In("Active", Ours(2));
  t.StopAll(5);
  t.RunFor(Milliseconds(10));
  EXPECT_TRUE(Do(t, "b"));
  EXPECT_EQ(t.StateOf("b"), "SelfCheck");
  t.Release();
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "SelfCheck") << "a release switches nothing on";
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_EQ(t.StateOf("b"), "Active");
}

TEST_F(RestartByHand, OfAProcessWhoseExitIsNotReportedEndsItsPartOfTheSwitch) {
  MachineConfig config = Ours(2);
  config.actuators[1].times.assign(config.states.size(), std::chrono::seconds(10));
  Harness& t = In("Protected", config);
  for (const char* what : {"Active", "TERM", "KILL"}) t.On("b", what).hangs = true;
  const RequestId request = t.RequestSwitch("Active");
  EXPECT_TRUE(Do(t, "b"));
  EXPECT_THAT(t.signals, ElementsAre("b:TERM", "b:KILL"));
  EXPECT_EQ(t.answers.at(request).outcome, SwitchOutcome::kUndone);
}

TEST_F(RestartByHand, DuringASwitchSendsNoTearDownBesideIt) {
  MachineConfig config = Ours(2);
  ActuatorNamed(config, "b").after = {"a"};
  Harness& t = In("Protected", config);
  t.On("a", "Active").takes = Milliseconds(80);
  t.RequestSwitch("Active");
  t.RunFor(Milliseconds(20));  // b is free, its turn comes after a
  EXPECT_TRUE(Do(t, "b"));
  EXPECT_THAT(t.signals, ElementsAre("b:TERM"));
  EXPECT_EQ(std::count(t.log().begin(), t.log().end(), "b:TearDown"), 0);
}

}  // namespace musher::testing::restart_test
