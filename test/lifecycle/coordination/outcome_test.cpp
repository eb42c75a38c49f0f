// The result of a switch for every actuator, and its effects.

#include "musher/base/code.hpp"
#include "musher/test/lifecycle/coordination/one_controller.hpp"

namespace musher::testing::outcome_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// Of a module without a name: texts have the number only.
constexpr std::int32_t kLegFailed = MakeCode(ModuleCode{6100}, KeyCode::kFailed);
constexpr std::int32_t kLegInvalid = MakeCode(ModuleCode{6100}, KeyCode::kStateInvalid);

class Outcomes : public OneController {
 protected:
  void RequestSwitch(const State& target, std::optional<std::string> actuator = {}) {
    Do(event::SetStateRequested{++request_, target, std::move(actuator)});
  }
  void Fail(ActuatorIndex i, std::int32_t code) {
    const PendingCommand command = Of(i).command.value();
    ActuatorReport report = Report(i, Of(i).state());
    report.number = report.outcome_number = command.number;
    report.outcome_code = code;
    Do(event::Replied{i, command.number, false, Verdict::kFailed, code, "it stumbled", report});
  }
  SwitchResult Result() {
    for (const auto& answer : Did<action::AnswerSetState>()) {
      if (answer.request == request_) return answer.result;
    }
    ADD_FAILURE() << "there is no answer";
    return {};
  }
  void In(const State& state) {
    StartUp();
    RequestSwitch(state);
    ObeyAll();
    EXPECT_EQ(machine_.state, state);
    Forget();
  }
  RequestId request_ = 0;
};

TEST_F(Outcomes, NameTheFailedActuatorAndNotTheActuatorsSkippedBecauseOfIt) {
  config_.actuators[0].after = {"b"};
  In("LowPower");
  RequestSwitch("Active");
  Fail(1, kLegFailed);
  Obey(1);  // it is rolled back
  EXPECT_EQ(Result().reason, "b: failed with 6101, it stumbled");
  EXPECT_EQ(Result().actuators[0].outcome, ActuatorOutcome::kSkipped);
  EXPECT_EQ(Result().actuators[0].code, kCodeStatusError);
}

TEST_F(Outcomes, AreInTheRecordOfTheEndAlsoAsValues) {
  In("Active");
  RequestSwitch("LowPower");
  ObeyAll();
  const auto of_switch = RecordWith(EventName::kSwitchDone).of_switch;
  ASSERT_TRUE(of_switch);
  EXPECT_EQ(*of_switch, (action::SwitchNote{"LowPower", SwitchOutcome::kDone, "LowPower"}));
}

TEST_F(Outcomes, NameTheFailedNeedOfASkippedActuatorThoughOthersMayContinue) {
  config_ = MachineOf(3);
  config_.actuators[0].after = {"b"};
  In("LowPower");
  Of(0).fault = Of(1).fault = ActuatorFault{kCodeFailed, "it was degraded before"};
  RequestSwitch("Active");
  Fail(1, kLegFailed);
  EXPECT_TRUE(Of(2).command);
  Obey(2);
  EXPECT_EQ(Result().actuators[0].message, texts::NeededOneFailed("b").message);
  EXPECT_EQ(machine_.state, kActive);
}

TEST_F(Outcomes, NameTheActuatorThatFailedWhereTheNeededOneWasItselfSkipped) {
  config_ = MachineOf(3);
  config_.actuators[0].after = {"b"};
  config_.actuators[1].after = {"c"};
  In("LowPower");
  RequestSwitch("Active");
  Fail(2, kLegFailed);
  Obey(2);  // it is rolled back
  EXPECT_EQ(Result().actuators[0].message, texts::NeededOneFailed("c").message);
  EXPECT_EQ(Result().actuators[1].message, texts::NeededOneFailed("c").message);
}

TEST_F(Outcomes, DependOnThePresentStatesAndNotOnAnEarlierFault) {
  StartUp();
  Of(1).fault = ActuatorFault{kCodeFailed, "its last check had failed"};
  Of(1).checked = false;
  RequestSwitch("LowPower");
  ObeyAll();
  EXPECT_EQ(Of(1).state(), "LowPower");
  EXPECT_EQ(Result().outcome, SwitchOutcome::kDone);
  EXPECT_THAT(Result().degraded, ElementsAre("b")) << "the fault is listed anyway";
}

TEST_F(Outcomes, OfAnActuatorInAnotherStateWithAReasonAreDoneDegraded) {
  StartUp();
  Do(event::Vanished{1, kFirst + 1, true, "its process ended"});
  Forget();
  RequestSwitch("LowPower");
  ObeyAll();
  EXPECT_EQ(Result().outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_EQ(Result().reason, "b: crashed: its process ended");
}

TEST_F(Outcomes, OfTwoEquallySevereFailuresNameTheFirst) {
  StartUp();
  RequestSwitch("LowPower");
  Fail(0, kLegFailed);
  Fail(1, kLegInvalid);
  EXPECT_EQ(Result().code, kLegFailed);
}

TEST_F(Outcomes, NameTheActuatorsThatAreBackAndThatFailed) {
  In("LowPower");
  RequestSwitch("Active");
  Obey(0);
  Fail(1, kLegFailed);
  Obey(0);
  Obey(1);
  const SwitchResult result = Result();
  EXPECT_EQ(result.outcome, SwitchOutcome::kUndone);
  EXPECT_EQ(result.actuators[0].outcome, ActuatorOutcome::kUndone);
  EXPECT_EQ(result.actuators[0].message, "is back in LowPower");
  EXPECT_EQ(result.actuators[1].outcome, ActuatorOutcome::kFailed);
}

TEST_F(Outcomes, ReportAnActuatorAsBackOnlyWhenItIs) {
  In("LowPower");
  RequestSwitch("Active");
  Obey(0);
  Fail(1, kLegFailed);
  Fail(0, kLegInvalid);
  Obey(1);
  const SwitchResult result = Result();
  EXPECT_EQ(result.actuators[0].outcome, ActuatorOutcome::kFailed) << "neither done nor undone";
  EXPECT_EQ(Of(0).fault->code, kLegInvalid);
}

TEST_F(Outcomes, OfASupersededSwitchNameTheActuatorsUnderWayAndNotCommanded) {
  config_.actuators[1].after = {"a"};
  In("LowPower");
  RequestSwitch("Active");
  const RequestId up = request_;
  RequestSwitch("Error");
  EXPECT_EQ(Did<action::AnswerSetState>()[0].request, up);
  const SwitchResult result = Did<action::AnswerSetState>()[0].result;
  EXPECT_EQ(result.outcome, SwitchOutcome::kSuperseded);
  EXPECT_EQ(result.code, kCodeTargetBusy);
  EXPECT_EQ(result.actuators[0].message, "was under way");
  EXPECT_EQ(result.actuators[1].message, "nothing was sent");
  EXPECT_FALSE(Of(0).command) << "it comes after b on the way down";
  ASSERT_TRUE(Of(1).command);
  EXPECT_EQ(Of(1).command->target, "Error");
}

TEST_F(Outcomes, OfALostActuatorAreLostAndOfAStartingActuatorSkipped) {
  config_ = MachineOf(3);
  config_.actuators[2].stage = 2;
  StartUp();
  Do(event::Vanished{0, kFirst, true, "its process ended"});
  Of(2).presence = Presence::kStarting;
  RequestSwitch("LowPower");
  Obey(1);
  EXPECT_EQ(Result().actuators[0].outcome, ActuatorOutcome::kLost);
  EXPECT_EQ(Result().actuators[2].outcome, ActuatorOutcome::kSkipped);
}

TEST_F(Outcomes, OfARefusalNameTheDegradedActuators) {
  StartUp();
  Of(1).fault = ActuatorFault{kCodeFailed, "it stumbled"};
  RequestSwitch("Nowhere");
  EXPECT_THAT(Result().degraded, ElementsAre("b"));
}

TEST_F(Outcomes, KeepAnActuatorDetachedUntilASwitchIsDoneNotUndone) {
  In("Protected");
  RequestSwitch("LowPower", "a");
  Obey(0);
  ASSERT_TRUE(Of(0).held);
  RequestSwitch("Active");
  Obey(0);
  Fail(1, kLegFailed);
  Obey(0);
  Obey(1);
  EXPECT_EQ(Of(0).state(), "LowPower");
  EXPECT_TRUE(Of(0).held);
  RequestSwitch("LowPower");
  Obey(1);
  EXPECT_FALSE(Of(0).held);
}

TEST_F(Outcomes, AFailedCheckOfOneActuatorIsDoneDegradedAndNotUndone) {
  StartUp();
  RequestSwitch("SelfCheck", "a");
  Fail(0, 5009);
  EXPECT_EQ(Result().outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_FALSE(Of(0).checked);
}

TEST_F(Outcomes, OfAnActuatorThatKeepsItsStateAreUndone) {
  StartUp();
  RequestSwitch("LowPower", "a");
  Fail(0, kLegFailed);
  EXPECT_EQ(Result().outcome, SwitchOutcome::kUndone);
}

TEST_F(Outcomes, OfAnActuatorThatHasNotReceivedItsCommandAreUndoneAndNotDegraded) {
  StartUp();
  RequestSwitch("LowPower", "a");
  const CommandNumber number = Of(0).command.value().number;
  Pass(Milliseconds(100));  // it is queried
  Do(event::Replied{0, number, true, Verdict::kDone, kCodeOk, "", Report(0, "Active")});
  EXPECT_EQ(Result().outcome, SwitchOutcome::kUndone);
  EXPECT_THAT(Result().degraded, IsEmpty());
}

// The search found that such a reply replaced "crashed" with the failure of the callback.
TEST_F(Outcomes, OfAProcessThatHasExitedDoNotChangeWhenItsReplyArrivesLate) {
  StartUp();
  RequestSwitch("LowPower");
  const CommandNumber number = Of(0).command.value().number;
  Do(event::Vanished{0, kFirst, true, "its process ended"});
  ASSERT_TRUE(Of(0).fault);
  ASSERT_THAT(Of(0).fault, Is(texts::Crashed("its process ended")));
  ActuatorReport late = Report(0, "Active");
  late.number = late.outcome_number = number;
  late.outcome_code = kCodeFailed;
  late.outcome_message = "the motor stalls";
  Do(event::Replied{0, number, false, Verdict::kFailed, kCodeFailed, "the motor stalls", late});
  EXPECT_THAT(Of(0).fault, Is(texts::Crashed("its process ended")));
}

// Its command has been sent, and no status that it is busy has arrived yet.
TEST_F(Outcomes, DoNotDependOnALateActuatorThatIsAboutToBeChecked) {
  config_ = MachineOf(3);
  StartUp();
  Do(event::Vanished{2, kFirst + 2, true, "its process ended"});
  ActuatorReport report = Report(2);
  report.incarnation += 100;
  Say(2, report);
  report.epoch = machine_.epoch;
  Do(event::Replied{2, 0, true, Verdict::kDone, kCodeOk, "", report});
  ASSERT_EQ(Of(2).command.value().target, "SelfCheck");
  RequestSwitch("LowPower");
  Obey(0);
  Obey(1);
  EXPECT_EQ(Result().outcome, SwitchOutcome::kDone) << Result().reason;
  EXPECT_THAT(Result().degraded, IsEmpty());
}

TEST_F(Outcomes, AnActuatorRestartedBeforeItsRollbackIsDrivenOnItsOwn) {
  config_.actuators[1].after = {"a"};
  In("LowPower");
  RequestSwitch("Active");
  Obey(0);
  Fail(1, kLegFailed);
  ASSERT_TRUE(Of(1).command) << "the reverse order";
  ActuatorReport report = Report(0);
  report.incarnation += 100;
  report.epoch = 0;
  Say(0, report);
  report.epoch = machine_.epoch;
  Do(event::Replied{0, 0, true, Verdict::kDone, kCodeOk, "", report});
  Obey(1);
  EXPECT_EQ(Of(0).command.value().target, "SelfCheck");
  ObeyAll();
  EXPECT_FALSE(Of(0).fault);
  EXPECT_EQ(Of(0).state(), "LowPower");
}

TEST_F(Outcomes, AnActuatorFoundInAnotherStateWithoutACheckHasItsOwnCode) {
  StartUp();
  Do(event::Vanished{0, kFirst, true, "its process ended"});
  ActuatorReport report = Report(0, "Error");
  report.incarnation += 100;
  report.epoch = 0;
  Say(0, report);
  report.epoch = machine_.epoch;
  Do(event::Replied{0, 0, true, Verdict::kDone, kCodeOk, "", report});
  ASSERT_TRUE(Of(0).fault);
  EXPECT_EQ(Of(0).fault->code, kCodeStatusError);
}

TEST_F(Outcomes, TheNameOfAnUnknownActuatorIsShortened) {
  StartUp();
  RequestSwitch("LowPower", std::string(100, 'x'));
  EXPECT_NE(Result().reason.find("'" + std::string(64, 'x') + "'"), std::string::npos);
}

TEST_F(Outcomes, AContradictingStateIsShortened) {
  StartUp();
  RequestSwitch("LowPower");
  const PendingCommand command = Of(0).command.value();
  Do(event::Replied{0, command.number, false, Verdict::kDone, kCodeOk, "",
                    Report(0, State(std::string(100, 'x')))});
  const std::string contradiction = texts::ContradictedBy(State(std::string(64, 'x'))).message;
  EXPECT_TRUE(IsRecorded(texts::CommandEnded("a", "LowPower", ActuatorOutcome::kFailed,
                                             Duration::zero(), contradiction)));
}

TEST_F(Outcomes, ListAnActuatorThatCameBackDuringTheSwitchWithoutItsSelfCheck) {
  StartUp();
  Do(event::Vanished{1, kFirst + 1, false, "connection lost"});
  Forget();
  RequestSwitch("LowPower");
  ASSERT_TRUE(Of(0).command);
  now_ += Milliseconds(1);
  Come(1, "Error");
  ASSERT_FALSE(Of(1).fault);
  Obey(0);
  EXPECT_THAT(Result().degraded, ElementsAre("b"));
  ASSERT_TRUE(Of(1).fault);
  EXPECT_EQ(Of(1).fault->code, kCodeStatusError);
}

TEST_F(Outcomes, OfATearDownDoNotNameTheEndOfAKeep) {
  config_.policy.emplace();
  StartUp();
  Do(event::PolicyRequested{1, PolicyRequest::kKeep, "Protected", 60, false});
  ObeyAll();
  ASSERT_TRUE(machine_.policy.keep);
  Do(event::SetStateRequested{2, "TearDown", {}});
  ObeyAll();
  ASSERT_TRUE(machine_.stopping && machine_.stopping->result);
  EXPECT_EQ(machine_.stopping->result->reason, "");
}

}  // namespace musher::testing::outcome_test
