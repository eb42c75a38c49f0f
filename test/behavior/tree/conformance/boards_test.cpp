// Boards that a program makes: of a main tree, and around several; backups of all boards of a tree.

#include "musher/behavior/tree/backup.hpp"
#include "musher/test/behavior/tree/trees.hpp"

namespace musher::tree::conformance_boards_test {

using testing::HasSubstr;

class Limit : public Action {
 public:
  explicit Limit(Setup& setup) : in_(setup.Input<int>("in")), out_(setup.Output<int>("out")) {}

 private:
  Status Do(const Tick&) override {
    out_.Set(in_.Get() / 2);
    return Status::kSuccess;
  }
  InPort<int> in_;
  OutPort<int> out_;
};

struct AGivenBoard : testing::Test {
  AGivenBoard() { EXPECT_TRUE(factory.Add<Limit>("Limit")); }

  Built Made(const std::string& xml, std::shared_ptr<Board> board) {
    const Reading reading = ReadTree(xml, "t.xml");
    return Build(reading.document, factory, {.board = std::move(board)});
  }
  std::unique_ptr<Tree> Tree_(const std::string& xml, std::shared_ptr<Board> board) {
    Built built = Made(xml, std::move(board));
    EXPECT_NE(built.tree, nullptr) << Texts(built.diagnostics);
    return std::move(built.tree);
  }

  Factory factory;
};

TEST_F(AGivenBoard, IsTheBoardOfTheMainTreeAndOutlivesIt) {
  const auto board = std::make_shared<Board>();
  ASSERT_TRUE(board->Set("speed", 8.0));
  auto tree = Tree_(Main("<Limit in=\"{speed}\" out=\"{half}\"/>"), board);
  EXPECT_EQ(&tree->board(), board.get());
  EXPECT_EQ(Ticks(*tree, 1), "S");
  tree = nullptr;
  EXPECT_EQ(board->Get<int>("half").value(), 4);
  const auto next = Tree_(Main("<ScriptCondition code=\"half == 4\"/>"), board);
  EXPECT_EQ(Ticks(*next, 1), "S");
}
TEST_F(AGivenBoard, AroundTwoTreesIsSharedByTheKeysThatBeginWithAt) {
  const auto outer = std::make_shared<Board>();
  ASSERT_TRUE(outer->Set("speed", 6));
  const std::string in_a_subtree =
      "<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\"><BehaviorTree ID=\"Main\">"
      "<SubTree ID=\"Part\"/></BehaviorTree><BehaviorTree ID=\"Part\">"
      "<Limit in=\"{@speed}\" out=\"{@speed}\"/></BehaviorTree></root>";
  const auto one = Tree_(in_a_subtree, std::make_shared<Board>(outer));
  const auto two =
      Tree_(Main("<Script code=\"speed := 1; seen := @speed\"/>"), std::make_shared<Board>(outer));
  EXPECT_EQ(Ticks(*one, 1, 3), "S");
  EXPECT_EQ(Ticks(*two, 1, 5), "S");
  EXPECT_EQ(two->board().Get<int>("seen").value(), 3);
  EXPECT_EQ(outer->Get<int>("speed").value(), 3) << "'speed' without '@' is the tree's own";
  EXPECT_EQ(outer->Find("speed")->stamp().at, At(30)) << "the time of the tree that sets it";
  EXPECT_EQ(two->board().Find("seen")->stamp().at, At(50));
}
TEST_F(AGivenBoard, AroundTreesIsGivenToEach) {
  const Document document = ReadTree(Main("<Script code=\"@n := 1\"/>"), "t.xml").document;
  const Document other = ReadTree(Main("<ScriptCondition code=\"@n == 1\"/>"), "t.xml").document;
  // [around]
  const auto robot = std::make_shared<Board>();
  const Built patrol = Build(document, factory, {.board = std::make_shared<Board>(robot)});
  const Built watch = Build(other, factory, {.board = std::make_shared<Board>(robot)});
  // [around end]
  EXPECT_EQ(Ticks(*patrol.tree, 1), "S");
  EXPECT_EQ(Ticks(*watch.tree, 1), "S");
}
TEST_F(AGivenBoard, IsShownWithTheKeysOfTheBoardAroundIt) {
  const auto outer = std::make_shared<Board>();
  ASSERT_TRUE(outer->Set("speed", 6));
  const auto board = std::make_shared<Board>(outer);
  ASSERT_TRUE(board->Set("own", 1));
  EXPECT_THAT(board->Keys(), testing::ElementsAre("@speed", "own"));
  EXPECT_EQ(board->size(), 2U);
  EXPECT_EQ(board->Find("@speed"), outer->Find("speed"));
  EXPECT_THAT(Board(board).Keys(), testing::ElementsAre("@speed")) << "only the outermost one";
}
TEST_F(AGivenBoard, WhoseValueIsNotOfThePortsTypeIsAnError) {
  const auto board = std::make_shared<Board>();
  ASSERT_TRUE(board->Set("speed", "fast"));
  const std::string xml = Main("<Limit in=\"{speed}\" out=\"{half}\"/>");
  EXPECT_EQ(
      Texts(Made(xml, board).diagnostics),
      "t.xml:3:12: error: 'speed' of the given board is 'fast': 'fast' is not valid: expected "
      "integer\n");
  EXPECT_EQ(board->Find("speed")->value.Shown(), "'fast'");
  ASSERT_TRUE(board->Set("speed", "7")) << "its type is as it was: a text is a value";
  EXPECT_EQ(Ticks(*Tree_(xml, board), 1), "S");
  EXPECT_EQ(board->Get<int>("half").value(), 3);
}
TEST_F(AGivenBoard, HasTheTypesThatEarlierTreesGaveIt) {
  const auto board = std::make_shared<Board>();
  const auto one = Tree_(Main("<Limit in=\"{speed}\" out=\"{half}\"/>"), board);
  EXPECT_EQ(Texts(Made(Main("<Sleep msec=\"{half}\"/>"), board).diagnostics),
            "t.xml:3:14: error: port 'msec' (integer from 0) uses 'half', which is of type integer "
            "in another tree that shares the board\n");
  EXPECT_NE(Made(Main("<Limit in=\"{half}\" out=\"{speed}\"/>"), board).tree, nullptr);
}
TEST_F(AGivenBoard, IsAsBeforeWhereTheTreeHasErrors) {
  const auto board = std::make_shared<Board>();
  EXPECT_EQ(
      Made(Main("<Sequence><Limit in=\"{n}\" out=\"{m}\"/><Unknown/></Sequence>"), board).tree,
      nullptr);
  EXPECT_NE(Made(Main("<Sleep msec=\"{n}\"/>"), board).tree, nullptr)
      << "what failed has given no type";
}

TEST_F(AGivenBoard, KeepsItsValuesWhereAnotherTreeOfTheDocumentHasErrors) {
  const auto board = std::make_shared<Board>();
  ASSERT_TRUE(board->Set("n", "250"));
  EXPECT_EQ(Made("<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\"><BehaviorTree ID=\"Main\">"
                 "<Sleep msec=\"{n}\"/></BehaviorTree><BehaviorTree ID=\"Other\"><Unknown/>"
                 "</BehaviorTree></root>",
                 board)
                .tree,
            nullptr);
  EXPECT_EQ(board->Find("n")->value.type(), TypeOf<std::string>());
  EXPECT_NE(Made(Main("<Sleep msec=\"{n}\"/>"), board).tree, nullptr);
  EXPECT_EQ(board->Find("n")->value.type(), TypeOf<unsigned>());
}

constexpr const char* kTwoBoards =
    "<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\"><BehaviorTree ID=\"Main\"><Sequence>"
    "<Script code=\"n := n + 1; word := 'a'\"/><SubTree ID=\"Part\" in=\"{n}\"/></Sequence>"
    "</BehaviorTree><BehaviorTree ID=\"Part\"><Script code=\"twice := in * 2\"/></BehaviorTree>"
    "</root>";

TEST(ABackup, RestoresAllBoardsOfATree) {
  const auto tree = MakeTree(kTwoBoards);
  ASSERT_TRUE(tree->board().Set("n", 1));
  EXPECT_EQ(Ticks(*tree, 1), "S");
  const Backup backup(*tree);
  EXPECT_EQ(Ticks(*tree, 3, 1), "SSS");
  ASSERT_TRUE(tree->board().Set("later", 1));
  EXPECT_EQ(tree->board().Get<int>("n").value(), 5);
  ASSERT_TRUE(backup.Restore(*tree));
  EXPECT_EQ(tree->board().Get<int>("n").value(), 2);
  EXPECT_EQ(tree->board(3).Get<int>("twice").value(), 4);
  EXPECT_FALSE(tree->board().Get<int>("later")) << "it had no value then";
}
TEST(ABackup, FillsATreeThatIsBuiltAgain) {
  const auto tree = MakeTree(kTwoBoards);
  ASSERT_TRUE(tree->board().Set("n", 1));
  EXPECT_EQ(Ticks(*tree, 2), "SS");
  const Backup backup(*tree);
  const auto again = MakeTree(kTwoBoards);
  ASSERT_TRUE(backup.Restore(*again));
  EXPECT_EQ(again->board().Find("word")->stamp().sequence, 1U) << "restored values count as set";
  EXPECT_EQ(Ticks(*again, 1), "S");
  EXPECT_EQ(again->board(3).Get<int>("twice").value(), 8);
}
TEST(ABackup, OfAnotherTreeIsRefusedAndChangesNothing) {
  const auto tree = MakeTree(kTwoBoards);
  ASSERT_TRUE(tree->board().Set("n", "many"));
  const auto alone = MakeTree(Main("<AlwaysSuccess/>"));
  EXPECT_EQ(Backup(*alone).Restore(*tree).error().message,
            "the backup has 1 blackboard, tree Main has 2");
  Factory factory;
  ASSERT_TRUE(factory.Add<Limit>("Limit"));
  const auto typed = MakeTree(
      "<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\"><BehaviorTree ID=\"Main\"><Sequence>"
      "<Limit in=\"{n}\" out=\"{word}\"/><SubTree ID=\"Part\"/></Sequence></BehaviorTree>"
      "<BehaviorTree ID=\"Part\"><AlwaysSuccess/></BehaviorTree></root>",
      factory);
  ASSERT_TRUE(typed->board().Set("word", 3));
  EXPECT_THAT(Backup(*tree).Restore(*typed).error().message,
              HasSubstr("entry 'n': 'many' is not valid: expected integer"));
  EXPECT_EQ(typed->board().Get<int>("word").value(), 3);
}
TEST(ABackup, OfATreeWithOtherSubtreesIsRefused) {
  const auto tree = MakeTree(kTwoBoards);
  ASSERT_TRUE(tree->board().Set("n", 1));
  const auto made = [](const std::string& main, const std::string& subtree) {
    return MakeTree("<root BTCPP_format=\"4\" main_tree_to_execute=\"" + main +
                    "\"><BehaviorTree ID=\"" + main + "\"><Sequence><SubTree ID=\"" + subtree +
                    "\"/></Sequence></BehaviorTree><BehaviorTree ID=\"" + subtree +
                    "\"><Script code=\"n := 3\"/></BehaviorTree></root>");
  };
  const auto other = made("Main", "Whole");
  ASSERT_TRUE(other->board().Set("n", 7));
  EXPECT_EQ(Backup(*tree).Restore(*other).error().message,
            "the backup has a blackboard of Main/Sequence/Part, tree Main has one of "
            "Main/Sequence/Whole in its place");
  EXPECT_EQ(other->board().Get<int>("n").value(), 7);
  const auto renamed = made("Course", "Part");
  EXPECT_EQ(Backup(*tree).Restore(*renamed).error().message,
            "the backup has a blackboard of Main, tree Course has one of Course in its place");
}
TEST(ABackup, LeavesTheBoardAroundTheTree) {
  const auto outer = std::make_shared<Board>();
  const Reading reading = ReadTree(Main("<Script code=\"@n := 1; n := 2\"/>"), "t.xml");
  const Built built = Build(reading.document, Factory(), {.board = std::make_shared<Board>(outer)});
  const Backup backup(*built.tree);
  EXPECT_EQ(Ticks(*built.tree, 1), "S");
  ASSERT_TRUE(backup.Restore(*built.tree));
  EXPECT_EQ(outer->Get<int>("n").value(), 1);
  EXPECT_FALSE(built.tree->board().Get<int>("n"));
}

}  // namespace musher::tree::conformance_boards_test
