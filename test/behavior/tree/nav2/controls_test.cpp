// The controls, tick by tick, as nav2 documents them.
// "a^" is a's first tick, "a" a further one, "a!" its halt.

#include "musher/test/behavior/tree/nav2/fake_robot.hpp"

namespace musher::tree::nav2::controls_test {

std::string Control(const std::string& name, const std::string& a, const std::string& b,
                    const std::string& c = "") {
  return "<" + name + ">" + SayXml("a", a) + SayXml("b", b) + (c.empty() ? "" : SayXml("c", c)) +
         "</" + name.substr(0, name.find(' ')) + ">";
}

using APipelineSequence = Nav2Tree;
TEST_F(APipelineSequence, TicksTheChildrenBeforeThePresentOneAgain) {
  // The example of the documentation: A runs; succeeds; runs beside B and C; is halted at the end.
  Make(Control("PipelineSequence", "RSRR", "RSS", "RS"));
  EXPECT_EQ(NextTicks(4),
            "R a^ \n"
            "R a b^ \n"
            "R a^ b c^ \n"
            "S a b^ c a! \n");
}
TEST_F(APipelineSequence, DoesNotPassAChildThatRunsBeforeItHasSucceededOnce) {
  Make(Control("PipelineSequence", "RRS", "S", "S"));
  EXPECT_EQ(NextTicks(3), "R a^ \nR a \nS a b^ c^ \n");
}
TEST_F(APipelineSequence, FailsWithAnyChildAndHaltsTheOthers) {
  Make(Control("PipelineSequence", "SF", "R"));
  EXPECT_EQ(NextTicks(2), "R a^ b^ \nF a^ b! \n");
  Make(Control("PipelineSequence", "SR", "RF"));
  EXPECT_EQ(NextTicks(2), "R a^ b^ \nF a^ b a! \n");
}
TEST_F(APipelineSequence, BeginsWithItsFirstChildAfterAHalt) {
  Make(Control("PipelineSequence", "SR", "R"));
  EXPECT_EQ(NextTicks(2), "R a^ b^ \nR a^ b \n");
  ASSERT_TRUE(tree->Halt(At(now_ms)));
  EXPECT_EQ(Take(), "a! b! ");
  EXPECT_EQ(NextTicks(2), "R a^ b^ \nR a^ b \n") << "a succeeds, then runs";
}
TEST_F(APipelineSequence, PassesOverSkippedChildrenAndIsSkippedWhereAllAre) {
  Make(Control("PipelineSequence", "-", "S", "-"));
  EXPECT_EQ(Next(), "S a^ b^ c^ ");
  Make(Control("PipelineSequence", "-", "-"));
  EXPECT_EQ(Next(), "- a^ b^ ");
}

using ARecoveryNode = Nav2Tree;
TEST_F(ARecoveryNode, SucceedsWithItsFirstChildAndDoesNotTickTheSecond) {
  Make(Control("RecoveryNode", "RS", "S"));
  EXPECT_EQ(NextTicks(2), "R a^ \nS a \n");
}
TEST_F(ARecoveryNode, TicksTheFirstChildAgainAfterARecovery) {
  Make(Control("RecoveryNode", "FRS", "RS"));
  EXPECT_EQ(NextTicks(3), "R a^ b^ \nR b a^ \nS a \n");
}
TEST_F(ARecoveryNode, FailsWhereTheRecoveryFails) {
  Make(Control("RecoveryNode number_of_retries=\"5\"", "F", "RF"));
  EXPECT_EQ(NextTicks(2), "R a^ b^ \nF b \n");
}
TEST_F(ARecoveryNode, RecoversSoManyTimesAndHasOneMoreAttempt) {
  Make(Control("RecoveryNode", "F", "S"));
  EXPECT_EQ(Next(), "F a^ b^ a^ ");
  Make(Control("RecoveryNode number_of_retries=\"3\"", "F", "S"));
  EXPECT_EQ(Next(), "F a^ b^ a^ b^ a^ b^ a^ ");
  EXPECT_EQ(Next(), "F a^ b^ a^ b^ a^ b^ a^ ") << "each run counts from 0";
  Make(Control("RecoveryNode number_of_retries=\"0\"", "F", "S"));
  EXPECT_EQ(Next(), "F a^ ");
}
TEST_F(ARecoveryNode, CountsAgainAfterAHalt) {
  Make(Control("RecoveryNode number_of_retries=\"1\"", "FR", "S"));
  EXPECT_EQ(Next(), "R a^ b^ a^ ");
  ASSERT_TRUE(tree->Halt(At(now_ms)));
  EXPECT_EQ(Take(), "a! ");
  EXPECT_EQ(Next(), "R a^ b^ a^ ") << "its one recovery is there again";
}
TEST_F(ARecoveryNode, HaltsTheRecoveryThatRuns) {
  Make(Control("RecoveryNode", "F", "R"));
  EXPECT_EQ(Next(), "R a^ b^ ");
  ASSERT_TRUE(tree->Halt(At(now_ms)));
  EXPECT_EQ(Take(), "b! ");
}
TEST_F(ARecoveryNode, IsSkippedWithItsFirstChildAndFailsWhereTheRecoveryIsSkipped) {
  Make(Control("RecoveryNode", "-", "S"));
  EXPECT_EQ(Next(), "- a^ ");
  Make(Control("RecoveryNode", "F", "-"));
  EXPECT_EQ(Next(), "F a^ b^ ");
}
TEST_F(ARecoveryNode, NeedsTwoChildren) {
  EXPECT_THAT(Findings(Main("<RecoveryNode><AlwaysSuccess/></RecoveryNode>"), factory),
              testing::HasSubstr("node 'RecoveryNode' has 1 child; expected 2"));
}

using ANonblockingSequence = Nav2Tree;
TEST_F(ANonblockingSequence, TicksAllItsChildrenUntilAllSucceedInOneTick) {
  Make(Control("NonblockingSequence", "RS", "S", "RRS"));
  EXPECT_EQ(NextTicks(3),
            "R a^ b^ c^ \n"
            "R a b^ c \n"
            "R a^ b^ c \n");
  EXPECT_EQ(Next(), "R a b^ c^ ");
  Make(Control("NonblockingSequence", "RS", "RS"));
  EXPECT_EQ(NextTicks(3), "R a^ b^ \nS a b \nR a^ b^ \n");
}
TEST_F(ANonblockingSequence, FailsWithAnyChildAndHaltsTheOthers) {
  Make(Control("NonblockingSequence", "R", "RF", "R"));
  EXPECT_EQ(NextTicks(2), "R a^ b^ c^ \nF a b a! c! \n");
}
TEST_F(ANonblockingSequence, IsSkippedWhereAllAreAndHaltsWhatRuns) {
  Make(Control("NonblockingSequence", "-", "-"));
  EXPECT_EQ(Next(), "- a^ b^ ");
  Make(Control("NonblockingSequence", "-", "S"));
  EXPECT_EQ(Next(), "S a^ b^ ");
  Make(Control("NonblockingSequence", "R", "S", "R"));
  EXPECT_EQ(Next(), "R a^ b^ c^ ");
  ASSERT_TRUE(tree->Halt(At(now_ms)));
  EXPECT_EQ(Take(), "a! c! ");
}

struct APersistentSequence : Nav2Tree {
  int Place() { return tree->board().Get<int>("current_child_idx").value(); }
};
TEST_F(APersistentSequence, IsASequenceThatCountsInItsEntry) {
  Make(Control("PersistentSequence", "S", "RS", "S"));
  EXPECT_EQ(Next(), "R a^ b^ ");
  EXPECT_EQ(Place(), 1);
  EXPECT_EQ(Next(), "S b c^ ");
  EXPECT_EQ(Place(), 0) << "it begins with its first child again";
  Make(Control("PersistentSequence", "-", "-"));
  EXPECT_EQ(Next(), "- a^ b^ ");
}
TEST_F(APersistentSequence, GoesOnWhereItWasAfterAHaltAndAfterAFailure) {
  Make(Control("PersistentSequence", "S", "RFS", "S"));
  EXPECT_EQ(Next(), "R a^ b^ ");
  ASSERT_TRUE(tree->Halt(At(now_ms)));
  EXPECT_EQ(Take(), "b! ");
  EXPECT_EQ(Next(), "F b^ ");
  EXPECT_EQ(Place(), 1);
  EXPECT_EQ(Next(), "S b^ c^ ");
}
TEST_F(APersistentSequence, GoesToTheChildThatAnotherNodeSets) {
  Make(Control("PersistentSequence current_child_idx=\"{at}\"", "R", "S", "R"));
  Put("at", 2);
  EXPECT_EQ(Next(), "R c^ ");
  Put("at", 0);
  EXPECT_EQ(Next(), "R c! a^ ");
}
TEST_F(APersistentSequence, WithoutSuchAChildIsAFaultOfTheTree) {
  for (const int place : {-1, 2}) {
    Make(Control("PersistentSequence current_child_idx=\"{at}\"", "S", "S"));
    Put("at", place);
    EXPECT_EQ(Next(), "! ");
    EXPECT_THAT(fault, testing::HasSubstr("there is no child " + std::to_string(place) +
                                          "; expected 0 to 1"));
  }
}

using ARoundRobin = Nav2Tree;
TEST_F(ARoundRobin, GoesOnBehindTheChildThatHasSucceeded) {
  // The example of the documentation, with the way back to the first child.
  Make("<KeepRunningUntilFailure>" + Control("RoundRobin wrap_around=\"true\"", "RFR", "RS", "RF") +
       "</KeepRunningUntilFailure>");
  EXPECT_EQ(NextTicks(5),
            "R a^ \n"
            "R a b^ \n"
            "R b \n"
            "R c^ \n"
            "R c a^ \n");
}
TEST_F(ARoundRobin, FailsWhereAllChildrenHaveFailedAndBeginsAgain) {
  Make(Control("RoundRobin wrap_around=\"true\"", "F", "F"));
  EXPECT_EQ(NextTicks(2), "F a^ b^ \nF a^ b^ \n");
}
TEST_F(ARoundRobin, CountsFailuresSinceTheLastSuccess) {
  Make("<KeepRunningUntilFailure>" + Control("RoundRobin wrap_around=\"true\"", "FF", "SF", "F") +
       "</KeepRunningUntilFailure>");
  EXPECT_EQ(NextTicks(2), "R a^ b^ \nF c^ a^ b^ \n");
}
TEST_F(ARoundRobin, FailsBehindItsLastChildWhereItDoesNotWrapAround) {
  Make("<KeepRunningUntilFailure>" + Control("RoundRobin", "S", "S") +
       "</KeepRunningUntilFailure>");
  EXPECT_EQ(NextTicks(4), "R a^ \nR b^ \nF \nR a^ \n");
  Make("<KeepRunningUntilFailure>" + Control("RoundRobin", "S", "F") +
       "</KeepRunningUntilFailure>");
  EXPECT_EQ(NextTicks(3), "R a^ \nF b^ \nR a^ \n");
}
// nav2 halts all nodes when a navigation has ended.
TEST_F(ARoundRobin, BeginsWithItsFirstChildInEachRunOfTheTree) {
  Make(Control("RoundRobin", "S", "S"));
  EXPECT_EQ(NextTicks(2), "S a^ \nS a^ \n") << "after its end";
  Make("<Sequence>" + Control("RoundRobin", "S", "S") + SayXml("d", "R") + "</Sequence>");
  EXPECT_EQ(Next(), "R a^ d^ ");
  ASSERT_TRUE(tree->Halt(At(now_ms)));
  EXPECT_EQ(Take(), "d! ");
  EXPECT_EQ(Next(), "R a^ d^ ") << "after a halt in which it did not run";
  Make("<Sequence>" + Control("RoundRobin", "S", "S") + SayXml("d", "!") + "</Sequence>");
  EXPECT_EQ(NextTicks(2), "! a^ d^ \n! a^ d^ \n") << "after a fault";
}
TEST_F(ARoundRobin, BeginsWithItsFirstChildAfterAHalt) {
  Make(Control("RoundRobin", "F", "R"));
  EXPECT_EQ(Next(), "R a^ b^ ");
  ASSERT_TRUE(tree->Halt(At(now_ms)));
  EXPECT_EQ(Take(), "b! ");
  EXPECT_EQ(Next(), "R a^ b^ ");
}
TEST_F(ARoundRobin, IsSkippedWhereAllChildrenAre) {
  Make(Control("RoundRobin", "-", "-"));
  EXPECT_EQ(Next(), "- a^ b^ ");
  Make(Control("RoundRobin", "-", "F"));
  EXPECT_EQ(Next(), "F a^ b^ ");
}

// Each recovery once, in order, as in the trees of nav2.
TEST_F(ARoundRobin, GivesARecoveryNodeOneRecoveryAtATime) {
  Make("<RecoveryNode number_of_retries=\"6\">" + SayXml("go", "F") +
       Control("RoundRobin", "S", "S", "F") + "</RecoveryNode>");
  EXPECT_EQ(Next(), "F go^ a^ go^ b^ go^ c^ ");
}

class APauseResumeController : public Nav2Tree {
 protected:
  void MakeOf(const std::string& children) {
    Make("<PauseResumeController pause_service_name=\"/pause\" resume_service_name=\"/resume\">" +
         children + "</PauseResumeController>");
  }
};
TEST_F(APauseResumeController, TicksTheBranchThatTheCallsChoose) {
  MakeOf(SayXml("resumed", "RRRRS") + SayXml("paused", "RSR") + SayXml("on_pause", "RS") +
         SayXml("on_resume", "RS"));
  robot.calls["/pause"] = 3;  // before it begins
  EXPECT_EQ(NextTicks(2), "R resumed^ \nR resumed \n");
  ++robot.calls["/pause"];
  EXPECT_EQ(NextTicks(5),
            "R resumed! on_pause^ \n"
            "R on_pause \n"
            "R paused^ \n"
            "R paused \n"
            "R paused^ \n");
  ++robot.calls["/resume"];
  EXPECT_EQ(NextTicks(5),
            "R paused! on_resume^ \n"
            "R on_resume \n"
            "R resumed^ \n"
            "R resumed \n"
            "S resumed \n");
}
TEST_F(APauseResumeController, NeedsOnlyItsFirstBranch) {
  MakeOf(SayXml("a", "RRS"));
  EXPECT_EQ(Next(), "R a^ ");
  ++robot.calls["/pause"];
  EXPECT_EQ(NextTicks(3), "R a! \nR \nR \n");
  ++robot.calls["/pause"];
  EXPECT_EQ(Next(), "R ");
  ++robot.calls["/resume"];
  EXPECT_EQ(NextTicks(3), "R \nR a^ \nS a \n");
}
TEST_F(APauseResumeController, FailsWithAnyBranchAndThenBeginsResumed) {
  MakeOf(SayXml("a", "R") + SayXml("b", "R") + SayXml("c", "F"));
  EXPECT_EQ(Next(), "R a^ ");
  ++robot.calls["/pause"];
  EXPECT_EQ(NextTicks(2), "F a! c^ \nR a^ \n");
}
TEST_F(APauseResumeController, TakesACallDuringATransitionBehindIt) {
  MakeOf(SayXml("a", "R") + SayXml("b", "R") + SayXml("c", "RS") + SayXml("d", "S"));
  EXPECT_EQ(Next(), "R a^ ");
  ++robot.calls["/pause"];
  EXPECT_EQ(Next(), "R a! c^ ");
  ++robot.calls["/resume"];
  EXPECT_EQ(NextTicks(3), "R c \nR d^ \nR a^ \n");
  ++robot.calls["/pause"];
  ++robot.calls["/resume"];
  EXPECT_EQ(Next(), "R a! c^ ") << "of both the pause counts";
}

}  // namespace musher::tree::nav2::controls_test
