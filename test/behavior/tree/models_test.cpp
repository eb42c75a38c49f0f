// Models of nodes: written for editors, read to check trees without their program.

#include <fstream>

#include "musher/behavior/tree/models.hpp"
#include "musher/behavior/tree/write_tree.hpp"
#include "musher/test/behavior/tree/trees.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::tree::models_test {

using testing::HasSubstr;
using testing::Not;

class Walk : public StatefulAction {
 public:
  explicit Walk(Setup& setup)
      : goal_(setup.Input<double>("goal_m", "m, \"<0\" is behind")),
        gait_(setup.Input<int>("gait", 3)),
        way_(setup.Output<double>("way_m")) {}

 private:
  Status OnStart(const Tick&) override { return Status::kRunning; }
  Status OnRunning(const Tick&) override { return Status::kSuccess; }
  InPort<double> goal_;
  InPort<int> gait_;
  OutPort<double> way_;
};

class Look : public Action {
 public:
  explicit Look(Setup& setup) : at_(setup.OptionalInput<double>("at_rad")) {}

 private:
  Status Do(const Tick&) override { return Status::kSuccess; }
  InPort<double> at_;
};

// The diagnostics of a document whose nodes come from models: its own, or those of `models`.
std::string Checked(const std::string& xml, const std::string& models = "") {
  Factory factory;
  std::string text;
  if (!models.empty()) {
    const TempFolder temp;
    std::ofstream(temp / "m.xml") << models;
    const Reading reading = ReadModelsFile(temp / "m.xml");
    EXPECT_TRUE(reading.ok()) << Texts(reading.diagnostics);
    text += Texts(AddPlaceholders(factory, reading.document));
  }
  const Reading reading = ReadTree(xml, "t.xml");
  EXPECT_TRUE(reading.ok()) << Texts(reading.diagnostics);
  text += Texts(AddPlaceholders(factory, reading.document));
  return text + Texts(Build(reading.document, factory).diagnostics);
}
std::string Document(const std::string& models, const std::string& content) {
  return "<root BTCPP_format=\"4\">\n<TreeNodesModel>\n" + models +
         "\n</TreeNodesModel>\n<BehaviorTree ID=\"Main\">\n" + content +
         "\n</BehaviorTree>\n</root>\n";
}

// It named a port's type as Musher does, and the models as BehaviorTree.CPP does.
TEST(Models, OfAWrittenTreeNameTheTypesAsTheModelsDo) {
  const Factory factory;
  const Reading reading = ReadTree(
      "<root BTCPP_format=\"4\"><BehaviorTree ID=\"Main\"><Delay delay_msec=\"5\">"
      "<AlwaysSuccess/></Delay></BehaviorTree></root>",
      "t.xml");
  const auto built = Build(reading.document, factory);
  ASSERT_TRUE(built.tree) << Texts(built.diagnostics);
  const std::string port = "<input_port name=\"delay_msec\" type=\"unsigned int\"";
  ASSERT_THAT(ModelsXml(factory), HasSubstr(port));
  EXPECT_THAT(WriteTree(*built.tree, reading.document, {.models = &factory}), HasSubstr(port));
}

TEST(Models, AreWrittenWithTheirPorts) {
  Factory factory;
  ASSERT_TRUE(factory.Add<Walk>("Walk"));
  const std::string xml = ModelsXml(factory);
  EXPECT_THAT(xml, HasSubstr("    <Action ID=\"Walk\">\n"
                             "      <input_port name=\"goal_m\" type=\"double\">m, "
                             "&quot;&lt;0&quot; is behind</input_port>\n"
                             "      <input_port name=\"gait\" type=\"int\" default=\"3\"/>\n"
                             "      <output_port name=\"way_m\" type=\"double\"/>\n"
                             "    </Action>\n"));
  EXPECT_THAT(xml, HasSubstr("<Control ID=\"Sequence\">"));
  for (const std::string& name : Factory().Names()) EXPECT_NE(DescriptionOf(name), "") << name;
}

TEST(Models, ThatWereWrittenAreReadAgain) {
  Factory program;
  ASSERT_TRUE(program.Add<Walk>("Walk"));
  const std::string xml = ModelsXml(program);
  EXPECT_EQ(Checked(Main("<Walk goal_m=\"2\" way_m=\"{way}\"/>"), xml), "");
  const TempFolder temp;
  std::ofstream(temp / "m.xml") << xml;
  const Reading reading = ReadModelsFile(temp / "m.xml");
  Factory factory;
  EXPECT_EQ(Texts(AddPlaceholders(factory, reading.document)), "");
  EXPECT_EQ(factory.Names(), program.Names());
  const std::vector<PortModel> ports = factory.PortsOf("Walk");
  ASSERT_EQ(ports.size(), 3U);
  EXPECT_EQ(ports[0].type, TypeOf<double>());
  EXPECT_EQ(ports[1].otherwise, "3");
  EXPECT_EQ(ports[2].direction, Direction::kOut);
}

// It warned of each optional input of a program's own nodes that a tree leaves out.
TEST(Models, LeaveOptionalInputsOptional) {
  Factory program;
  ASSERT_TRUE(program.Add<Look>("Look"));
  const std::string xml = ModelsXml(program);
  EXPECT_THAT(xml, HasSubstr("<input_port name=\"at_rad\" type=\"double\" default=\"\"/>"));
  EXPECT_EQ(Checked(Main("<Look/>"), xml), "");
  EXPECT_THAT(Checked(Main("<Look at_rad=\"x,y\"/>"), xml), HasSubstr("'x,y' is not valid"));
}

TEST(Placeholders, HaveThePortsOfTheirModel) {
  const std::string model =
      "<Action ID=\"Walk\"><input_port name=\"goal_m\" type=\"double\"/>"
      "<output_port name=\"way\"/></Action>";
  EXPECT_EQ(
      Checked(Document(model, "<Walk goal_m=\"far\" way=\"3\"/>")),
      "t.xml:6:15: warning: port 'goal_m': 'far' is not valid: expected number, or the name of "
      "an enum that the program has\n"
      "t.xml:6:25: error: port 'way' is written; expected an entry, such as \"{way}\"\n");
  EXPECT_THAT(Checked(Document(model, "<Walk goal_m=\"1,5\" spead=\"3\"/>")),
              HasSubstr("t.xml:6:15: error: port 'goal_m': '1,5' is not valid: expected number"));
  EXPECT_THAT(
      Checked(Document(model, "<Walk goal_n=\"1\"/>")),
      testing::AllOf(
          HasSubstr("t.xml:6:7: error: <Walk> has no port 'goal_n'; did you mean 'goal_m'?"),
          HasSubstr("t.xml:6:1: warning: node 'Walk' leaves out inputs that have no default in "
                    "its model: 'goal_m'")));
}

TEST(Placeholders, HaveTheChildrenOfTheirKind) {
  const std::string models =
      "<Decorator ID=\"Guard\"/><Control ID=\"Both\"/><Condition ID=\"Ok\"/>";
  EXPECT_EQ(Checked(Document(models, "<Both><Guard><Ok/></Guard></Both>")), "");
  EXPECT_THAT(Checked(Document(models, "<Both><Guard/><Ok><Ok/></Ok></Both>")),
              testing::AllOf(HasSubstr("node 'Guard' has 0 children; expected 1"),
                             HasSubstr("node 'Ok' has 1 child; expected 0")));
  EXPECT_THAT(Checked(Document(models, "<Action ID=\"Both\"><Ok/></Action>")),
              HasSubstr("node 'Both' is registered as Control, not as Action"));
}

TEST(Placeholders, GiveNoWarningThatDependsOnWhetherTheyTakeTime) {
  EXPECT_EQ(Checked(Document("<Action ID=\"Walk\"/>",
                             "<ReactiveSequence><Walk/><Timeout msec=\"5\"><Inverter><Walk/>"
                             "</Inverter></Timeout></ReactiveSequence>")),
            "");
}

TEST(Placeholders, FailInATick) {
  Factory factory;
  const Reading reading = ReadTree(Document("<Action ID=\"Walk\"/>", "<Walk/>"), "t.xml");
  EXPECT_EQ(Texts(AddPlaceholders(factory, reading.document)), "");
  const Built built = Build(reading.document, factory);
  ASSERT_NE(built.tree, nullptr) << Texts(built.diagnostics);
  EXPECT_EQ(built.tree->TickOnce(At(0)).error().message,
            "t.xml:6:1: Main/Walk: the node is a placeholder of a model; its program has the node");
}

TEST(Placeholders, AreRefusedWithTheirPlaceWhereTheModelIsWrong) {
  const std::string found =
      Checked(Document("<Acton ID=\"a\"/>\n<Action/>\n<Action ID=\"a b\"/>\n"
                       "<Action ID=\"b\"><input name=\"x\"/><input_port/></Action>",
                       "<AlwaysSuccess/>"));
  EXPECT_EQ(found,
            "t.xml:3:1: error: <Acton> has no place in <TreeNodesModel>; did you mean <Action>?\n"
            "t.xml:4:1: error: <Action> needs the attribute 'ID', the node's name\n"
            "t.xml:5:13: error: 'a b' can not be the name of a node\n"
            "t.xml:6:16: error: <input> has no place in a model\n"
            "t.xml:6:33: error: <input_port> needs the attribute 'name'\n");
}

TEST(Placeholders, DoNotTakeThePlaceOfNodesThatAreThere) {
  EXPECT_THAT(Checked(Document("<Action ID=\"Sleep\"/>", "<Sleep/>")),
              HasSubstr("<Sleep> needs port 'msec'"));
}

TEST(NodesReference, IsThatOfTheNodes) {
  const std::string path = SourceDir() + "/docs/tree-nodes.md";
  const std::string begin = "<!-- generated -->\n\n";
  std::ifstream file(path);
  std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const std::size_t at = text.find(begin);
  ASSERT_NE(at, std::string::npos);
  const std::string expected = text.substr(0, at) + begin + ModelsMarkdown(Factory());
  if (std::getenv("MUSHER_UPDATE_GOLDEN") != nullptr) {  // NOLINT(concurrency-mt-unsafe)
    std::ofstream(path) << expected;
    text = expected;
  }
  EXPECT_EQ(text, expected) << "docs/tree-nodes.md is old: run this test with "
                               "MUSHER_UPDATE_GOLDEN=1";
}

}  // namespace musher::tree::models_test
