// Stamps of entries: when and how often an entry was set.

#include "musher/test/behavior/tree/trees.hpp"

namespace musher::tree::conformance_stamps_test {

// Counts in `out`.
class Count : public Action {
 public:
  explicit Count(Setup& setup) : out_(setup.Output<int>("out")) {}

 private:
  Status Do(const Tick&) override {
    out_.Set(++count_);
    return Status::kSuccess;
  }
  OutPort<int> out_;
  int count_ = 0;
};

// [fresh]
// SUCCESS as long as the pose is not older than `limit_ms`.
class IsFresh : public Condition {
 public:
  explicit IsFresh(Setup& setup)
      : pose_(setup.Input<std::string>("pose")), limit_ms_(setup.Input<int>("limit_ms", 100)) {}

 private:
  Status Evaluate(const Tick& tick) override {
    const Stamp stamp = pose_.stamp();
    const bool fresh = stamp.sequence > 0 && tick.now - stamp.at <= Milliseconds(limit_ms_.Get());
    return fresh ? Status::kSuccess : Status::kFailure;
  }
  InPort<std::string> pose_;
  InPort<int> limit_ms_;
};
// [fresh end]

// Keeps the stamp of its port.
class Look : public Action {
 public:
  Look(Setup& setup, Stamp& seen) : in_(setup.Input<int>("in")), seen_(seen) {}

 private:
  Status Do(const Tick&) override {
    seen_ = in_.stamp();
    return Status::kSuccess;
  }
  InPort<int> in_;
  Stamp& seen_;
};

struct AStamp : testing::Test {
  AStamp() {
    EXPECT_TRUE(factory.Add<Count>("Count"));
    EXPECT_TRUE(factory.Add<IsFresh>("IsFresh"));
    EXPECT_TRUE(factory.Add<Look>("Look", seen));
  }
  static Stamp Of(Tree& tree, const std::string& key) { return tree.board().Find(key)->stamp(); }

  Stamp seen;
  Factory factory;
};

TEST_F(AStamp, IsTheTimeOfTheTickThatSetTheEntryAndHowOftenItWasSet) {
  const auto tree = MakeTree(Main("<Count out=\"{n}\"/>"), factory);
  EXPECT_EQ(Of(*tree, "n").sequence, 0U);
  Ticks(*tree, 3, 1);
  EXPECT_EQ(Of(*tree, "n").sequence, 3U);
  EXPECT_EQ(Of(*tree, "n").at, At(30));
  const auto stamped = tree->board().GetStamped<double>("n");
  ASSERT_TRUE(stamped);
  EXPECT_EQ(stamped.value().value, 3.0);
  EXPECT_EQ(stamped.value().stamp.at, At(30));
  EXPECT_FALSE(tree->board().GetStamped<int>("m"));
}
TEST_F(AStamp, RisesAlsoWhereTheValueStaysTheSame) {
  const auto tree = MakeTree(Main("<SetBlackboard value=\"a\" output_key=\"text\"/>"), factory);
  Ticks(*tree, 2, 1);
  EXPECT_EQ(Of(*tree, "text").sequence, 2U);
  EXPECT_EQ(Of(*tree, "text").at, At(20));
}
TEST_F(AStamp, IsThatOfAScriptToo) {
  const auto tree = MakeTree(Main("<Sleep msec=\"50\" _onHalted=\"halted := true\"/>"), factory);
  Ticks(*tree, 2);
  ASSERT_TRUE(tree->Halt(At(40)));
  EXPECT_EQ(Of(*tree, "halted").at, At(40));
}
TEST_F(AStamp, IsSeenByAPortAlsoInASubtree) {
  const auto tree = MakeTree(
      "<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\"><BehaviorTree ID=\"Main\"><Sequence>"
      "<Count out=\"{n}\"/><SubTree ID=\"Part\" in=\"{n}\"/></Sequence></BehaviorTree>"
      "<BehaviorTree ID=\"Part\"><Sequence><Look in=\"{in}\"/><Script code=\"own := in\"/>"
      "</Sequence></BehaviorTree></root>",
      factory);
  Ticks(*tree, 2, 5);
  EXPECT_EQ(seen.sequence, 2U);
  EXPECT_EQ(seen.at, At(60));
  EXPECT_EQ(tree->board(3).Find("own")->stamp().at, At(60));
}
TEST_F(AStamp, OfAFixedTextIsNone) {
  const auto tree = MakeTree(Main("<Look in=\"3\"/>"), factory);
  seen = {7, At(7)};
  Ticks(*tree, 1, 4);
  EXPECT_EQ(seen.sequence, 0U);
  EXPECT_EQ(seen.at, Time{});
}
TEST_F(AStamp, OfWhatAProgramSetsIsTheTimeOfTheLastTick) {
  const auto tree = MakeTree(Main("<IsFresh pose=\"{pose}\"/>"), factory);
  EXPECT_EQ(Ticks(*tree, 1), "F") << "never set";
  ASSERT_TRUE(tree->board().Set("pose", "1;2"));
  EXPECT_EQ(Of(*tree, "pose").at, At(0));
  EXPECT_EQ(Ticks(*tree, 1, 10), "S");
  EXPECT_EQ(Ticks(*tree, 1, 11), "F");
  tree->board().SetTime(At(150));
  ASSERT_TRUE(tree->board().Set("pose", "1;2"));
  EXPECT_EQ(Ticks(*tree, 1, 20), "S");
  EXPECT_EQ(Ticks(*tree, 1, 26), "F");
}

}  // namespace musher::tree::conformance_stamps_test
