// During an emergency stop no actuator goes to another state of the same rank, either: its callback
// may switch on again what the stop has switched off.

#include <gmock/gmock.h>

#include <string>
#include <utility>

#include "musher/lifecycle/config/flow.hpp"
#include "musher/test/lifecycle/coordination/one_controller.hpp"
#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::emergency_stop_level_test {

using ::testing::Contains;
using ::testing::IsEmpty;
using ::testing::SizeIs;

MachineConfig WithEqualRank() {
  return WithDancing(MachineOf(2));
}

// Why an actuator stays where it went by itself.
RecordText Stays() {
  return texts::HeldIn("Dancing", "Active");
}

class StoppedActuators : public Switching {
 protected:
  static void Stop(Harness& t) {
    t.StopAll(5);
    t.RunFor(Milliseconds(1));
  }
};

TEST_F(StoppedActuators, StayInTheirState) {
  Harness& t = In("Active", WithEqualRank());
  Stop(t);
  EXPECT_EQ(t.Set("Dancing").code, kCodeProtectedError);
  EXPECT_EQ(t.Set("Dancing", "b").code, kCodeProtectedError);
  EXPECT_THAT(t.log(), IsEmpty());
  t.Release();
  EXPECT_TRUE(t.Set("Dancing").done());
}

TEST_F(StoppedActuators, StayWhereTheyWentByThemselvesUntilTheNextSwitch) {
  Harness& t = In("Active", WithEqualRank());
  Stop(t);
  t.GoByItself("b", "Dancing");
  t.Rest();
  ASSERT_TRUE(t.RecordOf("b").fault);
  EXPECT_THAT(t.RecordOf("b").fault, Is(Stays()));
  t.Release();
  t.Rest();
  EXPECT_THAT(t.log(), IsEmpty());
  EXPECT_EQ(t.RecordOf("b").state(), "Dancing");
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_EQ(t.RecordOf("b").state(), "Active");
  EXPECT_FALSE(t.RecordOf("b").fault);
}

// The search found such a switch reported as done, with every actuator degraded, and its callbacks
// begun again by the controller at the release.
TEST_F(StoppedActuators, EndASwitchThatTheStopCrossesInTheStateBefore) {
  Harness& t = In("Active", WithEqualRank());
  t.On("b", "Dancing").takes = Milliseconds(90);
  const RequestId request = t.RequestSwitch("Dancing");
  t.RunFor(Milliseconds(40));  // a has done its part
  Stop(t);
  t.Rest();
  const SwitchResult& result = t.answers.at(request);
  EXPECT_EQ(result.outcome, SwitchOutcome::kUndone);
  EXPECT_EQ(result.code, kCodeProtectedError);
  EXPECT_EQ(Of(result, "a").message, texts::NotDrivenBack().message);
  EXPECT_EQ(t.machine().state, "Active");
  EXPECT_EQ(t.RecordOf("a").state(), "Dancing");
  ASSERT_TRUE(t.RecordOf("a").fault);
  EXPECT_THAT(t.RecordOf("a").fault, Is(texts::StoppedIn("Dancing", "Dancing")));
  EXPECT_EQ(t.RecordOf("b").state(), "Active");
  EXPECT_FALSE(t.RecordOf("b").fault);
}

// A release starts no callback.
TEST_F(StoppedActuators, StayWhereTheStopHasEndedTheirSwitchUntilTheNextOne) {
  Harness& t = In("Active", WithEqualRank());
  t.On("b", "Dancing").takes = Milliseconds(90);
  t.RequestSwitch("Dancing");
  t.RunFor(Milliseconds(40));
  Stop(t);
  t.Rest();
  t.ClearLog();
  t.Release();
  t.Rest();
  EXPECT_THAT(t.log(), IsEmpty());
  EXPECT_EQ(t.RecordOf("a").state(), "Dancing");
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_EQ(t.RecordOf("a").state(), "Active");
  EXPECT_FALSE(t.RecordOf("a").fault);
}

// Such an actuator stayed in the state before: the controller took its hold for that of a stop that
// nothing has been requested after.
TEST_F(StoppedActuators, AreDrivenAgainByASwitchRequestedAfterTheReleaseThatWasOverdue) {
  Harness& t = In("Active", WithEqualRank());
  Stop(t);
  t.Release();
  t.Rest();
  t.On("b", "Dancing").takes = Milliseconds(900);
  t.On("b", "Dancing").code = kCodeFailed;
  EXPECT_EQ(t.Set("Dancing").outcome, SwitchOutcome::kDoneDegraded);
  t.On("b", "Dancing") = {};
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Dancing");
  EXPECT_FALSE(t.RecordOf("b").fault);
}

TEST_F(StoppedActuators, AreHeldByTheNextStopAlthoughASwitchWasRequestedBeforeIt) {
  Harness& t = In("Active", WithEqualRank());
  Stop(t);
  t.Release();
  ASSERT_TRUE(t.Set("Dancing").done());
  t.StopAll(6);
  t.RunFor(Milliseconds(1));
  t.GoByItself("b", "Active");
  t.Release();
  t.ClearLog();
  t.Rest();
  EXPECT_THAT(t.log(), IsEmpty());
  EXPECT_EQ(t.StateOf("b"), "Active");
}

TEST_F(StoppedActuators, ArePermittedNothingByARequestDuringTheStopOrToAStateBelow) {
  for (const bool released : {false, true}) {
    Harness& t = In("Active", WithEqualRank());
    Stop(t);
    t.On("b", "Protected").code = kCodeFailed;
    if (released) t.Release();
    EXPECT_FALSE(t.Set("Protected", "b").done());
    if (!released) t.Release();
    t.GoByItself("b", "Dancing");
    t.ClearLog();
    t.Rest();
    EXPECT_THAT(t.log(), IsEmpty()) << released;
    EXPECT_EQ(t.StateOf("b"), "Dancing") << released;
  }
}

// The state in which such a machine was adopted was that of the first actuator in the config, and
// the release drove the others there.
TEST_F(StoppedActuators, AreAdoptedInTheStateOfMostOfThemAndNotDrivenThereByTheRelease) {
  for (const std::string actuator : {"a", "c"}) {
    MachineConfig config = WithDancing(Ours(3));
    const std::string last = actuator == "a" ? "c" : "a";
    ActuatorNamed(config, "b").after = {actuator};
    ActuatorNamed(config, last).after = {"b"};
    Harness& t = In("Active", std::move(config));
    t.On("b", "Dancing").takes = Milliseconds(90);
    t.RequestSwitch("Dancing");
    t.RunFor(Milliseconds(40));
    ASSERT_EQ(t.StateOf(actuator), "Dancing");
    Stop(t);
    t.RestartController();
    t.Rest();
    EXPECT_EQ(t.machine().state, "Active") << actuator;
    ASSERT_TRUE(t.RecordOf(actuator).fault);
    EXPECT_THAT(t.RecordOf(actuator).fault, Is(Stays()));
    t.ClearLog();
    t.Release();
    t.Rest();
    EXPECT_THAT(t.log(), IsEmpty()) << actuator;
    EXPECT_TRUE(t.Set("Dancing").done());
    EXPECT_FALSE(t.RecordOf(actuator).fault);
  }
}

TEST_F(StoppedActuators, StayAlsoWhereTheControllerIsRestartedAfterTheRelease) {
  for (const bool most_dance : {false, true}) {
    Harness& t = In("Active", WithDancing(Ours(3)));
    t.On("c", "Dancing").takes = Milliseconds(90);
    if (!most_dance) t.On("b", "Dancing").takes = Milliseconds(90);
    t.RequestSwitch("Dancing");
    t.RunFor(Milliseconds(40));
    Stop(t);
    t.Rest();
    t.Release();
    t.Rest();
    t.ClearLog();
    t.RestartController();
    t.Rest();
    EXPECT_THAT(t.log(), IsEmpty()) << most_dance;
  }
}

TEST_F(StoppedActuators, KeepTheFailureOfTheirOwnThatTheStopCrosses) {
  Harness& t = In("Active", WithEqualRank());
  t.On("a", "Dancing").code = kCodeFailed;
  t.On("a", "Dancing").message = "the motor stalls";
  t.On("b", "Dancing").takes = Milliseconds(90);
  const RequestId request = t.RequestSwitch("Dancing");
  t.RunFor(Milliseconds(40));
  Stop(t);
  t.Rest();
  EXPECT_EQ(t.answers.at(request).outcome, SwitchOutcome::kUndone);
  ASSERT_TRUE(t.RecordOf("a").fault);
  EXPECT_THAT(t.RecordOf("a").fault,
              Is(texts::Reported(ActuatorOutcome::kFailed, "the motor stalls")));
}

TEST_F(StoppedActuators, AreDrivenBackToAStateBelow) {
  Harness& t = In("Active", WithEqualRank());
  ASSERT_TRUE(t.Set("DeActive", "a").done());
  t.On("b", "Dancing").takes = Milliseconds(90);
  t.RequestSwitch("Dancing");
  t.RunFor(Milliseconds(40));
  ASSERT_EQ(t.StateOf("a"), "Dancing");
  Stop(t);
  t.Rest();
  EXPECT_EQ(t.StateOf("a"), "DeActive");
}

TEST_F(StoppedActuators, PassTheirSelfCheckIfTheyWereRestartedInTheSwitch) {
  MachineConfig config = WithDancing(Ours(2));
  for (Duration& time : ActuatorNamed(config, "b").times) time = Milliseconds(1000);
  Harness& t = In("Active", std::move(config));
  t.On("b", "Dancing").takes = Milliseconds(900);
  t.RequestSwitch("Dancing");
  t.RunFor(Milliseconds(40));
  t.Crash("a");
  t.RunFor(Milliseconds(300));
  ASSERT_EQ(t.RecordOf("a").state(), "SetUp") << "it is back, and waits for the end of the switch";
  Stop(t);
  t.Rest();
  t.Release();
  t.Rest();
  EXPECT_THAT(t.log(), Contains("a:SelfCheck"));
  EXPECT_TRUE(t.RecordOf("a").checked);
  EXPECT_EQ(t.RecordOf("a").state(), "SelfCheck");
  EXPECT_THAT(t.RecordOf("a").fault, Is(EventName::kHeldByEmergencyStop));
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_EQ(t.RecordOf("a").state(), "Active");
  EXPECT_FALSE(t.RecordOf("a").fault);
}

// A module of another protocol would run the callback: it does not receive the stop.
class ActuatorsOfAnyProtocol : public OneController {
 protected:
  void StartUp() {
    config_ = WithEqualRank();
    config_.actuators[1].after = {"a"};
    OneController::StartUp();
  }
  void Stop() { Do(event::EmergencyStopSeen{{7, "alice", "smoke"}}); }
};

TEST_F(ActuatorsOfAnyProtocol, AreNotCommandedOnceTheStopIsEngaged) {
  StartUp();
  Do(event::SetStateRequested{1, "Dancing", {}});
  ASSERT_TRUE(Of(0).command);
  Stop();
  Obey(0);
  EXPECT_FALSE(Of(1).command);
  ASSERT_THAT(Did<action::AnswerSetState>(), SizeIs(1));
  const SwitchResult result = Did<action::AnswerSetState>()[0].result;
  EXPECT_EQ(result.actuators.at(1).outcome, ActuatorOutcome::kRefused);
  EXPECT_EQ(result.actuators.at(1).code, kCodeProtectedError);
}

TEST_F(ActuatorsOfAnyProtocol, RecordTheStopAsTheCauseOfTheRollbackThatDrivesNoneBack) {
  StartUp();
  Do(event::SetStateRequested{1, "Dancing", {}});
  Stop();
  Obey(0);
  const action::Record record = RecordWith(EventName::kRollbackStarted);
  const CommandNumber number = record.switch_number;
  EXPECT_THAT(record, Is(texts::RollbackStarted(number, number + 1, 0)));
  EXPECT_NE(record.cause, RecordId(0));
  EXPECT_EQ(record.cause, machine_.emergency.cause);
}

TEST_F(ActuatorsOfAnyProtocol, AreCommandedWhereTheirRos2StateIsTheSame) {
  StartUp();
  config_.actuators[1].protocol = Protocol::kRos2Lifecycle;
  config_.actuators[1].ros2_states = {{"Dancing", Ros2State::kActive}};
  Stop();
  Say(1, Report(1, "Dancing"));
  EXPECT_FALSE(Of(1).fault);
  ASSERT_TRUE(Of(1).command);
  EXPECT_EQ(Of(1).command->target, "Active");
}

// Such a node ran no callback on the way, and was left in the state whose switch had been undone.
TEST_F(ActuatorsOfAnyProtocol, AreDrivenBackWhereTheirRos2StateIsTheSame) {
  StartUp();
  config_.actuators[0].protocol = Protocol::kRos2Lifecycle;
  config_.actuators[0].ros2_states = {{"Dancing", Ros2State::kActive}};
  Do(event::SetStateRequested{1, "Dancing", {}});
  Stop();
  Obey(0);
  ASSERT_TRUE(Of(0).command);
  EXPECT_EQ(Of(0).command->target, "Active");
}

// In both its ROS 2 state would be inactive, but `configure` runs on the way.
TEST_F(ActuatorsOfAnyProtocol, AreNotConfiguredDuringTheStop) {
  config_ = WithEqualRank();
  config_.actuators[1].protocol = Protocol::kRos2Lifecycle;
  EXPECT_TRUE(RunsCallback(config_, 1, config_.default_state, "Protected"));
  EXPECT_FALSE(RunsCallback(config_, 1, "DeActive", "Protected"));
  EXPECT_TRUE(RunsCallback(config_, 0, "DeActive", "Protected"));
}

TEST_F(ActuatorsOfAnyProtocol, KeepTheirOwnFailureWhereAStopHoldsThem) {
  StartUp();
  const ActuatorFault own{5001, "the motor stalls", EventName::kCommandFailed};
  Of(1).fault = own;
  Stop();
  ActuatorReport report = Report(1, "Dancing");
  report.outcome_code = 5001;
  Say(1, report);
  EXPECT_FALSE(Of(1).due);
  EXPECT_EQ(Of(1).fault, own);
}

TEST_F(ActuatorsOfAnyProtocol, AreNotSaidToBeBusyAnyMoreWhereAStopHoldsThem) {
  StartUp();
  const RecordText busy = texts::StillBusy("Dancing", Milliseconds(100));
  Of(1).fault = ActuatorFault{kCodeTimeout, busy.message, busy.event};
  Stop();
  Say(1, Report(1, "Dancing"));
  EXPECT_THAT(Of(1).fault, Is(Stays()));
}

// No person has requested it since. (It could overtake the release, too, and be refused.)
TEST_F(ActuatorsOfAnyProtocol, AreNotCommandedUpByTheRelease) {
  StartUp();
  Stop();
  ActuatorReport report = Report(1, "DeActive");  // by itself
  report.emergency_stop = 7;
  Say(1, report);
  Do(event::ReleaseRequested{2, "alice"});
  EXPECT_FALSE(Of(1).command);
  report.emergency_stop = 0;
  Say(1, report);
  EXPECT_FALSE(Of(1).command);
  EXPECT_THAT(Of(1).fault, Is(EventName::kHeldByEmergencyStop));
  Do(event::SetStateRequested{3, State("Active")});
  ASSERT_TRUE(Of(1).command);
  EXPECT_EQ(Of(1).command->target, "Active");
}

TEST_F(StoppedActuators, ThatASwitchUpHasNotReachedAreSkippedAndNotRefused) {
  Harness& t = In("Protected", Chain());
  t.On("c", "Active").takes = Milliseconds(50);
  const RequestId request = t.RequestSwitch("Active");
  t.RunFor(Milliseconds(10));
  Stop(t);
  ASSERT_TRUE(t.RunUntil([&] { return t.answers.count(request) > 0; }));
  EXPECT_EQ(Of(t.answers.at(request), "a").outcome, ActuatorOutcome::kSkipped);
}

}  // namespace musher::testing::emergency_stop_level_test
