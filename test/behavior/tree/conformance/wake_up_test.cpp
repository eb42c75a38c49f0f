// A node that wakes its tree up.

#include "musher/test/behavior/tree/trees.hpp"

namespace musher::tree::conformance_wake_up_test {

// RUNNING until `ready`; wakes its tree up in its first `wakes` ticks.
class Await : public StatefulAction {
 public:
  struct Shared {
    bool ready = false;
    int wakes = 0;
    int ticks = 0;
    WakeUp wake_up{};
  };
  Await(Setup& setup, Shared& shared) : shared_(shared) { shared.wake_up = setup.wake_up(); }

 private:
  Status OnStart(const Tick& tick) override { return OnRunning(tick); }
  Status OnRunning(const Tick&) override {
    if (++shared_.ticks <= shared_.wakes) shared_.wake_up.Request();
    return shared_.ready ? Status::kSuccess : Status::kRunning;
  }
  Shared& shared_;
};

struct AWakeUp : testing::Test {
  AWakeUp() {
    EXPECT_TRUE(factory.Add<Await>("Await", shared));
    tree = MakeTree(Main("<Await/>"), factory);
    tree->OnWakeUp([this] { ++notified; });
  }

  Await::Shared shared;
  int notified = 0;
  Factory factory;
  std::unique_ptr<Tree> tree;
};

TEST_F(AWakeUp, InATickIsAFurtherTickAtOnce) {
  shared.wakes = 3;
  EXPECT_EQ(tree->TickOnce(At(0)).value(), Status::kRunning);
  EXPECT_EQ(shared.ticks, 4);
  EXPECT_EQ(tree->TickOnce(At(10)).value(), Status::kRunning);
  EXPECT_EQ(shared.ticks, 5);
  EXPECT_EQ(notified, 0);
}
TEST_F(AWakeUp, InEachTickEndsAtTheMostTicksAtOnce) {
  shared.wakes = 1'000'000;
  EXPECT_EQ(tree->TickOnce(At(0)).value(), Status::kRunning);
  EXPECT_EQ(shared.ticks, Tree::kMostTicksAtOnce);
  EXPECT_EQ(notified, 0) << "else the program would tick without end";
}
TEST_F(AWakeUp, BetweenTwoTicksIsPassedOnOnceUntilTheNextTick) {
  tree->TickOnce(At(0)).value();
  shared.wake_up.Request();
  shared.wake_up.Request();
  EXPECT_EQ(notified, 1);
  EXPECT_EQ(tree->TickOnce(At(0)).value(), Status::kRunning);
  EXPECT_EQ(shared.ticks, 2);
  shared.wake_up.Request();
  EXPECT_EQ(notified, 2);
}
TEST_F(AWakeUp, OfATreeThatIsGoneDoesNothing) {
  tree = nullptr;
  shared.wake_up.Request();
  WakeUp().Request();
  EXPECT_EQ(notified, 0);
}

}  // namespace musher::tree::conformance_wake_up_test
