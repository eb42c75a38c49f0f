// Substitutions: by test nodes and by other nodes, in C++ and from JSON.

#include "musher/behavior/tree/json/substitutions.hpp"
#include "musher/behavior/tree/models.hpp"
#include "musher/test/behavior/tree/trees.hpp"

namespace musher::tree::conformance_substitutions_test {

using testing::HasSubstr;

// The result of its port.
class Move : public Action {
 public:
  explicit Move(Setup& setup) : goal_(setup.Input<int>("goal")) {}
  static MetadataFields Metadata() { return {{"author", "A & B"}, {"needs", "an arm"}}; }

 private:
  Status Do(const Tick&) override { throw std::runtime_error("the robot moves"); }
  InPort<int> goal_;
};
class Teleport : public Action {
 public:
  explicit Teleport(Setup& setup)
      : goal_(setup.Input<int>("goal")), at_(setup.Output<int>("at", FromEntry{"at"})) {}

 private:
  Status Do(const Tick&) override {
    at_.Set(goal_.Get());
    return Status::kSuccess;
  }
  InPort<int> goal_;
  OutPort<int> at_;
};

constexpr const char* kRules = R"({
  "TestNodeConfigs": {
    "Blocked": {"return_status": "FAILURE", "async_delay": 20, "failure_script": "why := 'door'"},
    "Far": {"post_script": "n := n + 1"}
  },
  "SubstitutionRules": {
    "Main/*/there": "Blocked",
    "*again": "Far",
    "Move": "Teleport"
  }
})";

struct Substitutions : testing::Test {
  Substitutions() {
    EXPECT_TRUE(factory.Add<Move>("Move"));
    EXPECT_TRUE(factory.Add<Teleport>("Teleport"));
  }
  std::string Added(std::string_view json) {
    return Texts(AddSubstitutions(factory, json, "r.json"));
  }
  Factory factory;
};

TEST_F(Substitutions, FromJsonReplaceLeavesByTestNodesAndByOtherNodes) {
  ASSERT_EQ(Added(kRules), "");
  const auto tree = MakeTree(Main("<Sequence><Move goal=\"3\"/><Move name=\"again\" goal=\"4\"/>"
                                  "<Move name=\"there\" goal=\"5\"/></Sequence>"),
                             factory);
  ASSERT_TRUE(tree->board().Set("n", 1));
  EXPECT_EQ(Ticks(*tree, 3), "RRF");
  EXPECT_EQ(tree->board().Get<int>("at").value(), 3) << "its port 'goal' is that of the other node";
  EXPECT_EQ(tree->board().Get<int>("n").value(), 2);
  EXPECT_EQ(tree->board().Get<std::string>("why").value(), "door");
}
TEST_F(Substitutions, FindLeavesAsBehaviorTreeCppDoesByTheirIdAndByThePathOfTheirSubtrees) {
  ASSERT_EQ(Added("{\"SubstitutionRules\": {\"Move\": \"AlwaysSuccess\", "
                  "\"arm/*\": \"AlwaysSuccess\", \"arm/hand/close\": \"AlwaysFailure\"}}"),
            "");
  const auto tree = MakeTree(
      "<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\"><BehaviorTree ID=\"Main\">"
      "<Sequence><Move name=\"there\" goal=\"3\"/><SubTree ID=\"Arm\" name=\"arm\"/>"
      "</Sequence></BehaviorTree><BehaviorTree ID=\"Arm\"><Sequence>"
      "<SubTree ID=\"Hand\" name=\"hand\"/></Sequence></BehaviorTree>"
      "<BehaviorTree ID=\"Hand\"><Inverter><Teleport name=\"close\" goal=\"1\"/></Inverter>"
      "</BehaviorTree></root>",
      factory);
  EXPECT_EQ(tree->info(1).id, "Move") << "its name is not that of its class";
  EXPECT_EQ(Ticks(*tree, 1), "F") << "the first rule that matches, in their order";
}
TEST_F(Substitutions, AreCheckedWithThePortsOfTheOtherNode) {
  ASSERT_EQ(Added("{\"SubstitutionRules\": {\"Move\": \"SetBlackboard\"}}"), "");
  EXPECT_THAT(Findings(Main("<Move goal=\"3\"/>"), factory),
              testing::AllOf(HasSubstr("t.xml:3:1: error: <Move> needs port 'value'"),
                             HasSubstr("t.xml:3:1: note: a substitution makes it the node "
                                       "'SetBlackboard'")));
}
TEST_F(Substitutions, OfANameOrPathThatNoLeafHasAreAnError) {
  ASSERT_EQ(Added("{\"SubstitutionRules\": {\"Moev\": \"AlwaysSuccess\", "
                  "\"Main/their\": \"AlwaysSuccess\"}}"),
            "");
  EXPECT_EQ(Findings(Main("<Move name=\"there\" goal=\"3\"/>"), factory),
            "t.xml:1:1: error: no leaf has the name, class or path 'Main/their', which has a "
            "substitution; did you mean 'Main/there'?\n"
            "t.xml:1:1: error: no leaf has the name, class or path 'Moev', which has a "
            "substitution; did you mean 'Move'?\n");
}
TEST_F(Substitutions, OfAPatternThatNoLeafMatchesAreAWarning) {
  ASSERT_EQ(Added("{\"SubstitutionRules\": {\"Moev*\": \"AlwaysSuccess\"}}"), "");
  EXPECT_EQ(Findings(Main("<Move goal=\"3\"/>"), factory),
            "t.xml:1:1: warning: no leaf has a name or path like 'Moev*', which has a "
            "substitution\n");
}
TEST_F(Substitutions, WhoseLeavesAnEarlierOneHasTakenAreNoError) {
  ASSERT_EQ(Added("{\"SubstitutionRules\": {\"Move\": \"AlwaysSuccess\", "
                  "\"Main/there\": \"AlwaysFailure\", \"*re\": \"AlwaysFailure\"}}"),
            "");
  EXPECT_EQ(Findings(Main("<Move name=\"there\" goal=\"3\"/>"), factory), "");
}
TEST_F(Substitutions, ReplaceLeavesOnly) {
  constexpr const char* kParts =
      "<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\"><BehaviorTree ID=\"Main\">"
      "<Sequence><SubTree ID=\"Part\"/></Sequence></BehaviorTree>"
      "<BehaviorTree ID=\"Part\"><AlwaysSuccess/></BehaviorTree></root>";
  factory.Substitute("*Sequence", {.result = Status::kFailure});
  factory.Substitute("*Part", {.result = Status::kFailure});
  EXPECT_EQ(Ticks(*MakeTree(kParts, factory), 1), "S");
  factory.Substitute("Part", {.result = Status::kFailure});
  EXPECT_THAT(Findings(kParts, factory),
              HasSubstr("error: no leaf has the name, class or path 'Part'"));
}
TEST_F(Substitutions, HaveAScriptOfATestNodeCheckedInItsTree) {
  ASSERT_EQ(Added("{\"TestNodeConfigs\": {\"A\": {\"post_script\": \"n :=\"}}, "
                  "\"SubstitutionRules\": {\"Move\": \"A\"}}"),
            "");
  EXPECT_THAT(Findings(Main("<Move goal=\"3\"/>"), factory),
              HasSubstr("t.xml:3:1: error: script of its test node: "));
}
TEST_F(Substitutions, ReportEachErrorAtItsPlaceAndAddNothing) {
  EXPECT_EQ(Added("{\n\"TestNodeConfigs\": {\n"
                  " \"A\": {\"return_status\": \"DONE\", \"async_dela\": 3},\n"
                  " \"B\": {\"async_delay\": -1, \"post_script\": 4, \"return_status\": 5},\n"
                  " \"C\": 3,\n \"D\": {\"async_delay\": 1.5}},\n"
                  "\"SubstitutionRules\": {\n \"Move\": \"Teleprot\",\n \"there\": [\"A\"],\n"
                  " \"b\\\"c\": \"B\", \"\": \"C\", \"d\": \"D\"}}"),
            "r.json:3:25: error: 'return_status' is 'DONE'; expected SUCCESS, FAILURE or SKIPPED\n"
            "r.json:3:33: error: unknown field 'async_dela'; did you mean 'async_delay'?\n"
            "r.json:4:23: error: 'async_delay' is -1; expected a whole number of ms from 0 to "
            "86400000\n"
            "r.json:4:42: error: 'post_script' is of type number; expected a script as a text\n"
            "r.json:4:62: error: 'return_status' is of type number; expected SUCCESS, FAILURE or "
            "SKIPPED\n"
            "r.json:5:7: error: test node 'C' is of type number; expected an object\n"
            "r.json:6:23: error: 'async_delay' is 1.5; expected a whole number of ms from 0 to "
            "86400000\n"
            "r.json:8:10: error: there is neither a test node nor a node 'Teleprot'; did you mean "
            "'Teleport'?\n"
            "r.json:9:11: error: rule 'there' is of type array; expected the name of a test node "
            "or of a node\n"
            "r.json:10:15: error: a rule has no name or path\n"
            "r.json:3:2: warning: no rule uses the test node 'A'\n"
            "r.json:5:2: warning: no rule uses the test node 'C'\n");
  EXPECT_FALSE(factory.has_substitutes());
}
TEST_F(Substitutions, RefuseWhatIsNoJsonOfRules) {
  EXPECT_EQ(Added("{\n\"SubstitutionRules\": {\"a\" \"b\"}}"),
            "r.json:2:29: error: it is no JSON\n");
  EXPECT_EQ(Added("[]"), "r.json:1:1: error: of type array; expected an object\n");
  EXPECT_EQ(Added("{\"SubstitutionRule\": {}}"),
            "r.json:1:2: error: unknown field 'SubstitutionRule'; did you mean "
            "'SubstitutionRules'?\n");
  EXPECT_EQ(Added("{\"SubstitutionRules\": 3}"),
            "r.json:1:23: error: 'SubstitutionRules' is of type number; expected an object\n");
  EXPECT_THAT(Added(std::string(5000, '[')), HasSubstr("nested deeper than 100"));
  EXPECT_EQ(Texts(AddSubstitutionsOfFile(factory, "/nowhere/r.json")),
            "/nowhere/r.json: error: the file can not be read\n");
}
TEST_F(Substitutions, InCppMayBeAnotherNodeOrAFunction) {
  ASSERT_TRUE(factory.SubstituteByNode("there", "Teleport"));
  EXPECT_THAT(factory.SubstituteByNode("there", "Teleprot").error().message,
              HasSubstr("did you mean 'Teleport'?"));
  std::string results = "RRS";
  factory.Substitute("Move", {.post_script = "done := true", .result_of = [&](const Tick&) {
                                const char next = results.front();
                                results.erase(0, 1);
                                return next == 'R' ? Status::kRunning : Status::kSuccess;
                              }});
  const auto tree = MakeTree(
      Main("<Sequence><Move name=\"there\" goal=\"1\"/><Move goal=\"2\"/></Sequence>"), factory);
  EXPECT_EQ(Ticks(*tree, 2), "RR");
  EXPECT_FALSE(tree->board().Get<bool>("done"));
  EXPECT_EQ(Ticks(*tree, 1, 2), "S");
  EXPECT_TRUE(tree->board().Get<bool>("done").value());
  EXPECT_EQ(tree->board().Get<int>("at").value(), 1);
}

TEST_F(Substitutions, LeaveTheMetadataOfANodeInItsModel) {
  EXPECT_THAT(ModelsXml(factory),
              HasSubstr("      <MetadataFields>\n        <Metadata author=\"A &amp; B\"/>\n"
                        "        <Metadata needs=\"an arm\"/>\n      </MetadataFields>\n"));
  EXPECT_THAT(ModelsMarkdown(factory), HasSubstr("needs: an arm\n"));
  EXPECT_EQ(factory.Find("Move")->metadata.size(), 2U);
  Factory::Registered node{.make = [](tree::Setup&) { return nullptr; },
                           .metadata = {{"a b", "c"}}};
  EXPECT_EQ(factory.Register("Wrong", node).error().message,
            "'a b' can not be the name of a field of the metadata of 'Wrong'");
}

}  // namespace musher::tree::conformance_substitutions_test
