// Faults of nodes, types of entries and names: as BehaviorTree.CPP 4.10 documents them, or as the
// table of differences in docs/behavior-trees.md says.

#include "musher/test/behavior/tree/trees.hpp"

namespace musher::tree::conformance_nodes_test {

using testing::HasSubstr;

struct Nodes : testing::Test, Logged {
  std::string Tick(const std::string& content) {
    tree = MakeTree(Main(content), factory);
    return tree == nullptr ? "" : TickAgain();
  }
  std::string TickAgain() {
    const Result<Status> result = tree->TickOnce(At(0));
    return result ? std::string(Name(result.value())) : result.error().message;
  }
  std::unique_ptr<Tree> tree;
};

TEST_F(Nodes, AFaultHasThePlaceInTheFileAndAPathThatNoOtherNodeHas) {
  EXPECT_EQ(Tick("<Sequence>\n<Say name=\"a\" does=\"S\"/>\n <Say name=\"a\" does=\"!\"/>\n"
                 "</Sequence>"),
            "t.xml:5:2: Main/Sequence/a#2: it broke");
  EXPECT_EQ(tree->Path(1), "Main/Sequence/a");
  EXPECT_EQ(tree->Path(2), "Main/Sequence/a#2");
  EXPECT_EQ(tree->Find("Main/Sequence/a"), 1U);
  EXPECT_EQ(tree->Find("Main/Sequence/a#2"), 2U);
}
TEST_F(Nodes, APatternOfTestNodesMeansAllNodesOfTheName) {
  factory.Substitute("*/a", {.result = Status::kFailure});
  EXPECT_EQ(Tick("<Fallback><Say name=\"a\" does=\"!\"/><Say name=\"a\" does=\"!\"/></Fallback>"),
            "FAILURE");
}

enum class Colour : std::uint8_t { kRed = 1, kBlue = 2 };
class Paint : public Action {
 public:
  explicit Paint(Setup& setup)
      : colour_(setup.Input<Colour>("colour")), layers_(setup.Input<int>("layers", 1)) {}

 private:
  Status Do(const tree::Tick&) override {
    return colour_.Get() == Colour::kRed ? Status::kSuccess : Status::kFailure;
  }
  InPort<Colour> colour_;
  InPort<int> layers_;
};

TEST_F(Nodes, AWrongNameOfAnEnumIsReportedWithTheKnownOnes) {
  ASSERT_TRUE(factory.Add<Paint>("Paint"));
  factory.AddEnum("RED", 1);
  factory.AddEnum("BLUE", 2);
  EXPECT_EQ(Tick("<Paint colour=\"RED\"/>"), "SUCCESS");
  EXPECT_THAT(Findings(Main("<Paint colour=\"REED\"/>"), factory),
              HasSubstr("port 'colour': 'REED' is not valid: expected BLUE (2), RED (1)"));
  EXPECT_THAT(Findings(Main("<Paint colour=\"RED\" layers=\"TWO\"/>"), factory),
              HasSubstr("'TWO' is not valid: expected integer, or BLUE (2), RED (1)"));
}

TEST_F(Nodes, AFractionIsNoValueOfAnEntryOfWholeNumbers) {
  ASSERT_TRUE(factory.Add<Paint>("Paint"));
  EXPECT_THAT(Tick("<Sequence><Script code=\"n := 2; n := 2.7\"/>"
                   "<Paint colour=\"{c}\" layers=\"{n}\"/></Sequence>"),
              HasSubstr("'n': 2.7 is not valid: expected integer"));
  EXPECT_EQ(tree->board().Get<int>("n").value(), 2);
}
TEST_F(Nodes, AnEntryThatNoPortGivesATypeTakesValuesOfAnyType) {
  EXPECT_EQ(Tick("<Sequence><Script code=\"x := 1; x := 'a'; x := 2.5\"/>"
                 "<ScriptCondition code=\"x == 2.5\"/></Sequence>"),
            "SUCCESS");
}
TEST_F(Nodes, ATreeMayHaveTheNameOfANode) {
  tree = MakeTree(
      "<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\"><BehaviorTree ID=\"Main\">"
      "<SubTree ID=\"AlwaysFailure\"/></BehaviorTree><BehaviorTree ID=\"AlwaysFailure\">"
      "<AlwaysSuccess/></BehaviorTree></root>");
  EXPECT_EQ(TickAgain(), "SUCCESS");
}
TEST_F(Nodes, TwoSubtreesOfOneNameHaveDifferentPaths) {
  tree = MakeTree(
      "<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\"><BehaviorTree ID=\"Main\"><Sequence>"
      "<SubTree ID=\"Part\" name=\"p\"/><SubTree ID=\"Part\" name=\"p\"/></Sequence></BehaviorTree>"
      "<BehaviorTree ID=\"Part\"><AlwaysSuccess/></BehaviorTree></root>");
  EXPECT_EQ(tree->Path(2), "Main/Sequence/p/AlwaysSuccess");
  EXPECT_EQ(tree->Path(4), "Main/Sequence/p#2/AlwaysSuccess");
}

template <class Thrown>
class DoesNotStart : public Action {
 public:
  DoesNotStart() { throw Thrown(); }

 private:
  Status Do(const tree::Tick&) override { return Status::kSuccess; }
};
TEST_F(Nodes, AConstructorThatThrowsAnythingIsAnErrorAtItsPlace) {
  ASSERT_TRUE(factory.Add<DoesNotStart<int>>("Bad"));
  EXPECT_EQ(Findings(Main("<Bad/>"), factory),
            "t.xml:3:1: error: node 'Bad' can not be made: an unknown exception\n");
}

TEST_F(Nodes, AnInvalidStatusIsAFault) {
  ASSERT_TRUE(factory.AddCondition("Odd", [](const auto&) { return static_cast<Status>(9); }));
  EXPECT_THAT(Tick("<Odd/>"), HasSubstr("Main/Odd: its tick returned no status (9)"));
}

template <char kKind>
class Named : public Action {
 public:
  explicit Named(Setup& setup) {
    setup.OptionalInput<int>(kKind == 'n' ? "name" : kKind == 'i' ? "ID" : "_x");
  }

 private:
  Status Do(const tree::Tick&) override { return Status::kSuccess; }
};
TEST_F(Nodes, APortWithAReservedNameIsAnError) {
  ASSERT_TRUE(factory.Add<Named<'n'>>("A"));
  ASSERT_TRUE(factory.Add<Named<'i'>>("B"));
  ASSERT_TRUE(factory.Add<Named<'_'>>("C"));
  EXPECT_THAT(Findings(Main("<Sequence><A/><B/><C/></Sequence>"), factory),
              testing::AllOf(HasSubstr("node 'A' has a port 'name', which is reserved"),
                             HasSubstr("node 'B' has a port 'ID', which is reserved"),
                             HasSubstr("node 'C' has a port '_x', which is reserved")));
}

TEST_F(Nodes, NodesPortsAndTreesMayHaveNamesInAnyLanguage) {
  ASSERT_TRUE(factory.Add<Say>("检查门状态", log));
  EXPECT_EQ(Tick("<检查门状态 name=\"a\" does=\"S\"/>"), "SUCCESS");
  for (const std::string bad : {"", "a b", "a/b", "1a", "a<", "root"}) {
    EXPECT_FALSE(factory.Add<Say>(bad, log)) << bad;
  }
}

TEST_F(Nodes, ANodeNeitherTicksNorHaltsItsOwnTree) {
  std::string said;
  int ticks = 0;
  ASSERT_TRUE(factory.AddCondition("Stop", [&](const auto&) {
    if (++ticks < 2) return Status::kRunning;
    const Result<> halted = tree->Halt(At(0));
    const Result<Status> ticked = tree->TickOnce(At(0));
    said = (halted ? "" : halted.error().message) + "; " + (ticked ? "" : ticked.error().message);
    return Status::kSuccess;
  }));
  EXPECT_EQ(Tick("<Parallel><Say name=\"a\" does=\"R\"/><Stop/></Parallel>"), "RUNNING");
  EXPECT_EQ(TickAgain(), "RUNNING");
  EXPECT_EQ(said,
            "a node of tree Main halts its own tree: do that after the tick; "
            "a node of tree Main ticks its own tree: do that after the tick");
  EXPECT_EQ(Take(), "a^ a ");
  EXPECT_TRUE(tree->Halt(At(10)).ok());
}

}  // namespace musher::tree::conformance_nodes_test
