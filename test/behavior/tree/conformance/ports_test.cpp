// Ports as BehaviorTree.CPP 4.10 documents them: defaults that are an entry.

#include "musher/behavior/tree/models.hpp"
#include "musher/test/behavior/tree/trees.hpp"

namespace musher::tree::conformance_ports_test {

using testing::HasSubstr;

// Adds `in` to `sum`, and writes the result to `out`.
class Add : public Action {
 public:
  explicit Add(Setup& setup)
      : in_(setup.Input<int>("in", FromEntry{"number"}, "a number")),
        sum_(setup.InOut<int>("sum", FromEntry{"="}, "the sum so far")),
        out_(setup.Output<int>("out", FromEntry{"result"})) {}

 private:
  Status Do(const Tick&) override {
    sum_.Set(sum_.Or(0) + in_.Get());
    out_.Set(sum_.Get());
    return Status::kSuccess;
  }

  InPort<int> in_;
  InOutPort<int> sum_;
  OutPort<int> out_;
};

struct ADefaultEntry : testing::Test {
  ADefaultEntry() { EXPECT_TRUE(factory.Add<Add>("Add")); }
  int Get(Tree& tree, const std::string& key) { return tree.board().Get<int>(key).value(); }

  Factory factory;
};

TEST_F(ADefaultEntry, IsReadAndWrittenWhereTheXmlLeavesThePortOut) {
  const auto tree = MakeTree(Main("<Add/>"), factory);
  ASSERT_TRUE(tree->board().Set("number", 3));
  EXPECT_EQ(Ticks(*tree, 2), "SS");
  EXPECT_EQ(Get(*tree, "sum"), 6);
  EXPECT_EQ(Get(*tree, "result"), 6);
}
TEST_F(ADefaultEntry, IsNotUsedWhereTheXmlSetsThePort) {
  const auto tree = MakeTree(Main("<Add in=\"5\" sum=\"{total}\" out=\"{=}\"/>"), factory);
  EXPECT_EQ(Ticks(*tree, 1), "S");
  EXPECT_EQ(Get(*tree, "total"), 5);
  EXPECT_EQ(Get(*tree, "out"), 5);
  EXPECT_FALSE(tree->board().Get<int>("result"));
}
TEST_F(ADefaultEntry, IsOneOfTheSubtreeInWhichTheNodeIs) {
  const auto tree = MakeTree(
      "<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\"><BehaviorTree ID=\"Main\">"
      "<SubTree ID=\"Part\" number=\"{mine}\"/></BehaviorTree>"
      "<BehaviorTree ID=\"Part\"><Add/></BehaviorTree></root>",
      factory);
  ASSERT_TRUE(tree->board().Set("mine", 4));
  EXPECT_EQ(Ticks(*tree, 1), "S");
  EXPECT_FALSE(tree->board().Get<int>("result")) << "an entry of the subtree";
}
TEST_F(ADefaultEntry, HasTheTypeOfThePort) {
  EXPECT_THAT(Findings(Main("<Sequence><Add/><Sleep msec=\"{number}\"/></Sequence>"), factory),
              HasSubstr("t.xml:3:30: error: port 'msec' (integer from 0) uses 'number', which is "
                        "of type integer at t.xml:3:11"));
}
TEST_F(ADefaultEntry, ThatNothingSetsIsTheErrorOfTheTick) {
  const auto tree = MakeTree(Main("<Add/>"), factory);
  EXPECT_THAT(tree->TickOnce(At(0)).error().message,
              HasSubstr("port 'in': the blackboard has no value of 'number'"));
}
TEST_F(ADefaultEntry, IsNoMisspeltKey) {
  EXPECT_EQ(Findings(Main("<Sequence><Script code=\"numbers := 3\"/><Add/></Sequence>"), factory),
            "");
}
TEST_F(ADefaultEntry, IsWrittenToModelsAndReadFromThem) {
  EXPECT_THAT(ModelsXml(factory),
              testing::AllOf(HasSubstr("name=\"in\" type=\"int\" default=\"{number}\""),
                             HasSubstr("name=\"out\" type=\"int\" default=\"{result}\"")));
  Factory checked;
  const Reading reading = ReadTree(
      "<root BTCPP_format=\"4\">\n<TreeNodesModel><Action ID=\"Go\"><input_port name=\"to\" "
      "type=\"int\" default=\"{=}\"/></Action></TreeNodesModel>\n<BehaviorTree ID=\"Main\">"
      "<Sequence><Go/><Sleep msec=\"{to}\"/></Sequence></BehaviorTree></root>",
      "t.xml");
  EXPECT_EQ(Texts(AddPlaceholders(checked, reading.document)), "");
  EXPECT_THAT(Texts(Build(reading.document, checked).diagnostics),
              HasSubstr("uses 'to', which is of type integer"));
}

}  // namespace musher::tree::conformance_ports_test
