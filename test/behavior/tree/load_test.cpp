// What is found when a tree is loaded: errors with their places, warnings, includes; the picture.

#include <fstream>

#include "musher/test/behavior/tree/trees.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::tree::load_test {

using testing::HasSubstr;

TEST(Load, ReportsAllErrorsAtOnceWithTheirPlaces) {
  EXPECT_EQ(Findings(R"(<root BTCPP_format="4">
  <BehaviorTree ID="Main">
    <Sequence nme="x">
      <Sequenze/>
      <Inverter/>
      <Sleep/> <Sleep msec="soon"/>
      <Script code="x &lt; &gt; 3"/>
      <AlwaysSuccess _skipif="true"/>
      <IfThenElse><AlwaysSuccess/></IfThenElse>
      <Parallel success_count="2"><AlwaysSuccess/></Parallel>
    </Sequence>
  </BehaviorTree>
</root>)"),
            "t.xml:3:15: error: <Sequence> has no port 'nme'; did you mean 'name'?\n"
            "t.xml:4:7: error: there is no node 'Sequenze'; did you mean 'Sequence'?\n"
            "t.xml:5:7: error: node 'Inverter' has 0 children; expected 1\n"
            "t.xml:6:7: error: <Sleep> needs port 'msec' (integer from 0): ms\n"
            "t.xml:6:29: error: port 'msec': 'soon' is not valid: expected integer from 0\n"
            "t.xml:7:28: error: script in code: expected a value\n"
            "t.xml:8:22: warning: attribute '_skipif' has no meaning; did you mean '_skipIf'?\n"
            "t.xml:9:7: error: node 'IfThenElse' has 1 child; expected 2 to 3\n");
}
TEST(Load, RefusesCountsThatCanNotBeReached) {
  EXPECT_EQ(Findings(Main("<Parallel success_count=\"2\"><AlwaysSuccess/></Parallel>")),
            "t.xml:3:26: error: success_count is more than the number of its children, 1\n");
}
TEST(Load, RefusesAScriptFromAnEntry) {
  EXPECT_EQ(
      Findings(Main("<Script code=\"{s}\"/>")),
      "t.xml:3:15: error: a script is fixed when the tree is loaded; expected its text instead "
      "of an entry\n");
}
TEST(Load, NamesWhatIsNoXml) {
  EXPECT_THAT(Findings("<root>\n<a>\n</b></root>"),
              HasSubstr("t.xml:2:1: error: an element is not closed, or closed with another name"));
  EXPECT_EQ(Findings(""), "t.xml:1:1: error: the text is empty\n");
  EXPECT_THAT(Findings("<tree/>"), HasSubstr("t.xml:1:1: error: the outermost element is <tree>"));
  EXPECT_THAT(Findings("<root BTCPP_format=\"3\"/>"),
              HasSubstr("t.xml:1:21: error: BTCPP_format is '3'; expected 4"));
  EXPECT_THAT(Findings("<root BTCPP_format=\"4\"><BehaviourTree/></root>"),
              HasSubstr("t.xml:1:24: error: <BehaviourTree> has no place in <root>; did you mean "
                        "<BehaviorTree>?"));
  EXPECT_EQ(Findings("<root BTCPP_format=\"4\"/>"), "t.xml: error: there is no <BehaviorTree>\n");
}
TEST(Load, AsksForTheMainTree) {
  const std::string two =
      "<BehaviorTree ID=\"A\"><AlwaysSuccess/></BehaviorTree>"
      "<BehaviorTree ID=\"B\"><AlwaysSuccess/></BehaviorTree></root>";
  EXPECT_THAT(Findings("<root BTCPP_format=\"4\">" + two),
              HasSubstr("there are 2 trees; name the first one"));
  EXPECT_THAT(Findings("<root BTCPP_format=\"4\" main_tree_to_execute=\"C\">" + two),
              HasSubstr("t.xml:1:46: error: there is no tree 'C'"));
}
TEST(Load, ChecksTreesThatNothingUses) {
  EXPECT_THAT(Findings("<root BTCPP_format=\"4\" main_tree_to_execute=\"A\">"
                       "<BehaviorTree ID=\"A\"><AlwaysSuccess/></BehaviorTree>\n"
                       "<BehaviorTree ID=\"B\"><Nothing/></BehaviorTree></root>"),
              HasSubstr("t.xml:2:22: error: there is no node 'Nothing'"));
}
TEST(Load, RefusesATreeThatIsThereTwice) {
  EXPECT_THAT(
      Findings("<root BTCPP_format=\"4\"><BehaviorTree ID=\"A\"><AlwaysSuccess/>"
               "</BehaviorTree>\n<BehaviorTree ID=\"A\"><AlwaysSuccess/></BehaviorTree></root>"),
      HasSubstr("t.xml:2:19: error: there is already a tree 'A', at t.xml:1"));
}
TEST(Load, ReadsTheLongFormsOfNodes) {
  const auto tree = MakeTree(
      Main("<Control ID=\"Sequence\"><Decorator ID=\"Inverter\"><Action ID=\"AlwaysFailure\"/>"
           "</Decorator><Condition ID=\"ScriptCondition\" code=\"1 &lt; 2\"/></Control>"));
  EXPECT_EQ(Ticks(*tree, 1), "S");
  EXPECT_THAT(Findings(Main("<Action ID=\"Inverter\"><AlwaysSuccess/></Action>")),
              HasSubstr("node 'Inverter' is registered as Decorator, not as Action"));
  EXPECT_THAT(Findings(Main("<Action/>")), HasSubstr("<Action> needs the attribute 'ID'"));
}

TEST(Load, FollowsIncludesRelativeToTheirFile) {
  const musher::TempFolder temp;
  const std::filesystem::path folder = temp.path();
  std::filesystem::create_directory(folder / "parts");
  std::ofstream(folder / "main.xml")
      << "<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\"><include path=\"parts/a.xml\"/>"
         "<BehaviorTree ID=\"Main\"><SubTree ID=\"B\"/></BehaviorTree></root>";
  std::ofstream(folder / "parts/a.xml")
      << "<root BTCPP_format=\"4\"><include path=\"b.xml\"/><include path=\"../main.xml\"/></root>";
  std::ofstream(folder / "parts/b.xml")
      << "<root BTCPP_format=\"4\">\n<BehaviorTree ID=\"B\">\n <Nothing/></BehaviorTree></root>";
  const Reading reading = ReadTreeFile((folder / "main.xml").string());
  ASSERT_TRUE(reading.ok()) << Texts(reading.diagnostics);
  EXPECT_THAT(Texts(Build(reading.document, Factory()).diagnostics),
              HasSubstr("parts/b.xml:3:2: error: there is no node 'Nothing'"));
}
TEST(Load, NamesAnIncludeThatIsMissing) {
  const musher::TempFolder temp;
  const std::filesystem::path folder = temp.path();
  std::ofstream(folder / "main.xml")
      << "<root BTCPP_format=\"4\"><include path=\"none.xml\"/></root>";
  EXPECT_THAT(Texts(ReadTreeFile((folder / "main.xml").string()).diagnostics),
              HasSubstr("main.xml:1:39: error: can not include"));
}

TEST(Warning, ANodeThatTakesTimeBeforeTheLastOfAReactiveSequence) {
  EXPECT_EQ(Findings(Main("<ReactiveSequence><Inverter><Sleep msec=\"1\"/></Inverter>"
                          "<Sleep msec=\"2\"/></ReactiveSequence>")),
            "t.xml:3:19: warning: 'Inverter' may return RUNNING, and is not the last child of "
            "ReactiveSequence: it is started again in each tick after it has completed, and each "
            "time it runs the children behind it are halted\n");
  EXPECT_EQ(
      Findings(Main("<ReactiveSequence><AlwaysSuccess/><Sleep msec=\"2\"/></ReactiveSequence>")),
      "");
}
TEST(Warning, ATimeoutWithoutEffect) {
  EXPECT_THAT(Findings(Main("<Timeout msec=\"10\"><AlwaysSuccess/></Timeout>")),
              HasSubstr("t.xml:3:1: warning: Timeout has no effect"));
  EXPECT_THAT(Findings(Main("<Timeout msec=\"0\"><Sleep msec=\"1\"/></Timeout>")),
              HasSubstr("t.xml:3:1: warning: msec=\"0\" is no limit"));
}
TEST(Warning, AKeyThatIsProbablyMisspelt) {
  EXPECT_EQ(Findings(Main("<Sequence><Script code=\"distance := 1\"/>"
                          "<AlwaysSuccess _skipIf=\"distanse > 1\"/></Sequence>")),
            "t.xml:3:65: warning: nothing in the tree sets 'distanse'; did you mean 'distance'?\n");
}
TEST(Warning, AnAssignmentInACondition) {
  EXPECT_THAT(
      Findings(Main("<AlwaysSuccess _skipIf=\"x = 1\"/>")),
      HasSubstr("t.xml:3:27: warning: script in _skipIf: '=' assigns; to compare, use '=='"));
}
TEST(Warning, AFileWithoutAFormat) {
  EXPECT_THAT(Findings("<root><BehaviorTree ID=\"A\"><AlwaysSuccess/></BehaviorTree></root>"),
              HasSubstr("t.xml:1:1: warning: the attribute BTCPP_format=\"4\" is missing"));
}

TEST(Picture, ShowsTheNodesWithTheirStatus) {
  Logged logged;
  const auto tree = MakeTree(Main("<Parallel name=\"both &quot;x&quot;\"><Say name=\"a\" "
                                  "does=\"R\"/><AlwaysSuccess/></Parallel>"),
                             logged.factory);
  EXPECT_EQ(Ticks(*tree, 1), "R");
  EXPECT_EQ(ToDot(*tree),
            "digraph \"Main\" {\n"
            "  ordering=out;\n"
            "  node [shape=box, style=filled, fontname=\"sans-serif\"];\n"
            "  n0 [label=\"both \\\"x\\\"\\nParallel\", shape=box, style=\"rounded,filled\", "
            "fillcolor=gold];\n"
            "  n1 [label=\"a\\nSay\", shape=box, fillcolor=gold];\n"
            "  n0 -> n1;\n"
            "  n2 [label=\"AlwaysSuccess\", shape=box, fillcolor=palegreen];\n"
            "  n0 -> n2;\n"
            "}\n");
}
TEST(History, KeepsTheLastChangesWithTheirTime) {
  const auto tree = MakeTree(Main("<Sleep name=\"nap\" msec=\"20\"/>"));
  EXPECT_EQ(Ticks(*tree, 4), "RRSR");
  ASSERT_TRUE(tree->Halt(At(500)));
  EXPECT_EQ(tree->HistoryText(),
            "0 s Main/nap: IDLE -> RUNNING\n"
            "0.02 s Main/nap: RUNNING -> SUCCESS\n"
            "0.03 s Main/nap: IDLE -> RUNNING\n"
            "0.5 s Main/nap: RUNNING -> IDLE\n");
}

}  // namespace musher::tree::load_test
