// An actuator latches an emergency stop itself.

#include <gmock/gmock.h>

#include "musher/test/lifecycle/one_actuator.hpp"

namespace musher::actuator_stop_test {

using namespace actuator_action;  // NOLINT(google-build-using-namespace)
using actuator_event::CallbackEnded;
using actuator_event::EmergencyStopReceived;
using actuator_event::QueryArrived;
using ::testing::_;
using testing::Actions;
using ::testing::Contains;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::VariantWith;

constexpr StopId kStop = 5;
const auto kRuns = Contains(VariantWith<RunEmergencyStop>(RunEmergencyStop{}));
const auto kRequestsStop = Contains(VariantWith<RequestStop>(RequestStop{}));

class Stopped : public testing::OneActuator {
 protected:
  Stopped() {
    SetUpIt();
    Switch(1, "DeActive");
  }
  Actions Engage(StopId id = kStop) { return Do(EmergencyStopReceived{id, true, 999}); }
  Actions Release(StopId id = kStop, Sender sender = 1, CommandNumber last_command = 0) {
    return Do(EmergencyStopReceived{id, false, sender, "", "", last_command});
  }
};

TEST_F(Stopped, StopsAtOnceWhicheverParticipantEngagesAndReports) {
  const Actions actions = Engage();
  EXPECT_THAT(actions, kRuns);
  EXPECT_THAT(actions, Contains(VariantWith<PublishStatus>(PublishStatus{})));
  EXPECT_EQ(core_.report.emergency_stop, kStop);
  EXPECT_EQ(core_.report.state, "DeActive");
}

// A controller that starts after the stop has no other source for its reason.
TEST_F(Stopped, ReportsTheSourceAndTheReasonOfTheOldestStop) {
  Do(EmergencyStopReceived{kStop, true, 999, "alice", "smoke"});
  Do(EmergencyStopReceived{kStop + 1, true, 999, "bob", "fire"});
  EXPECT_EQ(core_.report.emergency_stop_by, "alice");
  EXPECT_EQ(core_.report.emergency_stop_reason, "smoke");
  Release();
  EXPECT_EQ(core_.report.emergency_stop_by, "bob");
  Release(kStop + 1);
  EXPECT_EQ(core_.report.emergency_stop_reason, "");
}

TEST_F(Stopped, ByAStopWithAReasonOfAMegabyteReportsNoReason) {
  Do(EmergencyStopReceived{kStop, true, 999, "alice", std::string(1 << 20, 'a')});
  EXPECT_EQ(core_.report.emergency_stop, kStop);
  EXPECT_EQ(core_.report.emergency_stop_reason, "");
}

TEST_F(Stopped, RunsOnceForEach) {
  Engage();
  EXPECT_THAT(Engage(), IsEmpty());
  EXPECT_THAT(Engage(kStop + 1), kRuns) << "a person presses again because something still moves";
}

TEST_F(Stopped, ReleasingTheFirstOfTwoStopsDoesNotOpenTheActuator) {
  Engage();
  Engage(kStop + 1);
  Release();
  EXPECT_EQ(core_.report.emergency_stop, kStop + 1);
  EXPECT_EQ(AnswerIn(Do(Command(2, "Active"))).code, kCodeProtectedError);
  Release(kStop + 1);
  EXPECT_EQ(core_.report.emergency_stop, StopId(0));
  Switch(3, "Active");
}

// A link that holds a command back, or repeats it, delivers it when the stop is over.
TEST_F(Stopped, ACommandFromBeforeTheReleaseSwitchesNothingOnAfterIt) {
  Engage();
  Release(kStop, 1, 3);
  EXPECT_EQ(AnswerIn(Do(Command(3, "Active"))).code, kCodeProtectedError);
  EXPECT_EQ(core_.report.state, "DeActive");
  Switch(4, "Active");
}

TEST_F(Stopped, ACommandFromBeforeAReleaseWhoseStopItNeverReceivedSwitchesNothingOn) {
  Release(kStop, 1, 3);
  EXPECT_EQ(AnswerIn(Do(Command(3, "Active"))).code, kCodeProtectedError);
  Switch(4, "Active");
}

// The command came first, and ran on after the release: the machine was stopped meanwhile.
TEST_F(Stopped, ACallbackFromBeforeAReleaseWhoseStopItNeverReceivedEndsAsUnderTheStop) {
  Do(Command(3, "Active"));
  const Actions actions = Release(kStop, 1, 3);
  EXPECT_THAT(actions, kRuns);
  EXPECT_THAT(actions, kRequestsStop);
  EXPECT_EQ(AnswerIn(Do(CallbackEnded{})).code, kCodeProtectedError);
  EXPECT_EQ(core_.report.state, "DeActive");
  EXPECT_TRUE(core_.report.held_by_stop);
  Switch(4, "Active");
  EXPECT_FALSE(core_.report.held_by_stop);
}

TEST_F(Stopped, ACallbackThatARequestAfterTheReleaseHasBegunRunsOnWhenTheReleaseIsRepeated) {
  Engage();
  Release(kStop, 1, 2);
  Do(Command(3, "Active"));
  EXPECT_THAT(Release(kStop, 1, 2), Not(kRequestsStop));
  Do(CallbackEnded{});
  EXPECT_EQ(core_.report.state, "Active");
}

TEST_F(Stopped, ACommandFromBeforeTheReleaseThatLeadsDownIsObeyed) {
  Engage();
  Release(kStop, 1, 3);
  Switch(2, "LowPower");
  Switch(3, "TearDown");
}

TEST_F(Stopped, ARepeatedReleaseAndAnOlderOneChangeNothing) {
  Engage();
  Release(kStop, 1, 3);
  Release(kStop, 1, 3);
  Release(kStop, 1, 0);
  EXPECT_EQ(AnswerIn(Do(Command(3, "Active"))).code, kCodeProtectedError);
  Switch(4, "Active");
}

// The numbers of another controller may be lower: they follow on those that this actuator reports.
TEST_F(Stopped, WhatAReleaseNamesEndsWithTheControlOfItsController) {
  Engage();
  Release(kStop, 1, 90);
  Announce(2);
  EXPECT_THAT(Do(Command(2, "Active", 2)), Contains(VariantWith<RunCallback>(_)));
}

TEST_F(Stopped, ReportsEveryStopThatItHasLatched) {
  Engage();
  Engage(kStop + 1);
  Engage(kStop + 2);
  EXPECT_EQ(core_.report.emergency_stop, kStop);
  EXPECT_EQ(core_.report.other_stops, (std::vector<StopId>{kStop + 1, kStop + 2}));
  Release();
  EXPECT_EQ(core_.report.emergency_stop, kStop + 1);
  EXPECT_EQ(core_.report.other_stops, std::vector<StopId>{kStop + 2});
}

TEST_F(Stopped, ReleasingTheSecondOfTwoStopsLeavesTheFirst) {
  Engage();
  Engage(kStop + 1);
  Release(kStop + 1);
  EXPECT_EQ(core_.report.emergency_stop, kStop);
  EXPECT_THAT(Engage(kStop + 1), IsEmpty()) << "it is over";
}

// `ros2 topic pub` sends 0 where a person gives no id.
TEST_F(Stopped, AStopWithoutAnIdStopsAndHasTheIdOfItsSender) {
  EXPECT_THAT(Engage(0), kRuns);
  EXPECT_EQ(core_.report.emergency_stop, StopId(999));
  Release(999);
  EXPECT_EQ(core_.report.emergency_stop, StopId(0));
}

TEST_F(Stopped, AStopWithoutAnIdAndWithoutASenderStops) {
  EXPECT_THAT(Do(EmergencyStopReceived{0, true, 0}), kRuns);
  EXPECT_NE(core_.report.emergency_stop, StopId(0));
}

TEST_F(Stopped, EveryStopRunsTheStopActionHoweverManyAreEngaged) {
  for (StopId id = 1; id <= 5000; ++id) ASSERT_THAT(Engage(id), kRuns) << id.value();
  EXPECT_NE(core_.report.emergency_stop, StopId(0));
}

TEST_F(Stopped, AReleasedStopNeverStopsItAgainAndAnotherDoes) {
  Engage();
  Release();
  EXPECT_EQ(core_.report.emergency_stop, StopId(0));
  EXPECT_THAT(Engage(), IsEmpty());
  EXPECT_THAT(Engage(kStop + 1), kRuns);
}

// A link that repeats or reorders samples delivers the controller's own "engaged" behind its
// release, which the actuator may have confirmed by then.
TEST_F(Stopped, AnOlderSampleOfTheControllerThatHasReleasedAStopDoesNotStopItAgain) {
  Do(EmergencyStopReceived{kStop, true, SenderOf(1)});
  Release();
  EXPECT_THAT(Do(EmergencyStopReceived{kStop, true, SenderOf(1)}), IsEmpty());
  EXPECT_EQ(core_.report.emergency_stop, StopId(0));
}

// It leads another host, and does not know of the release.
TEST_F(Stopped, AReleasedStopThatTheNextControllerHasEngagedStopsItAgain) {
  Engage();
  Release();
  Announce(2);
  Do(Command(2, "DeActive", 2));
  EXPECT_THAT(Do(EmergencyStopReceived{kStop, true, SenderOf(2)}), kRuns);
  EXPECT_EQ(core_.report.emergency_stop, kStop);
}

TEST_F(Stopped, AReleaseThatOvertakesItsStopCounts) {
  Release();
  EXPECT_THAT(Engage(), IsEmpty());
}

TEST_F(Stopped, OnlyItsControllerReleases) {
  Engage();
  EXPECT_THAT(Release(kStop, 999), IsEmpty());
  EXPECT_EQ(core_.report.emergency_stop, kStop);
  Release(kStop + 1);  // and this one only
  EXPECT_EQ(core_.report.released_stop, kStop + 1);
  EXPECT_EQ(core_.report.emergency_stop, kStop);
  Release();
  EXPECT_EQ(core_.report.emergency_stop, StopId(0));
}

TEST_F(Stopped, NoParticipantReleasesAnActuatorWithoutAController) {
  core_.controller = 0;
  Engage();
  Release(kStop, 0);
  EXPECT_EQ(core_.report.emergency_stop, kStop);
}

TEST_F(Stopped, RefusesToGoUpAndGoesDown) {
  Engage();
  EXPECT_EQ(AnswerIn(Do(Command(2, "Active"))).code, kCodeProtectedError);
  Switch(3, "LowPower");
  EXPECT_EQ(AnswerIn(Do(Command(4, "DeActive"))).code, kCodeProtectedError);
  EXPECT_THAT(Do(Command(5, "SelfCheck")),
              Contains(VariantWith<RunCallback>(RunCallback{"SelfCheck"})));
  Do(CallbackEnded{});
  EXPECT_THAT(Do(Command(6, "TearDown")),
              Contains(VariantWith<RunCallback>(RunCallback{"TearDown"})));
}

TEST_F(Stopped, GoesUpAgainOnceItIsReleased) {
  Engage();
  Do(Command(2, "Active"));
  Release();
  EXPECT_EQ(core_.report.state, "DeActive") << "a release changes no state";
  Switch(3, "Active");
}

TEST_F(Stopped, AnUpwardCallbackIsRequestedToStop) {
  Do(Command(2, "Active"));
  const Actions actions = Engage();
  EXPECT_THAT(actions, kRuns);
  EXPECT_THAT(actions, kRequestsStop);
}

// Its callback has switched the motors on after the stop action had switched them off.
TEST_F(Stopped, AnUpwardCallbackThatSucceedsHasFailedAndTheStopActionRunsAgain) {
  Do(Command(2, "Active"));
  Engage();
  const Actions actions = Do(CallbackEnded{});
  EXPECT_THAT(actions, kRuns);
  EXPECT_EQ(AnswerIn(actions).verdict, Verdict::kFailed);
  EXPECT_EQ(AnswerIn(actions).code, kCodeProtectedError);
  EXPECT_EQ(core_.report.state, "DeActive");
  EXPECT_EQ(core_.report.outcome_code, kCodeProtectedError);
  EXPECT_THAT(Do(Command(3, "DeActive")),
              Contains(VariantWith<RunCallback>(RunCallback{"DeActive"})))
      << "it may be half way up, so the way back runs its callback";
}

TEST_F(Stopped, AnUpwardCallbackHasFailedThoughTheStopIsReleasedBeforeItEnds) {
  Do(Command(2, "Active"));
  Engage();
  Release();
  const Actions actions = Do(CallbackEnded{});
  EXPECT_THAT(actions, kRuns);
  EXPECT_EQ(AnswerIn(actions).code, kCodeProtectedError);
  EXPECT_EQ(core_.report.state, "DeActive");
}

TEST_F(Stopped, AnUpwardCallbackThatFailsUnderAStopIsStoppedAgainAndKeepsItsReason) {
  Do(Command(2, "Active"));
  Engage();
  const Actions actions = Do(CallbackEnded{2012, "no lidar"});
  EXPECT_THAT(actions, kRuns);
  EXPECT_EQ(AnswerIn(actions).code, 2012);
}

TEST_F(Stopped, ASelfCheckDuringWhichAStopCameIsStoppedAgain) {
  Do(Command(2, "SelfCheck"));
  Engage();
  const Actions actions = Do(CallbackEnded{});
  EXPECT_THAT(actions, kRuns) << "a check may move";
  EXPECT_EQ(AnswerIn(actions).verdict, Verdict::kDone);
}

TEST_F(Stopped, TheStopActionDoesNotRunAgainAfterACallbackThatBeganUnderTheStop) {
  Engage();
  Do(Command(2, "LowPower"));
  EXPECT_THAT(Do(CallbackEnded{}), Not(kRuns));
}

TEST_F(Stopped, ADownwardCallbackRunsOn) {
  Do(Command(2, "LowPower"));
  const Actions actions = Engage();
  EXPECT_THAT(actions, kRuns);
  EXPECT_THAT(actions, Not(kRequestsStop));
  Do(CallbackEnded{});
  EXPECT_EQ(core_.report.state, "LowPower");
}

TEST_F(Stopped, ACallbackThatMaySwitchOnAfterTheStopActionIsNamedUntilItHasEnded) {
  Do(Command(2, "Active"));
  EXPECT_EQ(StillSwitchingOn(config_, core_), "") << "no stop";
  Engage();
  EXPECT_EQ(StillSwitchingOn(config_, core_), "Active");
  Engage(kStop + 1);
  EXPECT_EQ(StillSwitchingOn(config_, core_), "Active");
  EXPECT_THAT(Do(CallbackEnded{}), kRuns);
  EXPECT_EQ(StillSwitchingOn(config_, core_), "");
}

TEST_F(Stopped, TheCallbackOfThePresentStateThatSwitchesOnAgainIsNamed) {
  Switch(2, "Active");
  Engage();
  Release();
  Do(Command(3, "Active"));
  EXPECT_EQ(StillSwitchingOn(config_, core_), "");
  Engage(kStop + 1);
  EXPECT_EQ(StillSwitchingOn(config_, core_), "Active");
}

TEST_F(Stopped, ACallbackThatMayAlsoBeginDuringAStopIsNotNamed) {
  CommandNumber number = 1;
  StopId stop = kStop;
  for (const State& state : std::vector<State>{"SelfCheck", "LowPower", "TearDown"}) {
    number = number + 1;
    Do(Command(number, state));
    ASSERT_EQ(core_.report.target, state);
    stop = stop + 1;
    EXPECT_THAT(Engage(stop), kRuns);
    EXPECT_EQ(StillSwitchingOn(config_, core_), "") << state;
    Do(CallbackEnded{});
  }
}

TEST_F(Stopped, AWaitingCommandUpwardIsRefusedAtOnce) {
  Do(Command(2, "LowPower"));
  Do(Command(3, "Active"));
  EXPECT_EQ(AnswerIn(Engage()).code, kCodeProtectedError);
  EXPECT_THAT(Do(CallbackEnded{}), Not(Contains(VariantWith<RunCallback>(RunCallback{"Active"}))));
}

TEST_F(Stopped, AWaitingCommandThatHasBecomeUpwardMeanwhileIsRefusedToo) {
  Do(Command(2, "LowPower"));
  Do(Command(3, "DeActive"));  // the state at the time of the stop
  Engage();
  EXPECT_EQ(AnswerIn(Do(CallbackEnded{})).verdict, Verdict::kDone);
  EXPECT_EQ(core_.report.state, "LowPower");
  EXPECT_FALSE(core_.report.busy());
}

// It led down when it came; the callback before it leads further down.
TEST_F(Stopped, AWaitingCommandThatHasBecomeUpwardIsRefusedAlsoAfterTheRelease) {
  for (const bool stopped_first : {false, true}) {
    SCOPED_TRACE(stopped_first ? "it came under the stop" : "the stop came while it waited");
    core_ = ActuatorCore{};
    core_.report.incarnation = 77;
    Announce(1);
    SetUpIt();
    Switch(1, "Active");
    Do(Command(2, "LowPower"));
    if (stopped_first) Engage();
    Do(Command(3, "DeActive"));
    if (!stopped_first) Engage();
    Release();
    const Actions actions = Do(CallbackEnded{});
    EXPECT_EQ(AnswersIn(actions).back().code, kCodeProtectedError);
    EXPECT_EQ(core_.report.state, "LowPower");
    EXPECT_FALSE(core_.report.busy());
    Switch(4, "DeActive");
  }
}

TEST_F(Stopped, ACommandThatCameAfterTheReleaseBeginsAfterTheCallbackBeforeIt) {
  Do(Command(2, "LowPower"));
  Engage();
  Release();
  Do(Command(3, "Active"));
  Do(CallbackEnded{});
  EXPECT_EQ(core_.report.target, "Active");
}

// Its callback would, for example, switch on the motors that the failed one has switched off.
TEST_F(Stopped, AFailedDownwardCallbackIsNotUndone) {
  Do(Command(2, "LowPower"));
  Do(CallbackEnded{kCodeFailed, ""});
  Engage();
  const Actions actions = Do(Command(3, "DeActive"));
  EXPECT_EQ(AnswerIn(actions).code, kCodeProtectedError);
  EXPECT_THAT(actions, Not(Contains(VariantWith<RunCallback>(RunCallback{"DeActive"}))));
  Switch(4, "LowPower");
  EXPECT_FALSE(core_.half_way_down);
}

TEST_F(Stopped, ACallbackThatUndoesAFailedDownwardOneIsRequestedToStop) {
  Do(Command(2, "LowPower"));
  Do(CallbackEnded{kCodeFailed, ""});
  Do(Command(3, "DeActive"));
  EXPECT_THAT(Engage(), kRequestsStop);
}

TEST_F(Stopped, AFailedUpwardCallbackIsUndone) {
  Do(Command(2, "Active"));
  Do(CallbackEnded{kCodeFailed, ""});
  Engage();
  EXPECT_THAT(Do(Command(3, "DeActive")),
              Contains(VariantWith<RunCallback>(RunCallback{"DeActive"})));
}

TEST_F(Stopped, AFailedUpwardCallbackIsUndoneAlsoAfterAFirstAttemptHasFailed) {
  Do(Command(2, "Active"));
  Do(CallbackEnded{kCodeFailed, ""});
  Do(Command(3, "DeActive"));
  Do(CallbackEnded{kCodeFailed, ""});
  Engage();
  EXPECT_THAT(Do(Command(4, "DeActive")),
              Contains(VariantWith<RunCallback>(RunCallback{"DeActive"})));
}

TEST_F(Stopped, AFailedDownwardCallbackIsNotUndoneAlsoAfterAFirstAttemptHasFailed) {
  Do(Command(2, "LowPower"));
  Do(CallbackEnded{kCodeFailed, ""});
  Do(Command(3, "DeActive"));
  Do(CallbackEnded{kCodeFailed, ""});
  Engage();
  const Actions actions = Do(Command(4, "DeActive"));
  EXPECT_EQ(AnswerIn(actions).code, kCodeProtectedError);
  EXPECT_THAT(actions, Not(Contains(VariantWith<RunCallback>(_))));
}

TEST_F(Stopped, AQueryIsAnsweredAsUsual) {
  Engage();
  EXPECT_EQ(AnswerIn(Do(QueryArrived{9, {1, 1, false}, 1})).verdict, Verdict::kDone);
}

// What a released stop has switched off

TEST_F(Stopped, AnActuatorInActiveIsHeldByTheStopUntilItsCallbackHasRun) {
  Switch(2, "Active");
  Engage();
  EXPECT_TRUE(core_.report.held_by_stop);
  Release();
  EXPECT_EQ(core_.report.state, "Active");
  EXPECT_TRUE(core_.report.held_by_stop) << "its power is off still";
  EXPECT_THAT(Do(Command(3, "Active")), Contains(VariantWith<RunCallback>(RunCallback{"Active"})));
  Do(CallbackEnded{});
  EXPECT_FALSE(core_.report.held_by_stop);
  EXPECT_THAT(Do(Command(4, "Active")), Not(Contains(VariantWith<RunCallback>(_))));
}

TEST_F(Stopped, RefusesItsOwnStateWhereItsCallbackWouldSwitchOnAgain) {
  Switch(2, "Active");
  Engage();
  const Actions actions = Do(Command(3, "Active"));
  EXPECT_EQ(AnswerIn(actions).verdict, Verdict::kRefused);
  EXPECT_EQ(AnswerIn(actions).code, kCodeProtectedError);
  EXPECT_THAT(actions, Not(Contains(VariantWith<RunCallback>(_))));
}

TEST_F(Stopped, RefusesAnotherStateOfItsRankThatWouldSwitchOnAgain) {
  for (const auto& [state, like] :
       {std::pair(State("Dancing"), kActive), std::pair(State("Sitting"), kLowPower)}) {
    config_.actuators[0].states.push_back(state);
    config_.ranks[state] = *BuiltInRank(like);
  }
  Switch(2, "Active");
  Do(Command(3, "Dancing"));
  EXPECT_THAT(Engage(), kRequestsStop);
  EXPECT_EQ(AnswerIn(Do(CallbackEnded{})).code, kCodeProtectedError) << "the state is not taken";
  EXPECT_EQ(AnswerIn(Do(Command(4, "Dancing"))).code, kCodeProtectedError);
  EXPECT_EQ(AnswerIn(Do(Command(5, "Active"))).code, kCodeProtectedError);
  Switch(6, "LowPower");
  Switch(7, "Sitting");
}

TEST_F(Stopped, ACallbackThatRanUnderTheStopDoesNotEndTheHold) {
  Switch(2, "Active");
  Engage();
  Switch(3, "LowPower");
  Release();
  EXPECT_TRUE(core_.report.held_by_stop) << "it may have left off what LowPower has on";
  Switch(4, "LowPower");
  EXPECT_FALSE(core_.report.held_by_stop);
}

TEST_F(Stopped, ACallbackThatBeganUnderTheStopDoesNotEndTheHoldThoughTheStopIsReleasedMeanwhile) {
  Switch(2, "Active");
  Engage();
  Do(Command(3, "LowPower"));
  Release();
  Do(CallbackEnded{});
  EXPECT_EQ(core_.report.state, "LowPower");
  EXPECT_TRUE(core_.report.held_by_stop);
}

TEST_F(Stopped, ADownwardCallbackAfterTheReleaseDoesNotEndTheHold) {
  Switch(2, "Active");
  Engage();
  Release();
  Switch(3, "LowPower");
  EXPECT_TRUE(core_.report.held_by_stop) << "a way down switches nothing on";
  Switch(4, "DeActive");
  EXPECT_FALSE(core_.report.held_by_stop);
}

TEST_F(Stopped, ASelfCheckDoesNotEndTheHold) {
  Switch(2, "Active");
  Engage();
  Release();
  Do(Command(3, "SelfCheck"));
  Do(CallbackEnded{});
  EXPECT_TRUE(core_.report.held_by_stop);
}

TEST_F(Stopped, TheCallbackThatSwitchesOnAgainIsRequestedToStopByTheNextStopAndNotRunUnderIt) {
  Switch(2, "Active");
  Engage();
  Release();
  Do(Command(3, "Active"));
  EXPECT_THAT(Engage(kStop + 1), kRequestsStop);
  EXPECT_EQ(AnswerIn(Do(CallbackEnded{})).code, kCodeProtectedError);
  EXPECT_EQ(AnswerIn(Do(Command(4, "Active"))).code, kCodeProtectedError);
  Release(kStop + 1);
  Switch(5, "Active");
  EXPECT_FALSE(core_.report.held_by_stop);
}

TEST_F(Stopped, AManagerWithoutEpochsRunsTheCallbackOfTheStateThatIsHeld) {
  core_.report.epoch = 0;
  core_.report.state = "Active";
  Engage();
  core_.stops.clear();  // no controller has released it; the process before did
  core_.report.emergency_stop = 0;
  EXPECT_THAT(Do(actuator_event::ManagerCommand{9, "Active"}),
              Contains(VariantWith<RunCallback>(RunCallback{"Active"})));
}

TEST_F(Stopped, TheSafeStateIsReachedAnyway) {
  config_.actuators[0].controller_lost = Milliseconds(2000);
  config_.actuators[0].on_controller_lost = "LowPower";
  Engage();
  now_ += Milliseconds(2000);
  EXPECT_THAT(Do(actuator_event::TimePassed{}),
              Contains(VariantWith<RunCallback>(RunCallback{"LowPower"})));
}

TEST(StopInSetUp, IsLatchedFromTheStart) {
  MachineConfig config;
  ActuatorConfig audio;
  audio.name = "audio";
  audio.states = {"SetUp"};
  config.actuators.push_back(audio);
  ActuatorCore core;
  Step(config, 0, core, actuator_event::Started{}, Time());
  EXPECT_THAT(Step(config, 0, core, EmergencyStopReceived{kStop, true, 3}, Time()), kRuns);
  Step(config, 0, core, CallbackEnded{}, Time());
  EXPECT_EQ(core.report.emergency_stop, kStop);
}

}  // namespace musher::actuator_stop_test
