// What a controller finds that a person, or the controller before it, has left: torn down alone,
// held or given up. And when a held actuator is lowered all the same.

#include <gmock/gmock.h>

#include "musher/test/lifecycle/coordination/next_controller.hpp"
#include "musher/test/lifecycle/coordination/one_controller.hpp"

namespace musher::testing::next_controller_test {

using ::testing::IsEmpty;

class FoundByTheNext : public NextController {};

class FoundByOne : public OneController {};

TEST_F(FoundByTheNext, HeldStaysHeldWhereAllProcessesEndWithTheController) {
  Harness& t = Held();
  for (const char* name : {"a", "b", "c"}) t.Crash(name);
  t.RestartController(false, true);
  t.Rest();
  EXPECT_EQ(t.machine().state, "Active");
  EXPECT_EQ(t.StateOf("b"), "LowPower");
  EXPECT_TRUE(t.RecordOf("b").held);
}

TEST_F(FoundByTheNext, HeldStaysHeldWhereTheMachineStartsAgainByItself) {
  Harness& t = Held();
  TakeDown(t, AfterTearDown::kStartsAgain);
  EXPECT_EQ(t.disk().actuators.size(), 1U) << "what was held is forgotten";
  CrashController(t);
  EXPECT_EQ(t.machine().state, "Active");
  EXPECT_EQ(t.StateOf("b"), "LowPower");
}

TEST_F(FoundByTheNext, TornDownAloneStaysDownWhereASupervisorStopsAndStartsTheController) {
  Harness& t = TornDown();
  TakeDown(t, AfterTearDown::kMayStart);
  CrashController(t);
  EXPECT_EQ(t.StateOf("a"), "Active");
  EXPECT_FALSE(t.IsAlive("b")) << "it is in " << t.StateOf("b");
}

TEST_F(FoundByTheNext, TornDownAloneOutlastsAnOrderlyReboot) {
  Harness& t = TornDown();
  TakeDown(t, AfterTearDown::kMayStart);  // systemd ends it
  t.supervised = true;
  t.ClearLog();
  t.RestartController();
  t.Rest();
  EXPECT_EQ(t.StateOf("a"), "Active");
  EXPECT_FALSE(t.IsAlive("b")) << "it is in " << t.StateOf("b");
}

TEST_F(FoundByTheNext, TornDownAloneWhoseProcessStillExitsIsNotRestartedByTheNextController) {
  for (const bool clean : {false, true}) {
    MachineConfig config = Ours(3);
    config.actuators[1].restart.policy = clean ? RestartPolicy::kOnFailure : RestartPolicy::kAlways;
    Harness& t = In("Active", config);
    t.shared.insert("b");
    ASSERT_TRUE(t.Set("TearDown", "b").done());
    t.Rest();
    ASSERT_TRUE(t.IsAlive("b"));
    t.ClearLog();
    bool ended = false;
    t.after_step = [&] {
      if (std::exchange(ended, true)) return;
      t.Exit("b", clean ? 0 : 1, "late");  // before its latched status has arrived
    };
    t.RestartController(false, true);
    t.Rest();
    EXPECT_FALSE(t.IsAlive("b")) << "it is in " << t.StateOf("b");
    EXPECT_THAT(t.log(), IsEmpty());
    CrashController(t);
    EXPECT_FALSE(t.IsAlive("b")) << "second: it is in " << t.StateOf("b");
    EXPECT_THAT(t.log(), IsEmpty());
  }
}

TEST_F(FoundByTheNext, AfterARollbackAHeldOneDoesNotLowerTheMachineByARestartOfTheController) {
  Harness& t = Held(State(kLowPower));
  ASSERT_TRUE(t.Set("Protected").done());
  t.On("a", "Active").code = 5012;
  ASSERT_FALSE(t.Set("Active").done());
  t.Rest();
  ASSERT_EQ(t.machine().state, "Protected");
  EXPECT_EQ(t.StateOf("b"), "LowPower");
  EXPECT_TRUE(t.RecordOf("b").held);
  EXPECT_TRUE(t.CoreOf("b").report.detached) << "the next controller has to know";
  CrashController(t);
  EXPECT_EQ(t.machine().state, "Protected");
  EXPECT_EQ(t.StateOf("a"), "Protected");
}

TEST_F(FoundByTheNext, OneThatWasLostInAStateThatTheNextConfigHasNotIsListed) {
  MachineConfig config = WithDancing(Ours(2));
  config.actuators[1].restart.policy = RestartPolicy::kNo;
  Harness& t = In("Active", config);
  ASSERT_TRUE(t.Set("Dancing").done());
  t.Crash("b");
  t.Rest();
  ASSERT_EQ(t.disk().actuators.size(), 1U);
  MachineConfig without = Ours(2);
  Harness next(without);
  next.disk() = t.disk();
  next.BeginController(false, true, true);
  next.Rest();
  const SwitchResult result = next.Set("TearDown");
  EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded);
}

TEST_F(FoundByTheNext, ARos2NodeThatIsNotConfiguredAgainIsListedByATearDown) {
  MachineConfig config = Ours(2);
  config.actuators[1].protocol = Protocol::kRos2Lifecycle;
  Harness& t = In("Active", config);
  t.On("b", "SetUp").code = 5012;
  t.Crash("b");
  t.Rest();
  const SwitchResult result = t.Set("TearDown");
  EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded);
}

TEST_F(FoundByTheNext, OneThatIsLostOnItsWayDownAloneIsNotRaised) {
  Harness& t = In("Active", Ours(3));
  t.On("b", "LowPower").hangs = true;
  t.RequestSwitch("LowPower", "b");
  t.RunFor(Milliseconds(20));
  t.Crash("b");
  t.On("b", "LowPower").hangs = false;
  t.Rest();
  EXPECT_NE(t.StateOf("b"), "Active");
}

TEST_F(FoundByTheNext, AnUpgradeStartsOneThatWasGivenUp) {
  Harness& t = In("Active", OursWithCriticalB());
  t.On("b", "SetUp").code = 5012;
  t.Crash("b");
  t.Rest();
  ASSERT_TRUE(t.RecordOf("b").restart.given_up);
  TakeDown(t, AfterTearDown::kStartsAgain);
  t.On("b", "SetUp").code = kCodeOk;  // the new version
  CrashController(t);
  EXPECT_EQ(t.StateOf("b"), "Active");
  EXPECT_FALSE(t.RecordOf("b").fault) << "its trial boot fails";
}

TEST_F(FoundByTheNext, TheFallbackLowersAHeldOneThatIsOnItsWayUp) {
  MachineConfig config = OursWithCriticalB();
  ActuatorNamed(config, "b").restart.policy = RestartPolicy::kNo;
  Harness& t = In("Active", config);
  ASSERT_TRUE(t.Set("LowPower", "a").done());
  t.On("a", "Active").takes = Milliseconds(90);
  const RequestId up = t.RequestSwitch("Active", "a");
  t.RunFor(Milliseconds(20));
  t.Crash("b");
  t.Rest();
  EXPECT_EQ(t.answers.at(up).outcome, SwitchOutcome::kSuperseded);
  ASSERT_EQ(t.machine().state, "Protected");
  EXPECT_EQ(t.StateOf("c"), "Protected");
  EXPECT_NE(t.StateOf("a"), "Active");
}

TEST_F(FoundByTheNext, ASwitchDownLowersAHeldOneThatWentUpByItself) {
  Harness& t = Held();
  t.GoByItself("b", State(kActive));
  t.Rest();
  t.Set("Protected");
  t.Rest();
  EXPECT_EQ(t.StateOf("a"), "Protected");
  EXPECT_EQ(t.StateOf("b"), "Protected");
}

TEST_F(FoundByTheNext, ASwitchDownLowersAHeldOneWhoseRollbackHasFailed) {
  Harness& t = Held(State(kLowPower));
  ASSERT_TRUE(t.Set("Protected").done());
  t.On("a", "Active").takes = Milliseconds(50);
  t.On("a", "Active").code = 5012;
  t.On("b", "LowPower").code = 5012;
  ASSERT_FALSE(t.Set("Active").done());
  t.Rest();
  ASSERT_EQ(t.StateOf("b"), "Active");
  t.On("b", "LowPower").code = kCodeOk;
  const SwitchResult down = t.Set("DeActive");
  t.Rest();
  EXPECT_EQ(t.machine().state, "DeActive");
  EXPECT_NE(t.StateOf("b"), "Active") << down.reason;
}

TEST_F(FoundByTheNext, OneThatNoPolicyRestartsIsNotSwitchedOnByASecondRestartOfTheController) {
  MachineConfig config = Ours(2);
  config.actuators[1].restart.policy = RestartPolicy::kNo;
  Harness& t = In("Active", config);
  CrashController(t);
  t.Crash("b");
  t.Rest();
  ASSERT_FALSE(t.IsAlive("b"));
  CrashController(t);
  EXPECT_FALSE(t.IsAlive("b")) << "it is in " << t.StateOf("b");
  EXPECT_THAT(t.log(), IsEmpty());
}

TEST_F(FoundByTheNext, OneThatWasJustGivenUpIsNotSwitchedOnByARestartOfTheController) {
  Harness& t = In("Active", Ours(2));
  t.On("b", "exec").exit_code = 1;
  t.Crash("b");
  ASSERT_TRUE(t.RunUntil([&] { return t.RecordOf("b").restart.given_up; }));
  t.RunFor(Milliseconds(10));
  t.On("b", "exec").exit_code = 0;
  CrashController(t);
  EXPECT_FALSE(t.IsAlive("b")) << "it is in " << t.StateOf("b");
  EXPECT_THAT(t.log(), IsEmpty());
}

TEST_F(FoundByTheNext, HeldInAStateAsActiveAsTheMachineStaysThere) {
  Harness& t = In("Active", WithDancing(Ours(3)));
  ASSERT_TRUE(t.Set("Dancing").done());
  ASSERT_TRUE(t.Set("Active", "b").done());
  t.Rest();
  ASSERT_TRUE(t.RecordOf("b").held);
  t.Crash("b");
  t.Rest();
  EXPECT_NE(t.StateOf("b"), "Dancing");
}

TEST_F(FoundByTheNext, HeldInErrorIsNotRaisedByASwitchDown) {
  Harness& t = Held(State(kError));
  t.Set("Protected");
  EXPECT_EQ(t.StateOf("b"), "Error");
}

TEST_F(FoundByTheNext, HeldInErrorIsNotRaisedByARestart) {
  Harness& t = Held(State(kError));
  t.Crash("b");
  t.Rest();
  EXPECT_NE(t.StateOf("b"), "Active");
}

TEST_F(FoundByTheNext, OneThatNoPolicyRestartsAndThatEndsBesideTheControllerIsNotStarted) {
  MachineConfig config = Ours(3);
  config.actuators[1].restart.policy = RestartPolicy::kNo;
  Harness& t = In("Active", config);
  t.Crash("b");
  CrashController(t);
  EXPECT_FALSE(t.IsAlive("b")) << "it is in " << t.StateOf("b");
}

TEST_F(FoundByTheNext, ATearDownListsOneThatEndedBesideTheControllerAndIsNotSetUpAgain) {
  Harness& t = In("Active", Ours(3));
  t.Crash("b");
  t.On("b", "SetUp").code = 5012;
  CrashController(t);
  EXPECT_EQ(t.Set("TearDown").outcome, SwitchOutcome::kDoneDegraded);
}

// A person leads it out of Error by a self-check, and its hold ends with that.
TEST_F(FoundByTheNext, HeldInErrorIsLedOutBySelfCheckAlsoAfterARestart) {
  Harness& t = Held(State(kError));
  CrashController(t);
  ASSERT_EQ(t.StateOf("b"), "Error");
  EXPECT_TRUE(t.Set("SelfCheck").done());
  EXPECT_TRUE(t.Set("Protected").done());
  EXPECT_EQ(t.StateOf("b"), "Protected");
}

// It crashed with its motor on, a person took it out of the config, and "down" was done.
TEST_F(FoundByTheNext, OneThatIsTakenOutOfTheConfigIsNamedByATearDownAndKnownWhenItIsListedAgain) {
  Harness& t = In("Active", Ours(3));
  ASSERT_TRUE(t.Set("TearDown", "c").done());
  t.On("b", "SetUp").code = 5012;
  t.Crash("b");
  t.Rest();
  ASSERT_EQ(t.disk().actuators.size(), 2U);
  Harness next(Ours(1));  // a alone
  next.disk() = t.disk();
  next.BeginController(false, true, true);
  next.Rest();
  EXPECT_EQ(next.disk().actuators.size(), 2U);
  const SwitchResult down = next.Set("TearDown");
  EXPECT_EQ(down.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_EQ(down.reason,
            "b, which the config does not list: its process has ended in Active without "
            "its TearDown; what it had switched on may be on");
}

TEST_F(FoundByOne, OneThatIsTakenByAnotherMachineIsNotStoredAsGivenUp) {
  config_.transport = TransportProfile::kLan;
  HostConfig& host = config_.hosts.emplace_back();
  host.name = "board";
  host.address = "10.0.0.2";
  config_.actuators[0].host = "board";
  config_.actuators[0].command = {"run", "a"};
  config_.actuators[0].restart.policy = RestartPolicy::kAlways;
  Begin();
  Do(event::ProcessStarted{0, 700, "board", true});
  Do(event::Vanished{0, kFirst, false, "it follows another machine now", true, 700, "board"});
  Come(1);
  ObeyAll();
  Pass(std::chrono::seconds(5));
  for (const auto& save : Did<action::SaveActuators>()) EXPECT_TRUE(save.actuators.empty());
}

TEST_F(FoundByOne, AHeldRos2NodeLowersNoMachineByARestartOfTheController) {
  config_.actuators[1].protocol = Protocol::kRos2Lifecycle;
  for (ActuatorConfig& actuator : config_.actuators) actuator.command = {"run", actuator.name};
  machine_ = MakeMachine(config_);
  event::Begin begin{false, 1, {true, true}, "here"};
  begin.processes = {700, 701};
  begin.restarted = begin.supervised = true;
  begin.actuators = {{"b", StaysDown::kNo, {}, State("LowPower")}};
  Do(begin);
  Come(0, "Active");
  Come(1, "LowPower");
  EXPECT_EQ(machine_.state, "Active");
  EXPECT_TRUE(Of(1).held);
  for (const auto& sent : Did<action::SendSwitch>()) ADD_FAILURE() << sent.command.target;
}

TEST_F(FoundByOne, AHeldRos2NodeIsNotRaisedWhereItsConnectionComesBack) {
  config_.actuators[1].protocol = Protocol::kRos2Lifecycle;
  StartUp();
  Do(event::SetStateRequested{71, State("LowPower"), "b"});
  ObeyAll();
  ASSERT_TRUE(Of(1).held);
  Do(event::Vanished{1, Of(1).report.incarnation, false, "its samples ended"});
  ASSERT_EQ(Of(1).presence, Presence::kLost);
  Forget();
  Come(1, "LowPower");
  EXPECT_TRUE(Of(1).held);
  for (const auto& sent : Did<action::SendSwitch>()) ADD_FAILURE() << sent.command.target;
}

TEST_F(FoundByOne, ATearDownListsAFoundProcessThatSaidNothingAndWasKilled) {
  for (ActuatorConfig& actuator : config_.actuators) actuator.command = {"run", actuator.name};
  machine_ = MakeMachine(config_);
  PerActuator<bool> running(config_.actuators.size(), true);
  PerActuator<std::int32_t> pids;
  for (const ActuatorIndex i : running.Indices()) {
    pids.push_back(static_cast<std::int32_t>(700 + i.value()));
  }
  event::Begin begin{false, 1, running, "here", {}, pids};
  begin.restarted = begin.supervised = true;
  Do(begin);
  Come(1, kActive);
  Pass(std::chrono::seconds(1));
  ASSERT_EQ(machine_.state, kActive);
  ASSERT_EQ(Of(0).presence, Presence::kAbsent);
  Do(event::SetStateRequested{71, kTearDown, {}});
  ObeyAll();
  Do(event::ProcessEnded{0, 700, false, "killed by SIGKILL"});
  Do(event::ProcessEnded{1, 701, true, "exit code 0"});
  Pass(config_.shutdown_budget);
  ASSERT_EQ(machine_.phase, Phase::kStopped);
  const auto answers = Did<action::AnswerSetState>();
  ASSERT_FALSE(answers.empty());
  EXPECT_EQ(answers.back().result.outcome, SwitchOutcome::kDoneDegraded);
}

}  // namespace musher::testing::next_controller_test
