// Breakpoints and results in place of nodes. "a^" is a's first tick, "a" a further one, "a!" its
// halt.

#include "musher/behavior/tree/hooks.hpp"

#include "musher/test/behavior/tree/trees.hpp"

namespace musher::tree::hooks_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr NodeId kRoot = 0;
constexpr NodeId kA = 1;
constexpr NodeId kB = 2;

struct Hooked : testing::Test, Logged {
  void Make(const std::string& content) { tree = MakeTree(Main(content), factory); }
  void MakeSequence(const std::string& b_does) {
    Make("<Sequence><Say name=\"a\" does=\"S\"/><Say name=\"b\" does=\"" + b_does +
         "\"/></Sequence>");
  }
  void Set(const Hook& hook) {
    hooks->Set(hook);
    tree->Attach(hooks);
  }
  std::string Run(int ticks) {
    const std::string letters = Ticks(*tree, ticks, next);
    next += ticks;
    return letters + " " + Take();
  }

  std::vector<NodeId> reached;
  std::shared_ptr<Hooks> hooks =
      std::make_shared<Hooks>([this](NodeId node) { reached.push_back(node); });
  std::unique_ptr<Tree> tree;
  int next = 0;
};

TEST_F(Hooked, ANodeIsHeldBeforeItStartsAndTheTreeGoesOnTicking) {
  MakeSequence("RS");
  Set({.node = kB});
  EXPECT_EQ(Run(4), "RRRR a^ ");
  EXPECT_EQ(tree->status(kB), Status::kIdle);
  EXPECT_EQ(tree->status(), Status::kRunning);
  EXPECT_THAT(reached, ElementsAre(kB)) << "reported once";
  EXPECT_TRUE(hooks->Release(kB, Status::kSkipped, false));
  EXPECT_EQ(Run(2), "RS b^ b ") << "it is not held while it runs";
  EXPECT_EQ(Run(1), "R a^ ") << "its next start is held again";
  EXPECT_THAT(reached, ElementsAre(kB, kB));
}

TEST_F(Hooked, AHeldNodeIsNotHaltedWithItsBranch) {
  MakeSequence("R");
  Set({.node = kB});
  Run(2);
  ASSERT_TRUE(tree->Halt(At(100)));
  EXPECT_EQ(Take(), "") << "it has not been started";
  EXPECT_EQ(tree->status(), Status::kIdle);
  EXPECT_EQ(Run(2), "RR a^ ") << "and is held again";
  EXPECT_THAT(reached, ElementsAre(kB, kB)) << "and reported again";
}

TEST_F(Hooked, ANodeIsReleasedOnlyWhileItIsHeld) {
  MakeSequence("R");
  Set({.node = kB});
  EXPECT_FALSE(hooks->Release(kB, Status::kSkipped, false)) << "it is not reached yet";
  Run(2);
  ASSERT_TRUE(tree->Halt(At(100)));
  EXPECT_FALSE(hooks->Release(kB, Status::kSkipped, false)) << "its branch was halted";
  Take();
  EXPECT_EQ(Run(2), "RR a^ ") << "its next start is held";
}

TEST_F(Hooked, AReleaseDoesNotOutlastAHaltOfTheTree) {
  MakeSequence("R");
  Set({.node = kB});
  Run(2);
  EXPECT_TRUE(hooks->Release(kB, Status::kSkipped, false));
  ASSERT_TRUE(tree->Halt(At(100)));
  Take();
  EXPECT_EQ(Run(2), "RR a^ ") << "its next start is held";
}

TEST_F(Hooked, AReleaseDoesNotOutlastItsBranch) {
  Make(
      "<KeepRunningUntilFailure><ForceSuccess><Timeout msec=\"25\">"
      "<Say name=\"a\" does=\"R\"/></Timeout></ForceSuccess></KeepRunningUntilFailure>");
  constexpr NodeId kHeld = 3;
  Set({.node = kHeld});
  EXPECT_EQ(Run(3), "RRR ");
  EXPECT_TRUE(hooks->Release(kHeld, Status::kSkipped, false));
  EXPECT_EQ(Run(1), "R ") << "the time was over first, and the tree goes on";
  EXPECT_FALSE(hooks->Release(kHeld, Status::kSkipped, false));
  EXPECT_EQ(Run(2), "RR ") << "its next start is held";
}

TEST_F(Hooked, ANodeThatIsReachedAgainInTheTickOfItsReleaseIsReportedAgain) {
  Make("<Repeat num_cycles=\"2\"><Sequence><Say name=\"a\" does=\"S\"/></Sequence></Repeat>");
  constexpr NodeId kHeld = 2;
  Set({.node = kHeld});
  EXPECT_EQ(Run(2), "RR ");
  EXPECT_TRUE(hooks->Release(kHeld, Status::kSkipped, false));
  EXPECT_EQ(Run(2), "RR a^ ");
  EXPECT_THAT(reached, ElementsAre(kHeld, kHeld));
}

TEST_F(Hooked, AHookThatHeldANodeBeforeAHaltOfItsTreeActsUntilTheNextTick) {
  MakeSequence("R");
  Set({.node = kB});
  Run(2);
  ASSERT_TRUE(tree->Halt(At(100)));
  EXPECT_FALSE(hooks->IsHeld(kB));
  EXPECT_TRUE(hooks->Acts(kB));
}

TEST_F(Hooked, ANodeThatRunsIsNotHeldAndIsHaltedAsAlways) {
  MakeSequence("R");
  Run(1);
  Set({.node = kB});
  EXPECT_EQ(Run(2), "RR b b ");
  ASSERT_TRUE(tree->Halt(At(100)));
  EXPECT_EQ(Take(), "b! ");
}

TEST_F(Hooked, AHeldNodeIsReleasedWithAResultInItsPlace) {
  MakeSequence("S");
  Set({.node = kB});
  Run(1);
  EXPECT_TRUE(hooks->Release(kB, Status::kFailure, true));
  EXPECT_EQ(Run(1), "F ");
  EXPECT_TRUE(hooks->empty()) << "once";
  EXPECT_EQ(Run(1), "S a^ b^ ");
  EXPECT_FALSE(hooks->Release(kB, Status::kFailure, true));
}

TEST_F(Hooked, ANodeIsReplacedAndOneThatRunsIsHaltedFirst) {
  MakeSequence("R");
  Run(1);
  Set({.node = kB, .holds = false, .instead = Status::kFailure});
  EXPECT_EQ(Run(1), "F b! ");
  EXPECT_EQ(Run(2), "FF a^ a^ ") << "each time";
  EXPECT_TRUE(hooks->Remove(kB));
  EXPECT_FALSE(hooks->Remove(kB));
  EXPECT_EQ(Run(1), "R a^ b^ ");
}

TEST_F(Hooked, AReplacedNodeRunsItsScriptsOfItsResultAndItsConditionsBefore) {
  Make(
      "<Fallback><Say name=\"a\" does=\"R\" _onFailure=\"why := 'stuck'\" _skipIf=\"skip\"/>"
      "<AlwaysSuccess/></Fallback>");
  ASSERT_TRUE(tree->board().Set("skip", false));
  Set({.node = kA, .holds = false, .once = true, .instead = Status::kFailure});
  EXPECT_EQ(Run(1), "S ");
  EXPECT_EQ(tree->board().Get<std::string>("why").value(), "stuck");
  Set({.node = kA});
  ASSERT_TRUE(tree->board().Set("skip", true));
  EXPECT_EQ(Run(1), "S ");
  EXPECT_THAT(reached, ElementsAre(kA)) << "a node that is skipped is not held";
}

TEST_F(Hooked, TheRootIsHeldToo) {
  MakeSequence("S");
  Set({.node = kRoot, .once = true});
  EXPECT_EQ(Run(2), "RR ");
  EXPECT_TRUE(hooks->Release(kRoot, Status::kSkipped, false));
  EXPECT_EQ(Run(2), "SS a^ b^ a^ b^ ");
}

TEST_F(Hooked, NothingIsHeldOnceHooksAreDisabledClearedOrGone) {
  MakeSequence("S");
  Set({.node = kA});
  Set({.node = kB});
  EXPECT_EQ(Run(1), "R ");
  hooks->DisableAll();
  EXPECT_EQ(Run(1), "S a^ b^ ");
  Set({.node = kA});
  EXPECT_EQ(Run(1), "R ");
  hooks->Clear();
  EXPECT_EQ(Run(1), "S a^ b^ ");
  Set({.node = kA});
  EXPECT_EQ(Run(1), "R ");
  hooks.reset();
  EXPECT_EQ(Run(1), "S a^ b^ ");
}

TEST_F(Hooked, ACleanupWithinAHaltIsNeitherHeldNorReplaced) {
  Make("<Finally><Say name=\"a\" does=\"R\"/><Say name=\"b\" does=\"S\"/></Finally>");
  Set({.node = kB});
  Run(1);
  ASSERT_TRUE(tree->Halt(At(100)));
  EXPECT_EQ(Take(), "a! b^ ");
  EXPECT_THAT(reached, IsEmpty());
}

TEST_F(Hooked, ANodeIsHeldAfterItsTickWithItsResult) {
  Make(
      "<Sequence><Say name=\"a\" does=\"RS\" _onSuccess=\"done := 1\"/>"
      "<Say name=\"b\" does=\"S\"/></Sequence>");
  Set({.node = kA, .after = true});
  EXPECT_EQ(Run(4), "RRRR a^ a ") << "it is not ticked again, and its parent waits";
  EXPECT_EQ(tree->status(kA), Status::kSuccess);
  EXPECT_FALSE(tree->board().Get<int>("done")) << "its scripts run when it goes on";
  EXPECT_THAT(reached, ElementsAre(kA));
  EXPECT_FALSE(hooks->Release(kA, Status::kSkipped, false)) << "there is none before its tick";
  EXPECT_TRUE(hooks->Release(kA, Status::kSkipped, false, true));
  EXPECT_EQ(Run(1), "S b^ ");
  EXPECT_EQ(tree->board().Get<int>("done").value(), 1);
  EXPECT_EQ(Run(3), "RRR a^ a ") << "its next end is held again";
}
TEST_F(Hooked, AResultIsReplacedAfterTheTickWithTheScriptsOfTheLastOne) {
  Make(
      "<Fallback><Say name=\"a\" does=\"RS\" _onFailure=\"why := 'test'\"/>"
      "<Say name=\"b\" does=\"S\"/></Fallback>");
  Set({.node = kA, .holds = false, .instead = Status::kFailure, .after = true});
  EXPECT_EQ(Run(2), "RS a^ a b^ ") << "not while it runs";
  EXPECT_EQ(tree->board().Get<std::string>("why").value(), "test");
  EXPECT_THAT(reached, ElementsAre(kA));
  Set({.node = kA, .once = true, .after = true});
  EXPECT_EQ(Run(3), "RRR a^ a ");
  EXPECT_TRUE(hooks->Release(kA, Status::kFailure, false, true));
  EXPECT_EQ(Run(1), "S b^ ");
  EXPECT_TRUE(hooks->empty());
}
TEST_F(Hooked, ANodeThatIsHeldWithItsResultIsNotHalted) {
  MakeSequence("S");
  Set({.node = kA, .after = true});
  Set({.node = kB});
  EXPECT_EQ(Run(2), "RR a^ ");
  ASSERT_TRUE(tree->Halt(At(100)));
  EXPECT_EQ(Take(), "") << "it has completed";
  next = 11;
  EXPECT_EQ(Run(2), "RR a^ ") << "and begins again";
  hooks->Release(kA, Status::kSkipped, true, true);
  EXPECT_EQ(Run(2), "RR ") << "now the next one is held before its tick";
  EXPECT_TRUE(hooks->Remove(kB));
  EXPECT_FALSE(hooks->Remove(kB, true));
}
TEST_F(Hooked, ANodeThatIsHeldWithItsResultGoesOnWithItOnceItsHookIsGone) {
  MakeSequence("S");
  for (const auto& end :
       std::vector<std::function<void()>>{[this] { hooks->DisableAll(); },
                                          [this] { hooks->Clear(); }, [this] { hooks.reset(); }}) {
    Set({.node = kA, .after = true});
    EXPECT_EQ(Run(2), "RR a^ ");
    end();
    EXPECT_EQ(Run(1), "S b^ ");
  }
}

TEST_F(Hooked, ATimeoutEndsTheWaitOfAHeldNode) {
  Make("<Timeout msec=\"25\"><Say name=\"a\" does=\"R\"/></Timeout>");
  Set({.node = kA});
  EXPECT_EQ(Run(4), "RRRF ");
  EXPECT_EQ(Run(1), "R ");
  EXPECT_THAT(reached, ElementsAre(kA, kA)) << "a tick without it was in between";
}

TEST_F(Hooked, ALoopGivesAHeldNodeItsNextValueOnce) {
  Make("<LoopInt queue=\"1;2\" value=\"{i}\"><Say name=\"a\" does=\"S\"/></LoopInt>");
  Set({.node = kA});
  EXPECT_EQ(Run(3), "RRR ");
  EXPECT_EQ(tree->board().Get<int>("i").value(), 1);
  hooks->Clear();
  EXPECT_EQ(Run(3), "RRS a^ a^ ");
  Make("<WaitValueUpdate entry=\"{key}\"><Say name=\"a\" does=\"S\"/></WaitValueUpdate>");
  ASSERT_TRUE(tree->board().Set("key", 1));
  Set({.node = kA});
  EXPECT_EQ(Run(2), "RR ");
  hooks->Clear();
  EXPECT_EQ(Run(1), "S a^ ");
}

}  // namespace musher::tree::hooks_test
