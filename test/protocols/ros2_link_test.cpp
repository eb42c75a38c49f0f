#include <gmock/gmock.h>

#include "musher/base/code.hpp"
#include "musher/test/protocols/link_harness.hpp"
#include "musher/test/protocols/ros_managed_node.hpp"
#include "musher/test/support/refusals.hpp"

namespace musher::testing::ros2_link_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Outcome = RosManagedNode::Outcome;

class DrivingARos2Node : public LinkStage {
 protected:
  DrivingARos2Node() : LinkStage(Protocol::kRos2Lifecycle) {
    OpenLink();
    StartNode();
  }

  void StartNode() {
    process_ = network_.MakeNode("robot");
    ros_ = std::make_unique<RosManagedNode>(*process_, "a");
  }
  void EndNode() {
    ros_ = nullptr;
    process_ = nullptr;
  }
  void SetUp() override {
    ASSERT_TRUE(Until([&] { return IsIn("SetUp"); }));
  }
  void BringUp() { ASSERT_EQ(Do("Active").verdict, Verdict::kDone); }

  std::unique_ptr<transport::Node> process_;
  std::unique_ptr<RosManagedNode> ros_;
};

TEST_F(DrivingARos2Node, ConfiguresANodeAsSoonAsItIsSeen) {
  EXPECT_THAT(ros_->log(), ElementsAre("configure"));
  EXPECT_EQ(ros_->state(), Ros2State::kInactive);
}

TEST_F(DrivingARos2Node, TakesItWhereEachStateOfTheMachineBelongs) {
  EXPECT_EQ(Do("SelfCheck").report.state, "SelfCheck");
  EXPECT_EQ(Do("Active").report.state, "Active");
  EXPECT_EQ(ros_->state(), Ros2State::kActive);
  EXPECT_EQ(Do("SelfCheck").report.state, "Active") << "in the run phase a check changes nothing";
  for (const BuiltInState state : {kProtected, kLowPower, kOta, kDeActive}) {
    EXPECT_EQ(Do(state).report.state, state);
    EXPECT_EQ(ros_->state(), Ros2State::kInactive);
  }
  EXPECT_THAT(ros_->log(), ElementsAre("configure", "activate", "deactivate"));
}

TEST_F(DrivingARos2Node, TearsItDownByCleanupAndShutdown) {
  BringUp();
  EXPECT_EQ(Do("TearDown").report.state, "TearDown");
  EXPECT_EQ(ros_->state(), Ros2State::kFinalized);
  EXPECT_THAT(ros_->log(),
              ElementsAre("configure", "activate", "deactivate", "cleanup", "shutdown"));
}

TEST_F(DrivingARos2Node, ReachesOtherStatesIfTheConfigMapsThem) {
  config_.actuators[0].ros2_states = {{"LowPower", Ros2State::kUnconfigured},
                                      {"Protected", Ros2State::kActive}};
  EXPECT_EQ(Do("Protected").verdict, Verdict::kDone);
  EXPECT_EQ(ros_->state(), Ros2State::kActive);
  EXPECT_EQ(Do("LowPower").verdict, Verdict::kDone);
  EXPECT_EQ(ros_->state(), Ros2State::kUnconfigured);
  EXPECT_EQ(Do("Active").verdict, Verdict::kDone);
  EXPECT_EQ(ros_->state(), Ros2State::kActive);
}

TEST_F(DrivingARos2Node, ALostReplyIsNoFailureBecauseTheEventHasTheOutcome) {
  ros_->lost_change_replies = 1;
  const Time begun = network_.now();
  EXPECT_EQ(Do("Active").verdict, Verdict::kDone);
  EXPECT_LT(network_.now() - begun, Milliseconds(100));
}

TEST_F(DrivingARos2Node, ALostReplyIsNoFailureThoughTheEventIsLostToo) {
  ros_->lost_change_replies = 1;
  ros_->publishes_events = false;
  EXPECT_EQ(Do("Active").verdict, Verdict::kDone);
}

TEST_F(DrivingARos2Node, IsSetUpThoughItsFirstRepliesAreLost) {
  EndNode();
  ASSERT_TRUE(Until([&] { return !losses_.empty(); }));
  StartNode();
  ros_->lost_get_replies = 3;
  ros_->lost_change_replies = 1;
  EXPECT_TRUE(Until([&] { return IsIn("SetUp"); }));
}

TEST_F(DrivingARos2Node, ACallbackThatFailsIsAFailureAndTheNodeIsWhereItWas) {
  ros_->script["activate"].outcome = Outcome::kFailure;
  const event::Replied reply = Do("Active");
  EXPECT_EQ(reply.verdict, Verdict::kFailed);
  EXPECT_EQ(reply.message, "activate failed; the node is inactive now");
  EXPECT_EQ(reply.report.state, "SetUp");
}

TEST_F(DrivingARos2Node, AFailureIsKnownThoughItsReplyIsLost) {
  ros_->script["activate"].outcome = Outcome::kFailure;
  ros_->lost_change_replies = 1;
  EXPECT_EQ(Do("Active").message, "activate failed; the node is inactive now");
}

TEST_F(DrivingARos2Node, AfterErrorProcessingItIsConfiguredAgainOnTheWayUp) {
  ros_->script["activate"].outcome = Outcome::kError;
  EXPECT_EQ(Do("Active").message, "activate failed; the node is unconfigured now");
  EXPECT_EQ(reply_->report.state, "Uninitialized");
  ros_->script["activate"].outcome = Outcome::kSuccess;
  EXPECT_EQ(Do("Active").verdict, Verdict::kDone);
  EXPECT_THAT(ros_->log(), ElementsAre("configure", "activate", "configure", "activate"));
}

TEST_F(DrivingARos2Node, AFinalizedNodeIsTornDownAndComesBackByANewStartOnly) {
  ros_->script["activate"].outcome = Outcome::kError;
  ros_->recovers = false;
  EXPECT_EQ(Do("Active").report.state, "TearDown");
  EXPECT_THAT(Do("DeActive").message, HasSubstr("only a new start"));
}

TEST_F(DrivingARos2Node,
       ANodeWhoseOnlyThreadIsInACallbackIsBusyWhenQueriedAndItsLateEndIsReported) {
  ros_->script["activate"].takes = std::chrono::seconds(3);
  Switch("Active");
  network_.RunFor(Milliseconds(100));
  const auto answer = Query();
  ASSERT_TRUE(answer) << "silence of a node that owes a transition means busy";
  EXPECT_EQ(answer->report.busy_number, number_);
  EXPECT_TRUE(Until([&] { return IsIn("Active"); }));
  EXPECT_EQ(status_.outcome_number, number_);
  EXPECT_EQ(status_.outcome_code, kCodeOk);
}

TEST_F(DrivingARos2Node, TheLateEndIsNoticedThoughItsReplyIsLost) {
  ros_->script["activate"].takes = std::chrono::seconds(3);
  ros_->lost_change_replies = 1;
  Switch("Active");
  network_.RunFor(Milliseconds(100));
  ASSERT_TRUE(Query());
  EXPECT_TRUE(Until([&] { return IsIn("Active"); }));
}

TEST_F(DrivingARos2Node, AQueryEndsACommandOfSeveralTransitionsAfterTheRunningOne) {
  BringUp();
  ros_->script["deactivate"].takes = Milliseconds(500);
  Switch("TearDown");
  network_.RunFor(Milliseconds(100));
  ASSERT_TRUE(Query());
  const event::Replied reply = Outcome();
  EXPECT_EQ(reply.verdict, Verdict::kFailed);
  EXPECT_EQ(reply.report.state, "DeActive") << "not Active any more, not torn down";
  EXPECT_THAT(ros_->log(), ElementsAre("configure", "activate", "deactivate"));
}

TEST_F(DrivingARos2Node, ARequestThatNeverArrivedHadNotBegunAndWhenItDoesTheNodeIsDrivenBack) {
  ros_->holds_changes = true;
  Switch("Active");
  network_.RunFor(Milliseconds(100));
  const auto answer = Query();
  ASSERT_TRUE(answer);
  EXPECT_FALSE(answer->report.busy());
  EXPECT_NE(answer->report.outcome_number, number_);
  const int before = statuses_;
  ros_->Release();
  ASSERT_TRUE(Until([&] { return IsIn("Active"); }));
  EXPECT_GE(statuses_, before + 2) << "busy and free once, so that the coordinator takes note";
}

TEST_F(DrivingARos2Node, ACommandThatIsNotQueriedEndsToo) {
  ros_->holds_changes = true;
  Switch("Active");
  const CommandNumber next = Switch("Error");
  network_.RunFor(Milliseconds(50));
  ros_->holds_changes = false;  // the first request is lost for good
  network_.RunFor(std::chrono::seconds(2));
  EXPECT_EQ(reply_->number, next);
  EXPECT_THAT(*reply_, IsRefused(Refusal::kCommandWaitedTooLong));
  EXPECT_EQ(Do("Active").verdict, Verdict::kDone);
}

TEST_F(DrivingARos2Node, ItIsNotSwitchedToSetUp) {
  EXPECT_THAT(Do("SetUp"), IsRefused(Refusal::kNoStateToSwitchTo));
}

TEST_F(DrivingARos2Node, ARequestThatArrivesAfterAPartitionEndsAsItEnds) {
  network_.Partition("controller", "robot");
  Switch("Active");
  network_.RunFor(Milliseconds(400));
  network_.Heal("controller", "robot");
  EXPECT_EQ(Outcome().verdict, Verdict::kDone);
  EXPECT_EQ(ros_->state(), Ros2State::kActive);
}

TEST_F(DrivingARos2Node, AFrozenNodeWithoutACommandAnswersNoQuery) {
  ros_->frozen = true;
  EXPECT_FALSE(Query(false));
  Switch("SelfCheck");
  network_.RunFor(Milliseconds(100));
  EXPECT_FALSE(Query());
}

TEST_F(DrivingARos2Node, ANodeThatWasSilentIsReportedAgain) {
  network_.Block("robot", "controller");
  EXPECT_FALSE(Query(false));
  const int before = statuses_;
  network_.Free("robot", "controller");
  EXPECT_TRUE(Until([&] { return statuses_ > before; }));
  EXPECT_TRUE(IsIn("SetUp"));
}

TEST_F(DrivingARos2Node, ASelfCheckQueriesTheNodeAndRequestsNoTransition) {
  BringUp();
  EXPECT_EQ(Do("SelfCheck").verdict, Verdict::kDone);
  EXPECT_EQ(reply_->report.state, "Active");
  EXPECT_THAT(ros_->log(), ElementsAre("configure", "activate"));
}

TEST_F(DrivingARos2Node, ASelfCheckConfiguresANodeThatHasFallenOutOfItsConfiguration) {
  BringUp();
  ros_->script["deactivate"].outcome = Outcome::kError;
  EXPECT_EQ(Do("LowPower").report.state, "Uninitialized");
  ros_->script["configure"].outcome = Outcome::kFailure;
  EXPECT_EQ(Do("SelfCheck").message, "configure failed; the node is unconfigured now");
  ros_->script["configure"].outcome = Outcome::kSuccess;
  EXPECT_EQ(Do("SelfCheck").verdict, Verdict::kDone);
  EXPECT_EQ(reply_->report.state, "SelfCheck");
  EXPECT_EQ(ros_->state(), Ros2State::kInactive);
}

TEST_F(DrivingARos2Node, ATransitionByAnotherClientIsReportedAndNotCorrectedByTheLink) {
  BringUp();
  ros_->Change("deactivate");
  EXPECT_TRUE(Until([&] { return IsIn("DeActive"); }));
  network_.RunFor(std::chrono::seconds(2));
  EXPECT_EQ(ros_->state(), Ros2State::kInactive);
}

TEST_F(DrivingARos2Node, IsNotTakenForActiveBecauseAnEventWasLost) {
  BringUp();
  ros_->publishes_events = false;
  ros_->Change("deactivate");
  network_.RunFor(Milliseconds(50));
  EXPECT_EQ(Do("Active").verdict, Verdict::kDone);
  EXPECT_EQ(ros_->state(), Ros2State::kActive);
}

TEST_F(DrivingARos2Node, AnAnswerFromBeforeACommandIsNotTakenForItsResult) {
  BringUp();
  ros_->holds_looks = true;
  link_->Query({1, number_, false});
  network_.RunFor(Milliseconds(50));
  ASSERT_EQ(Do("LowPower").verdict, Verdict::kDone);
  statuses_ = 0;
  ros_->Release();
  network_.RunFor(Milliseconds(50));
  EXPECT_EQ(statuses_, 0) << "it has not become active again";
}

TEST_F(DrivingARos2Node, AQueryGetsNoAnswerAfterTheExitOfAProcessOfTheController) {
  link_->OnProcess(4711);
  network_.Crash(*process_);
  link_->OnProcessEnded(4711);
  Switch("Active");
  EXPECT_FALSE(Query());
  EXPECT_FALSE(reply_);
}

TEST_F(DrivingARos2Node, AnExitIsDetectedAndTheSuccessorIsSetUpAgain) {
  const Incarnation first = status_.incarnation;
  EndNode();
  ASSERT_TRUE(Until([&] { return !losses_.empty(); }));
  StartNode();
  ASSERT_TRUE(Until([&] { return IsIn("SetUp") && status_.incarnation != first; }));
  EXPECT_GT(status_.incarnation, first);
  EXPECT_THAT(ros_->log(), ElementsAre("configure"));
}

TEST_F(DrivingARos2Node, ASuccessorIsDrivenBeforeTheLeaseOfThePreviousProcessExpires) {
  const Incarnation first = status_.incarnation;
  network_.Crash(*process_);
  EndNode();
  StartNode();
  ASSERT_TRUE(Until([&] { return IsIn("SetUp") && status_.incarnation != first; },
                    std::chrono::seconds(2)));
  EXPECT_EQ(Do("Active").verdict, Verdict::kDone);
  network_.RunFor(std::chrono::seconds(20));
  EXPECT_THAT(losses_, IsEmpty()) << "the end of the dead one's lease is not the successor's";
}

// A killed process stays matched for 10 s; meanwhile its successor exits with code 0.
TEST_F(DrivingARos2Node, AnExitedPredecessorIsNotTakenForTheNodeWhenItsSuccessorExits) {
  link_->OnProcess(4711);
  network_.Crash(*process_);
  EndNode();
  link_->OnProcessEnded(4711);
  StartNode();
  link_->OnProcess(4712);
  ASSERT_TRUE(Until([&] { return IsIn("SetUp") && status_.pid == 4712; }));
  const Incarnation second = status_.incarnation;
  EndNode();
  ASSERT_TRUE(Until([&] { return !losses_.empty(); }));
  network_.RunFor(std::chrono::seconds(20));
  EXPECT_EQ(status_.incarnation, second) << "no process came after it";
}

// Both were driven, and the journal said that the node was restarted.
class TwoNodesOfOneName : public DrivingARos2Node {
 protected:
  void SetUp() override {
    DrivingARos2Node::SetUp();
    BringUp();
    first_ = status_.incarnation;
    second_process_ = network_.MakeNode("robot");
    second_ = std::make_unique<RosManagedNode>(*second_process_, "a");
    ASSERT_TRUE(Until([&] { return status_.degraded_code != kCodeOk; }));
  }
  void EndSecond() {
    second_ = nullptr;
    second_process_ = nullptr;
  }

  Incarnation first_ = 0;
  std::unique_ptr<transport::Node> second_process_;
  std::unique_ptr<RosManagedNode> second_;
};

TEST_F(TwoNodesOfOneName, AreReportedAndTheFirstOneStaysTheActuator) {
  EXPECT_THAT(status_.degraded_reason, HasSubstr("two nodes /a: "));
  EXPECT_EQ(status_.incarnation, first_);
  EXPECT_EQ(status_.state, "Active");
  EXPECT_THAT(second_->log(), IsEmpty()) << "it is not configured";
  EXPECT_THAT(losses_, IsEmpty());
}

TEST_F(TwoNodesOfOneName, AreSwitchedByTheAnswersOfTheFirst) {
  second_->script["deactivate"].outcome = Outcome::kFailure;
  EXPECT_EQ(Do("LowPower").verdict, Verdict::kDone);
  EXPECT_EQ(ros_->state(), Ros2State::kInactive);
  EXPECT_EQ(Do("Active").verdict, Verdict::kDone);
  EXPECT_EQ(status_.incarnation, first_);
}

TEST_F(TwoNodesOfOneName, AreOneAgainWhenTheSecondHasEnded) {
  EndSecond();
  EXPECT_TRUE(Until([&] { return status_.degraded_code == kCodeOk; }));
  EXPECT_EQ(status_.degraded_reason, "");
  EXPECT_EQ(status_.incarnation, first_);
}

TEST_F(TwoNodesOfOneName, AreOneAgainWhenTheFirstHasEndedAndTheSecondIsDriven) {
  EndNode();
  ASSERT_TRUE(Until([&] { return status_.incarnation != first_ && IsIn("SetUp"); }));
  EXPECT_EQ(status_.degraded_code, kCodeOk);
  EXPECT_THAT(second_->log(), ElementsAre("configure"));
}

TEST_F(DrivingARos2Node, ASecondNodeIsReportedAtOnceIfTheFirstIsWatched) {
  BringUp();
  link_->OnParticipantWatched(link_->ProgramsParticipant());
  const auto process = network_.MakeNode("robot");
  const RosManagedNode second(*process, "a");
  ros_->frozen = true;  // it need not answer
  EXPECT_TRUE(Until([&] { return status_.degraded_code != kCodeOk; }, Milliseconds(500)));
}

TEST_F(DrivingARos2Node, TheExitOfAWatchedProcessIsALossAtOnce) {
  BringUp();
  const transport::ParticipantId participant = link_->ProgramsParticipant();
  ASSERT_NE(participant, transport::ParticipantId(0));
  link_->OnParticipantWatched(participant);
  network_.Crash(*process_);
  link_->OnParticipantEnded(participant, 4711);
  EXPECT_THAT(losses_, ElementsAre("its process 4711 ended"));
}

TEST_F(DrivingARos2Node, AFinalizedNodeSaysWhatBringsItBack) {
  BringUp();
  ros_->Change("shutdown");
  network_.RunFor(Milliseconds(50));
  EXPECT_THAT(Do("Active").message, HasSubstr("start it again where it was started"));
  config_.actuators[0].command = {"planner"};
  EXPECT_THAT(Do("Active").message, HasSubstr("musher restart a"));
}

TEST_F(DrivingARos2Node, ANodeWithACheckpointIsSilentWhenItDoesNotAnswerLongAfterItsDeadline) {
  config_.actuators[0].checkpoint = Milliseconds(500);
  ros_->script["activate"].takes = std::chrono::seconds(30);
  Switch("Active");
  network_.RunFor(Milliseconds(300));
  EXPECT_TRUE(Query()) << "it is busy";
  network_.RunFor(Milliseconds(500));
  EXPECT_FALSE(Query());
}

class FindingARos2Node : public DrivingARos2Node {
 protected:
  void SetUp() override {}
  void Prepare(const std::vector<std::string>& transitions) {
    link_ = nullptr;
    for (const std::string& transition : transitions) {
      ros_->Change(transition);
      network_.RunFor(Milliseconds(20));
    }
    statuses_ = 0;
    OpenLink();
  }
};

TEST_F(FindingARos2Node, AnActiveNodeIsAdoptedAsActive) {
  Prepare({"configure", "activate"});
  EXPECT_TRUE(Until([&] { return IsIn("Active"); }));
  EXPECT_THAT(ros_->log(), ElementsAre("configure", "activate"));
}

TEST_F(FindingARos2Node, AnInactiveNodeIsAdoptedAsDeActiveWhateverItWas) {
  Prepare({"configure"});
  EXPECT_TRUE(Until([&] { return IsIn("DeActive"); }));
}

TEST_F(FindingARos2Node, AnActiveNodeThatMayBeProtectedIsAdoptedAsProtected) {
  config_.actuators[0].ros2_states = {{"Protected", Ros2State::kActive}};
  Prepare({"configure", "activate"});
  EXPECT_TRUE(Until([&] { return IsIn("Protected"); }));
}

TEST_F(FindingARos2Node, ANodeOfTheControllerThatActivatedItselfIsDrivenBackToItsSetUp) {
  link_ = nullptr;
  ros_->Change("configure");
  ros_->Change("activate");
  network_.RunFor(Milliseconds(50));
  OpenLink();
  link_->OnProcess(4711);
  EXPECT_TRUE(Until([&] { return IsIn("SetUp"); }));
  EXPECT_EQ(ros_->state(), Ros2State::kInactive);
  EXPECT_EQ(status_.pid, 4711);
}

TEST_F(FindingARos2Node, ANodeStartedByAnEarlierControllerIsAdoptedInItsState) {
  Prepare({"configure", "activate"});
  link_->OnProcessFound(4711);
  EXPECT_TRUE(Until([&] { return IsIn("Active"); }));
  EXPECT_EQ(status_.pid, 4711);
  EXPECT_THAT(ros_->log(), ElementsAre("configure", "activate"));
}

TEST_F(FindingARos2Node, ANodeThatCannotBeConfiguredHasAFailedSetUpUntilAnotherClientConfiguresIt) {
  ros_->script["configure"].outcome = Outcome::kFailure;
  ASSERT_TRUE(Until([&] { return status_.outcome_code != kCodeOk; }));
  EXPECT_FALSE(status_.busy());
  EXPECT_EQ(status_.state, "Uninitialized");
  EXPECT_EQ(status_.outcome_message, "configure failed; the node is unconfigured now");
  ros_->script["configure"].outcome = Outcome::kSuccess;
  ros_->Change("configure");
  EXPECT_TRUE(Until([&] { return IsIn("SetUp"); }));
}

TEST_F(FindingARos2Node, ANodeThatMissedTheRequestToConfigureGetsAnother) {
  ros_->holds_changes = true;
  ASSERT_TRUE(Until([&] { return status_.target == "SetUp"; }));
  network_.RunFor(std::chrono::seconds(1));
  ros_->holds_changes = false;
  EXPECT_TRUE(Until([&] { return IsIn("SetUp"); }));
  EXPECT_THAT(ros_->log(), ElementsAre("configure"));
}

TEST_F(FindingARos2Node, ANodeThatConfiguresForLongIsBusyInSetUpMeanwhile) {
  ros_->script["configure"].takes = std::chrono::seconds(22);
  ASSERT_TRUE(Until([&] { return status_.target == "SetUp"; }));
  network_.RunFor(std::chrono::seconds(21));
  EXPECT_EQ(status_.target, "SetUp");
  EXPECT_TRUE(Until([&] { return IsIn("SetUp"); }));
  EXPECT_THAT(ros_->log(), ElementsAre("configure"));
}

}  // namespace musher::testing::ros2_link_test
