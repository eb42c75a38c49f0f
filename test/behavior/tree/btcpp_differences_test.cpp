// What a file does differently in BehaviorTree.CPP 4.10: each place with a case where it does and
// one where it does not.

#include "musher/behavior/tree/btcpp.hpp"
#include "musher/test/behavior/tree/trees.hpp"

namespace musher::tree::btcpp_differences_test {

using testing::HasSubstr;

std::string DifferencesOf(const std::string& xml, const Factory& factory = {}) {
  const Reading reading = ReadTree(xml, "t.xml");
  EXPECT_TRUE(reading.ok()) << Texts(reading.diagnostics);
  return Texts(DifferencesToBtcpp(reading.document, factory));
}
std::string Of(const std::string& content) {
  return DifferencesOf(Main(content));
}
std::string Script(const std::string& code) {
  return Of("<Script code=\"" + code + "\"/>");
}
const std::string kLeaf = "<AlwaysSuccess/>";
const std::string kSkipped = "<AlwaysSuccess _skipIf=\"a\"/>";

TEST(DifferencesToBtcpp, AreNoneInAnOrdinaryTree) {
  EXPECT_EQ(Of("<Sequence><Sleep msec=\"5\"/><Repeat num_cycles=\"3\"><Inverter><AlwaysFailure/>"
               "</Inverter></Repeat><Script code=\"a := 1; b = a + 2 * a; s := 'x'\"/>"
               "<Timeout msec=\"9\" _skipIf=\"a &gt; 1 &amp;&amp; b\"><AlwaysSuccess/></Timeout>"
               "<ReactiveSequence><AlwaysSuccess/><Sleep msec=\"1\"/></ReactiveSequence>"
               "<TryCatch _while=\"a\"><AlwaysSuccess/><AlwaysSuccess/></TryCatch></Sequence>"),
            "");
}
TEST(DifferencesToBtcpp, HaveTheirPlaceInTheFile) {
  EXPECT_EQ(Of("<Sequence>\n  <ManualSelector selection=\"{s}\"><AlwaysSuccess/>"
               "</ManualSelector></Sequence>"),
            "t.xml:4:3: warning: BehaviorTree.CPP 4.10 asks on the terminal of the process, which "
            "waits; here the entry of 'selection' has the answer\n");
}
TEST(DifferencesToBtcpp, OfConditionsThatAreSkipped) {
  EXPECT_THAT(Of("<IfThenElse>" + kSkipped + kLeaf + "</IfThenElse>"),
              HasSubstr("throws where this condition is skipped; here IfThenElse is skipped"));
  EXPECT_EQ(Of("<WhileDoElse>" + kLeaf + kSkipped + "</WhileDoElse>"), "");
  EXPECT_THAT(Of("<Timeout msec=\"5\">" + kSkipped + "</Timeout>"),
              HasSubstr("keeps the decorator RUNNING where this child is skipped"));
  EXPECT_THAT(Of("<Parallel>" + kSkipped + kSkipped + "</Parallel>"),
              HasSubstr("has a result by success_count where all children are skipped"));
  EXPECT_EQ(Of("<Parallel>" + kSkipped + kLeaf + "</Parallel>"), "");
}
TEST(DifferencesToBtcpp, OfAConditionOfWhileDoElseThatMayRun) {
  const std::string condition = "<Inverter><Sleep msec=\"1\"/></Inverter>";
  EXPECT_THAT(Of("<WhileDoElse>" + condition + kLeaf + "</WhileDoElse>"),
              HasSubstr("leaves the branch running without ticks while this condition is RUNNING; "
                        "here it is halted"));
  EXPECT_EQ(Of("<WhileDoElse>" + kLeaf + condition + "</WhileDoElse>"), "");
}
TEST(DifferencesToBtcpp, OfHalts) {
  EXPECT_THAT(Of("<SkipUnlessUpdated entry=\"{a}\">" + kLeaf + "</SkipUnlessUpdated>"),
              HasSubstr("does not halt the child of this node with it"));
  EXPECT_THAT(Of("<Finally>" + kLeaf + kLeaf + "</Finally>"), HasSubstr("with sleeps, in a halt"));
  EXPECT_THAT(Of("<TryCatch catch_on_halt=\"true\">" + kLeaf + kLeaf + "</TryCatch>"),
              HasSubstr("prints what the clean-up throws in a halt"));
}
TEST(DifferencesToBtcpp, OfLimits) {
  EXPECT_THAT(Of("<Repeat num_cycles=\"-1\">" + kLeaf + "</Repeat>"),
              HasSubstr("here TickOnce ticks at most 100 times"));
  const std::string sleep = "<Sleep msec=\"1\"/>";
  EXPECT_THAT(Of("<Repeat num_cycles=\"{n}\">" + sleep + "</Repeat>"),
              HasSubstr("t.xml:3:21: warning: BehaviorTree.CPP 4.10 leaves the child running where "
                        "this number becomes smaller meanwhile; here it is halted"));
  EXPECT_EQ(Of("<Repeat num_cycles=\"3\">" + sleep + "</Repeat>"), "");
  EXPECT_EQ(Of("<RetryUntilSuccessful num_attempts=\"{n}\">" + kLeaf + "</RetryUntilSuccessful>"),
            "");
  EXPECT_THAT(Of("<Switch2 variable=\"{v}\" case_1=\"1.5\" case_2=\"2\">" + kLeaf + kLeaf + kLeaf +
                 "</Switch2>"),
              testing::AllOf(HasSubstr("t.xml:3:33: "), HasSubstr("differ by less than 1e-7")));
  EXPECT_EQ(Of("<Switch2 variable=\"{v}\" case_1=\"1\" case_2=\"RED\">" + kLeaf + kLeaf + kLeaf +
               "</Switch2>"),
            "");
}
// It has a switch to throw where a second child runs, which is off: both halt the other child.
TEST(DifferencesToBtcpp, AreNoneOfSeveralNodesThatTakeTimeInAReactiveControl) {
  const std::string sleep = "<Sleep msec=\"1\"/>";
  EXPECT_EQ(Of("<ReactiveSequence>" + sleep + kLeaf + sleep + "</ReactiveSequence>"), "");
  EXPECT_EQ(Of("<ReactiveFallback>" + sleep + sleep + "</ReactiveFallback>"), "");
}
TEST(DifferencesToBtcpp, OfSeveralAsyncSequencesInAReactiveSequence) {
  const std::string async = "<AsyncSequence>" + kLeaf + "</AsyncSequence>";
  EXPECT_THAT(Of("<ReactiveSequence>\n" + async + "\n" + async + "</ReactiveSequence>"),
              testing::StartsWith("t.xml:5:1: warning: BehaviorTree.CPP 4.10 refuses a second "
                                  "AsyncSequence in a ReactiveSequence"));
  EXPECT_EQ(Of("<ReactiveSequence>" + kLeaf + async + "</ReactiveSequence>"), "");
  EXPECT_EQ(Of("<ReactiveFallback>" + async + async + "</ReactiveFallback>"), "");
}
TEST(DifferencesToBtcpp, OfOperatorsWhoseRankIsNotDocumented) {
  EXPECT_THAT(Script("a := 1 .. 2 + 3"), HasSubstr("does not document the rank"));
  EXPECT_THAT(Script("a := b &amp; 3 == 1"), HasSubstr("does not document the rank"));
  EXPECT_THAT(Script("a := b | c ^ d"), HasSubstr("does not document the rank"));
  EXPECT_EQ(Script("a := b .. c .. d"), "");
  EXPECT_EQ(Script("a := b | c"), "");
  EXPECT_EQ(Script("a := 'x .. y + z &amp; |'"), "") << "texts do not count";
  for (const std::string code :
       {"a := b | -1", "a := -1 | b", "a := b .. -2", "a := b .. 1e-3", "a += b | c", "a -= b | c",
        "a := b | c; d := e + f", "a := (b | c) == d", "a := (b &amp; (c | d)) + 1"}) {
    EXPECT_EQ(Script(code), "") << code;
  }
  for (const std::string code : {"a := b | c - 1", "a := b - -1 | c", "a := (b | c == d)",
                                 "b := 1; a := b | c + 1", "a := (b | c) ^ d &amp; e"}) {
    EXPECT_THAT(Script(code), HasSubstr("does not document the rank")) << code;
  }
  EXPECT_THAT(Of("<AlwaysSuccess _post=\"a := b | c == d\"/>"), HasSubstr("rank"));
}
TEST(DifferencesToBtcpp, OfTypesOfEntries) {
  const std::string text =
      "<ManualSelector selection=\"s\"><AlwaysSuccess/></ManualSelector>";  // a fixed text
  EXPECT_THAT(Of(text), HasSubstr("fails where a node writes to this port"));
  EXPECT_THAT(Of("<Sequence><Sleep msec=\"{n}\"/><Switch2 variable=\"{n}\">" + kLeaf + kLeaf +
                 kLeaf + "</Switch2></Sequence>"),
              HasSubstr("refuses a port of type text on 'n', which is of type integer from 0"));
  EXPECT_THAT(Of("<Sequence><Script code=\"n := 2.7\"/><Sleep msec=\"{n}\"/></Sequence>"),
              HasSubstr("t.xml:3:25: warning: BehaviorTree.CPP 4.10 may lose the fraction"));
  EXPECT_THAT(Script("n := 1; n = 'a'"),
              HasSubstr("t.xml:3:23: warning: BehaviorTree.CPP 4.10 keeps the type of the first "
                        "value of 'n'"));
  EXPECT_EQ(Script("n := 1; n = 2.5; m == 'a'"), "");
}
TEST(DifferencesToBtcpp, OfNames) {
  const auto tree = [](const std::string& id, const std::string& content) {
    return "<BehaviorTree ID=\"" + id + "\">" + content + "</BehaviorTree>";
  };
  const auto file = [](const std::string& trees) {
    return "<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\">\n" + trees + "</root>";
  };
  EXPECT_THAT(DifferencesOf(file(tree("Main", kLeaf) + tree("Sleep", kLeaf))),
              HasSubstr("refuses a tree with the name of a node"));
  EXPECT_THAT(DifferencesOf(file(tree("Main", kLeaf) + tree("a.b", kLeaf))),
              HasSubstr("refuses '.' in the name of a tree"));
  EXPECT_THAT(DifferencesOf(Main("<Move.To/>")),
              HasSubstr("t.xml:3:1: warning: BehaviorTree.CPP 4.10 refuses '.' in the name of a "
                        "node"));
  EXPECT_THAT(DifferencesOf(Main("<Move goal.x=\"1\"/>")),
              HasSubstr("refuses '.' in the name of a port"));
  EXPECT_EQ(Of("<AlwaysSuccess name=\"a.b\"/>"), "") << "the name of an instance may have it";
  const std::string part = "<SubTree ID=\"Part\" name=\"p\"/>";
  EXPECT_THAT(DifferencesOf(file(tree("Main", "<Sequence>" + part + part + "</Sequence>") +
                                 tree("Part", kLeaf))),
              HasSubstr("refuses a second subtree of this name in the tree"));
  EXPECT_THAT(DifferencesOf(file(tree("Main", "<SubTreePlus ID=\"Part\"/>") + tree("Part", kLeaf))),
              HasSubstr("knows <SubTreePlus> only where it was compiled for version 3"));
}
// A file need not be valid.
TEST(DifferencesToBtcpp, AreFoundBesideErrors) {
  EXPECT_THAT(Of("<Sequence><Nothing/><Finally/></Sequence>"), HasSubstr("with sleeps, in a halt"));
  EXPECT_EQ(Script(""), "");
  EXPECT_EQ(Script("';=;'=;;:=;a="), "");
}

}  // namespace musher::tree::btcpp_differences_test
