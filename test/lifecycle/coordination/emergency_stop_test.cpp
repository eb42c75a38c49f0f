// An emergency stop in every phase: latched, blocks every switch up, released by request only.

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include "musher/test/lifecycle/coordination/records.hpp"
#include "musher/test/lifecycle/coordination/switching.hpp"
#include "musher/test/support/refusals.hpp"

namespace musher::testing::emergency_stop_test {

using ::testing::Contains;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::UnorderedElementsAre;

constexpr StopId kStop = 5;
constexpr StopId kNone = 0;

class EmergencyStopped : public Switching {
 protected:
  static void Stop(Harness& t, StopId id = kStop) {
    t.StopAll(id);
    t.RunFor(Milliseconds(1));
  }
};

TEST_F(EmergencyStopped, IsPublishedToAllSavedAndChangesNoState) {
  Harness& t = In("Active");
  Stop(t);
  for (const char* name : {"a", "b", "c"}) {
    EXPECT_EQ(t.CoreOf(name).report.emergency_stop, kStop);
    EXPECT_EQ(t.StateOf(name), "Active");
  }
  ASSERT_EQ(t.disk().stops.engaged.size(), 1U);
  EXPECT_EQ(t.disk().stops.engaged[0].id, kStop);
  EXPECT_EQ(t.disk().stops.engaged[0].by, "the test");
  EXPECT_EQ(t.machine().state, "Active");
  EXPECT_THAT(t.log(), IsEmpty());
}

TEST_F(EmergencyStopped, RefusesSwitchesUpAndAllowsSwitchesDown) {
  Harness& t = In("Protected");
  Stop(t);
  const SwitchResult up = t.Set("Active");
  EXPECT_EQ(up.outcome, SwitchOutcome::kRefused);
  EXPECT_EQ(up.code, kCodeProtectedError);
  EXPECT_THAT(up.reason, HasSubstr("engaged by the test"));
  EXPECT_TRUE(t.Set("LowPower").done());
  EXPECT_TRUE(t.Set("SelfCheck").done());
  EXPECT_EQ(t.Set("Protected").code, kCodeProtectedError);
  EXPECT_TRUE(t.Set("Error").done());
}

TEST_F(EmergencyStopped, RefusesASwitchUpAlsoWhenNoActuatorWouldBeDriven) {
  Harness& t = In("Protected", MachineOf(1));
  t.Crash("a");
  t.RunFor(Milliseconds(1));
  Stop(t);
  EXPECT_EQ(t.Set("Active").code, kCodeProtectedError);
  EXPECT_EQ(t.machine().state, "Protected");
}

TEST_F(EmergencyStopped, RefusesOneActuatorToGoUp) {
  Harness& t = In("Active");
  ASSERT_TRUE(t.Set("LowPower", "b").done());
  Stop(t);
  EXPECT_EQ(t.Set("Protected", "b").code, kCodeProtectedError);
  EXPECT_EQ(t.Set("Active").code, kCodeProtectedError) << "b would have to come up for it";
  EXPECT_TRUE(t.Set("DeActive", "a").done());
}

TEST_F(EmergencyStopped, UndoesASwitchUpUnderWay) {
  Harness& t = In("Protected", Chain());
  t.On("b", "Active").ends_when_requested = true;
  const RequestId request = t.RequestSwitch("Active");
  t.RunFor(Milliseconds(30));
  ASSERT_EQ(t.StateOf("c"), "Active");
  const Time begun = t.now();
  Stop(t);
  t.RunUntil([&] { return t.answers.count(request) > 0; });
  EXPECT_EQ(t.answers.at(request).outcome, SwitchOutcome::kUndone);
  EXPECT_LT(t.now() - begun, Milliseconds(50)) << "running callbacks are requested to stop";
  for (const char* name : {"a", "b", "c"}) EXPECT_EQ(t.StateOf(name), "Protected");
  EXPECT_THAT(t.log(), Not(Contains("a:Active")));
}

TEST_F(EmergencyStopped, UndoesASwitchUpWhoseLastCallbackEndsAnyway) {
  Harness& t = In("Protected");
  const RequestId request = t.RequestSwitch("Active");
  t.RunFor(Milliseconds(5));
  Stop(t);
  t.Rest();
  EXPECT_EQ(t.answers.at(request).outcome, SwitchOutcome::kUndone);
  for (const char* name : {"a", "b", "c"}) EXPECT_EQ(t.StateOf(name), "Protected");
}

TEST_F(EmergencyStopped, LetsASwitchDownContinue) {
  Harness& t = In("Active", Chain());
  const RequestId request = t.RequestSwitch("LowPower");
  t.RunFor(Milliseconds(15));
  Stop(t);
  t.Rest();
  EXPECT_TRUE(t.answers.at(request).done());
  EXPECT_EQ(t.machine().state, "LowPower");
}

TEST_F(EmergencyStopped, AllowsAFallbackAndTheEndOfTheMachine) {
  Harness& t = In("Active", OursWithCriticalB());
  Stop(t);
  t.On("b", "SetUp").code = 3001;
  t.Crash("b");
  t.Rest();
  EXPECT_EQ(t.machine().state, "Protected");
  t.Set("TearDown");
  EXPECT_TRUE(t.stopped());
}

// The release of the stop brought it up to Active, without a request.
TEST_F(EmergencyStopped, ARestartedActuatorIsCheckedAndWaitsUntilTheStateIsSetAgain) {
  Harness& t = In("Active", Ours(2));
  Stop(t);
  t.Crash("b");
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "SelfCheck");
  EXPECT_EQ(t.CoreOf("b").report.emergency_stop, kStop)
      << "the latched stop is published to late actuators";
  EXPECT_THAT(t.log(), Not(Contains("b:Active")));
  t.Release();
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "SelfCheck");
  EXPECT_THAT(t.log(), Not(Contains("b:Active")));
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_EQ(t.StateOf("b"), "Active");
}

TEST_F(EmergencyStopped, AnActuatorThatComesBackAfterTheReleaseWaitsUntilTheStateIsSetAgain) {
  Harness& t = In("Active", Ours(2));
  Stop(t);
  t.Release();
  t.Rest();
  t.Crash("b");
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "SelfCheck") << "it was on when the stop switched it off";
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_EQ(t.StateOf("b"), "Active");
  t.Crash("b");
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Active") << "the stop is over";
}

TEST_F(EmergencyStopped, AnActuatorThatASetAfterTheReleaseHasNotReachedFollowsIt) {
  Harness& t = In("Active", Ours(2));
  Stop(t);
  t.Release();
  t.Rest();
  t.Crash("b");
  t.Set("Active");
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Active");
}

TEST_F(EmergencyStopped, AJoinUnderWayEndsAndTheNextStepWaits) {
  Harness& t = In("Active", Ours(2));
  t.On("b", "Active").ends_when_requested = true;
  t.Crash("b");
  ASSERT_TRUE(t.RunUntil([&] { return t.CoreOf("b").report.target == "Active"; }));
  Stop(t);
  t.RunFor(std::chrono::seconds(5));
  EXPECT_EQ(t.StateOf("b"), "SelfCheck");
}

// What a released stop has switched off

TEST_F(EmergencyStopped, RefusesThePresentStateInsteadOfReportingDone) {
  Harness& t = In("Active");
  Stop(t);
  const SwitchResult again = t.Set("Active");
  EXPECT_EQ(again.outcome, SwitchOutcome::kRefused);
  EXPECT_EQ(again.code, kCodeProtectedError);
  EXPECT_THAT(again.reason, HasSubstr("until it is released it holds Active"));
  EXPECT_EQ(t.Set("Active", "a").outcome, SwitchOutcome::kRefused);
  EXPECT_THAT(t.log(), IsEmpty());
}

TEST_F(EmergencyStopped, SettingThePresentStateAfterTheReleaseRunsTheCallbacksOfTheHeldActuators) {
  Harness& t = In("Active");
  Stop(t);
  t.Release();
  t.Rest();
  EXPECT_THAT(t.log(), IsEmpty()) << "a release changes nothing by itself";
  for (const char* name : {"a", "b", "c"}) EXPECT_TRUE(t.RecordOf(name).report.held_by_stop);
  const SwitchResult again = t.Set("Active");
  EXPECT_TRUE(again.done());
  EXPECT_THAT(t.log(), UnorderedElementsAre("a:Active", "b:Active", "c:Active"));
  for (const char* name : {"a", "b", "c"}) EXPECT_FALSE(t.RecordOf(name).report.held_by_stop);
  t.ClearLog();
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_THAT(t.log(), IsEmpty()) << "now they were there already";
}

TEST_F(EmergencyStopped, TheHoldOfOneActuatorEndsWhenItsOwnStateIsSet) {
  Harness& t = In("Active");
  Stop(t);
  t.Release();
  t.Rest();
  EXPECT_TRUE(t.Set("Active", "b").done());
  EXPECT_THAT(t.log(), UnorderedElementsAre("b:Active"));
  EXPECT_TRUE(t.RecordOf("a").report.held_by_stop);
}

TEST_F(EmergencyStopped, ANewControllerFindsTheActuatorsHeldByAReleasedStop) {
  Harness& t = In("Active");
  Stop(t);
  t.Release();
  t.Rest();
  t.RestartController();
  t.Rest();
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_THAT(t.log(), UnorderedElementsAre("a:Active", "b:Active", "c:Active"));
}

TEST_F(EmergencyStopped, AnActuatorRestartedAfterTheReleaseIsSwitchedOnWithTheOthers) {
  Harness& t = In("Active", Ours(2));
  Stop(t);
  t.Release();
  t.Crash("b");
  t.Rest();
  EXPECT_FALSE(t.RecordOf("b").report.held_by_stop);
  t.ClearLog();
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_THAT(t.log(), UnorderedElementsAre("a:Active", "b:Active"));
}

// It had gone to that state on its own before the stop, and the machine followed without a request.
TEST_F(EmergencyStopped, AFallbackToTheStateOfAHeldActuatorDoesNotSwitchItOn) {
  MachineConfig config = Ours(2);
  ActuatorNamed(config, "b").critical = true;
  ActuatorNamed(config, "b").on_lost = "Protected";
  Harness& t = In("Active", std::move(config));
  ASSERT_TRUE(t.Set("Protected", "a").done());
  Stop(t);
  t.Release();
  t.Rest();
  t.ClearLog();
  t.On("b", "SetUp").code = 3001;
  t.Crash("b");
  t.Rest();
  ASSERT_EQ(t.machine().state, "Protected");
  EXPECT_THAT(t.log(), Not(Contains("a:Protected")));
  EXPECT_TRUE(t.RecordOf("a").report.held_by_stop);
  t.Set("Protected");
  EXPECT_THAT(t.log(), Contains("a:Protected"));
  EXPECT_FALSE(t.RecordOf("a").report.held_by_stop);
}

// The start

TEST(EmergencyStopAtTheStart, KeepsTheMachineFromGoingUpAndReportsWhatToDo) {
  Harness t(Ours(2));
  t.disk().stops.engaged = {{kStop, "operator", "smoke"}};
  t.Begin();
  t.Rest();
  EXPECT_EQ(t.machine().phase, Phase::kFailed);
  EXPECT_THAT(t.start_up()->message, HasSubstr("estop --release"));
  EXPECT_THAT(t.log(), Not(Contains("a:Active")));
  EXPECT_TRUE(t.Set("SelfCheck").done());
  EXPECT_EQ(t.Set("Active").code, kCodeProtectedError);
  EXPECT_TRUE(t.Released());
  t.Rest();
  EXPECT_EQ(t.machine().state, "SelfCheck") << "a release changes no state";
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_EQ(t.machine().phase, Phase::kRunning);
}

TEST(EmergencyStopAtTheStart, EndsAStartInTheMiddleOfItsCheck) {
  Harness t(Ours(2));
  t.Begin();
  ASSERT_TRUE(t.RunUntil([&] { return t.CoreOf("a").report.target == "SelfCheck"; }));
  t.StopAll(kStop);
  t.Rest();
  EXPECT_EQ(t.machine().phase, Phase::kFailed);
  EXPECT_THAT(t.log(), Not(Contains("a:Active")));
}

// The start is a request of before the stop.
TEST(EmergencyStopAtTheStart, ThatIsReleasedDuringItsSetUpEndsIt) {
  Harness t(Ours(2));
  t.On("b", "SetUp").takes = Milliseconds(80);
  t.Begin();
  ASSERT_TRUE(t.RunUntil([&] { return t.StateOf("a") == "SetUp"; }));
  t.StopAll(kStop);
  t.RunFor(Milliseconds(10));
  t.Release();
  t.Rest();
  EXPECT_EQ(t.machine().phase, Phase::kFailed);
  EXPECT_EQ(t.machine().state, "SetUp");
  EXPECT_THAT(t.start_up()->message, HasSubstr("no state was requested since the last"));
  EXPECT_TRUE(t.Set("SelfCheck").done());
  EXPECT_TRUE(t.Set("Active").done());
}

TEST(EmergencyStopAtTheStart, ThatIsReleasedDuringItsSelfCheckEndsIt) {
  Harness t(Ours(2));
  t.On("b", "SelfCheck").takes = Milliseconds(80);
  t.Begin();
  ASSERT_TRUE(t.RunUntil([&] { return t.StateOf("a") == "SelfCheck"; }));
  t.StopAll(kStop);
  t.RunFor(Milliseconds(10));
  t.Release();
  t.Rest();
  EXPECT_EQ(t.machine().phase, Phase::kFailed);
  EXPECT_THAT(t.log(), Not(Contains("a:Active")));
  EXPECT_TRUE(t.Set("SelfCheck").done());
  EXPECT_TRUE(t.Set("Active").done());
}

TEST(EmergencyStopAtTheStart, EndsAStartOnItsWayToActive) {
  Harness t(Ours(2));
  t.On("b", "Active").ends_when_requested = true;
  t.Begin();
  ASSERT_TRUE(t.RunUntil([&] { return t.StateOf("a") == "Active"; }));
  t.StopAll(kStop);
  t.Rest();
  EXPECT_EQ(t.machine().phase, Phase::kFailed);
  EXPECT_EQ(t.StateOf("a"), "DeActive");
  t.Release();
  t.On("b", "Active") = {};
  EXPECT_TRUE(t.Set("SelfCheck").done());
  EXPECT_TRUE(t.Set("Active").done());
}

TEST(StateFolderAtTheStart, ThatCannotBeWrittenKeepsTheMachineInDeActiveUntilAPersonSetsActive) {
  Harness t(Ours(2));
  t.disk_fails = "the disk is full";
  t.Begin();
  t.Rest();
  EXPECT_EQ(t.machine().state, "DeActive");
  EXPECT_TRUE(t.usable());
  EXPECT_TRUE(IsRecorded(t.records, EventName::kStateNotWritable));
  EXPECT_TRUE(t.Set("Active").done());
}

TEST(StateFolderAtTheStart, ThatCannotBeWrittenFailsTheStartOfAMachineWithoutDeActive) {
  MachineConfig config = Ours(2);
  std::erase(config.states, State(kDeActive));
  Harness t(config);
  t.disk_fails = "the disk is full";
  t.Begin();
  t.Rest();
  EXPECT_EQ(t.machine().phase, Phase::kFailed);
  EXPECT_EQ(t.machine().state, "SelfCheck");
}

// Several stops, and their release

TEST_F(EmergencyStopped, TwoAtOnceAreReleasedTogether) {
  Harness& t = In("Active");
  t.Inject("a", actuator_event::EmergencyStopReceived{6, true, 0});  // it received the second first
  Stop(t, 5);
  Stop(t, 6);
  EXPECT_EQ(t.CoreOf("a").report.emergency_stop, StopId(6));
  EXPECT_EQ(t.CoreOf("b").report.emergency_stop, StopId(5));
  EXPECT_TRUE(t.Released());
  t.Rest();
  for (const char* name : {"a", "b", "c"}) EXPECT_EQ(t.CoreOf(name).report.emergency_stop, kNone);
  EXPECT_FALSE(t.machine().emergency.stop);
  EXPECT_TRUE(t.disk().stops.engaged.empty());
}

// A panel that is pressed for a minute pushed the stops of all others out.
TEST_F(EmergencyStopped, ANewerStopOfOneSourceReplacesItsOwnAndNoStopOfAnother) {
  Harness& t = In("Active");
  t.StopAll(1000, "the door");
  t.RunFor(Milliseconds(1));
  for (StopId id = 1; id <= 100; ++id) Stop(t, id);
  const auto& emergency = t.machine().emergency;
  ASSERT_TRUE(emergency.stop);
  EXPECT_EQ(emergency.stop->by, "the door");
  EXPECT_EQ(emergency.stop->id, StopId(1000));
  ASSERT_EQ(emergency.others.size(), 1U) << "the one source has one stop";
  EXPECT_EQ(emergency.others[0].id, StopId(100)) << "its newest";
  EXPECT_THAT(emergency.released, Not(Contains(StopId(1000))));
  EXPECT_THAT(emergency.released, Contains(StopId(99))) << "an actuator may have latched it";
  EXPECT_EQ(t.disk().stops.engaged.size(), 2U);
}

TEST_F(EmergencyStopped, OneReleaseEndsAHundredStopsOfOneSource) {
  Harness& t = In("Active");
  for (StopId id = 1; id <= 100; ++id) Stop(t, id);
  EXPECT_TRUE(t.Released());
  for (const char* name : {"a", "b", "c"}) EXPECT_EQ(t.CoreOf(name).report.emergency_stop, kNone);
  t.Rest();
  EXPECT_FALSE(t.machine().emergency.stop);
}

TEST_F(EmergencyStopped, OneReleaseEndsTheStopsOfAHundredSources) {
  Harness& t = In("Active");
  for (StopId id = 1; id <= 100; ++id) {
    t.StopAll(id, "panel " + ToString(id));
    t.RunFor(Milliseconds(1));
  }
  EXPECT_TRUE(t.Released());
  for (const char* name : {"a", "b", "c"}) EXPECT_EQ(t.CoreOf(name).report.emergency_stop, kNone);
  t.Rest();
  EXPECT_FALSE(t.machine().emergency.stop);
}

TEST_F(EmergencyStopped, AReleaseIsAnsweredOnceEveryActuatorHasConfirmedIt) {
  Harness& t = In("Active");
  Stop(t);
  t.DelayReports("b", Milliseconds(500));
  const RequestId request = t.Release();
  t.RunFor(Milliseconds(400));
  EXPECT_EQ(t.calls.count(request), 0U);
  t.RunFor(Milliseconds(400));
  ASSERT_EQ(t.calls.count(request), 1U);
  EXPECT_TRUE(t.calls.at(request));
}

TEST_F(EmergencyStopped, AReleaseThatAnActuatorDoesNotConfirmNamesItAndIsNotReported) {
  Harness& t = In("Active");
  Stop(t);
  t.Mute("b", true, true);
  const Result<> released = t.Released();
  ASSERT_FALSE(released);
  EXPECT_EQ(released.error().code, kCodeTimeout);
  EXPECT_THAT(released.error().message, HasSubstr("not confirmed by b"));
}

// On another host "crashed" is a verdict from silence: it may go on, still stopped.
TEST_F(EmergencyStopped, AReleaseIsNotConfirmedByAnActuatorWhoseExitIsNotKnown) {
  Harness& t = In("Active");
  Stop(t);
  t.Mute("b", true, true);
  t.Find("b", Health::kCrashed, true);
  EXPECT_EQ(t.RecordOf("b").presence, Presence::kLost);
  const Result<> released = t.Released();
  ASSERT_FALSE(released);
  EXPECT_THAT(released.error().message, HasSubstr("not confirmed by b"));
}

// Its last report has no stop, as the stop came later: the journal had the machine as released.
TEST_F(EmergencyStopped, AReleaseIsNotConfirmedByAReportFromBeforeTheConnectionWasLost) {
  Harness& t = In("Active");
  t.Mute("b", true, true);
  t.Find("b", Health::kPartitioned, true);
  EXPECT_EQ(t.RecordOf("b").presence, Presence::kLost);
  Stop(t);
  const Result<> released = t.Released();
  ASSERT_FALSE(released);
  EXPECT_THAT(released.error().message, HasSubstr("not confirmed by b"));
  EXPECT_THAT(t.whole_records,
              Not(Contains(Field(&action::Record::event, EventName::kEmergencyStopReleased))));
}

TEST_F(EmergencyStopped, ALostReleaseIsPublishedUntilItIsConfirmed) {
  Harness& t = In("Active");
  Stop(t);
  t.lost_stops = true;
  const RequestId request = t.Release();
  t.RunFor(Milliseconds(10));
  t.lost_stops = false;
  t.RunUntil([&] { return t.calls.count(request) > 0; });
  EXPECT_TRUE(t.calls.at(request));
  EXPECT_EQ(t.CoreOf("a").report.emergency_stop, kNone);
}

TEST_F(EmergencyStopped, AReleaseThatAnotherStopCrossesIsNotReportedAsReleased) {
  Harness& t = In("Active");
  Stop(t);
  t.DelayReports("b", Milliseconds(500));
  const RequestId request = t.Release();
  t.StopAll(kStop + 1, "a panel");
  t.RunUntil([&] { return t.calls.count(request) > 0; });
  ASSERT_FALSE(t.calls.at(request));
  EXPECT_THAT(t.calls.at(request).error().message, HasSubstr("engaged again"));
}

// Each number below 4 delays an actuator, restarts one or the controller, or loses a release; each
// other one is a stop.
RC_GTEST_FIXTURE_PROP(EmergencyStopped, AfterReleasedNoActuatorReportsAStopWhateverCameBefore, ()) {
  Harness& t = In("Active", Ours(3));
  const auto steps = *rc::gen::container<std::vector<int>>(rc::gen::inRange(0, 200));
  for (const int step : steps) {
    const std::string name(1, static_cast<char>('a' + step % 3));
    if (step == 0) {
      t.Crash(name);
    } else if (step == 1) {
      t.RestartController();
    } else if (step == 2) {
      t.DelayReports(name, Milliseconds(30));
    } else if (step == 3) {
      t.lost_stops = !t.lost_stops;
    } else {
      t.StopAll(StopId(static_cast<std::uint64_t>(step)), "panel " + std::to_string(step % 7));
    }
    t.RunFor(Milliseconds(1 + step % 5));
  }
  t.RunFor(Milliseconds(1));
  if (!t.machine().emergency.stop) return;
  t.lost_stops = false;
  const Result<> released = t.Released();
  if (!released) RC_SUCCEED("not reported as released");
  for (const char* name : {"a", "b", "c"}) {
    if (t.RecordOf(name).presence != Presence::kPresent) continue;
    RC_ASSERT(t.CoreOf(name).report.emergency_stop == kNone);
  }
}

TEST_F(EmergencyStopped, AReleasedStopDoesNotComeBackByALateSample) {
  Harness& t = In("Active");
  Stop(t);
  t.Release();
  t.Rest();
  Stop(t);  // the same, delayed
  EXPECT_FALSE(t.machine().emergency.stop);
  for (const char* name : {"a", "b", "c"}) EXPECT_EQ(t.CoreOf(name).report.emergency_stop, kNone);
  Stop(t, kStop + 1);
  EXPECT_TRUE(t.machine().emergency.stop) << "another one is another one";
}

TEST_F(EmergencyStopped, ReleasingWhereNoneIsEngagedIsRefused) {
  Harness& t = In("Active");
  EXPECT_EQ(t.Released().error().code, kCodeStateInvalid);
}

TEST_F(EmergencyStopped, TheReleaseIsPublishedAgainToAnActuatorThatMissedIt) {
  Harness& t = In("Active", Ours(2));
  Stop(t);
  t.Release();
  t.Crash("b");
  t.Rest();  // the new controller has received no release
  t.Inject("b", actuator_event::EmergencyStopReceived{kStop, true, 0});
  EXPECT_EQ(t.CoreOf("b").report.emergency_stop, kStop);
  t.Rest();
  EXPECT_EQ(t.CoreOf("b").report.emergency_stop, kNone);
  EXPECT_FALSE(t.machine().emergency.stop);
}

// The second was engaged while the first was being released: the actuators have it, the controller
// not yet.
TEST_F(EmergencyStopped, AStopEngagedDuringAReleaseStaysEngaged) {
  Harness& t = In("Active");
  Stop(t);
  t.Inject("a", actuator_event::EmergencyStopReceived{kStop + 1, true, 0});
  t.Release();
  t.Rest();
  EXPECT_EQ(t.CoreOf("a").report.emergency_stop, kStop + 1);
  ASSERT_TRUE(t.machine().emergency.stop) << "the controller gets it from the actuator's status";
  EXPECT_EQ(t.machine().emergency.stop->id, kStop + 1);
}

// A callback that switches on at its end, and a stop that comes while it runs.
TEST_F(EmergencyStopped, AStopDuringAnUpwardCallbackUndoesTheSwitch) {
  Harness& t = In("DeActive");
  t.On("b", "Active").takes = Milliseconds(80);  // it ignores the request to stop
  const RequestId up = t.RequestSwitch("Active");
  t.RunFor(Milliseconds(40));
  Stop(t);
  t.Rest();
  EXPECT_EQ(t.answers.at(up).outcome, SwitchOutcome::kUndone);
  EXPECT_EQ(t.machine().state, "DeActive");
  for (const char* name : {"a", "b", "c"}) EXPECT_EQ(t.StateOf(name), "DeActive");
}

// Other controllers

// Its panel still publishes "engaged" to the next controller.
TEST_F(EmergencyStopped, AReleasedStopStaysReleasedAfterARestartOfTheController) {
  Harness& t = In("Active", Ours(2));
  Stop(t);
  t.Release();
  t.Rest();
  t.RestartController();
  Stop(t);
  t.Rest();
  EXPECT_FALSE(t.machine().emergency.stop);
  for (const char* name : {"a", "b"}) EXPECT_EQ(t.CoreOf(name).report.emergency_stop, kNone);
}

// The exhaustive search found it, with a stop, a crash and a killed controller: the next controller
// did not know of the stop, which was over.
TEST_F(EmergencyStopped, AReleasedStopSwitchesNothingOnByTheNextController) {
  Harness& t = In("Active", Ours(2));
  Stop(t);
  t.Release();
  t.Rest();
  t.Crash("b");
  t.RestartController();
  t.Rest();
  EXPECT_EQ(t.machine().state, "Active");
  EXPECT_EQ(t.StateOf("b"), "SelfCheck");
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_EQ(t.StateOf("b"), "Active");
  EXPECT_FALSE(t.disk().stops.awaits_request);
  t.Crash("b");
  t.RestartController();
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Active") << "the stop is over";
}

TEST_F(EmergencyStopped, AReleasedStopKeepsAMachineDownThatIsTakenOverInItsStart) {
  Harness& t = In("Active", Ours(1));
  Stop(t);
  t.Crash("a");
  t.Rest();
  t.Release();
  t.Rest();
  t.RestartController();  // by a person, who takes over a running actuator
  t.Rest();
  EXPECT_EQ(t.StateOf("a"), "SelfCheck") << "no request for Active since the stop";
  EXPECT_THAT(t.log(), Not(Contains("a:Active")));
  EXPECT_TRUE(t.Set("SelfCheck").done());
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_EQ(t.StateOf("a"), "Active");
}

// A power cut. On one host the machine went to Active by itself at boot; one of several hosts did
// not even when a person started it.
TEST_F(EmergencyStopped, AReleasedStopLeavesAMachineInSetUpAtBootUntilAPersonStartsIt) {
  for (const bool several_hosts : {false, true}) {
    SCOPED_TRACE(several_hosts ? "of several hosts" : "of one host");
    Harness t(several_hosts ? MachineOf(2) : Ours(2));
    t.disk().stops = {{}, {kStop}, true};
    if (several_hosts) t.disk().remote = {{"b", "another host"}};
    t.supervised = true;
    t.Begin();
    t.Rest();
    EXPECT_EQ(t.machine().state, "SetUp");
    EXPECT_FALSE(t.usable());
    EXPECT_THAT(t.start_up()->message, HasSubstr("no state was requested since the last"));
    EXPECT_TRUE(t.disk().stops.awaits_request);
    Harness by_person(several_hosts ? MachineOf(2) : Ours(2));
    by_person.disk() = t.disk();
    by_person.Begin();
    by_person.Rest();
    EXPECT_EQ(by_person.machine().state, "Active");
    for (const char* name : {"a", "b"}) EXPECT_EQ(by_person.StateOf(name), "Active");
    EXPECT_FALSE(by_person.disk().stops.awaits_request) << "the next boot starts it";
  }
}

// `musher up --takeover` of the robot that waits: the actuators run, and nothing begins.
TEST_F(EmergencyStopped, ATakeoverOfAMachineThatWaitsInSetUpRequestsNothing) {
  Harness t(Ours(2));
  t.disk().stops = {{}, {kStop}, true};
  t.supervised = true;
  t.Begin();
  t.Rest();
  ASSERT_EQ(t.machine().state, "SetUp");
  t.supervised = false;
  t.RestartController();
  t.Rest();
  EXPECT_EQ(t.machine().state, "SetUp");
  EXPECT_THAT(t.log(), Not(Contains("a:SelfCheck")));
  EXPECT_TRUE(t.disk().stops.awaits_request);
  EXPECT_TRUE(t.Set("SelfCheck").done());
  EXPECT_TRUE(t.Set("Active").done());
}

// nav2's manager activates at boot by itself.
TEST_F(EmergencyStopped, AReleasedStopIsNotEndedByAManagerAtBoot) {
  MachineConfig config = Ours(2);
  config.ros2.started_by_manager = true;
  const Requester manager{"/lifecycle_manager", true};
  Harness t(config);
  t.disk().stops = {{}, {kStop}, true};
  t.supervised = true;
  t.Begin();
  t.Rest();
  EXPECT_TRUE(t.Set("SelfCheck", std::nullopt, manager).done());
  EXPECT_THAT(t.Set("Active", std::nullopt, manager).reason,
              HasSubstr("no state was requested since the last emergency stop"));
  EXPECT_THAT(t.log(), Not(Contains("a:Active")));
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_TRUE(t.Set("DeActive", std::nullopt, manager).done());
  EXPECT_TRUE(t.Set("Active", std::nullopt, manager).done()) << "a person's request was last";
}

// [ros2] activate = "Protected": the state that the machine was stopped in.
TEST_F(EmergencyStopped, AManagerMayNotSetThePresentStateOfAMachineThatWaits) {
  Harness& t = In("Protected", Ours(2));
  Stop(t);
  t.Release();
  t.Rest();
  t.RestartController();
  t.Rest();
  ASSERT_EQ(t.machine().state, "Protected");
  t.ClearLog();
  EXPECT_THAT(t.Set("Protected", std::nullopt, {"/lifecycle_manager", true}),
              IsRefused(Refusal::kStopAwaitsPerson));
  EXPECT_THAT(t.log(), IsEmpty());
  EXPECT_TRUE(t.disk().stops.awaits_request);
  EXPECT_TRUE(t.Set("Protected").done());
  EXPECT_FALSE(t.disk().stops.awaits_request);
}

TEST_F(EmergencyStopped, AFolderThatMayNotBeReadIsNotAnsweredByAManagerThatLearnsOfTheFolder) {
  MachineConfig config = Ours(2);
  config.ros2.started_by_manager = true;
  const Requester manager{"/lifecycle_manager", true};
  Harness t(config);
  t.disk().stops.unread = {{"/var/lib/musher/robot", "root", 7, false}};
  t.Begin();
  t.Rest();
  EXPECT_THAT(t.start_up()->message,
              HasSubstr("an emergency stop may be engaged in /var/lib/musher/robot: "));
  EXPECT_TRUE(t.Set("SelfCheck", std::nullopt, manager).done());
  const SwitchResult refused = t.Set("Active", std::nullopt, manager);
  EXPECT_THAT(refused, IsRefused(Refusal::kStopsUnread));
  EXPECT_THAT(refused.reason, HasSubstr("/var/lib/musher/robot: this user may not read it, user "
                                        "root may; a manager cannot decide that"));
  EXPECT_THAT(t.log(), Not(Contains("a:Active")));
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_TRUE(t.disk().stops.unread.at(0).answered);
}

// Under systemd the robot was stopped, and a person who may not read its files there started it by
// hand: it went to Active.
TEST_F(EmergencyStopped, AFolderThatMayNotBeReadLeavesTheMachineInSetUpUntilAPersonSetsAState) {
  for (const bool supervised : {false, true}) {
    SCOPED_TRACE(supervised ? "started by a supervisor" : "started by a person");
    Harness t(Ours(2));
    t.disk().stops.unread = {{"/var/lib/musher/robot", "root", 7, false}, {"/old", "", 8, true}};
    t.supervised = supervised;
    t.Begin();
    t.Rest();
    EXPECT_EQ(t.machine().state, "SetUp");
    EXPECT_FALSE(t.usable());
    EXPECT_THAT(
        t.start_up()->message,
        HasSubstr("an emergency stop may be engaged in /var/lib/musher/robot: this user may "
                  "not read it, user root may; check the robot, then run `musher set "
                  "SelfCheck` and `musher set Active`"));
    t.RestartController();
    t.Rest();
    EXPECT_EQ(t.machine().state, "SetUp") << "a second start is no answer either";
    EXPECT_TRUE(t.Set("SelfCheck").done());
    EXPECT_TRUE(t.Set("Active").done());
    EXPECT_TRUE(t.disk().stops.unread.at(0).answered);
    Harness next(Ours(2));
    next.disk().stops = t.disk().stops;
    next.supervised = supervised;
    next.Begin();
    next.Rest();
    EXPECT_EQ(next.machine().state, "Active") << "it is answered";
  }
}

// Its controller was of another host, whose disk has the stop. Only what the stop holds reports it.
TEST_F(EmergencyStopped, AReleasedStopThatThisDiskDoesNotKnowSwitchesNothingOnEither) {
  Harness& t = In("Active", Ours(2));
  Stop(t);
  t.Release();
  t.Rest();
  t.Crash("b");
  t.disk().stops = {};
  t.RestartController();
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "SelfCheck");
  EXPECT_TRUE(t.disk().stops.awaits_request);
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_EQ(t.StateOf("b"), "Active");
  t.Crash("b");
  t.RestartController();
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Active") << "the stop is over";
}

TEST_F(EmergencyStopped, AllStopsThatAreEngagedSurviveAController) {
  Harness& t = In("Active", Ours(2));
  Stop(t);
  t.StopAll(kStop + 1, "a panel");
  t.RunFor(Milliseconds(1));
  t.RestartController();
  t.Rest();
  EXPECT_EQ(t.disk().stops.engaged.size(), 2U);
  EXPECT_TRUE(t.Released());
  t.Rest();
  for (const char* name : {"a", "b"}) EXPECT_EQ(t.CoreOf(name).report.emergency_stop, kNone);
}

// A controller neither publishes nor saves what it receives before it leads.
TEST(EmergencyStopBeforeBegin, IsKeptAndPublishedOnceTheControllerLeads) {
  const MachineConfig config = MachineOf(1);
  Machine machine = MakeMachine(config);
  EXPECT_TRUE(Step(config, machine, event::EmergencyStopSeen{{7, "a panel", ""}}, Time()).empty());
  const StoredStops stored{{{8, "a panel", "released by the controller before"}}, {}};
  event::Begin begin;
  begin.running = {false};
  begin.stops = Merge(stored, {{{7, "a panel", ""}}, {8}});
  const auto actions = Step(config, machine, begin, Time());
  EXPECT_EQ(std::count_if(actions.begin(), actions.end(),
                          [](const Action& action) {
                            return std::holds_alternative<action::PublishEmergencyStop>(action);
                          }),
            2);
  EXPECT_EQ(machine.emergency.stop, (EmergencyStop{7, "a panel", ""}));
  EXPECT_TRUE(machine.emergency.others.empty()) << "8 is over";
}

TEST_F(EmergencyStopped, SurvivesAControllerByItsDisk) {
  Harness& t = In("Active", Ours(2));
  Stop(t);
  t.RestartController();
  t.Rest();
  ASSERT_TRUE(t.machine().emergency.stop);
  EXPECT_EQ(t.machine().emergency.stop->id, kStop);
  EXPECT_EQ(t.machine().emergency.stop->by, "the test");
  EXPECT_EQ(t.machine().state, "Active") << "adopted as it was";
  EXPECT_TRUE(t.Released());
  t.Rest();
  EXPECT_EQ(t.CoreOf("a").report.emergency_stop, kNone);
}

TEST_F(EmergencyStopped, SurvivesAControllerByItsActuators) {
  Harness& t = In("Active", Ours(2));
  Stop(t);
  t.disk().stops = {};
  t.RestartController(/*lost_disk=*/true);
  t.Rest();
  ASSERT_TRUE(t.machine().emergency.stop);
  EXPECT_EQ(t.machine().emergency.stop->id, kStop);
  EXPECT_FALSE(t.disk().stops.engaged.empty());
}

TEST_F(EmergencyStopped, EngagedWithoutAControllerIsFoundByTheNext) {
  Harness& t = In("Active", Ours(2));
  for (const char* name : {"a", "b"}) {
    t.Inject(name, actuator_event::EmergencyStopReceived{kStop, true, 0});
  }
  t.RestartController();
  t.Rest();
  EXPECT_TRUE(t.machine().emergency.stop);
}

}  // namespace musher::testing::emergency_stop_test
