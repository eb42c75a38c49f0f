// The emergency stops that a controller receives: from its disk, from panels, from the controller
// before it.

#include <algorithm>
#include <string>

#include "musher/lifecycle/step/emergency_stops.hpp"
#include "musher/test/lifecycle/coordination/one_controller.hpp"

namespace musher::testing::received_stops_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

using ReceivedStops = OneController;

TEST_F(ReceivedStops, AReleaseByThePreviousControllerIsStored) {
  machine_ = MakeMachine(config_);
  event::Begin begin{false, 0, {false, false}, "here"};
  begin.stops.released = {8};
  Do(begin);
  ASSERT_THAT(Did<action::SaveEmergencyStops>(), SizeIs(1));
  EXPECT_THAT(Did<action::SaveEmergencyStops>()[0].stops.released, ElementsAre(StopId(8)));
}

TEST_F(ReceivedStops, AReleaseByAPanelEngagesNoStop) {
  StartUp();
  Do(event::EmergencyStopSeen{{7, "a panel", ""}, false});
  EXPECT_FALSE(machine_.emergency.stop);
  EXPECT_THAT(Did<action::PublishEmergencyStop>(), IsEmpty());
}

// With LowPower = "unconfigured" its way up is configure, then activate. It was activated seconds
// after the stop.
TEST_F(ReceivedStops, EndTheWayUpOfARos2NodeAfterTheTransitionThatRuns) {
  config_.actuators[1].protocol = Protocol::kRos2Lifecycle;
  config_.actuators[1].ros2_states = {{State(kLowPower), Ros2State::kUnconfigured}};
  StartUp();
  Do(event::SetStateRequested{1, "LowPower", {}});
  ObeyAll();
  ASSERT_EQ(machine_.state, kLowPower);
  Do(event::SetStateRequested{2, "Active", {}});
  ASSERT_TRUE(Of(1).command);
  Forget();
  Do(event::EmergencyStopSeen{{7, "a panel", "smoke"}});
  const auto queries = Did<action::SendQuery>();
  ASSERT_THAT(queries, SizeIs(1));
  EXPECT_EQ(queries[0].actuator, ActuatorIndex(1));
  EXPECT_EQ(queries[0].command.number, Of(1).command->number);
  EXPECT_TRUE(queries[0].command.stop);
}

TEST_F(ReceivedStops, OfAFloodAsManyAreMergedAsAMachineKeeps) {
  StoredStops flood;
  for (StopId id = 1; id <= 100; ++id) flood.engaged.push_back({id, "a panel", ""});
  StartUp();
  for (const EmergencyStop& stop : flood.engaged) Do(event::EmergencyStopSeen{stop});
  EXPECT_EQ(Merge({}, flood).engaged, StopsOf(machine_).engaged);
}

// A person saw the first reason only, and released the second with it.
TEST_F(ReceivedStops, OfOneSourceShowEveryReason) {
  StartUp();
  Do(event::EmergencyStopSeen{{7, "anna@bench", "smoke"}});
  Do(event::EmergencyStopSeen{{8, "anna@bench", "hand in the gripper"}});
  Do(event::EmergencyStopSeen{{9, "anna@bench", "smoke"}});
  ASSERT_TRUE(machine_.emergency.stop);
  EXPECT_EQ(machine_.emergency.stop->reason, "smoke; then: hand in the gripper");
  for (StopId id = 10; id < 100; ++id) {
    Do(event::EmergencyStopSeen{{id, "anna@bench", "reason " + std::to_string(id.value())}});
  }
  EXPECT_LE(machine_.emergency.stop->reason.size(), 512U);
  EXPECT_TRUE(machine_.emergency.stop->reason.ends_with("; then: more"));
}

// Only what a person has released is over for the next start from another state folder.
TEST_F(ReceivedStops, ThatNewerOnesHaveReplacedAreReleasedByTheNextReleaseOnly) {
  StartUp();
  Do(event::EmergencyStopSeen{{7, "a panel", "smoke"}});
  Do(event::EmergencyStopSeen{{8, "a panel", "smoke"}});
  EXPECT_THAT(StopsOf(machine_).released, ElementsAre(StopId(7)));
  EXPECT_THAT(StopsOf(machine_).replaced, ElementsAre(StopId(7)));
  Do(event::ReleaseRequested{1, "alice", {8}});
  EXPECT_THAT(StopsOf(machine_).released, ElementsAre(StopId(7), StopId(8)));
  EXPECT_THAT(StopsOf(machine_).replaced, IsEmpty());
}

TEST_F(ReceivedStops, ThatOneSideHasReleasedAreNotOnlyReplaced) {
  const StoredStops replaced{{{8, "a panel", ""}}, {7}, true, {}, {7}};
  EXPECT_THAT(Merge(replaced, {}).replaced, ElementsAre(StopId(7)));
  EXPECT_THAT(Merge(replaced, {{}, {7}}).replaced, IsEmpty());
  EXPECT_THAT(Merge({{}, {7}}, replaced).replaced, IsEmpty());
  EXPECT_THAT(Merge(replaced, replaced).replaced, ElementsAre(StopId(7)));
}

// A start that finds it engaged engages it again.
TEST_F(ReceivedStops, EachStartThatEngagesOneIsCountedWithItsFolder) {
  StartUp();
  Do(event::EmergencyStopSeen{{7, "a panel", "smoke"}});
  Do(event::EmergencyStopSeen{{7, "a panel", "smoke"}});
  StoredStops stored = StopsOf(machine_);
  EXPECT_EQ(stored.engagements, 1U);
  machine_ = MakeMachine(config_);
  event::Begin begin{false, 0, {false, false}, "here"};
  begin.stops = Merge(stored, {});
  Do(begin);
  EXPECT_EQ(StopsOf(machine_).engagements, 2U);
  Do(event::ReleaseRequested{1, "alice", {7}});
  EXPECT_EQ(StopsOf(machine_).engagements, 2U);
}

// Its panel still published it, and a start with the other folder engaged it again: the robot was
// reported as stopped. The next start with this folder went to Active.
TEST_F(ReceivedStops, ThatAreEngagedAgainInAnotherFolderAfterTheirReleaseWaitForOneRequestHere) {
  StoredStops elsewhere{{{7, "a panel", "smoke"}}, {}, true};
  elsewhere.engagements = 1;
  StoredStops own = Merge({}, StopsThatHold({}, elsewhere, 0));
  EXPECT_EQ(own.engaged, elsewhere.engaged);
  own.engaged.clear();  // it was released, and a state was requested
  AddReleased(own, 7);
  own.awaits_request = false;
  EXPECT_FALSE(StopsThatHold(own, elsewhere, 0).awaits_request);

  ++elsewhere.engagements;
  own = Merge(own, StopsThatHold(own, elsewhere, 0));
  EXPECT_THAT(own.engaged, IsEmpty()) << "it was released once";
  EXPECT_TRUE(own.awaits_request);
  own.awaits_request = false;
  EXPECT_FALSE(StopsThatHold(own, elsewhere, 0).awaits_request);
  EXPECT_TRUE(StopsThatHold({{}, {7}}, elsewhere, 0).awaits_request) << "only its release is known";
}

// As `ros2 topic pub` and a plain C client send them. The second one replaced the first one, which
// was over for all that learned of it then.
TEST_F(ReceivedStops, OfUnnamedSourcesReplaceNoneOfAnother) {
  StartUp();
  Do(event::EmergencyStopSeen{{7, "", "door open"}});
  Do(event::EmergencyStopSeen{{8, "", ""}});
  EXPECT_THAT(StopsOf(machine_).engaged,
              ElementsAre(EmergencyStop{7, "", "door open"}, EmergencyStop{8, "", ""}));
  EXPECT_THAT(machine_.emergency.released, IsEmpty());
  Do(event::ReleaseRequested{1, "alice", {7}});
  EXPECT_TRUE(machine_.emergency.stop) << "8 was not shown";
  Do(event::ReleaseRequested{2, "alice", {8}});
  EXPECT_TRUE(machine_.emergency.stop) << "7 was not shown";
  Do(event::ReleaseRequested{3, "alice", {7, 8}});
  EXPECT_FALSE(machine_.emergency.stop);
}

// An actuator reports the ids alone. The sample of the first one was dropped as that of a stop
// which is over.
TEST_F(ReceivedStops, ThatAnActuatorHadLatchedGetTheirSourcesWhenTheirSamplesArrive) {
  StartUp();
  ActuatorReport report = Of(0).report;
  report.emergency_stop = 7;
  report.other_stops = {8, 9};
  report.stamp += Milliseconds(1);
  Say(0, report);
  for (StopId id = 7; id < 10; ++id) {
    Do(event::EmergencyStopSeen{{id, "panel " + ToString(id), "smoke"}});
  }
  EXPECT_THAT(StopsOf(machine_).engaged, ElementsAre(EmergencyStop{7, "panel 7", "smoke"},
                                                     EmergencyStop{8, "panel 8", "smoke"},
                                                     EmergencyStop{9, "panel 9", "smoke"}));
}

// Found by simulation: the list was filled by one panel, and its newest stop fell out of it.
TEST_F(ReceivedStops, ThatAnActuatorHadLatchedReplaceThoseOfTheirSourceWhenTheirSamplesArrive) {
  StartUp();
  for (StopId id = 7; id < 17; ++id) {
    ActuatorReport report = Of(0).report;
    report.emergency_stop = id;
    report.stamp += Milliseconds(1);
    Say(0, report);
    Do(event::EmergencyStopSeen{{id, "a panel", "smoke"}});
    EXPECT_THAT(StopsOf(machine_).engaged, ElementsAre(EmergencyStop{id, "a panel", "smoke"}));
  }
}

TEST_F(ReceivedStops, OfAFloodWithoutASourceReplaceNoStopThatHasOne) {
  StartUp();
  Do(event::EmergencyStopSeen{{1000, "the door", "open"}});
  for (StopId id = 1; id <= 100; ++id) Do(event::EmergencyStopSeen{{id, "", "smoke"}});
  const StoredStops stops = StopsOf(machine_);
  EXPECT_EQ(stops.engaged.size(), 65U);
  EXPECT_EQ(stops.engaged.front(), (EmergencyStop{1000, "the door", "open"}));
  EXPECT_EQ(std::ranges::count(stops.engaged, StopId(100), &EmergencyStop::id), 1);
  Do(event::EmergencyStopSeen{{2000, "the gate", "open"}});
  EXPECT_EQ(StopsOf(machine_).engaged.back(), (EmergencyStop{2000, "the gate", "open"}));
  EXPECT_EQ(StopsOf(machine_).engaged.front().id, StopId(1000));
}

TEST_F(ReceivedStops, AreSavedOnceTheLastSaveHasEndedAndNotAnEarlierOne) {
  StartUp();
  Do(event::EmergencyStopSeen{{7, "a panel", ""}});
  const SaveNumber first = machine_.saves.last;
  Do(event::EmergencyStopSeen{{8, "another panel", ""}});
  const SaveNumber second = machine_.saves.last;
  ASSERT_NE(first, second);
  const auto unsaved = [this] {
    return std::ranges::count(machine_.saves.unsaved, Stored::kEmergencyStops, &Unsaved::what);
  };
  Do(event::SaveEnded{Stored::kEmergencyStops, first, true, {}});
  EXPECT_EQ(unsaved(), 1);
  Do(event::SaveEnded{Stored::kEmergencyStops, second, true, {}});
  EXPECT_EQ(unsaved(), 0);
}

// A regression: a controller that had been away during a hundred stops took notice of one more with
// each release, and each of them was reported as engaged again.
TEST_F(ReceivedStops, AReleaseCoversEveryStopThatAnActuatorHadLatched) {
  StartUp();
  ActuatorReport report = machine_.actuators[0].report;
  report.emergency_stop = 7;
  report.emergency_stop_by = "a panel";
  report.other_stops = {8, 9};
  report.stamp += Milliseconds(1);
  Do(event::StatusSeen{0, report});
  ASSERT_TRUE(machine_.emergency.stop);
  EXPECT_EQ(machine_.emergency.stop->by, "a panel");
  Do(event::ReleaseRequested{1, "alice"});
  EXPECT_FALSE(machine_.emergency.stop);
  EXPECT_THAT(machine_.emergency.released,
              ::testing::UnorderedElementsAre(StopId(7), StopId(8), StopId(9)));
}

// A regression: an actuator that had missed an earlier release was released only with the
// repetition of the one under way, and counted as confirmed.
TEST_F(ReceivedStops, AReleasedStopThatAnActuatorReportsDuringAnotherReleaseIsReleasedAtOnce) {
  StartUp();
  Do(event::EmergencyStopSeen{{3, "a panel", ""}});
  Do(event::ReleaseRequested{1, "alice"});
  ASSERT_TRUE(machine_.emergency.release) << "no actuator has confirmed it yet";
  Forget();
  ActuatorReport report = Of(0).report;
  report.emergency_stop = 3;
  report.stamp += Milliseconds(1);
  Say(0, report);
  ASSERT_THAT(Did<action::PublishEmergencyStop>(), SizeIs(1));
  EXPECT_EQ(Did<action::PublishEmergencyStop>()[0].stop.id, StopId(3));
  EXPECT_FALSE(Did<action::PublishEmergencyStop>()[0].engaged);
}

// It was repeated for an actuator that had not confirmed it, during a switch that a person had
// requested since: the actuators whose turn came later refused that one.
TEST_F(ReceivedStops, ARepeatedReleaseNamesNoCommandThatWasRequestedSinceTheFirst) {
  StartUp();
  Do(event::EmergencyStopSeen{{3, "a panel", ""}});
  ActuatorReport report = Of(0).report;
  report.emergency_stop = 3;
  report.stamp += Milliseconds(1);
  Say(0, report);
  const CommandNumber before = machine_.number;
  Do(event::ReleaseRequested{1, "alice"});
  Pass(std::chrono::seconds(4));
  ASSERT_FALSE(machine_.emergency.release) << "it has ended without the actuator";
  Do(event::SetStateRequested{2, "LowPower"});
  ASSERT_GT(machine_.number, before);
  Forget();
  Do(event::ReleaseRequested{3, "alice"});
  ASSERT_THAT(Did<action::PublishEmergencyStop>(), SizeIs(1));
  EXPECT_EQ(Did<action::PublishEmergencyStop>()[0].last_command, before);
}

// A person had stopped the robot twice without a controller, with a release between. The first
// command still published its stop, which arrived last and replaced the second one. The disk had it
// as released, so the next controller held no stop, and released the second one at the actuators.
TEST_F(ReceivedStops, AReleasedOneThatIsStillPublishedEndsNoLaterOneOfItsSource) {
  const EmergencyStop first{7, "anna@bench", "smoke"};
  const EmergencyStop second{8, "anna@bench", "hand in the gripper"};
  const StoredStops stored{{}, {7}};
  for (const bool in_order : {true, false}) {
    StoredStops received;
    AddReceived(received, in_order ? first : second);
    AddReceived(received, in_order ? second : first);
    const StoredStops begin = Merge(stored, WithoutReleased(stored, received));
    EXPECT_THAT(begin.engaged, ElementsAre(second));
    EXPECT_THAT(begin.released, ElementsAre(StopId(7)));
    EXPECT_TRUE(begin.awaits_request);
  }
}

// The controller before it, with another disk, publishes the release.
TEST_F(ReceivedStops, TheReleaseOfOneBeforeTheBeginEndsNoOtherOneOfItsSource) {
  StoredStops received;
  AddReceived(received, {8, "anna@bench", "hand in the gripper"});
  AddReceived(received, {7, "anna@bench", "smoke"});
  AddReceivedRelease(received, 7);
  const StoredStops begin = Merge({}, WithoutReleased({}, received));
  EXPECT_THAT(begin.engaged, ElementsAre(EmergencyStop{8, "anna@bench", "hand in the gripper"}));
  EXPECT_THAT(begin.released, ElementsAre(StopId(7)));
}

TEST_F(ReceivedStops, OfOneSourceBeforeTheBeginAreReleasedTogether) {
  StoredStops received;
  AddReceived(received, {7, "anna@bench", "smoke"});
  AddReceived(received, {7, "anna@bench", "smoke"});
  AddReceived(received, {8, "anna@bench", "hand in the gripper"});
  machine_ = MakeMachine(config_);
  event::Begin begin{false, 0, {false, false}, "here"};
  begin.stops = Merge({}, WithoutReleased({}, received));
  Do(begin);
  EXPECT_THAT(StopsOf(machine_).engaged,
              ElementsAre(EmergencyStop{8, "anna@bench", "smoke; then: hand in the gripper"}));
  Do(event::ReleaseRequested{1, "alice", {8}});
  EXPECT_THAT(StopsOf(machine_).engaged, IsEmpty());
  EXPECT_THAT(StopsOf(machine_).released, ElementsAre(StopId(7), StopId(8)));
}

TEST_F(ReceivedStops, OfAFloodBeforeTheBeginForgetNoneOfAnotherSource) {
  StoredStops received;
  AddReceived(received, {1000, "the door", "open"});
  for (StopId id = 1; id < 1000; ++id) AddReceived(received, {id, "a panel", ""});
  EXPECT_EQ(received.engaged.front(), (EmergencyStop{1000, "the door", "open"}));
  EXPECT_EQ(received.engaged.back(), (EmergencyStop{999, "a panel", ""}));
  EXPECT_EQ(received.engaged.size(), 320U);
  EXPECT_THAT(received.released, IsEmpty());
}

// A panel publishes it for ever. A robot whose controller was started again waited for a person
// each time.
TEST_F(ReceivedStops, OneThatTheDiskHasAsReleasedWaitsForNoRequest) {
  const StoredStops stored{{}, {7}, false};
  const StoredStops again{{{7, "a panel", ""}}, {}, true};
  EXPECT_EQ(WithoutReleased(stored, again), StoredStops());
  const StoredStops with_another{{{7, "a panel", ""}}, {8}, true};
  EXPECT_TRUE(WithoutReleased(stored, with_another).awaits_request);
  EXPECT_TRUE(WithoutReleased({}, again).awaits_request) << "another disk";
  const StoredStops unknown{{{kUnknownStop, "a panel", ""}}, {}, true};
  EXPECT_TRUE(WithoutReleased({{}, {kUnknownStop}, false}, unknown).awaits_request);
}

// A command after the release has a higher number, and the actuator must obey it.
TEST_F(ReceivedStops, AReleaseNamesTheLastCommandBeforeItAlsoWhenItIsRepeated) {
  StartUp();
  const CommandNumber before = machine_.number;
  Do(event::EmergencyStopSeen{{3, "a panel", ""}});
  Forget();
  Do(event::ReleaseRequested{1, "alice"});
  ASSERT_THAT(Did<action::PublishEmergencyStop>(), SizeIs(1));
  EXPECT_EQ(Did<action::PublishEmergencyStop>()[0].last_command, before);
  Do(event::SetStateRequested{2, "LowPower"});
  ASSERT_GT(machine_.number, before);
  Forget();
  Pass(Milliseconds(500));
  ASSERT_THAT(Did<action::PublishEmergencyStop>(), SizeIs(1));
  EXPECT_EQ(Did<action::PublishEmergencyStop>()[0].last_command, before);
}

}  // namespace musher::testing::received_stops_test
