// The scripting language as BehaviorTree.CPP 4.10 documents it.

#include "musher/test/behavior/tree/scripts.hpp"
#include "musher/test/behavior/tree/trees.hpp"

namespace musher::tree::conformance_scripts_test {

struct ScriptsAsDocumented : testing::Test, Logged, ScriptRunner {
  // No script of this file is warned of.
  std::string Run(const std::string& text) {
    std::string result = ScriptRunner::Run(text);
    for (const auto& finding : findings) EXPECT_TRUE(finding.error) << "warning: " << finding.what;
    return result;
  }
  std::string Tick(const std::string& xml) {
    tree = MakeTree(xml, factory);
    const Result<Status> result = tree->TickOnce(At(0));
    return result ? std::string(Name(result.value())) : result.error().message;
  }
  std::unique_ptr<Tree> tree;
};

TEST_F(ScriptsAsDocumented, AndBindsTighterThanOr) {
  EXPECT_EQ(Run("true || true && false"), "1");
  EXPECT_EQ(Run("false && false || true"), "1");
  EXPECT_EQ(Run("true || false && false || false"), "1");
  EXPECT_EQ(Run("(true || true) && false"), "0");
  EXPECT_EQ(Run("1 < 2 || 1 == 2 && 1 == 2"), "1");
}

// Part has the port `level`, which reads a text or an entry.
class ReadsAText : public Action {
 public:
  explicit ReadsAText(Setup& setup) : text_(setup.OptionalInput<std::string>("text")) {}

 private:
  Status Do(const tree::Tick&) override {
    return text_.Find() == nullptr ? Status::kFailure : Status::kSuccess;
  }
  InPort<std::string> text_;
};

TEST_F(ScriptsAsDocumented, AnEqualsSignAssignsAnEntryThatAPortDeclares) {
  ASSERT_TRUE(factory.Add<ReadsAText>("ReadsAText"));
  EXPECT_EQ(Tick(Main("<Sequence><Script code=\"t = 'a'\"/><ReadsAText text=\"{t}\"/></Sequence>")),
            "SUCCESS");
  EXPECT_EQ(Tick(Main("<Sequence><Script code=\"v = 3\"/><SetBlackboard value=\"{v}\" "
                      "output_key=\"w\"/><ScriptCondition code=\"w == 3\"/></Sequence>")),
            "SUCCESS");
  EXPECT_EQ(Tick(Main("<Sequence><Script code=\"q = '1;2'\"/><LoopInt queue=\"{q}\" "
                      "value=\"{i}\"><AlwaysSuccess/></LoopInt></Sequence>")),
            "RUNNING");
}
TEST_F(ScriptsAsDocumented, AnEqualsSignNeedsAnEntry) {
  const std::string error =
      "t.xml:3:1: Main/Script: the blackboard has no value of 'x'; to make an entry, use ':='";
  EXPECT_EQ(Tick(Main("<Script code=\"x = 1\"/>")), error);
  EXPECT_EQ(Tick(Main("<Script code=\"x += 1\"/>")), error);
}
TEST_F(ScriptsAsDocumented, AnEqualsSignNeedsAnEntryAgainAfterItWasUnset) {
  EXPECT_EQ(Tick(Main("<Sequence><SetBlackboard value=\"{x}\" output_key=\"y\" _skipIf=\"true\"/>"
                      "<UnsetBlackboard key=\"x\"/><Script code=\"x = 1\"/></Sequence>")),
            "t.xml:3:95: Main/Sequence/Script: the blackboard has no value of 'x'; to make an "
            "entry, use ':='");
}

TEST_F(ScriptsAsDocumented, AComparisonConvertsATextToANumberABoolOrAnEnum) {
  EXPECT_EQ(Run("'2' == 2"), "1");
  EXPECT_EQ(Run("2 == '2'"), "1");
  EXPECT_EQ(Run("'1.5' > 1 && 1 < '1.5'"), "1");
  EXPECT_EQ(Run("'true' == true && 'false' == false"), "1");
  EXPECT_EQ(Run("'true' != false"), "1");
  EXPECT_EQ(Run("color := 'RED'; color == RED && color != BLUE"), "1");
  EXPECT_EQ(Run("n := 2; n == 'BLUE'"), "1");
  EXPECT_EQ(Run("0 < '1' < 2"), "1");
  EXPECT_EQ(Run("x := 'a'; x == 1"), "can not compare 'a' with 1");
}
TEST_F(ScriptsAsDocumented, AComparisonThatCanOnlyFailIsFoundWhenLoading) {
  EXPECT_EQ(Run("1 < 2 && 'a' == 1"),
            "16: 'a' can not be compared with 1: it is neither a number nor the name of an enum");
  EXPECT_EQ(Run("0 < RED != 'GREEN'"),
            "11: 'GREEN' can not be compared with 1: it is neither a number nor the name of an "
            "enum");
}
TEST_F(ScriptsAsDocumented, AnEqualsSignThatCanOnlyFailIsFoundWhenLoading) {
  const std::string warning =
      "warning: nothing in the tree makes 'x', which '=' needs: use ':=', unless the program sets "
      "it\n";
  EXPECT_EQ(Findings(Main("<Script code=\"x = 1\"/>")), "t.xml:3:15: " + warning);
  EXPECT_EQ(Findings(Main("<AlwaysSuccess _onSuccess=\"x += 1\"/>")), "t.xml:3:28: " + warning);
  EXPECT_EQ(Findings(Main("<Script code=\"x := 1; x = 2\"/>")), "");
  EXPECT_EQ(Findings(Main("<Sequence><AlwaysSuccess _skipIf=\"false\" _post=\"x := 1\"/>"
                          "<Script code=\"x = 2\"/></Sequence>")),
            "");
  EXPECT_EQ(Findings(Main("<Sequence><SetBlackboard value=\"1\" output_key=\"x\"/>"
                          "<Script code=\"x = 2\"/></Sequence>")),
            "");
}
TEST_F(ScriptsAsDocumented, AnEqualsSignBeforeTheEntryIsMadeIsFoundWhenLoading) {
  const std::string set = "<Script code=\"x = 2\"/>";
  const std::string make = "<Script code=\"x := 1\"/>";
  const std::string warning =
      "warning: only what runs later makes 'x', which '=' needs: use ':=', unless the program sets "
      "it\n";
  EXPECT_EQ(Findings(Main("<Sequence>" + set + make + "</Sequence>")), "t.xml:3:25: " + warning);
  EXPECT_THAT(Findings(Main("<Fallback><AlwaysFailure/><Sequence>" + set + "</Sequence><Inverter>" +
                            make + "</Inverter></Fallback>")),
              testing::HasSubstr(warning));
  EXPECT_THAT(Findings(Main("<Precondition if=\"x = 2\">" + make + "</Precondition>")),
              testing::HasSubstr(warning));
  for (const std::string& content :
       {make + set, "<Switch2 variable=\"{v}\" case_1=\"1\">" + set + make + make + "</Switch2>",
        "<Fallback><Sequence><AlwaysFailure/>" + set + "</Sequence>" + make + "</Fallback>",
        "<Sequence _skipIf=\"v\">" + set + "</Sequence>" + make,
        "<Delay delay_msec=\"5\">" + set + "</Delay>" + make,
        "<Script code=\"x = 2\" _skipIf=\"v\"/>" + make,
        "<AlwaysSuccess _post=\"x = 2\"/>" + make}) {
    const std::string unsure = "<Script code=\"v := false\"/>";
    EXPECT_EQ(Findings(Main("<Sequence>" + unsure + content + "</Sequence>")), "") << content;
  }
}
// `tree check` found nothing, and the mission ended in its first tick.
TEST_F(ScriptsAsDocumented, ANameThatNothingSetsIsFoundWhenLoading) {
  const std::string read = "<ScriptCondition code=\"level &gt; 3\"/>";
  EXPECT_EQ(
      Findings(Main(read)),
      "t.xml:3:24: warning: nothing in the tree sets 'level', and without a value this script "
      "ends the mission, unless the program sets it\n");
  EXPECT_EQ(Findings(Main("<Sequence>" + read + read + "</Sequence>")).find("warning"),
            Findings(Main("<Sequence>" + read + read + "</Sequence>")).rfind("warning"))
      << "once for each name";
  for (const char* sets :
       {"<Script code=\"level := 1\"/>", "<SetBlackboard value=\"1\" output_key=\"level\"/>",
        "<AlwaysSuccess _onSuccess=\"level := 1\"/>"}) {
    EXPECT_EQ(Findings(Main("<Sequence>" + read + std::string(sets) + "</Sequence>")), "") << sets;
  }
}
TEST_F(ScriptsAsDocumented, TwoTextsAreComparedAsTexts) {
  EXPECT_EQ(Run("'2' == '2.0'"), "0");
  EXPECT_EQ(Run("'10' < '9'"), "1");
}
TEST_F(ScriptsAsDocumented, AFixedTextOfASubtreeComparesWithABool) {
  const auto run = [this](const std::string& flag, const std::string& code) {
    return Tick(
        "<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\"><BehaviorTree ID=\"Main\">"
        "<SubTree ID=\"Part\" flag=\"" +
        flag + "\"/></BehaviorTree><BehaviorTree ID=\"Part\"><ScriptCondition code=\"" + code +
        "\"/></BehaviorTree></root>");
  };
  EXPECT_EQ(run("true", "flag == true"), "SUCCESS");
  EXPECT_EQ(run("false", "flag == true"), "FAILURE");
  EXPECT_EQ(run("true", "flag == 1"), "SUCCESS");
  EXPECT_EQ(run("true", "!flag"), "FAILURE");
  EXPECT_EQ(run("false", "!flag"), "SUCCESS");
  EXPECT_EQ(run("3", "flag == '3'"), "SUCCESS");
}

TEST_F(ScriptsAsDocumented, TwoDotsJoinTextsAndNumbers) {
  EXPECT_EQ(Run("'a' .. 'b'"), "'ab'");
  EXPECT_EQ(Run("'n' .. 3 .. 'm' .. 0.5"), "'n3m0.5'");
  EXPECT_EQ(Run("1..2"), "'12'");
  EXPECT_EQ(Run("x := 2; 'x' .. x + 1"), "'x3'");
  EXPECT_EQ(Run("'a' .. 1 == 'a1'"), "1");
  EXPECT_EQ(Run("'a' .. 100000"), "'a100000'");
  EXPECT_EQ(Run("x := 0; 'a' .. -x"), "'a0'");
}

TEST_F(ScriptsAsDocumented, WholeNumbersThatAreReadAsTextsPrintAsWholeNumbers) {
  for (const auto& [number, text] :
       std::vector<std::pair<double, std::string>>{{100000, "100000"},
                                                   {-2e6, "-2000000"},
                                                   {1e15, "1000000000000000"},
                                                   {0, "0"},
                                                   {-0.0, "0"},
                                                   {0.5, "0.5"},
                                                   {1e300, "1e+300"}}) {
    ASSERT_TRUE(board.Set("n", number));
    EXPECT_EQ(board.Get<std::string>("n").value(), text);
    EXPECT_EQ(board.At("n").value.Shown(), text);
  }
}

TEST_F(ScriptsAsDocumented, ANumberThatALetterFollowsIsAnErrorAtItsPlace) {
  EXPECT_EQ(Findings(Main("<Script code=\"n := 1x\"/>")),
            "t.xml:3:20: error: script in code: expected a number such as 2, 0.5, 1e3 or 0x1F\n");
}

// Each would need as many frames of the stack as it has operators.
TEST_F(ScriptsAsDocumented, AScriptWhoseDepthWouldExhaustTheStackIsRefused) {
  const auto repeated = [](int times, const std::string& text) {
    std::string all;
    for (int i = 0; i < times; ++i) all += text;
    return all;
  };
  constexpr int kMany = 200'000;
  for (const std::string& text :
       {repeated(kMany, "1+") + "1", repeated(kMany, "1*") + "1", repeated(kMany, "1&&") + "1",
        repeated(kMany, "1|") + "1", repeated(kMany, "'a'..") + "1", repeated(kMany, "1?2:") + "1",
        repeated(kMany, "1?") + "1", repeated(kMany, "x:=") + "1", repeated(kMany, "1<(") + "1",
        repeated(90, "1<2<(" + repeated(900, "1+")) + "1" + repeated(90, ")")}) {
    EXPECT_THAT(Run(text), testing::HasSubstr("nested too deeply")) << text.substr(0, 20);
  }
  EXPECT_EQ(Run(repeated(900, "1+") + "1"), "901");
  EXPECT_EQ(Run(repeated(kMany, "0;") + "1"), "1");
  EXPECT_EQ(Run(repeated(kMany, "0<=") + "1"), "1");
  EXPECT_EQ(Run(repeated(40, "false ? 1 : ") + "2"), "2");
}

}  // namespace musher::tree::conformance_scripts_test
