#include <gmock/gmock.h>

#include "musher/test/lifecycle/one_actuator.hpp"

namespace musher::actuator_core_test {

using namespace actuator_action;  // NOLINT(google-build-using-namespace)
using actuator_event::CallbackEnded;
using actuator_event::EmergencyStopReceived;
using actuator_event::ManagerCommand;
using actuator_event::PartFailed;
using actuator_event::QueryArrived;
using actuator_event::Started;
using actuator_event::SwitchArrived;
using testing::Actions;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::VariantWith;

class Actuator : public testing::OneActuator {};

TEST_F(Actuator, RunsSetUpByItselfAndReportsThatItIsBusyFromTheStart) {
  EXPECT_THAT(Do(Started{}), ElementsAre(VariantWith<RunCallback>(RunCallback{"SetUp"}),
                                         VariantWith<PublishStatus>(PublishStatus{})));
  EXPECT_EQ(core_.report.target, "SetUp");
  EXPECT_THAT(Do(CallbackEnded{}), ElementsAre(VariantWith<BecomeVisible>(BecomeVisible{}),
                                               VariantWith<PublishStatus>(PublishStatus{})));
  EXPECT_EQ(core_.report.state, "SetUp");
}

TEST_F(Actuator, IsFinishedWithTheCodeOfASetUpThatFailed) {
  Do(Started{});
  const Actions actions = Do(CallbackEnded{5012, "no sound card"});
  EXPECT_THAT(actions, Contains(VariantWith<Finish>(Finish{5012, "no sound card"})));
  EXPECT_THAT(actions, Not(Contains(VariantWith<BecomeVisible>(BecomeVisible{}))));
  EXPECT_EQ(core_.report.outcome_code, 5012);
}

TEST_F(Actuator, AnswersWhenTheCallbackHasEnded) {
  SetUpIt();
  EXPECT_THAT(Do(Command(1, "Active")), Contains(VariantWith<RunCallback>(RunCallback{"Active"})));
  EXPECT_EQ(core_.report.busy_number, CommandNumber(1));
  EXPECT_EQ(AnswerIn(Do(CallbackEnded{})).verdict, Verdict::kDone);
  EXPECT_EQ(core_.report.state, "Active");
  EXPECT_FALSE(core_.report.busy());
}

TEST_F(Actuator, KeepsItsStateWhenTheCallbackFails) {
  SetUpIt();
  Do(Command(1, "Active"));
  const Answer answer = AnswerIn(Do(CallbackEnded{5001, "amplifier"}));
  EXPECT_EQ(answer.verdict, Verdict::kFailed);
  EXPECT_EQ(answer.code, 5001);
  EXPECT_EQ(core_.report.state, "SetUp");
}

TEST_F(Actuator, DoesNothingForTheStateItIsIn) {
  SetUpIt();
  Switch(1, "Active");
  const Actions actions = Do(Command(2, "Active"));
  EXPECT_EQ(AnswerIn(actions).verdict, Verdict::kDone);
  EXPECT_THAT(actions, Not(Contains(VariantWith<RunCallback>(RunCallback{"Active"}))));
}

TEST_F(Actuator, RunsTheCallbackOfItsOwnStateAgainAfterAFailureToLeaveIt) {
  SetUpIt();
  Switch(1, "Active");
  Do(Command(2, "LowPower"));
  Do(CallbackEnded{5001, ""});
  EXPECT_THAT(Do(Command(3, "Active")), Contains(VariantWith<RunCallback>(RunCallback{"Active"})));
}

TEST_F(Actuator, RefusesAnOutdatedEpoch) {
  SetUpIt();
  Announce(5);
  Do(Command(1, "Active", 5));
  Do(CallbackEnded{});
  const Answer answer = AnswerIn(Do(Command(2, "DeActive", 4)));
  EXPECT_EQ(answer.verdict, Verdict::kRefused);
  EXPECT_EQ(answer.code, kCodePermissionDenied);
  EXPECT_EQ(AnswerIn(Do(QueryArrived{9, {4, 2, true}, 4})).code, kCodePermissionDenied);
  EXPECT_EQ(core_.report.state, "Active");
}

TEST_F(Actuator, AnswersACommandWithoutANumberThoughItHasNotExecutedAnyYet) {
  SetUpIt();
  EXPECT_EQ(AnswerIn(Do(Command(0, "Active"))).verdict, Verdict::kRefused);
}

TEST_F(Actuator, RefusesAnOutdatedNumber) {
  SetUpIt();
  Switch(5, "Active");
  const Answer answer = AnswerIn(Do(Command(4, "DeActive")));
  EXPECT_EQ(answer.verdict, Verdict::kRefused);
  EXPECT_EQ(answer.code, kCodeStatusError);
}

TEST_F(Actuator, RefusesAnOutdatedNumberAlsoInANewEpoch) {
  SetUpIt();
  Switch(5, "Active");
  EXPECT_EQ(AnswerIn(Do(Command(4, "DeActive", 2))).verdict, Verdict::kRefused);
}

TEST_F(Actuator, GivesARepeatedCommandTheSameAnswerAndRunsItOnce) {
  SetUpIt();
  Do(Command(1, "Active"));
  EXPECT_THAT(Do(Command(1, "Active")), ElementsAre());  // the reply to the first was lost
  const Actions ended = Do(CallbackEnded{5001, "amplifier"});
  EXPECT_EQ(std::count_if(ended.begin(), ended.end(),
                          [](const auto& a) { return std::holds_alternative<Answer>(a); }),
            2);
  const Answer again = AnswerIn(Do(Command(1, "Active")));
  EXPECT_EQ(again.verdict, Verdict::kFailed);
  EXPECT_EQ(again.code, 5001);
}

// The search found that such a copy switched an actuator on, after its switch had been undone.
TEST_F(Actuator, ACopyOfARefusedCommandDoesNotRunOnceTheStopIsReleased) {
  SetUpIt();
  Switch(1, "DeActive");
  Do(EmergencyStopReceived{5, true, 999});
  EXPECT_EQ(AnswerIn(Do(Command(2, "Active"))).code, kCodeProtectedError);
  Do(EmergencyStopReceived{5, false, 1});
  EXPECT_THAT(AnswerIn(Do(Command(2, "Active"))).message, HasSubstr("is outdated"));
  EXPECT_FALSE(core_.report.busy());
}

TEST_F(Actuator, RefusesAStateItDoesNotList) {
  SetUpIt();
  const Answer answer = AnswerIn(Do(Command(1, "OTA")));
  EXPECT_EQ(answer.code, kCodeUnSupport);
  EXPECT_THAT(answer.message, HasSubstr("audio has no state 'OTA'"));
}

TEST_F(Actuator, RefusesToBeSetUpByCommand) {
  SetUpIt();
  EXPECT_EQ(AnswerIn(Do(Command(1, "SetUp"))).code, kCodeStateInvalid);
}

TEST_F(Actuator, RefusesACommandMeantForAnEarlierProcessOfItsName) {
  SetUpIt();
  SwitchArrived command = Command(1, "Active");
  command.command.incarnation = 76;
  EXPECT_EQ(AnswerIn(Do(command)).code, kCodePermissionDenied);
}

TEST_F(Actuator, RefusesACommandThatIsOlderThanItsBudgetByItsOwnClock) {
  SetUpIt();
  SwitchArrived command = Command(1, "Active");
  now_ += Milliseconds(101);  // it was delayed, for example by a link that was down
  const Answer answer = AnswerIn(Do(command));
  EXPECT_EQ(answer.code, kCodeTimeout);
  EXPECT_THAT(answer.message, HasSubstr("101 ms old"));
}

TEST_F(Actuator, DoesNotTakeAnOldStatusStampForAnOldCommand) {
  SetUpIt();
  SwitchArrived command = Command(1, "Active");
  now_ += std::chrono::hours(1);  // no status for an hour; the sender knows that
  command.command.since_status = std::chrono::hours(1);
  EXPECT_THAT(Do(command), Contains(VariantWith<RunCallback>(RunCallback{"Active"})));
}

TEST_F(Actuator, RefusesACommandWithInvalidTimes) {
  SetUpIt();
  CommandNumber number = 0;
  for (const auto& [stamp, since] :
       {std::pair(Time::max(), Duration::zero()), std::pair(Time::min(), Duration::zero()),
        std::pair(now_, Duration::min()), std::pair(now_, Duration::max())}) {
    SwitchArrived command = Command(++number, "Active");
    command.command.status_stamp = stamp;
    command.command.since_status = since;
    EXPECT_EQ(AnswerIn(Do(command)).code, kCodeParametersInvalid);
  }
}

TEST_F(Actuator, ACommandThatHadNotBegunWhenItWasQueriedNeverBegins) {
  SetUpIt();
  const SwitchArrived late = Command(7, "Active");
  EXPECT_EQ(AnswerIn(Do(QueryArrived{9, {1, 7, true}, 1})).verdict, Verdict::kDone);
  EXPECT_EQ(AnswerIn(Do(late)).verdict, Verdict::kRefused);
  EXPECT_EQ(core_.report.state, "SetUp");
}

TEST_F(Actuator, AWaitingCommandThatIsQueriedNeverBegins) {
  SetUpIt();
  Do(Command(1, "Active"));
  Do(Command(2, "LowPower"));
  const Actions queried = Do(QueryArrived{9, {1, 2, false}, 1});
  EXPECT_EQ(AnswerIn(queried).verdict, Verdict::kRefused);  // of the waiting one
  EXPECT_THAT(Do(CallbackEnded{}),
              Not(Contains(VariantWith<RunCallback>(RunCallback{"LowPower"}))));
}

// It waits behind a callback while the process is silent for a moment; the probe only checks that
// the actuator answers.
TEST_F(Actuator, AHealthProbeDoesNotCancelAWaitingTearDown) {
  SetUpIt();
  Do(Command(2, "Active"));
  Do(Command(3, "TearDown"));
  const Actions probed = Do(QueryArrived{9, {1, 0, false}, 1});
  EXPECT_EQ(AnswerIn(probed).verdict, Verdict::kDone);
  EXPECT_EQ(core_.report.number, CommandNumber(3));
  EXPECT_THAT(Do(CallbackEnded{}), Contains(VariantWith<RunCallback>(RunCallback{"TearDown"})));
}

TEST_F(Actuator, RequestsARunningCallbackToStopOnlyWhenCommanded) {
  SetUpIt();
  Do(Command(1, "Active"));
  EXPECT_THAT(Do(QueryArrived{8, {1, 1, false}, 1}),
              Not(Contains(VariantWith<RequestStop>(RequestStop{}))));
  EXPECT_THAT(Do(QueryArrived{9, {1, 1, true}, 1}),
              Contains(VariantWith<RequestStop>(RequestStop{})));
  EXPECT_EQ(core_.report.busy_number, CommandNumber(1)) << "it runs on until it gives up by itself";
}

TEST_F(Actuator, TheNewestCommandWaitsBehindARunningCallback) {
  SetUpIt();
  Do(Command(1, "Active"));
  Do(Command(2, "LowPower"));
  const Answer dropped = AnswerIn(Do(Command(3, "DeActive")));
  EXPECT_EQ(dropped.token, RequestToken(2));
  EXPECT_EQ(dropped.code, kCodeTargetBusy);
  EXPECT_THAT(Do(CallbackEnded{}), Contains(VariantWith<RunCallback>(RunCallback{"DeActive"})));
}

TEST_F(Actuator, AWaitingCommandThatHasExpiredIsRefused) {
  SetUpIt();
  Do(Command(1, "Active"));
  Do(Command(2, "LowPower"));
  now_ += Milliseconds(150);
  const Actions ended = Do(CallbackEnded{});
  EXPECT_THAT(ended, Not(Contains(VariantWith<RunCallback>(RunCallback{"LowPower"}))));
  EXPECT_EQ(core_.report.state, "Active");
}

TEST_F(Actuator, SelfCheckIsAStepOfAStartAndACheckLater) {
  SetUpIt();
  Switch(1, "SelfCheck");
  Switch(2, "Active");
  Do(Command(3, "SelfCheck"));
  Do(CallbackEnded{});
  EXPECT_EQ(core_.report.state, "Active");
  Do(Command(4, "SelfCheck"));
  EXPECT_EQ(AnswerIn(Do(CallbackEnded{1409, ""})).code, 1409);
  EXPECT_FALSE(core_.unsettled) << "a check leaves nothing half done";
}

TEST_F(Actuator, ASelfCheckThatFailsReportsNoPartialFaultOfTheOneBefore) {
  SetUpIt();
  Do(Command(1, "SelfCheck"));
  Do(CallbackEnded{kCodeOk, "", 1109, "led: silent"});
  EXPECT_EQ(core_.report.degraded_code, 1109);
  Do(Command(2, "SelfCheck"));
  Do(CallbackEnded{1409, "no motor answers"});
  EXPECT_EQ(core_.report.degraded_code, kCodeOk);
  EXPECT_EQ(core_.report.degraded_reason, "");
}

TEST_F(Actuator, APartThatFailsOutsideOfACallbackIsReportedUntilItIsOverOrTheNextSelfCheck) {
  SetUpIt();
  Switch(1, "SelfCheck");
  Switch(2, "Active");
  EXPECT_FALSE(Do(PartFailed{1, "the tree has failed: a"}).empty()) << "published";
  EXPECT_TRUE(Do(PartFailed{1, "the tree has failed: a"}).empty()) << "nothing new";
  EXPECT_EQ(core_.report.degraded_code, 1);
  EXPECT_EQ(core_.report.degraded_reason, "the tree has failed: a");
  EXPECT_TRUE(Do(PartFailed{kCodeOk, "another fault"}).empty()) << "is not that one";
  EXPECT_FALSE(Do(PartFailed{kCodeOk, "the tree has failed: a"}).empty());
  EXPECT_EQ(core_.report.degraded_code, kCodeOk);
  EXPECT_EQ(core_.report.degraded_reason, "");
  Do(PartFailed{1, "the tree has failed: b"});
  Do(Command(3, "SelfCheck"));
  Do(CallbackEnded{});
  EXPECT_EQ(core_.report.degraded_code, kCodeOk);
}

TEST_F(Actuator, IsFinishedAfterTearDownAndRefusesEverythingFromThenOn) {
  SetUpIt();
  Do(Command(1, "TearDown"));
  EXPECT_THAT(Do(CallbackEnded{}), Contains(VariantWith<Finish>(Finish{})));
  EXPECT_EQ(AnswerIn(Do(Command(2, "Active"))).code, kCodeStateInvalid);
}

TEST_F(Actuator, StaysWhenTearDownFails) {
  SetUpIt();
  Do(Command(1, "TearDown"));
  EXPECT_THAT(Do(CallbackEnded{5001, ""}), Not(Contains(VariantWith<Finish>(Finish{}))));
}

TEST_F(Actuator, ObeysAManagerWithoutEpochsUntilAControllerHasTakenControl) {
  SetUpIt();
  EXPECT_THAT(Do(ManagerCommand{7, "Active"}),
              Contains(VariantWith<RunCallback>(RunCallback{"Active"})));
  EXPECT_THAT(Do(CallbackEnded{}),
              Contains(VariantWith<Answer>(Answer{7, Verdict::kDone, kCodeOk, ""})));
  EXPECT_EQ(core_.report.state, "Active");
  Do(Command(1, "DeActive"));
  Do(CallbackEnded{});
  EXPECT_EQ(AnswerIn(Do(ManagerCommand{8, "Active"})).code, kCodePermissionDenied);
}

TEST_F(Actuator, BelongsToTheControllerThatHasTakenControl) {
  SetUpIt();
  Announce(3);
  Do(QueryArrived{1, {3, 0, false}, 3});
  EXPECT_EQ(AnswerIn(Do(ManagerCommand{2, "Active"})).code, kCodePermissionDenied);
}

TEST_F(Actuator, RunsOneCallbackAtATimeAndAManagersCommandDoesNotWait) {
  Do(Started{});
  EXPECT_EQ(AnswerIn(Do(ManagerCommand{1, "Active"})).code, kCodeTargetBusy);
  Do(CallbackEnded{});
  Do(ManagerCommand{2, "Active"});
  EXPECT_EQ(AnswerIn(Do(ManagerCommand{3, "LowPower"})).code, kCodeTargetBusy);
}

TEST_F(Actuator, AControllersCommandWaitsForTheCallbackOfAManager) {
  SetUpIt();
  Do(ManagerCommand{1, "Active"});
  EXPECT_THAT(Do(Command(1, "LowPower")), Not(Contains(VariantWith<RunCallback>(::testing::_))));
  EXPECT_THAT(Do(CallbackEnded{}), Contains(VariantWith<RunCallback>(RunCallback{"LowPower"})));
}

TEST_F(Actuator, RefusesAManagerWhatItRefusesAController) {
  SetUpIt();
  EXPECT_EQ(AnswerIn(Do(ManagerCommand{1, "OTA"})).code, kCodeUnSupport);
  EXPECT_EQ(AnswerIn(Do(ManagerCommand{2, "SetUp"})).code, kCodeStateInvalid);
  Do(ManagerCommand{3, "Active"});
  EXPECT_EQ(AnswerIn(Do(CallbackEnded{5001, "no"})).code, 5001);
  EXPECT_EQ(core_.report.state, "SetUp");
}

TEST_F(Actuator, RefusesAManagerWhatGoesUpWhileAnEmergencyStopIsLatched) {
  SetUpIt();
  Do(ManagerCommand{1, "LowPower"});
  Do(CallbackEnded{});
  Do(EmergencyStopReceived{5, true, 0});
  EXPECT_EQ(AnswerIn(Do(ManagerCommand{2, "Active"})).code, kCodeProtectedError);
  EXPECT_THAT(Do(ManagerCommand{3, "TearDown"}),
              Contains(VariantWith<RunCallback>(RunCallback{"TearDown"})));
}

TEST_F(Actuator, ReportsWhetherItIsDetachedAlsoWhereItWasInThatStateAlready) {
  SetUpIt();
  Switch(1, "LowPower");
  EXPECT_FALSE(core_.report.detached);
  auto alone = Command(2, "LowPower");
  alone.command.detached = true;
  Do(alone);
  EXPECT_TRUE(core_.report.detached);
  Do(Command(3, "LowPower"));
  EXPECT_FALSE(core_.report.detached);
}

}  // namespace musher::actuator_core_test
