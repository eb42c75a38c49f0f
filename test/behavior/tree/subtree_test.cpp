// Subtrees and blackboards: remapping, autoremap, defaults, types; pre- and postconditions.

#include "musher/test/behavior/tree/trees.hpp"

namespace musher::tree::subtree_test {

// Two trees: Main with `main`, and Sub with `sub`.
std::string Both(const std::string& main, const std::string& sub, const std::string& more = "") {
  return "<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\">\n<BehaviorTree ID=\"Main\">" +
         main + "</BehaviorTree>\n<BehaviorTree ID=\"Sub\">" + sub + "</BehaviorTree>\n" + more +
         "</root>";
}
std::string Script(const std::string& code) {
  return "<Script code=\"" + code + "\"/>";
}

TEST(Subtree, HasABlackboardOfItsOwn) {
  const auto tree = MakeTree(
      Both("<Sequence>" + Script("x := 1") + "<SubTree ID=\"Sub\"/></Sequence>", Script("x := 2")));
  EXPECT_EQ(Ticks(*tree, 1), "S");
  EXPECT_EQ(tree->board().Get<int>("x").value(), 1);
  EXPECT_EQ(tree->board(3).Get<int>("x").value(), 2);
}
TEST(Subtree, RemapsKeysBothWays) {
  const auto tree = MakeTree(Both(
      "<Sequence>" + Script("x := 1") + "<SubTree ID=\"Sub\" in=\"{x}\" out=\"{=}\"/></Sequence>",
      Script("out := in + 1")));
  EXPECT_EQ(Ticks(*tree, 1), "S");
  EXPECT_EQ(tree->board().Get<int>("out").value(), 2);
}
TEST(Subtree, TakesFixedTextsAsNumbersOrTexts) {
  const auto tree =
      MakeTree(Both("<SubTree ID=\"Sub\" n=\"1.5\" t=\"go\"/>",
                    "<Sequence>" + Script("@sum := n * 2; @word := t + '!'") + "</Sequence>"));
  EXPECT_EQ(Ticks(*tree, 1), "S");
  EXPECT_EQ(tree->board().Get<double>("sum").value(), 3);
  EXPECT_EQ(tree->board().Get<std::string>("word").value(), "go!");
}
TEST(Subtree, AutoremapsAllButPrivateKeys) {
  const auto tree = MakeTree(Both("<SubTree ID=\"Sub\" _autoremap=\"true\" own=\"5\"/>",
                                  Script("x := 1; _y := 2; own := own + 1")));
  EXPECT_EQ(Ticks(*tree, 1), "S");
  EXPECT_EQ(tree->board().Keys(), (std::vector<std::string>{"x"}));
  EXPECT_EQ(tree->board(1).Get<int>("own").value(), 6);
  EXPECT_EQ(tree->board(1).Get<int>("_y").value(), 2);
}
TEST(Subtree, RemapsThroughSeveralLevels) {
  const auto tree = MakeTree(
      "<root BTCPP_format=\"4\" main_tree_to_execute=\"A\">"
      "<BehaviorTree ID=\"A\"><SubTree ID=\"B\" b=\"{a}\"/></BehaviorTree>"
      "<BehaviorTree ID=\"B\"><SubTree ID=\"C\" c=\"{b}\" _autoremap=\"1\"/></BehaviorTree>"
      "<BehaviorTree ID=\"C\">" +
      Script("c := 4; d := 5; @e := 6") + "</BehaviorTree></root>");
  EXPECT_EQ(Ticks(*tree, 1), "S");
  EXPECT_EQ(tree->board().Get<int>("a").value(), 4);
  EXPECT_EQ(tree->board(1).Get<int>("d").value(), 5);
  EXPECT_EQ(tree->board().Get<int>("e").value(), 6);
}
TEST(Subtree, HasDefaultsFromItsModel) {
  const std::string model =
      "<TreeNodesModel><SubTree ID=\"Sub\"><input_port name=\"n\" default=\"3\"/>"
      "<input_port name=\"m\"/></SubTree></TreeNodesModel>";
  const auto tree = MakeTree(Both("<SubTree ID=\"Sub\" m=\"4\"/>", Script("@sum := n + m"), model));
  EXPECT_EQ(Ticks(*tree, 1), "S");
  EXPECT_EQ(tree->board().Get<int>("sum").value(), 7);
  EXPECT_THAT(Findings(Both("<SubTree ID=\"Sub\"/>", Script("@sum := n + m"), model)),
              testing::HasSubstr("t.xml:2:25: error: <SubTree ID=\"Sub\"> needs 'm', which "
                                 "<TreeNodesModel> declares without a default"));
}
TEST(Subtree, UsedTwiceKeepsTwoStates) {
  const auto tree = MakeTree(
      Both("<Sequence><SubTree ID=\"Sub\" n=\"{a}\"/><SubTree ID=\"Sub\" n=\"{b}\"/></Sequence>",
           Script("n := 1")));
  EXPECT_EQ(Ticks(*tree, 1), "S");
  EXPECT_EQ(tree->board().Keys(), (std::vector<std::string>{"a", "b"}));
}
TEST(Subtree, RefusesRecursion) {
  EXPECT_THAT(
      Findings(Both("<SubTree ID=\"Sub\"/>", "<Inverter><SubTree ID=\"Main\"/></Inverter>")),
      testing::HasSubstr("t.xml:3:47: error: the trees are recursive: Main -> Sub -> Main"));
}
TEST(Subtree, NamesTheNearestTree) {
  EXPECT_THAT(Findings(Both("<SubTree ID=\"Sup\"/>", "<AlwaysSuccess/>")),
              testing::HasSubstr("t.xml:2:38: error: there is no tree 'Sup'; did you mean 'Sub'?"));
}
TEST(Subtree, ThatGrowsExponentiallyIsRefused) {
  std::string xml = "<root BTCPP_format=\"4\" main_tree_to_execute=\"T0\">";
  for (int i = 0; i < 30; ++i) {
    const std::string sub = "<SubTree ID=\"T" + std::to_string(i + 1) + "\"/>";
    xml += "<BehaviorTree ID=\"T" + std::to_string(i) + "\"><Sequence>" + sub + sub +
           "</Sequence></BehaviorTree>\n";
  }
  xml += "<BehaviorTree ID=\"T30\"><AlwaysSuccess/></BehaviorTree></root>";
  EXPECT_THAT(Findings(xml), testing::HasSubstr("the tree has more than"));
}

// <Typed in="..." out="..."/> with ports of type T.
template <class T>
class Typed : public Action {
 public:
  explicit Typed(Setup& setup) : in_(setup.OptionalInput<T>("in")), out_(setup.Output<T>("out")) {}
  Status Do(const Tick&) override {
    if (const T* value = in_.Find()) out_.Set(*value);
    return Status::kSuccess;
  }

 private:
  InPort<T> in_;
  OutPort<T> out_;
};

struct Pose {
  double x = 0;
  double y = 0;
  std::vector<double> more{};
  friend bool operator==(const Pose&, const Pose&) = default;
};

}  // namespace musher::tree::subtree_test

template <>
struct musher::tree::Convert<musher::tree::subtree_test::Pose> {
  static constexpr std::string_view kName = "pose";
  static Result<subtree_test::Pose> FromText(std::string_view text) {
    const auto numbers = Convert<std::vector<double>>::FromText(text);
    if (!numbers || numbers.value().size() != 2) return NoValue(text, "a pose \"x;y\"");
    return subtree_test::Pose{numbers.value()[0], numbers.value()[1]};
  }
};

namespace musher::tree::subtree_test {

struct Types : testing::Test {
  Types() {
    EXPECT_TRUE(factory.Add<Typed<int>>("Int"));
    EXPECT_TRUE(factory.Add<Typed<double>>("Double"));
    EXPECT_TRUE(factory.Add<Typed<std::string>>("Text"));
    EXPECT_TRUE(factory.Add<Typed<Pose>>("Pose"));
    factory.AddEnum("RED", 4);
  }
  Factory factory;
};

TEST_F(Types, ConvertTextsWhenTheTreeIsBuilt) {
  const auto tree =
      MakeTree(Main("<Sequence><Int in=\"12\" out=\"{i}\"/><Int in=\"RED\" out=\"{r}\"/>"
                    "<Pose in=\"1;2\" out=\"{p}\"/><Pose in=\"{p}\" out=\"{q}\"/>"
                    "</Sequence>"),
               factory);
  EXPECT_EQ(Ticks(*tree, 1), "S");
  EXPECT_EQ(tree->board().Get<int>("i").value(), 12);
  EXPECT_EQ(tree->board().Get<int>("r").value(), 4);
  EXPECT_EQ(tree->board().Get<Pose>("q").value(), (Pose{1, 2}));
}
TEST_F(Types, ReportATextOfAnotherTypeAtItsPlace) {
  EXPECT_EQ(
      Findings(Main("<Sequence>\n  <Int in=\"1.5\"/>\n  <Pose in=\"x\"/>\n</Sequence>"), factory),
      "t.xml:4:12: error: port 'in': '1.5' is not valid: expected integer\n"
      "t.xml:5:13: error: port 'in': 'x' is not valid: expected a pose \"x;y\"\n");
}
TEST_F(Types, ReportAnEntryThatPortsUseWithTwoTypes) {
  EXPECT_EQ(Findings(Main("<Sequence>\n  <Int out=\"{v}\"/>\n  <Double in=\"{v}\"/>\n</Sequence>"),
                     factory),
            "t.xml:5:15: error: port 'in' (number) uses 'v', which is of type integer at "
            "t.xml:4:13\n");
}
TEST_F(Types, AreCheckedAcrossSubtrees) {
  EXPECT_THAT(
      Findings(Both("<Sequence><Int out=\"{v}\"/><SubTree ID=\"Sub\" w=\"{v}\"/></Sequence>",
                    "<Double in=\"{w}\"/>"),
               factory),
      testing::HasSubstr("t.xml:3:36: error: port 'in' (number) uses 'v'"));
  EXPECT_THAT(Findings(Both("<SubTree ID=\"Sub\" w=\"1.5\"/>", "<Int in=\"{w}\"/>"), factory),
              testing::HasSubstr("t.xml:2:46: error: 'w': '1.5' is not valid: expected integer"));
}
TEST_F(Types, ATextAndAnotherTypeMayShareAnEntryInEitherOrder) {
  for (const char* order : {"<Text in=\"7\" out=\"{v}\"/><Int in=\"{v}\" out=\"{i}\"/>",
                            "<Int in=\"7\" out=\"{v}\"/><Text in=\"{v}\" out=\"{i}\"/>"}) {
    const auto tree = MakeTree(Main("<Sequence>" + std::string(order) + "</Sequence>"), factory);
    EXPECT_EQ(Ticks(*tree, 1), "S");
    EXPECT_EQ(tree->board().Get<int>("i").value(), 7);
  }
}
TEST_F(Types, OfAWriteAreChecked) {
  const auto tree = MakeTree(Main("<Int in=\"{v}\" out=\"{o}\"/>"), factory);
  EXPECT_FALSE(tree->board().Set("v", "x"));
  EXPECT_FALSE(tree->board().Set("v", 1.5));
  EXPECT_TRUE(tree->board().Set("v", 2.0));
  EXPECT_EQ(Ticks(*tree, 1), "S");
  EXPECT_EQ(tree->board().Get<int>("o").value(), 2);
}

struct ConditionTest : testing::Test, Logged {
  std::string Run(const std::string& conditions, const std::string& values) {
    tree = MakeTree(Main("<Say name=\"a\" does=\"RRS\" " + conditions + "/>"), factory);
    std::string letters;
    for (const char value : values) {
      EXPECT_TRUE(tree->board().Set("x", static_cast<double>(value - '0')));
      letters += Letter(tree->TickExactlyOnce(At(0)));
    }
    return letters + " " + Take();
  }
  std::unique_ptr<Tree> tree;
};

TEST_F(ConditionTest, DecideBeforeTheStartOnly) {
  EXPECT_EQ(Run("_skipIf=\"x == 1\"", "1011"), "-RRS a^ a a ");
  EXPECT_EQ(Run("_failureIf=\"x == 1\"", "1011"), "FRRS a^ a a ");
  EXPECT_EQ(Run("_successIf=\"x == 1\"", "1011"), "SRRS a^ a a ");
}
TEST_F(ConditionTest, AreEvaluatedInAFixedOrder) {
  EXPECT_EQ(Run("_skipIf=\"true\" _successIf=\"true\" _failureIf=\"true\"", "1"), "F ");
  EXPECT_EQ(Run("_while=\"false\" _skipIf=\"true\" _successIf=\"true\"", "1"), "S ");
}
TEST_F(ConditionTest, WhileHaltsARunningNode) {
  EXPECT_EQ(Run("_while=\"x == 1\" _onHalted=\"halted := 1\"", "0110"), "-RR- a^ a a! ");
  EXPECT_EQ(tree->board().Get<int>("halted").value(), 1);
}
TEST_F(ConditionTest, ScriptsFollowTheResult) {
  EXPECT_EQ(Run("_onSuccess=\"s := x\" _onFailure=\"f := 1\" _post=\"p := x\"", "123"),
            "RRS a^ a a ");
  EXPECT_EQ(tree->board().Get<int>("s").value(), 3);
  EXPECT_EQ(tree->board().Get<int>("p").value(), 3);
  EXPECT_FALSE(tree->board().Get<int>("f"));
}
TEST_F(ConditionTest, AlsoHoldForControlsAndSubtrees) {
  tree = MakeTree(
      Both("<Sequence _onSuccess=\"s := 1\"><SubTree ID=\"Sub\" _skipIf=\"x == 1\"/></Sequence>",
           "<Say name=\"a\" does=\"R\"/>"),
      factory);
  ASSERT_TRUE(tree->board().Set("x", 1.0));
  EXPECT_EQ(Ticks(*tree, 1), "-");
  ASSERT_TRUE(tree->board().Set("x", 0.0));
  EXPECT_EQ(Ticks(*tree, 1), "R");
}
TEST_F(ConditionTest, OfAReactiveSequenceAreEvaluatedInEachTick) {
  tree = MakeTree(Main("<ReactiveSequence><AlwaysSuccess _failureIf=\"x == 1\"/>"
                       "<Say name=\"a\" does=\"R\"/></ReactiveSequence>"),
                  factory);
  ASSERT_TRUE(tree->board().Set("x", 0.0));
  EXPECT_EQ(Ticks(*tree, 2), "RR");
  ASSERT_TRUE(tree->board().Set("x", 1.0));
  EXPECT_EQ(Ticks(*tree, 1), "F");
  EXPECT_EQ(Take(), "a^ a a! ");
}
TEST_F(ConditionTest, ThatFailNameTheNode) {
  tree = MakeTree(Main("<AlwaysSuccess name=\"go\" _skipIf=\"none > 1\"/>"));
  EXPECT_EQ(tree->TickExactlyOnce(At(0)).error().message,
            "t.xml:3:1: Main/go: the blackboard has no value of 'none'");
}

}  // namespace musher::tree::subtree_test
