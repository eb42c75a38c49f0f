// XML as BehaviorTree.CPP's users write it, and rules of BehaviorTree.CPP that the other tests do
// not look at. Where the engine differs, docs/behavior-trees.md cites the test.

#include "musher/test/behavior/tree/trees.hpp"

namespace musher::tree::btcpp_test {

using testing::HasSubstr;

using Btcpp = TickedTree;

TEST_F(Btcpp, SpacesAroundTheEqualsSignAndRawOperatorsAreRead) {
  EXPECT_EQ(Run("<Sequence><Script  code = \" x := 1 \" />" + Leaf("a", "S", "_skipIf=\"x<2\"") +
                    "<ScriptCondition code=\" x==1 && true \"/></Sequence>",
                1),
            "S ");
  EXPECT_THAT(Findings(Main("<Script  code = \" x := \" />")), HasSubstr("t.xml:3:24: error: "));
}
TEST_F(Btcpp, OldNamesAreUnknown) {
  EXPECT_THAT(Findings(Main("<SequenceStar><AlwaysSuccess/></SequenceStar>")),
              HasSubstr("there is no node 'SequenceStar'"));
}
TEST_F(Btcpp, ATreeMayHaveNoName) {
  const auto nameless =
      MakeTree("<root BTCPP_format=\"4\"><BehaviorTree><AlwaysSuccess/></BehaviorTree></root>");
  EXPECT_EQ(Ticks(*nameless, 1), "S");
}
TEST_F(Btcpp, AnAssignmentMaySetAnEntryThatAPortUses) {
  const std::string xml =
      "<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\"><BehaviorTree ID=\"Main\"><Sequence>"
      "<Script code=\"ms = 10\"/><SubTree ID=\"Part\" time_ms=\"{ms}\"/></Sequence></BehaviorTree>"
      "<BehaviorTree ID=\"Part\"><Sleep msec=\"{time_ms}\"/></BehaviorTree></root>";
  EXPECT_EQ(Ticks(*MakeTree(xml), 2), "RS");
}
TEST_F(Btcpp, ConditionsBeforeTheStartAreEvaluatedInTheirOrder) {
  const std::string all = "_skipIf=\"x == 1\" _successIf=\"x &lt;= 2\" _failureIf=\"x == 3\"";
  for (const auto& [x, letter] :
       std::vector<std::pair<double, std::string>>{{1, "S "}, {2, "S "}, {3, "F "}, {4, "S a^ "}}) {
    tree = MakeTree(Main(Leaf("a", "S", all)), factory);
    ASSERT_TRUE(tree->board().Set("x", x));
    const std::string letters = Ticks(*tree, 1);
    EXPECT_EQ(letters + " " + Take(), letter) << x;
  }
}
TEST_F(Btcpp, ScriptsAfterTheEndRunAlsoWhereAConditionDecides) {
  tree = MakeTree(
      Main(Leaf("a", "S", "_failureIf=\"true\" _onFailure=\"f := 1\" _post=\"p := 1\"")), factory);
  EXPECT_EQ(Ticks(*tree, 1), "F");
  EXPECT_EQ(tree->board().Get<int>("f").value(), 1);
  EXPECT_EQ(tree->board().Get<int>("p").value(), 1);
}
TEST_F(Btcpp, WhileHaltsANodeThatRunsAndSkipsIt) {
  tree = MakeTree(Main("<Sequence>" + Leaf("a", "R", "_while=\"go\" _onHalted=\"h := 1\"") +
                       Leaf("b", "S") + "</Sequence>"),
                  factory);
  ASSERT_TRUE(tree->board().Set("go", true));
  EXPECT_EQ(Ticks(*tree, 1), "R");
  ASSERT_TRUE(tree->board().Set("go", false));
  EXPECT_EQ(Ticks(*tree, 1, 1), "S");
  EXPECT_EQ(Take(), "a^ a! b^ ");
  EXPECT_EQ(tree->board().Get<int>("h").value(), 1);
}
TEST_F(Btcpp, ParallelEndsInTheMiddleOfATick) {
  EXPECT_EQ(Run("<Parallel success_count=\"1\">" + Leaf("a", "R") + Leaf("b", "S") +
                    Leaf("c", "S") + "</Parallel>",
                1),
            "S a^ b^ a! ");
}
TEST_F(Btcpp, NegativeThresholdsCountFromAllChildren) {
  EXPECT_EQ(Run("<Parallel success_count=\"-2\" failure_count=\"-2\">" + Leaf("a", "F") +
                    Leaf("b", "S") + Leaf("c", "S") + "</Parallel>",
                1),
            "S a^ b^ c^ ");
  EXPECT_EQ(
      Run("<ParallelAll max_failures=\"-1\">" + Leaf("a", "F") + Leaf("b", "S") + "</ParallelAll>",
          1),
      "S a^ b^ ");
}
TEST_F(Btcpp, RepeatKeepsItsCountWhenItsChildIsSkipped) {
  tree = MakeTree(
      Main("<Repeat num_cycles=\"2\">" + Leaf("a", "S", "_skipIf=\"no\"") + "</Repeat>"), factory);
  ASSERT_TRUE(tree->board().Set("no", false));
  EXPECT_EQ(Ticks(*tree, 1), "R");
  ASSERT_TRUE(tree->board().Set("no", true));
  EXPECT_EQ(Ticks(*tree, 1, 1), "-");
  ASSERT_TRUE(tree->board().Set("no", false));
  EXPECT_EQ(Ticks(*tree, 1, 2), "S");
}
TEST_F(Btcpp, RepeatOfZeroSucceedsWithoutItsChild) {
  EXPECT_EQ(Run("<Repeat num_cycles=\"0\">" + Leaf("a", "F") + "</Repeat>", 1), "S ");
  EXPECT_EQ(
      Run("<RetryUntilSuccessful num_attempts=\"0\">" + Leaf("a", "S") + "</RetryUntilSuccessful>",
          1),
      "F ");
}
// There the time goes on, because the node stays RUNNING until its parent ends.
TEST_F(Btcpp, DelayAndTimeoutBeginAgainAfterASkippedChild) {
  const std::string child = Leaf("a", "S", "_skipIf=\"no\"");
  tree = MakeTree(Main("<Delay delay_msec=\"10\">" + child + "</Delay>"), factory);
  ASSERT_TRUE(tree->board().Set("no", true));
  EXPECT_EQ(Ticks(*tree, 2), "R-");
  ASSERT_TRUE(tree->board().Set("no", false));
  EXPECT_EQ(Ticks(*tree, 2, 2), "RS");
  tree = MakeTree(Main("<Timeout msec=\"20\">" + Leaf("b", "R", "_skipIf=\"no\"") + "</Timeout>"),
                  factory);
  ASSERT_TRUE(tree->board().Set("no", true));
  EXPECT_EQ(Ticks(*tree, 1), "-");
  ASSERT_TRUE(tree->board().Set("no", false));
  EXPECT_EQ(Ticks(*tree, 3, 5), "RRF");
}
TEST_F(Btcpp, LoopsTakeTheNextValueAfterASkippedChild) {
  EXPECT_EQ(Run("<LoopInt queue=\"1;2\" value=\"{x}\">" + Leaf("a", "S", "_skipIf=\"x == 1\"") +
                    "</LoopInt>",
                3),
            "RRS a^ ");
}
// There numbers that differ by less than 1e-7 are equal.
TEST_F(Btcpp, SwitchComparesWholeTextsAndEqualNumbers) {
  tree = MakeTree(Main("<Switch2 variable=\"{v}\" case_1=\"1\" case_2=\"2.0\">" + Leaf("a", "S") +
                       Leaf("b", "S") + Leaf("c", "S") + "</Switch2>"),
                  factory);
  for (const auto& [value, log] : std::vector<std::pair<std::string, std::string>>{
           {"1", "a^ "}, {"1.0", "a^ "}, {"2", "b^ "}, {"1x", "c^ "}, {"1.00000001", "c^ "}}) {
    ASSERT_TRUE(tree->board().Set("v", value));
    EXPECT_EQ(Ticks(*tree, 1), "S");
    EXPECT_EQ(Take(), log) << value;
  }
}
TEST_F(Btcpp, KeepRunningUntilFailureRunsOnAfterASkippedChild) {
  EXPECT_EQ(Run("<KeepRunningUntilFailure>" + Leaf("a", "SF", "_skipIf=\"false\"") +
                    "</KeepRunningUntilFailure>",
                2),
            "RF a^ a^ ");
  EXPECT_EQ(Run("<KeepRunningUntilFailure>" + Leaf("a", "S", "_skipIf=\"true\"") +
                    "</KeepRunningUntilFailure>",
                2),
            "RR ");
}
TEST_F(Btcpp, ModelsOfSubtreesGiveDefaultsAndRemapOutputs) {
  const std::string xml =
      "<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\"><TreeNodesModel><SubTree ID=\"Part\">"
      "<input_port name=\"level\" default=\"42\"/><output_port name=\"result\" "
      "default=\"{found}\"/>"
      "</SubTree></TreeNodesModel><BehaviorTree ID=\"Main\"><Sequence><SubTree ID=\"Part\"/>"
      "<ScriptCondition code=\"found == 43\"/></Sequence></BehaviorTree>"
      "<BehaviorTree ID=\"Part\"><Script code=\"result := level + 1\"/></BehaviorTree></root>";
  EXPECT_EQ(Ticks(*MakeTree(xml), 1), "S");
}

}  // namespace musher::tree::btcpp_test
