// All boards of a tree as JSON, and back.

#include "musher/behavior/tree/json/boards_json.hpp"

#include "musher/behavior/tree/json/json_fields.hpp"
#include "musher/test/behavior/tree/trees.hpp"

namespace musher::tree::conformance_boards_json_test {

struct Spot {
  double x_m = 0;
};

}  // namespace musher::tree::conformance_boards_json_test

template <>
struct musher::tree::Convert<musher::tree::conformance_boards_json_test::Spot>
    : musher::tree::JsonFields<musher::tree::conformance_boards_json_test::Spot> {
  static constexpr std::string_view kName = "Spot";
  static void Fields(auto& json, auto& spot) { json("x_m", spot.x_m); }
};

namespace musher::tree::conformance_boards_json_test {

class Step : public Action {
 public:
  explicit Step(Setup& setup)
      : n_(setup.InOut<int>("n")), at_(setup.Output<Spot>("at", FromEntry{"at"})) {}

 private:
  Status Do(const Tick&) override {
    n_.Set(n_.Or(0) + 1);
    at_.Set({n_.Get() / 2.0});
    return Status::kSuccess;
  }
  InOutPort<int> n_;
  OutPort<Spot> at_;
};

constexpr const char* kXml =
    "<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\"><BehaviorTree ID=\"Main\"><Sequence>"
    "<Step n=\"{n}\"/><Script code=\"word := 'a &quot;b'; ok := true\"/>"
    "<SubTree ID=\"Part\" outer=\"{n}\"/></Sequence></BehaviorTree>"
    "<BehaviorTree ID=\"Part\"><Script code=\"half := outer / 2; @seen := 1\"/></BehaviorTree>"
    "</root>";

struct BoardsAsJson : testing::Test {
  BoardsAsJson() {
    EXPECT_TRUE(factory.Add<Step>("Step"));
    tree = MakeTree(kXml, factory);
    EXPECT_EQ(Ticks(*tree, 1), "S");
  }
  std::string Read(const std::string& json) { return Texts(BoardsFromJson(*tree, json, "b.json")); }
  Factory factory;
  std::unique_ptr<Tree> tree;
};

TEST_F(BoardsAsJson, HaveEachEntryOnceByTheSubtreeThatHasIt) {
  EXPECT_EQ(BoardsToJson(*tree), R"({
  "Main": {
    "at": {
      "x_m": 0.5
    },
    "n": 1,
    "ok": 1,
    "seen": 1,
    "word": "a \"b"
  },
  "Main/Sequence/Part": {
    "half": 0.5
  }
})");
}
TEST_F(BoardsAsJson, FillATreeThatIsBuiltAgain) {
  ASSERT_TRUE(tree->board().Set("shared", std::make_shared<int>(1))) << "a type without JSON";
  tree->board().Find("ok")->value.Clear();
  ASSERT_TRUE(tree->board().Set("flag", true));
  const std::string json = BoardsToJson(*tree);
  EXPECT_THAT(json, testing::Not(testing::HasSubstr("shared")));
  const auto again = MakeTree(kXml, factory);
  EXPECT_EQ(Texts(BoardsFromJson(*again, json, "b.json")), "");
  EXPECT_EQ(BoardsToJson(*again), json);
  EXPECT_EQ(*again->board().Find("flag")->value.As<bool>(), true);
  EXPECT_EQ(again->board().Get<Spot>("at").value().x_m, 0.5);
  EXPECT_EQ(Ticks(*again, 1), "S");
  EXPECT_EQ(again->board().Get<int>("n").value(), 2);
}
TEST_F(BoardsAsJson, KeepLargeWholeNumbersExactly) {
  Board& board = tree->board();
  board.At("small").type = TypeOf<std::int64_t>();
  board.At("large").type = TypeOf<std::uint64_t>();
  ASSERT_TRUE(board.Set("small", INT64_MAX));
  ASSERT_TRUE(board.Set("large", UINT64_MAX));
  const std::string json = BoardsToJson(*tree);
  ASSERT_TRUE(board.Set("small", std::int64_t{0}));
  ASSERT_TRUE(board.Set("large", std::uint64_t{0}));
  EXPECT_EQ(Read(json), "");
  EXPECT_EQ(board.Get<std::int64_t>("small").value(), INT64_MAX);
  EXPECT_EQ(board.Get<std::uint64_t>("large").value(), UINT64_MAX);
  EXPECT_THAT(Read("{\"Main\": {\"small\": 18446744073709551615}}"),
              testing::HasSubstr("b.json:1:20: error: entry 'small': "));
}
TEST_F(BoardsAsJson, ReportEachErrorAtItsPlaceAndChangeNothing) {
  const std::string before = BoardsToJson(*tree);
  EXPECT_EQ(Read("{\"Main\": {\"word\": \"new\", \"n\": 1.5,\n \"at\": {\"y_m\": 1},\n"
                 " \"ok\": {}},\n\"Main/Sequence/Pert\": {}, \"Main/Sequence/Part\": 3}"),
            "b.json:1:31: error: entry 'n': 1.5 is not valid: expected integer\n"
            "b.json:2:8: error: entry 'at': the JSON field 'x_m' is missing\n"
            "b.json:3:8: error: entry 'ok': no port gives the entry a type that has JSON\n"
            "b.json:4:1: error: there is no tree 'Main/Sequence/Pert'; did you mean "
            "'Main/Sequence/Part'?\n"
            "b.json:4:49: error: expected an object with the entries of 'Main/Sequence/Part'\n");
  EXPECT_EQ(BoardsToJson(*tree), before);
  EXPECT_EQ(Read("[]"), "b.json:1:1: error: expected an object with the boards\n");
  EXPECT_EQ(Read("{\"Main\"}"), "b.json:1:8: error: it is no JSON\n");
}
TEST_F(BoardsAsJson, LeaveEntriesThatTheyDoNotHaveAndMakeNewOnes) {
  EXPECT_EQ(Read("{\"Main\": {\"new\": -3, \"word\": null}}"), "");
  EXPECT_EQ(tree->board().Get<int>("new").value(), -3);
  EXPECT_EQ(tree->board().Get<int>("n").value(), 1);
  EXPECT_FALSE(tree->board().Get<std::string>("word"));
}

}  // namespace musher::tree::conformance_boards_json_test
