// `musher tree`, and `musher behavior --tree` and `musher graph --tree` with an actuator that is a
// behaviour tree.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "musher/cli/render/tree.hpp"
#include "musher/test/cli/fake_tree.hpp"
#include "musher/test/cli/program.hpp"
#include "musher/test/support/domain.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/process.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::cli::tree_command_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::Process;

constexpr const char* kPatrol = R"(<root BTCPP_format="4" main_tree_to_execute="Patrol">
  <BehaviorTree ID="Patrol">
    <Sequence>
      <BatteryOk/>
      <SubTree ID="Drive" goal="5" _skipIf="1 == 2"/>
    </Sequence>
  </BehaviorTree>
  <BehaviorTree ID="Drive">
    <Timeout msec="100"><Action ID="Move" name="there" goal_m="{goal}"/></Timeout>
  </BehaviorTree>
</root>
)";
constexpr const char* kModels = R"(<root BTCPP_format="4"><TreeNodesModel>
  <Condition ID="BatteryOk"/>
  <Action ID="Move"><input_port name="goal_m" type="double"/></Action>
</TreeNodesModel></root>
)";

nlohmann::json Json(const std::string& text) {
  return nlohmann::json::parse(text, nullptr, false);
}

class TreeFileCommand : public ::testing::Test {
 protected:
  std::string Write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  const TempFolder folder_;
  const std::string patrol_ = Write("patrol.xml", kPatrol);
  const std::string models_ = Write("models.xml", kModels);
};

TEST_F(TreeFileCommand, ChecksATreeWithTheModelsOfItsNodes) {
  const Ran ran = RunProgram({"tree", "check", patrol_, "--models", models_});
  EXPECT_EQ(ran.exit, 0) << ran.out;
  EXPECT_EQ(ran.out, "ok: tree Patrol, 5 nodes in 2 trees; from models: BatteryOk, Move\n");
}

TEST_F(TreeFileCommand, ReportsEveryErrorWithItsPlace) {
  const std::string bad = Write("bad.xml",
                                "<root BTCPP_format=\"4\">\n<BehaviorTree ID=\"A\"><Sequence>\n"
                                "<Sleep msec=\"soon\"/>\n<Sequense/></Sequence></BehaviorTree>\n"
                                "</root>");
  const Ran ran = RunProgram({"tree", "check", bad, patrol_, "--models", models_});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.out,
              AllOf(HasSubstr(bad + ":3:14: error: port 'msec': 'soon' is not valid"),
                    HasSubstr(bad + ":4:1: error: there is no node 'Sequense'; did you mean "
                                    "'Sequence'?"),
                    HasSubstr(patrol_ + ": ok: tree Patrol"), Not(HasSubstr("--models"))));
  EXPECT_THAT(RunProgram({"tree", "check", patrol_}).out,
              AllOf(HasSubstr("there is no node 'BatteryOk'"), HasSubstr("--models FILE")));
  const Ran json = RunProgram({"--json", "tree", "check", bad});
  EXPECT_EQ(json.exit, 2);
  EXPECT_EQ(Json(json.out)["valid"], false);
  EXPECT_EQ(Json(json.out)["diagnostics"][0]["line"], 3) << json.out;
}

TEST_F(TreeFileCommand, ChecksEachTreeThatNoOtherOneUsesWhereNoneIsTheMainOne) {
  const auto file = [this](const std::string& b) {
    return Write("several.xml",
                 "<root BTCPP_format=\"4\">\n<BehaviorTree ID=\"Part\"><AlwaysSuccess/>"
                 "</BehaviorTree>\n<BehaviorTree ID=\"A\"><SubTree ID=\"Part\"/></BehaviorTree>\n"
                 "<BehaviorTree ID=\"B\">" +
                     b + "</BehaviorTree></root>");
  };
  const Ran ran = RunProgram({"tree", "check", file("<AlwaysSuccess/>")});
  EXPECT_EQ(ran.exit, 0) << ran.out;
  EXPECT_EQ(ran.out, "ok: tree A, 2 nodes in 3 trees\n");
  EXPECT_EQ(RunProgram({"tree", "check", file("<AlwaysSuccess/>"), "--tree", "B"}).out,
            "ok: tree B, 1 node in 3 trees\n");
  EXPECT_THAT(RunProgram({"tree", "check", file("<Sleep/>")}).out,
              HasSubstr(":4:22: error: <Sleep> needs port 'msec'"));
  EXPECT_THAT(RunProgram({"tree", "check", file("<AlwaysSuccess/>"), "--tree", "C"}).out,
              HasSubstr("error: there is no tree 'C'"));
}

TEST_F(TreeFileCommand, LetsWarningsPassAndRefusesAFileThatIsNotThere) {
  const std::string warned =
      Write("w.xml", "<root><BehaviorTree ID=\"A\"><AlwaysSuccess/></BehaviorTree></root>");
  const Ran ran = RunProgram({"tree", "check", warned});
  EXPECT_EQ(ran.exit, 0);
  EXPECT_THAT(ran.out, AllOf(HasSubstr(":1:1: warning: "), HasSubstr("\nok: tree A, 1 node in")));
  EXPECT_EQ(RunProgram({"tree", "check", folder_ / "none.xml"}).exit, 2);
  EXPECT_EQ(RunProgram({"tree", "check"}).exit, 2);
}

TEST_F(TreeFileCommand, ShowsTheNodesOfATreeAndOfItsSubtrees) {
  const Ran ran = RunProgram({"tree", "show", patrol_});
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_EQ(ran.out,
            "Sequence\n"
            "  BatteryOk\n"
            "  Drive  SubTree  goal=\"5\" _skipIf=\"1 == 2\"\n"
            "    Timeout  msec=\"100\"\n"
            "      there  Move  goal_m=\"{goal}\"\n");
  EXPECT_EQ(RunProgram({"tree", "show", patrol_, "--tree", "Drive"}).out,
            "Timeout  msec=\"100\"\n"
            "  there  Move  goal_m=\"{goal}\"\n");
  const Ran unknown = RunProgram({"tree", "show", patrol_, "--tree", "Drice"});
  EXPECT_EQ(unknown.exit, 2);
  EXPECT_THAT(unknown.err, HasSubstr("there is no tree 'Drice'; did you mean 'Drive'?"));
  const auto json = Json(RunProgram({"--json", "tree", "show", patrol_}).out);
  EXPECT_EQ(json["nodes"][4]["name"], "there");
  EXPECT_EQ(json["nodes"][4]["parent"], 3);
  EXPECT_EQ(json["nodes"][4]["line"], 9);
}

TEST_F(TreeFileCommand, RefusesToShowTreesThatContainThemselves) {
  const std::string round = Write("round.xml",
                                  "<root BTCPP_format=\"4\"><BehaviorTree ID=\"A\">"
                                  "<SubTree ID=\"A\"/></BehaviorTree></root>");
  const Ran ran = RunProgram({"tree", "show", round});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.err, HasSubstr("the trees are recursive: 'A' contains itself"));
}

TEST_F(TreeFileCommand, PrintsModelsThatItReadsItself) {
  const Ran ran = RunProgram({"tree", "models"});
  EXPECT_THAT(ran.out, HasSubstr("<Action ID=\"Sleep\">\n"
                                 "      <input_port name=\"msec\" type=\"unsigned int\">ms</"));
  const Ran again = RunProgram(
      {"tree", "check", patrol_, "--models", Write("builtin.xml", ran.out), "--models", models_});
  EXPECT_EQ(again.exit, 0) << again.out;
  EXPECT_THAT(RunProgram({"tree", "models", "--format", "markdown"}).out,
              HasSubstr("\n### `Sleep`\n"));
}

TEST_F(TreeFileCommand, WarnsOfWhatBehaviorTreeCppDoesDifferently) {
  const std::string tree =
      Write("mine.xml",
            "<root BTCPP_format=\"4\"><BehaviorTree ID=\"A\">\n<Finally><AlwaysSuccess/>"
            "<AlwaysSuccess/></Finally></BehaviorTree></root>");
  EXPECT_THAT(RunProgram({"tree", "check", tree}).out, Not(HasSubstr("warning")));
  const Ran ran = RunProgram({"tree", "check", tree, "--as", "btcpp-4.10"});
  EXPECT_EQ(ran.exit, 0);
  EXPECT_THAT(ran.out, HasSubstr(tree + ":2:1: warning: BehaviorTree.CPP 4.10 waits for the second "
                                        "child, with sleeps, in a halt; here it is ticked once"));
  EXPECT_EQ(RunProgram({"tree", "check", tree, "--as", "btcpp-3"}).exit, 2);
  const auto json = Json(RunProgram({"--json", "tree", "check", tree, "--as", "btcpp-4.10"}).out);
  EXPECT_EQ(json["valid"], true);
  EXPECT_EQ(json["diagnostics"][0]["severity"], "warning") << json;
}

TEST_F(TreeFileCommand, KnowsTheNodesOfNav2OnRequest) {
  const std::string tree = Write("nav2.xml",
                                 "<root BTCPP_format=\"4\"><BehaviorTree ID=\"A\">"
                                 "<PipelineSequence><RateController hz=\"1\">"
                                 "<ComputePathToPose goal=\"{goal}\" path=\"{path}\"/>"
                                 "</RateController><DockRobot/>"
                                 "</PipelineSequence></BehaviorTree></root>");
  const Ran ran = RunProgram({"tree", "check", tree, "--nav2"});
  EXPECT_EQ(ran.exit, 0) << ran.out;
  EXPECT_EQ(ran.out, "ok: tree A, 4 nodes in 1 tree; from models: DockRobot\n");
  EXPECT_THAT(RunProgram({"tree", "check", tree}).out,
              AllOf(HasSubstr("there is no node 'PipelineSequence'"), HasSubstr("--nav2")));
  const Ran models = RunProgram({"tree", "models", "--nav2"});
  EXPECT_THAT(models.out, AllOf(HasSubstr("<Control ID=\"RecoveryNode\">"),
                                Not(HasSubstr("<Control ID=\"Sequence\">"))));
  const Ran again = RunProgram({"tree", "check", tree, "--models", Write("m.xml", models.out)});
  EXPECT_EQ(again.exit, 0) << again.out;
}

TEST_F(TreeFileCommand, PrefersANodeOfTheProgramToOneOfNav2WithItsName) {
  const std::string content = "<BehaviorTree ID=\"A\"><Wait until=\"noon\"/></BehaviorTree>";
  const std::string model =
      "<TreeNodesModel><Action ID=\"Wait\"><input_port name=\"until\" type=\"std::string\"/>"
      "</Action></TreeNodesModel>";
  const auto file = [](const std::string& text) {
    return "<root BTCPP_format=\"4\">" + text + "</root>";
  };
  const std::string with_model = Write("with_model.xml", file(content + model));
  const Ran own = RunProgram({"tree", "check", with_model, "--nav2"});
  EXPECT_EQ(own.exit, 0) << own.out;
  const std::string tree = Write("wait.xml", file(content));
  const std::string models = Write("models.xml", file(model));
  const Ran given = RunProgram({"tree", "check", tree, "--nav2", "--models", models});
  EXPECT_EQ(given.exit, 0) << given.out;
  EXPECT_THAT(RunProgram({"tree", "check", tree, "--nav2"}).out, HasSubstr("no port 'until'"));
}

TEST_F(TreeFileCommand, DrawsATree) {
  const Ran dot = RunProgram({"graph", patrol_});
  EXPECT_EQ(dot.exit, 0) << dot.err;
  EXPECT_THAT(dot.out, AllOf(HasSubstr("digraph \"patrol\""),
                             HasSubstr("n4 [label=\"there\\nMove\""), HasSubstr("n3 -> n4;")));
  EXPECT_THAT(RunProgram({"graph", patrol_, "--format", "mermaid"}).out,
              HasSubstr("n2[\"Drive<br/>SubTree\"]\n"));
  EXPECT_THAT(RunProgram({"graph", "--tree", patrol_}).out, HasSubstr("n3 -> n4;"));
  EXPECT_EQ(RunProgram({"graph", folder_ / "none.xml"}).exit, 2);
}

class RunningTree : public ::testing::Test {
 protected:
  RunningTree() { setenv("ROS_DOMAIN_ID", std::to_string(transport::TestDomain()).c_str(), 1); }
};

TEST_F(RunningTree, IsShownWithStatusTimesAndChanges) {
  const FakeTree patrol("patrol");
  const Ran ran = RunProgram({"behavior", "patrol", "--tree", "--history", "2"});
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_EQ(ran.out,
            "patrol  tree Patrol  RUNNING\n"
            "250 ticks in 12.500 s of its time\n"
            "NODE           TYPE      STATUS   RUNNING   RUNS\n"
            "▶ Patrol       Sequence  RUNNING  12.500 s  1\n"
            "  ✓ BatteryOk            SUCCESS\n"
            "  ▶ there      Move      RUNNING  12.250 s  2\n"
            "\n"
            "AT       NODE              FROM  TO\n"
            "0.000 s  Patrol/BatteryOk  IDLE  SUCCESS\n"
            "0.250 s  Patrol/there      IDLE  RUNNING\n");
  EXPECT_THAT(RunProgram({"behavior", "patrol", "--tree", "--entries"}).out,
              HasSubstr("BOARD  KEY     TYPE    VALUE\n"
                        "-      goal_m  number  5\n"
                        "Drive  way     text    a b\n"));
  const auto json = Json(RunProgram({"--json", "behavior", "patrol", "--tree"}).out);
  EXPECT_EQ(json["status"], "RUNNING");
  EXPECT_EQ(json["nodes"][2]["spent_s"], 12.25);
  EXPECT_EQ(json["history"][2]["path"], "Patrol/there");
  EXPECT_EQ(json["entries"].size(), 0U);
}

TEST_F(RunningTree, IsFollowedUntilItIsLost) {
  auto patrol = std::make_unique<FakeTree>("patrol");
  Process text({BinDir() + "/musher", "behavior", "patrol", "--tree", "--follow"});
  Process json({BinDir() + "/musher", "--json", "behavior", "patrol", "--tree", "--follow"});
  ASSERT_NE(text.LineWith("Patrol/there"), "");
  ASSERT_NE(json.LineWith("Patrol/there"), "");
  patrol->End(msg::TreeState::kFailure);
  EXPECT_THAT(text.LineWith("FAILURE"), HasSubstr("12.500 s  Patrol/there  RUNNING -> FAILURE"));
  const auto line = Json(json.LineWith("FAILURE"));
  EXPECT_EQ(line["history"].size(), 1U);
  EXPECT_EQ(line["nodes"][2]["status"], "FAILURE");
  patrol.reset();
  EXPECT_NE(text.LineWith("patrol is lost"), "");
  text.Signal(SIGINT);
  EXPECT_EQ(text.Wait().exit, 0);
}

TEST_F(RunningTree, IsDrawnWithItsTimes) {
  const FakeTree patrol("patrol");
  EXPECT_THAT(RunProgram({"graph", "--tree", "patrol"}).out,
              AllOf(HasSubstr("n2 [label=\"there\\nMove\\n12.2 s, 2 runs\", shape=box, "
                              "style=filled, fillcolor=gold];"),
                    HasSubstr("n0 -> n1;")));
  EXPECT_EQ(RunProgram({"graph", "--tree", "patrol", "--skill", "x"}).exit, 2);
}

TEST_F(RunningTree, IsReportedAsMissing) {
  FakeTree patrol("patrol");
  patrol.Refuse("unknown format");
  const Ran refused = RunProgram({"behavior", "patrol", "--tree"});
  EXPECT_EQ(refused.exit, 1);
  EXPECT_EQ(refused.err, "musher: patrol: unknown format\n");
  EXPECT_EQ(RunProgram({"behavior", "nothing", "--tree"}).exit, 3);
  EXPECT_EQ(RunProgram({"behavior", "patrol", "--entries"}).exit, 2) << "--entries needs --tree";
}

TEST_F(RunningTree, BeginsByACommand) {
  const FakeTree patrol("patrol");
  const Ran begun = RunProgram({"behavior", "patrol", "--tree", "--send", "START"});
  EXPECT_EQ(begun.exit, 0) << begun.err;
  EXPECT_THAT(begun.out, HasSubstr("patrol"));
  const Ran refused = RunProgram({"behavior", "patrol", "--tree", "--send", "x"});
  EXPECT_EQ(refused.exit, 1);
  EXPECT_EQ(refused.err, "musher: there is no command 'x'\n");
}

TEST(TreeText, OfAnUntrustedReportStaysWithinItsNodes) {
  msg::GetTree::Response report = PatrolReport();
  report.nodes[1].parent = 7;
  report.nodes[0].parent = 0;
  report.nodes[2].name = "a\x1b[2J\"";
  report.state.status = {9};
  report.history[0].node = 99;
  report.state.last_fault = "Patrol: it\nbroke";
  const std::string text = TreeText("p", report, false);
  EXPECT_THAT(text, AllOf(HasSubstr("? Patrol"), HasSubstr("\n· BatteryOk"), HasSubstr("a [2J\""),
                          HasSubstr("0.000 s  ?"), HasSubstr("last fault: Patrol: it broke\n")));
  EXPECT_THAT(TreeDot("p", report), HasSubstr("label=\"a [2J\\\"\\nMove"));
  EXPECT_THAT(TreeMermaid(report), HasSubstr("a [2J#quot;<br/>Move"));
  EXPECT_THAT(TreeText("p", {}, false), HasSubstr("no tree is loaded"));
  EXPECT_THAT(TreeText("p", PatrolReport(), true), HasSubstr("\x1b["));
}

}  // namespace musher::cli::tree_command_test
