#include <gmock/gmock.h>

#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::stopping_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;

class Shutdown : public ::testing::Test {
 protected:
  static MachineConfig Chain() {
    MachineConfig config = MachineOf(3);
    for (ActuatorConfig& actuator : config.actuators) actuator.command = {"run", actuator.name};
    ActuatorNamed(config, "a").after = {"b"};
    ActuatorNamed(config, "b").after = {"c"};
    config.shutdown_budget = Milliseconds(2000);
    return config;
  }
  Shutdown() : t(Chain()) {
    t.Begin();
    t.Rest();
    EXPECT_EQ(t.machine().state, "Active");
    t.ClearLog();
  }
  Harness t;
};

TEST_F(Shutdown, TearsDownInReverseOrderAndTheProcessesEndByThemselves) {
  EXPECT_TRUE(t.Set("TearDown").done());
  EXPECT_THAT(t.log(), ElementsAre("a:TearDown", "b:TearDown", "c:TearDown"));
  EXPECT_TRUE(t.stopped());
  EXPECT_EQ(t.machine().phase, Phase::kStopped);
  EXPECT_THAT(t.signals, ElementsAre());
}

// A previous controller has started it, just before it received the first heartbeat of this one.
TEST_F(Shutdown, AnUnknownProcessEndsWithTheMachine) {
  t.Crash("c");
  t.RunUntil([&] { return t.RecordOf("c").presence == Presence::kLost; });
  const auto request = t.RequestSwitch("TearDown");
  t.Mute("c", true, true);
  t.StartActuator("c");  // nothing is received from it
  t.Rest();
  EXPECT_TRUE(t.stopped());
  EXPECT_TRUE(t.answers.contains(request));
  EXPECT_FALSE(t.IsAlive("c"));
  EXPECT_THAT(t.signals, ElementsAre("c:TERM"));
}

TEST_F(Shutdown, AProcessThatIsBeingStartedWhenTheMachineStopsEndsWithIt) {
  t.Crash("c");
  t.RunUntil([&] { return t.RecordOf("c").restart.at.has_value(); });
  t.RunUntil([&] { return t.RecordOf("c").process.pid != 0; });
  t.Set("TearDown");
  EXPECT_TRUE(t.stopped());
  for (const char* name : {"a", "b", "c"}) EXPECT_FALSE(t.IsAlive(name)) << name;
}

TEST_F(Shutdown, AnActuatorThatFailsToTearDownGetsSigtermAndDoesNotDelayTheOthers) {
  t.On("b", "TearDown").code = 5001;
  const SwitchResult result = t.Set("TearDown");
  EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_THAT(t.log(), ElementsAre("a:TearDown", "b:TearDown", "c:TearDown"));
  EXPECT_THAT(t.signals, ElementsAre("b:TERM"));
  EXPECT_TRUE(t.stopped());
}

TEST_F(Shutdown, AnActuatorThatHangsAndIgnoresSigtermIsKilledWithinTheBudget) {
  t.On("b", "TearDown").hangs = true;
  t.On("b", "TERM").hangs = true;
  const Time begun = t.now();
  t.Set("TearDown");
  EXPECT_THAT(t.signals, ElementsAre("b:TERM", "b:KILL"));
  EXPECT_TRUE(t.stopped());
  EXPECT_LE(t.now() - begun, Milliseconds(2000));
}

TEST_F(Shutdown, TheBudgetIsNeverExceededThoughEveryActuatorHangs) {
  for (const char* name : {"a", "b", "c"}) {
    t.On(name, "TearDown").hangs = true;
    t.On(name, "TERM").hangs = true;
  }
  const Time begun = t.now();
  t.Set("TearDown");
  EXPECT_TRUE(t.stopped());
  EXPECT_LE(t.now() - begun, Milliseconds(2000));
  EXPECT_THAT(t.signals, ::testing::IsSupersetOf({"a:KILL", "b:KILL", "c:KILL"}));
}

TEST_F(Shutdown, SupersedesASwitchUnderWay) {
  t.On("b", "LowPower").takes = Milliseconds(80);
  const RequestId first = t.RequestSwitch("LowPower");
  t.RunFor(Milliseconds(30));
  EXPECT_TRUE(t.Set("TearDown").done());
  EXPECT_EQ(t.answers.at(first).outcome, SwitchOutcome::kSuperseded);
}

TEST_F(Shutdown, RequestedTwiceIsOneStop) {
  const RequestId first = t.RequestSwitch("TearDown");
  const RequestId second = t.RequestSwitch("TearDown");
  t.Rest();
  EXPECT_TRUE(t.answers.at(first).done());
  EXPECT_TRUE(t.answers.at(second).done());
}

TEST_F(Shutdown, RequestedAgainWhileAProcessStillRunsIsTheSameStop) {
  t.shared.insert("c");
  t.RequestSwitch("TearDown");
  ASSERT_TRUE(t.RunUntil([&] { return !t.machine().current; }));
  const RequestId again = t.RequestSwitch("TearDown");
  EXPECT_FALSE(t.answers.contains(again));
  t.Rest();
  EXPECT_TRUE(t.answers.at(again).done());
}

TEST_F(Shutdown, RecordsHowLongItTook) {
  const Time begun = t.now();
  t.Set("TearDown");
  EXPECT_THAT(t.records, Contains(Is(texts::MachineStopped(t.now() - begun, std::nullopt))));
}

TEST_F(Shutdown, RefusesEverythingElseFromThenOn) {
  t.Set("TearDown");
  EXPECT_EQ(t.Set("Active").outcome, SwitchOutcome::kRefused);
}

TEST(StoppingEarly, EndsProcessesThatAreStillSettingUp) {
  MachineConfig config = MachineOf(2);
  for (ActuatorConfig& actuator : config.actuators) actuator.command = {"run", actuator.name};
  ActuatorNamed(config, "b").times.assign(9, Milliseconds(60'000));
  Harness t(config);
  t.On("b", "SetUp").hangs = true;
  t.Begin();
  t.RunFor(Milliseconds(500));
  EXPECT_TRUE(t.Set("TearDown").done()) << "what never was there is not left behind";
  EXPECT_TRUE(t.stopped());
  EXPECT_THAT(t.signals, UnorderedElementsAre("b:TERM"));
}

// What still runs

TEST_F(Shutdown, AFrozenActuatorWithoutACommandIsListedThoughTheRestIsDown) {
  MachineConfig config = MachineOf(2);
  ActuatorNamed(config, "a").command = {"run", "a"};
  Harness robot(config);
  robot.Begin();
  robot.Rest();
  robot.Mute("b", true, true);
  robot.Find("b", Health::kPartitioned, true);
  const SwitchResult result = robot.Set("TearDown");
  EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_THAT(result.degraded, ElementsAre("b"));
  EXPECT_THAT(result.reason, HasSubstr(texts::MayStillRun("Active").message));
  EXPECT_TRUE(robot.stopped());
}

TEST_F(Shutdown, AnActuatorThatIsLostDuringTearDownIsListed) {
  MachineConfig config = MachineOf(2);
  Harness robot(config);
  robot.Begin();
  robot.Rest();
  robot.On("a", "TearDown").takes = Milliseconds(80);
  robot.Mute("b", true, true);
  const SwitchResult result = robot.Set("TearDown");
  EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_THAT(result.degraded, ElementsAre("b"));
}

// This controller was stopped for longer than the leases of the actuators: all of them were ended
// by signals, with what they had switched on.
TEST_F(Shutdown, AwaitsActuatorsWhoseConnectionAloneWasLost) {
  for (const char* name : {"a", "b", "c"}) {
    t.Feed(event::Vanished{*t.config().IndexOf(name), t.RecordOf(name).report.incarnation, false,
                           "connection lost"});
  }
  const RequestId request = t.RequestSwitch("TearDown");
  t.RunFor(Milliseconds(100));
  EXPECT_THAT(t.signals, ElementsAre());
  for (const char* name : {"a", "b", "c"}) t.RepeatStatus(name);
  t.Rest();
  EXPECT_TRUE(t.answers.at(request).done()) << t.answers.at(request).reason;
  EXPECT_THAT(t.log(), ElementsAre("a:TearDown", "b:TearDown", "c:TearDown"));
  EXPECT_THAT(t.signals, ElementsAre());
}

TEST_F(Shutdown, EndsAnActuatorWhoseConnectionStaysLost) {
  t.Feed(event::Vanished{2, t.RecordOf("c").report.incarnation, false, "connection lost"});
  t.Mute("c", true, true);
  const SwitchResult result = t.Set("TearDown");
  EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_THAT(result.degraded, ElementsAre("c"));
  EXPECT_THAT(t.signals, ElementsAre("c:TERM"));
  EXPECT_THAT(t.log(), ElementsAre("a:TearDown", "b:TearDown"));
}

TEST_F(Shutdown, AnActuatorThatIsReachedAgainDuringTearDownIsListed) {
  Harness robot(MachineOf(2));
  robot.Begin();
  robot.Rest();
  robot.On("a", "TearDown").takes = Milliseconds(80);
  robot.Find("b", Health::kPartitioned, true);
  const RequestId request = robot.RequestSwitch("TearDown");
  robot.RunFor(Milliseconds(40));
  robot.Find("b", Health::kWell);  // it still runs, and its TearDown was not sent
  robot.Rest();
  EXPECT_EQ(robot.answers.at(request).outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_THAT(robot.answers.at(request).degraded, ElementsAre("b"));
}

TEST_F(Shutdown, AProcessThatOutlivesSigkillIsListed) {
  t.On("b", "TearDown").hangs = true;
  t.On("b", "TERM").hangs = true;
  t.On("b", "KILL").hangs = true;
  const SwitchResult result = t.Set("TearDown");
  EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_THAT(result.degraded, ElementsAre("b"));
  EXPECT_THAT(t.RecordOf("b").fault,
              Is(texts::ProcessLeftBehind(t.RecordOf("b").process.pid, std::nullopt)));
}

// With a short budget the queries for the outcome of TearDown end after SIGKILL.
TEST(StoppingInAShortTime, NoSigtermFollowsSigkill) {
  MachineConfig config = MachineOf(1);
  config.actuators[0].command = {"run", "a"};
  config.shutdown_budget = Milliseconds(800);
  Harness t(config);
  t.Begin();
  t.Rest();
  t.On("a", "TearDown").hangs = true;
  t.On("a", "KILL").hangs = true;
  t.Mute("a", true, true);
  EXPECT_EQ(t.Set("TearDown").outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_THAT(t.signals, ElementsAre("a:KILL"));
}

TEST(StoppingWithAFault, AnOldFaultOfATornDownActuatorDoesNotMakeTheTearDownDegraded) {
  MachineConfig config = MachineOf(3);
  for (ActuatorConfig& actuator : config.actuators) actuator.command = {"run", actuator.name};
  Harness t(config);
  t.On("b", "SelfCheck").code = 3009;
  t.Begin();
  t.Rest();
  ASSERT_THAT(Degraded(t.config(), t.machine()), ElementsAre("b"));
  const SwitchResult result = t.Set("TearDown");
  EXPECT_TRUE(result.done()) << result.reason;
  EXPECT_THAT(result.degraded, ElementsAre());
  EXPECT_TRUE(t.stopped());
}

// The stop intent

TEST_F(Shutdown, TheIntentIsOnDiskBeforeTheFirstTearDown) {
  t.disk_takes = Milliseconds(40);
  t.RequestSwitch("TearDown");
  t.RunFor(Milliseconds(30));
  EXPECT_THAT(t.log(), ElementsAre());
  EXPECT_TRUE(t.RunUntil([&] { return !t.log().empty(); }));
  EXPECT_TRUE(t.disk().stop_intent);
}

TEST_F(Shutdown, ADiskThatNeverAnswersDelaysTearDownForAMomentOnly) {
  t.disk_takes.reset();
  const Time begun = t.now();
  EXPECT_TRUE(t.Set("TearDown").done());
  EXPECT_TRUE(t.stopped());
  EXPECT_LE(t.now() - begun, Milliseconds(2000));
  EXPECT_THAT(t.records, Contains(Is(EventName::kStopIntentLate)));
}

TEST_F(Shutdown, AControllerThatASupervisorStartsAfterACrashInTearDownFinishesIt) {
  t.On("b", "TearDown").takes = Milliseconds(60);
  t.RequestSwitch("TearDown");
  EXPECT_TRUE(t.RunUntil([&] { return t.log().size() == 2; }));  // a is down, b is switching
  t.RestartController(/*lost_disk=*/false, /*restarted=*/true);
  t.Rest();
  EXPECT_TRUE(t.stopped());
  EXPECT_FALSE(t.usable());
  for (const char* name : {"a", "b", "c"}) EXPECT_FALSE(t.IsAlive(name)) << name;
  EXPECT_THAT(t.log(), ElementsAre("a:TearDown", "b:TearDown", "c:TearDown"));
}

// All had been torn down and had exited: no process is left that could report it.
TEST_F(Shutdown, AControllerThatASupervisorStartsAfterTheLastProcessHasEndedStaysDown) {
  t.Set("TearDown");
  t.ClearLog();
  t.RestartController(false, true);
  t.Rest();
  EXPECT_TRUE(t.stopped());
  EXPECT_THAT(t.log(), ElementsAre());
}

TEST_F(Shutdown, APersonsStartClearsTheIntent) {
  t.Set("TearDown");
  t.RestartController();
  t.Rest();
  EXPECT_EQ(t.machine().state, "Active");
  EXPECT_FALSE(t.disk().stop_intent);
}

TEST_F(Shutdown, ARestartBySupervisorWithoutAnIntentAdoptsTheMachine) {
  t.RestartController(false, true);
  t.Rest();
  EXPECT_EQ(t.machine().state, "Active");
  EXPECT_THAT(t.log(), ElementsAre());
}

TEST_F(Shutdown, ATearDownToStartAgainLeavesNoIntentUnlessAnOperatorRequestsOne) {
  t.Feed(event::SetStateRequested{71, "TearDown", std::nullopt, AfterTearDown::kStartsAgain});
  t.RunFor(Milliseconds(1));
  EXPECT_FALSE(t.disk().stop_intent);
  t.RequestSwitch("TearDown");
  t.Rest();
  EXPECT_TRUE(t.disk().stop_intent);
}

// `systemctl restart`: the supervisor that ends it starts it again.
TEST_F(Shutdown, AStopByASupervisorLeavesAnIntentOnlyUntilTheMachineIsDown) {
  t.Feed(event::SetStateRequested{71, "TearDown", std::nullopt, AfterTearDown::kMayStart});
  EXPECT_TRUE(t.RunUntil([&] { return !t.log().empty(); }));
  EXPECT_TRUE(t.disk().stop_intent);
  t.Rest();
  EXPECT_TRUE(t.stopped());
  EXPECT_FALSE(t.disk().stop_intent);
}

// The caller got the reply that it was released, and no panel received the release.
TEST(AfterTearDown, AnEmergencyStopIsNotReleasedByAControllerThatPublishesNoMore) {
  Harness t(Ours(2));
  t.Begin();
  t.Rest();
  ASSERT_TRUE(t.Set("TearDown").done());
  ASSERT_EQ(t.machine().phase, Phase::kStopped);
  t.StopAll(7);
  t.Rest();
  const Result<>& reply = t.calls.at(t.Release());
  ASSERT_FALSE(reply);
  EXPECT_EQ(reply.error().message,
            "the machine is stopped; start it (`musher up`), then release the emergency stop");
}

}  // namespace musher::testing::stopping_test
