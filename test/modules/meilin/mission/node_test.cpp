// The nodes around Move and Fetch, each in a small tree.

#include "musher/test/modules/meilin/mission/match.hpp"

namespace musher::meilin::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::StartsWith;
using tree::Status;

struct MeilinNode : ::testing::Test {
  Match& Play(const std::string& xml, double seconds = 5) {
    Make(xml).Run(seconds);
    return *match;
  }
  Match& Make(const std::string& xml) {
    match = std::make_unique<Match>(Match::FromText{xml});
    return *match;
  }
  void EndAll(Outcome outcome) {
    match->robot.decide = [outcome](const FakeGoal&) { return outcome; };
  }
  std::unique_ptr<Match> match;
};

TEST_F(MeilinNode, AlignAndMoveToPoseSendTheSameGoal) {
  Play(
      "<Sequence><Align target_x=\"1\" target_y=\"2\" target_yaw=\"0\"/>"
      "<MoveToPose target_x=\"1\" target_y=\"2\" target_yaw=\"0\" frame_id=\"map\"/></Sequence>");
  EXPECT_THAT(match->robot.Texts(), ElementsAre("move 1.00 2.00 0", "move 1.00 2.00 0"));
  EXPECT_EQ(match->last, Status::kSuccess);
}
TEST_F(MeilinNode, AnAlignDoesNotDriveOverAnotherHeightUnlessAClimbRunsBesideIt) {
  const auto drive = [this](const std::string& more, double x_m, double y_m) {
    Make("<Align target_x=\"2.4\" target_y=\"2.4\" target_yaw=\"0\" " + more + "/>");
    match->robot.fix = PoseFix{x_m, y_m, 0, match->robot.Now()};
    match->Run(5);
    return match->robot.goals.size();
  };
  EXPECT_EQ(drive("", 1.2, 2.4), 0U);
  EXPECT_THAT(match->mission.last_error(),
              ::testing::HasSubstr("crosses (1, 1), which has 200 mm"));
  EXPECT_EQ(drive("", 0.2, 2.4), 0U) << "from outside of the field";
  EXPECT_EQ(drive("level=\"false\"", 1.2, 2.4), 1U);
  EXPECT_EQ(drive("", 2.3, 2.4), 1U);
}
TEST_F(MeilinNode, ArmActionThatDoesNotWaitLeavesItsGoal) {
  Make("<ArmAction command=\"2\" wait_result=\"false\"/>");
  EndAll({GoalState::kAccepted});
  match->Run(5);
  EXPECT_EQ(match->last, Status::kSuccess);
  EXPECT_EQ(match->robot.Running(), 1U);
}
TEST_F(MeilinNode, SuspensionControlReportsItsEnd) {
  Make("<SuspensionControl mode=\"3\" height=\"30\" message=\"{m}\" final_state=\"{s}\"/>");
  EndAll({GoalState::kSucceeded, "Direct height set"});
  match->Run(5);
  EXPECT_EQ(match->tree->board().Get<std::string>("m").value(), "Direct height set");
  EXPECT_EQ(match->tree->board().Get<int>("s").value(), 7);
}
TEST_F(MeilinNode, SpearActionTimesOutAndCancels) {
  Make("<SpearAction command=\"3\" timeout_sec=\"2\"/>");
  EndAll({GoalState::kAccepted});
  match->Run(5);
  EXPECT_THAT(match->mission.last_error(), StartsWith("SpearAction timed out"));
  EXPECT_EQ(match->robot.Running(), 0U);
}
TEST_F(MeilinNode, AHaltCancelsTheGoal) {
  Make("<SpearAction command=\"3\"/>");
  EndAll({GoalState::kAccepted});
  match->Tick();
  ASSERT_TRUE(match->tree->Halt(match->robot.Now()));
  EXPECT_TRUE(match->robot.goals.front()->cancelled);
}
TEST_F(MeilinNode, WaitForR1SignalNeedsAReadyPartnerSinceItHasStarted) {
  Make("<WaitForR1Signal timeout_sec=\"1\"/>");
  FakeRobot::Raise(match->robot.r1, true);  // before the node has started
  match->RunFor(0.5);
  EXPECT_EQ(match->last, Status::kRunning);
  FakeRobot::Raise(match->robot.r1, true);
  FakeRobot::Raise(match->robot.r1, false);
  match->Tick();
  EXPECT_EQ(match->last, Status::kRunning) << "it is not ready any more";
  FakeRobot::Raise(match->robot.r1, true);
  match->Tick();
  EXPECT_EQ(match->last, Status::kSuccess);
}
TEST_F(MeilinNode, WaitForR1SignalCountsAPartnerThatIsReadyWhileTheDockIsExtended) {
  Make("<Sequence><SpearAction command=\"3\"/><WaitForR1Signal timeout_sec=\"1\"/></Sequence>");
  FakeRobot::Raise(match->robot.r1, true);  // of the match before
  EndAll({GoalState::kSucceeded, "", Milliseconds(200)});
  match->Tick();
  FakeRobot::Raise(match->robot.r1, true);
  match->robot.r1_stays = true;
  match->Run(0.5);
  EXPECT_EQ(match->last, Status::kSuccess);
}
TEST_F(MeilinNode, APartnerThatStaysReadyIsReadyWhenTheDockIsTriedAgain) {
  Make(
      "<RetrySegment num_attempts=\"2\"><Sequence><SpearAction command=\"3\"/>"
      "<WaitForR1Signal timeout_sec=\"1\"/><SpearAction command=\"4\"/></Sequence></RetrySegment>");
  match->robot.r1_stays = true;
  match->robot.decide = [this](const FakeGoal& goal) {
    const bool first = match->robot.goals.size() < 2;
    return goal.spear.command == 4 && first ? Outcome{GoalState::kFailed, "jammed"} : Outcome{};
  };
  match->Tick();
  FakeRobot::Raise(match->robot.r1, true);  // the only message of it
  match->Run(5);
  EXPECT_EQ(match->last, Status::kSuccess) << match->mission.last_error();
  EXPECT_THAT(match->robot.Texts(), ElementsAre("spear 3", "spear 4", "spear 3", "spear 4"));
}
TEST_F(MeilinNode, WaitForR1SignalHasALimit) {
  Play("<WaitForR1Signal timeout_sec=\"1\"/>");
  EXPECT_EQ(match->last, Status::kFailure);
  EXPECT_THAT(match->mission.last_error(), StartsWith("WaitForR1Signal timed out"));
}
TEST_F(MeilinNode, WaitArmIdle) {
  Play("<WaitArmIdle timeout_sec=\"1\"/>");
  EXPECT_THAT(match->mission.last_error(), StartsWith("WaitArmIdle timed out"));
  Make("<WaitArmIdle timeout_sec=\"1\"/>");
  match->Tick();
  FakeRobot::Raise(match->robot.arm, true);
  match->Tick();
  EXPECT_EQ(match->last, Status::kSuccess);
}
TEST_F(MeilinNode, WaitArmIdleDoesNotBelieveWhatAnArmThatIsSilentHasSaid) {
  Make("<WaitArmIdle timeout_sec=\"1\"/>");
  FakeRobot::Raise(match->robot.arm, true);
  match->robot.Advance(Milliseconds(10));
  match->robot.arm_reports = false;
  match->robot.Advance(Milliseconds(1100));
  match->RunFor(2);
  EXPECT_THAT(match->mission.last_error(),
              ::testing::HasSubstr("no message of the arm comes any more"));
}
TEST_F(MeilinNode, WaitSecondsWaits) {
  Make("<WaitSeconds seconds=\"0.5\"/>");
  match->RunFor(0.4);
  EXPECT_EQ(match->last, Status::kRunning);
  match->RunFor(0.2);
  EXPECT_TRUE(match->rests);
}
TEST_F(MeilinNode, RetrySegmentTriesSoOften) {
  Make("<RetrySegment num_attempts=\"3\"><SpearAction command=\"1\"/></RetrySegment>");
  EndAll({GoalState::kFailed, "broken"});
  match->Run(5);
  EXPECT_EQ(match->robot.goals.size(), 3U);
  EXPECT_EQ(match->last, Status::kFailure);
  EXPECT_EQ(match->board->retry_count.Get(), 3);
}
TEST_F(MeilinNode, SwitchSegmentTypeTakesTheChildOfThatName) {
  const auto ticked = [this](const std::string& type) {
    Play("<SwitchSegmentType segment_type=\"" + type +
         "\"><SpearAction name=\"a\" command=\"1\"/><SpearAction name=\"b\" command=\"2\"/>"
         "<SpearAction name=\"default\" command=\"4\"/></SwitchSegmentType>");
    return match->robot.Texts();
  };
  EXPECT_THAT(ticked("b"), ElementsAre("spear 2"));
  EXPECT_THAT(ticked("a"), ElementsAre("spear 1"));
  EXPECT_THAT(ticked("c"), ElementsAre("spear 4"));
  Play("<SwitchSegmentType segment_type=\"c\"><SpearAction command=\"1\"/></SwitchSegmentType>");
  EXPECT_EQ(match->last, Status::kFailure);
}
TEST_F(MeilinNode, ATreeAsTheDocumentsDrawItRunsAPlanAndWarnsOfWhatIsMeantByName) {
  Make(R"(<ForEachSegment><Sequence>
    <PopNextMeilinSegment queue="{segment_queue}" segment_type="{segment_type}"
        move_row="{move_row}" move_col="{move_col}" target_height_mm="{target_height_mm}"
        kfs_row="{kfs_row}" kfs_col="{kfs_col}" height_diff="{height_diff}"
        target_yaw="{target_yaw}"/>
    <SwitchSegmentType>
      <Move segment_type="move" move_row="{move_row}" move_col="{move_col}"
            target_height_mm="{target_height_mm}" target_yaw="{target_yaw}"/>
      <Fetch segment_type="fetch" kfs_row="{kfs_row}" kfs_col="{kfs_col}"
             height_diff="{height_diff}" target_yaw="{target_yaw}"/>
      <ForceSuccess segment_type="PLAN_DONE" />
    </SwitchSegmentType></Sequence></ForEachSegment>)");
  ASSERT_EQ(match->drawn.size(), 4U);
  for (const Diagnostic& each : match->drawn) EXPECT_EQ(each.severity, Severity::kWarning);
  EXPECT_THAT(FormatDiagnostic(match->drawn[0]),
              ::testing::EndsWith(":7:13: warning: a child of <SwitchSegmentType> is chosen by its "
                                  "name; segment_type=\"move\" is read as name=\"move\""));
  ASSERT_TRUE(match->Offer({MoveStep(0, 1, 0), FetchStep(1, 1, 200)}));
  match->Run(20);
  EXPECT_EQ(match->last, Status::kSuccess) << match->mission.last_error();
  EXPECT_EQ(match->mission.state(), "MISSION_SUCCESS");
  EXPECT_EQ(match->robot.Texts().back(), "arm 1");
}
TEST_F(MeilinNode, ANameThatContradictsTheSegmentTypeOfAChildIsAnError) {
  tree::Reading reading = tree::ReadTree(
      R"(<root BTCPP_format="4"><BehaviorTree ID="Main"><SwitchSegmentType>
           <Move name="fetch" segment_type="move"/><Move name="move" segment_type="move"/>
         </SwitchSegmentType></BehaviorTree></root>)",
      "t.xml");
  ASSERT_TRUE(reading.ok());
  const std::vector<Diagnostic> found = AcceptDrawnForm(reading.document);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].severity, Severity::kError);
  EXPECT_THAT(found[0].message, ::testing::HasSubstr("segment_type=\"move\" contradicts it"));
  EXPECT_EQ(found[1].severity, Severity::kWarning);
}
TEST_F(MeilinNode, ConditionsLookAtTexts) {
  const auto is = [this](const std::string& xml) { return Play(xml).last == Status::kSuccess; };
  EXPECT_TRUE(is("<IsStringEmpty value=\"\"/>"));
  EXPECT_FALSE(is("<IsStringEmpty value=\"a\"/>"));
  EXPECT_TRUE(is("<IsStringNonEmpty value=\"a\"/>"));
  EXPECT_TRUE(is("<IsSegmentType segment_type=\"move\" expected_type=\"move\"/>"));
  EXPECT_FALSE(is("<IsSegmentType segment_type=\"move\" expected_type=\"fetch\"/>"));
}
TEST_F(MeilinNode, PopNextMeilinSegmentWithoutAQueueSaysSo) {
  Make("<PopNextMeilinSegment queue=\"{nothing}\"/>");
  match->Tick();
  EXPECT_EQ(match->last, Status::kRunning);
  EXPECT_EQ(match->mission.last_error(), "Missing meilin segment_queue");
  EXPECT_EQ(match->mission.state(), "WAITING_MF_ACTION_SEQ");
}
TEST_F(MeilinNode, PopNextSegmentHasTheFieldsOfOldPlans) {
  Make("<PopNextSegment queue=\"{segment_queue}\" target_x=\"{x}\" arm_command=\"{a}\"/>");
  ASSERT_TRUE(match->OfferOld(
      R"({"segment_type": "ALIGN", "move_target": {"x": 1.5, "y": 0}, "arm_command": 7})"));
  match->Tick();
  EXPECT_EQ(match->tree->board().Get<double>("x").value(), 1.5);
  EXPECT_EQ(match->tree->board().Get<int>("a").value(), 7);
  EXPECT_EQ(match->board->segment_type.Get(), "ALIGN");
}

}  // namespace
}  // namespace musher::meilin::testing
