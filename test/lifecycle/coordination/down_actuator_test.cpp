// Actuators that have ended: what the next controller starts of them by itself, and what a TearDown
// of the machine says of them.

#include <gmock/gmock.h>

#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::down_actuator_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class DownActuators : public Switching {
 protected:
  // The controller crashes, and its supervisor starts the next.
  static void CrashController(Harness& t) {
    t.ClearLog();
    t.RestartController(false, true);
    t.Rest();
  }
  static void GiveUpB(Harness& t) {
    t.On("b", "SetUp").code = 5012;
    t.Crash("b");
    t.Rest();
    ASSERT_TRUE(t.RecordOf("b").restart.given_up);
    t.On("b", "SetUp").code = kCodeOk;
  }
  static void ExpectListed(const SwitchResult& result, const State& lost_in = State(kActive)) {
    EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded);
    EXPECT_THAT(result.degraded, ElementsAre("b"));
    EXPECT_THAT(result.reason, HasSubstr(texts::LostWithoutTearDown(lost_in).message));
  }
};

TEST_F(DownActuators, OneThatWasTornDownAloneIsNotSwitchedOnByARestartOfTheController) {
  Harness& t = In("Active", Ours(2));
  ASSERT_TRUE(t.Set("TearDown", "b").done());
  t.Rest();
  ASSERT_FALSE(t.IsAlive("b"));
  CrashController(t);
  EXPECT_FALSE(t.IsAlive("b")) << "it is in " << t.StateOf("b");
  EXPECT_THAT(t.log(), IsEmpty());
  EXPECT_THAT(t.RecordOf("b").fault, Is(texts::TornDownAlone()));
  CrashController(t);
  EXPECT_FALSE(t.IsAlive("b")) << "nor by a second one";
}

// `musher up` beside actuators that a crashed controller has left takes over, and requests nothing.
TEST_F(DownActuators, OneThatWasTornDownAloneIsNotSwitchedOnByAStartThatTakesOver) {
  Harness& t = In("Active", Ours(2));
  ASSERT_TRUE(t.Set("TearDown", "b").done());
  t.Rest();
  t.ClearLog();
  t.RestartController();
  t.Rest();
  EXPECT_FALSE(t.IsAlive("b"));
  EXPECT_THAT(t.log(), IsEmpty());
}

TEST_F(DownActuators, ARestartThatAPersonRequestsStartsIt) {
  Harness& t = In("Active", Ours(2));
  ASSERT_TRUE(t.Set("TearDown", "b").done());
  t.Rest();
  CrashController(t);
  const RequestId call = t.Restart("b");
  t.Rest();
  EXPECT_TRUE(t.calls.at(call));
  EXPECT_EQ(t.StateOf("b"), "Active");
  CrashController(t);
  EXPECT_EQ(t.StateOf("b"), "Active");
  EXPECT_THAT(t.disk().actuators, IsEmpty());
}

// The first start of a robot after its boot is no person's either.
TEST_F(DownActuators, TheLossOfACriticalOneThatAPersonHasTornDownMovesNoNextController) {
  Harness& t = In("Active", OursWithCriticalB());
  ASSERT_TRUE(t.Set("TearDown", "b").done());
  t.Rest();
  CrashController(t);
  EXPECT_FALSE(t.IsAlive("b"));
  EXPECT_EQ(t.machine().state, "Active");
  EXPECT_THAT(t.log(), IsEmpty());
}

TEST_F(DownActuators, AStartOfAPersonAfterATearDownOfTheMachineStartsAll) {
  Harness& t = In("Active", Ours(2));
  ASSERT_TRUE(t.Set("TearDown", "b").done());
  t.Rest();
  ASSERT_TRUE(t.Set("TearDown").done());
  t.Rest();
  ASSERT_TRUE(t.stopped());
  EXPECT_THAT(t.disk().actuators, IsEmpty());
  t.RestartController();
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Active");
}

// As for an upgrade: no person has decided that all of them start.
TEST_F(DownActuators, OneThatWasTornDownAloneStaysDownWhereTheMachineStartsAgainByItself) {
  Harness& t = In("Active", Ours(2));
  ASSERT_TRUE(t.Set("TearDown", "b").done());
  t.Rest();
  t.Feed(event::SetStateRequested{71, "TearDown", {}, AfterTearDown::kStartsAgain});
  t.Rest();
  ASSERT_TRUE(t.stopped());
  CrashController(t);
  EXPECT_EQ(t.StateOf("a"), "Active");
  EXPECT_FALSE(t.IsAlive("b"));
}

TEST_F(DownActuators, OneThatWasGivenUpIsNotSwitchedOnByARestartOfTheController) {
  Harness& t = In("Active", Ours(2));
  GiveUpB(t);
  CrashController(t);
  EXPECT_FALSE(t.IsAlive("b"));
  EXPECT_THAT(t.log(), IsEmpty());
  EXPECT_THAT(t.RecordOf("b").fault, Is(texts::GivenUpBefore(State(kActive))));
  const RequestId call = t.Restart("b");
  t.Rest();
  EXPECT_TRUE(t.calls.at(call));
  EXPECT_EQ(t.StateOf("b"), "Active");
}

TEST_F(DownActuators, OneThatNoPolicyRestartsIsNotSwitchedOnByARestartOfTheController) {
  MachineConfig config = Ours(2);
  config.actuators[1].restart.policy = RestartPolicy::kNo;
  Harness& t = In("Active", config);
  t.Crash("b");
  t.Rest();
  ASSERT_FALSE(t.IsAlive("b"));
  CrashController(t);
  EXPECT_FALSE(t.IsAlive("b"));
  EXPECT_THAT(t.log(), IsEmpty());
}

TEST_F(DownActuators, OneThatWasAboutToBeRestartedIsStartedByTheNextController) {
  MachineConfig config = Ours(2);
  config.actuators[1].restart.delay = std::chrono::seconds(30);
  config.actuators[1].restart.max_delay = std::chrono::seconds(30);
  Harness& t = In("Active", config);
  t.Crash("b");
  ASSERT_TRUE(t.RunUntil([&] { return t.RecordOf("b").restart.at.has_value(); }));
  CrashController(t);
  EXPECT_EQ(t.StateOf("b"), "Active");
}

// `musher down` was done, exit code 0, beside a motor that was on.
TEST_F(DownActuators, ATearDownListsOneThatHasEndedWithoutItsOwn) {
  for (const bool ours : {false, true}) {
    MachineConfig config = ours ? Ours(2) : MachineOf(2);
    for (ActuatorConfig& actuator : config.actuators) {
      actuator.restart.policy = RestartPolicy::kNo;
    }
    Harness& t = In("Active", config);
    t.Crash("b");
    t.Rest();
    ExpectListed(t.Set("TearDown"));
  }
}

// The reply that it is in Active had not arrived.
TEST_F(DownActuators, ATearDownNamesTheStateToWhichOneMayHaveComeBeforeItEnded) {
  MachineConfig config = Ours(2);
  config.actuators[1].restart.policy = RestartPolicy::kNo;
  Harness& t = In("DeActive", config);
  t.On("b", "Active").takes = Milliseconds(80);
  t.RequestSwitch("Active");
  t.RunFor(Milliseconds(20));
  t.Crash("b");
  t.Rest();
  ExpectListed(t.Set("TearDown"));
}

TEST_F(DownActuators, ATearDownListsOneThatIsRestartedAtThatMoment) {
  Harness& t = In("Active", Ours(2));
  t.On("b", "SetUp").hangs = true;
  t.Crash("b");
  ASSERT_TRUE(t.RunUntil([&] { return t.RecordOf("b").process.pid != 0 && t.IsAlive("b"); }));
  ExpectListed(t.Set("TearDown"));
}

TEST_F(DownActuators, ATearDownListsNoneThatHasEndedInAStepOfAStart) {
  Harness& t = In("Active", Ours(2));
  t.On("b", "SelfCheck").hangs = true;
  t.Restart("b");
  ASSERT_TRUE(t.RunUntil([&] { return t.StateOf("b") == "SetUp" && t.RecordOf("b").command; }));
  t.On("b", "SetUp").hangs = true;
  t.Crash("b");
  t.RunFor(Milliseconds(20));
  EXPECT_TRUE(t.Set("TearDown").done());
}

// An actuator that ends itself at an emergency stop, and again once it was set up: the second end
// hid the first, and `down` was done, exit code 0.
TEST_F(DownActuators, ATearDownListsOneWhoseSuccessorHasEndedInSetUp) {
  MachineConfig config = Ours(2);
  config.actuators[1].restart.limit = 1;
  Harness& t = In("Active", config);
  t.On("b", "SelfCheck").hangs = true;
  const auto is = [&t](Presence presence) { return t.RecordOf("b").presence == presence; };
  t.Crash("b");
  ASSERT_TRUE(t.RunUntil([&] { return is(Presence::kLost); }));
  ASSERT_TRUE(t.RunUntil([&] { return is(Presence::kPresent); }));
  t.Crash("b");
  ASSERT_TRUE(t.RunUntil([&] { return t.RecordOf("b").restart.given_up; }));
  ExpectListed(t.Set("TearDown"));
}

// It runs in the process of a, which is started again for a.
TEST_F(DownActuators, OneThatWasTornDownAloneStaysDownWhereItsProcessIsRestartedForAnother) {
  MachineConfig config = Ours(3);
  config.actuators[1].command.clear();
  Harness& t = In("Active", config);
  const auto share = [&t] {  // what the process of b reports
    t.Feed(event::ProcessStarted{0, t.CoreOf("b").report.pid});
  };
  share();
  ASSERT_TRUE(t.Set("TearDown", "b").done());
  t.Rest();
  t.ClearLog();
  t.StartActuator("b");
  t.RunFor(Milliseconds(1));
  share();
  t.Rest();
  EXPECT_THAT(t.log(), ElementsAre("b:SetUp"));
  EXPECT_EQ(t.StateOf("b"), "SetUp");
  EXPECT_THAT(t.RecordOf("b").fault, Is(texts::StartedBeside("a")));
  EXPECT_TRUE(t.Set("SelfCheck", "b").done());
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_EQ(t.StateOf("b"), "Active") << "a person has led it up";
}

// Another party, as systemd or a person, has started it: it decides.
TEST_F(DownActuators, OneThatWasTornDownAloneComesOnWhereAnotherPartyStartsIt) {
  MachineConfig config = Ours(2);
  config.actuators[1].command.clear();
  Harness& t = In("Active", config);
  ASSERT_TRUE(t.Set("TearDown", "b").done());
  t.Rest();
  t.StartActuator("b");
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Active");
}

TEST_F(DownActuators, ATearDownListsNoneThatIsSetUpAgain) {
  Harness& t = In("Active", Ours(2));
  t.Crash("b");
  t.Rest();
  ASSERT_EQ(t.StateOf("b"), "Active");
  EXPECT_TRUE(t.Set("TearDown").done());
}

TEST_F(DownActuators, ATearDownListsOneThatWasKilledInItsOwnAlone) {
  Harness& t = In("Active", Ours(2));
  t.On("b", "TearDown").hangs = true;
  t.RequestSwitch("TearDown", "b");
  t.RunFor(Milliseconds(20));
  t.Crash("b");
  t.Rest();
  ExpectListed(t.Set("TearDown"));
}

TEST_F(DownActuators, ATearDownListsNoneThatWasTornDownAlone) {
  Harness& t = In("Active", Ours(2));
  ASSERT_TRUE(t.Set("TearDown", "b").done());
  t.Rest();
  EXPECT_TRUE(t.Set("TearDown").done());
}

// The controller crashes, too, before the TearDown that a person has requested is done.
TEST_F(DownActuators, AControllerThatFinishesATearDownListsOneThatWasLostBefore) {
  MachineConfig config = Ours(2);
  config.actuators[1].restart.policy = RestartPolicy::kNo;
  Harness& t = In("Active", config);
  t.Crash("b");
  t.Rest();
  t.On("a", "TearDown").takes = Milliseconds(80);
  t.RequestSwitch("TearDown");
  t.RunFor(Milliseconds(20));
  CrashController(t);
  ASSERT_TRUE(t.stopped());
  ASSERT_TRUE(t.machine().stopping && t.machine().stopping->result);
  EXPECT_THAT(t.RecordOf("b").fault, Is(texts::LostWithoutTearDown(State(kActive))));
}

}  // namespace musher::testing::down_actuator_test
