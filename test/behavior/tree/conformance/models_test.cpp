// Files as Groot2 and nav2 write them are accepted, and findings about a node are one line each.

#include "musher/behavior/tree/models.hpp"
#include "musher/test/behavior/tree/trees.hpp"

namespace musher::tree::conformance_models_test {

using testing::HasSubstr;

std::string Checked(const std::string& models, const std::string& content) {
  Factory factory;
  const Reading reading = ReadTree("<root BTCPP_format=\"4\">\n<TreeNodesModel>\n" + models +
                                       "\n</TreeNodesModel>\n<BehaviorTree ID=\"Main\">\n" +
                                       content + "\n</BehaviorTree>\n</root>\n",
                                   "t.xml");
  std::string text = Texts(reading.diagnostics);
  text += Texts(AddPlaceholders(factory, reading.document));
  return text + Texts(Build(reading.document, factory).diagnostics);
}

TEST(FilesAsWritten, ABidirectionalPortIsAnInOutPort) {
  EXPECT_EQ(Checked("<Action ID=\"Spin\"><bidirectional_port name=\"id\"/></Action>",
                    "<Spin id=\"{x}\"/>"),
            "");
}
TEST(FilesAsWritten, AFixedTextOfAnInOutPortIsAccepted) {
  EXPECT_THAT(Checked("<Action ID=\"Spin\"><inout_port name=\"id\" type=\"int\"/></Action>",
                      "<Spin id=\"3\"/>"),
              testing::AllOf(Not(HasSubstr("error")), HasSubstr("what is written to it is lost")));
  EXPECT_THAT(Checked("<Action ID=\"Spin\"><inout_port name=\"id\" type=\"int\"/></Action>",
                      "<Spin id=\"3.5\"/>"),
              HasSubstr("error: port 'id': '3.5' is not valid: expected integer"));
}
TEST(FilesAsWritten, TheFoldedNodesOfGroot2HaveNoWarning) {
  EXPECT_EQ(Findings(Main("<Sequence _collapsed=\"true\"><AlwaysSuccess/></Sequence>")), "");
}
TEST(FilesAsWritten, AConditionMayBeWrittenAsAnAction) {
  EXPECT_EQ(Findings(Main("<Sequence><Action ID=\"ScriptCondition\" code=\"true\"/>"
                          "<Condition ID=\"AlwaysSuccess\"/></Sequence>")),
            "");
  EXPECT_THAT(Findings(Main("<Action ID=\"Inverter\"><AlwaysSuccess/></Action>")),
              HasSubstr("node 'Inverter' is registered as Decorator, not as Action"));
}
TEST(FilesAsWritten, AModelOfASubtreeWithoutIdIsAWarning) {
  EXPECT_EQ(Checked("<SubTree/>", "<AlwaysSuccess/>"),
            "t.xml:3:1: warning: <SubTree> needs the attribute 'ID', the name of a tree; it has no "
            "effect\n");
}
TEST(FilesAsWritten, AMissingModelIsOneErrorWithTheNumberOfItsUses) {
  EXPECT_EQ(Findings(Main("<Sequence>\n<Mov/>\n<Mov/>\n<Turn/>\n<Mov/></Sequence>")),
            "t.xml:4:1: error: there is no node 'Mov' (3 times)\n"
            "t.xml:6:1: error: there is no node 'Turn'\n");
}
TEST(FilesAsWritten, MissingDefaultsOfAModelAreOneWarning) {
  EXPECT_EQ(Checked("<Action ID=\"Go\"><input_port name=\"b\"/><input_port name=\"a\"/>"
                    "<input_port name=\"c\" default=\"1\"/></Action>",
                    "<Sequence>\n<Go a=\"1\"/>\n<Go/>\n<Go a=\"1\" b=\"2\"/></Sequence>"),
            "t.xml:7:1: warning: node 'Go' leaves out inputs that have no default in its model: "
            "'a', 'b' (2 times)\n");
}

}  // namespace musher::tree::conformance_models_test
