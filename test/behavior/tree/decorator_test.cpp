// The decorators and the leaves.

#include "musher/test/behavior/tree/trees.hpp"

namespace musher::tree::decorator_test {

std::string Say(const std::string& does) {
  return "<Say name=\"a\" does=\"" + does + "\"/>";
}

using Decorators = TickedTree;

TEST_F(Decorators, ChangeTheResult) {
  EXPECT_EQ(Run("<Inverter>" + Say("RSF") + "</Inverter>", 3), "RFS a^ a a^ ");
  EXPECT_EQ(Run("<ForceSuccess>" + Say("RF") + "</ForceSuccess>", 2), "RS a^ a ");
  EXPECT_EQ(Run("<ForceFailure>" + Say("RS") + "</ForceFailure>", 2), "RF a^ a ");
  EXPECT_EQ(Run("<KeepRunningUntilFailure>" + Say("SSF") + "</KeepRunningUntilFailure>", 3),
            "RRF a^ a^ a^ ");
}

TEST_F(Decorators, RepeatGivesTheTreeATurnAfterEachRound) {
  const std::string xml = "<Repeat num_cycles=\"3\">" + Say("S") + "</Repeat>";
  EXPECT_EQ(Run(xml, 4), "RRSR a^ a^ a^ a^ ");
  tree = MakeTree(Main(xml), factory);
  EXPECT_EQ(Letter(tree->TickOnce(At(0))), 'S');
  EXPECT_EQ(Take(), "a^ a^ a^ ");
}
TEST_F(Decorators, RepeatGoesOnInTheSameTickAfterAChildThatRan) {
  EXPECT_EQ(Run("<Repeat num_cycles=\"2\">" + Say("RS") + "</Repeat>", 3), "RRS a^ a a^ a ");
}
// The child ran on without ticks, below a tree that had ended.
TEST_F(Decorators, RepeatHaltsItsChildWhereItsNumberHasBecomeSmaller) {
  for (const std::string repeat : {"Repeat num_cycles", "RetryUntilSuccessful num_attempts"}) {
    const std::string end = "</" + repeat.substr(0, repeat.find(' ')) + ">";
    tree = MakeTree(Main("<" + repeat + "=\"{n}\">" + Leaf("a", "R") + end), factory);
    ASSERT_TRUE(tree->board().Set("n", 2));
    EXPECT_EQ(Ticks(*tree, 1), "R");
    ASSERT_TRUE(tree->board().Set("n", 0));
    EXPECT_EQ(Ticks(*tree, 1, 1), repeat.starts_with("Repeat") ? "S" : "F");
    EXPECT_EQ(Take(), "a^ a! ");
    EXPECT_EQ(tree->status(1), Status::kIdle);
  }
}
TEST_F(Decorators, RepeatReadsItsNumberOnceInATick) {
  tree = MakeTree(
      Main("<Repeat num_cycles=\"{n}\">" + Leaf("a", "RS", "_onSuccess=\"n := 1\"") + "</Repeat>"),
      factory);
  ASSERT_TRUE(tree->board().Set("n", 2));
  EXPECT_EQ(Ticks(*tree, 3), "RRS");
  EXPECT_EQ(Take(), "a^ a a^ a! ");
}
TEST_F(Decorators, RepeatEndsWithAFailure) {
  EXPECT_EQ(Run("<Repeat num_cycles=\"3\">" + Say("SF") + "</Repeat>", 2), "RF a^ a^ ");
}
TEST_F(Decorators, RepeatWithoutALimitEndsATickOnce) {
  const std::string findings =
      Findings(Main("<Repeat num_cycles=\"-1\"><AlwaysSuccess/></Repeat>"));
  EXPECT_THAT(findings, testing::HasSubstr("t.xml:3:1: warning: Repeat has no limit"));
  tree = MakeTree(Main("<Repeat num_cycles=\"-1\"><AlwaysSuccess/></Repeat>"));
  EXPECT_EQ(Letter(tree->TickOnce(At(0))), 'R');
}
TEST_F(Decorators, ALimitBelowMinusOneIsAWarning) {
  EXPECT_THAT(Findings(Main("<Repeat num_cycles=\"-5\"><AlwaysSuccess/></Repeat>")),
              testing::HasSubstr("warning: num_cycles below -1 counts as 0"));
  EXPECT_THAT(Findings(Main("<RetryUntilSuccessful num_attempts=\"-2\"><AlwaysFailure/>"
                            "</RetryUntilSuccessful>")),
              testing::HasSubstr("warning: num_attempts below -1 counts as 0"));
}
TEST_F(Decorators, RetryTriesAgain) {
  const std::string open = "<RetryUntilSuccessful num_attempts=\"3\">";
  EXPECT_EQ(Run(open + Say("FS") + "</RetryUntilSuccessful>", 2), "RS a^ a^ ");
  EXPECT_EQ(Run(open + Say("F") + "</RetryUntilSuccessful>", 4), "RRFR a^ a^ a^ a^ ");
}
TEST_F(Decorators, RetryCountsAgainAfterAHalt) {
  tree = MakeTree(
      Main("<RetryUntilSuccessful num_attempts=\"2\">" + Say("F") + "</RetryUntilSuccessful>"),
      factory);
  EXPECT_EQ(Ticks(*tree, 1), "R");
  ASSERT_TRUE(tree->Halt(At(0)));
  EXPECT_EQ(Ticks(*tree, 2), "RF");
}

TEST_F(Decorators, DelayWaitsBeforeTheFirstTick) {
  EXPECT_EQ(Run("<Delay delay_msec=\"20\">" + Say("RS") + "</Delay>", 6), "RRRSRR a^ a ");
}
TEST_F(Decorators, TimeoutHaltsTheChild) {
  EXPECT_EQ(Run("<Timeout msec=\"20\">" + Say("R") + "</Timeout>", 4), "RRFR a^ a a! a^ ");
  EXPECT_EQ(Run("<Timeout msec=\"20\">" + Say("RS") + "</Timeout>", 2), "RS a^ a ");
}
TEST_F(Decorators, DelayAndTimeoutReadTheirTimeWhenTheyStart) {
  for (const std::string node : {"Delay delay_msec", "Timeout msec"}) {
    const std::string kind = node.substr(0, node.find(' '));
    tree = MakeTree(Main("<" + node + "=\"{time}\">" + Say("R") + "</" + kind + ">"), factory);
    ASSERT_TRUE(tree->board().Set("time", 30));
    std::string letters = Ticks(*tree, 1);
    ASSERT_TRUE(tree->board().Set("time", 0));
    letters += Ticks(*tree, 3, 1);
    EXPECT_EQ(letters + " " + Take(), kind == "Delay" ? "RRRR a^ " : "RRRF a^ a a a! ");
  }
}
TEST_F(Decorators, TimeoutOfZeroIsNoLimit) {
  EXPECT_EQ(Run("<Timeout msec=\"0\">" + Say("R") + "</Timeout>", 3), "RRR a^ a a ");
}
TEST_F(Decorators, TimeThatGoesBackStandsStill) {
  tree = MakeTree(Main("<Sleep msec=\"50\"/>"));
  EXPECT_EQ(Letter(tree->TickExactlyOnce(At(1000))), 'R');
  EXPECT_EQ(Letter(tree->TickExactlyOnce(At(10))), 'R');
  EXPECT_EQ(Letter(tree->TickExactlyOnce(At(1050))), 'S');
}

TEST_F(Decorators, RunOnceSkipsOrRepeatsItsResult) {
  EXPECT_EQ(Run("<RunOnce>" + Say("RF") + "</RunOnce>", 4), "RF-- a^ a ");
  EXPECT_EQ(Run("<RunOnce then_skip=\"false\">" + Say("RF") + "</RunOnce>", 4), "RFFF a^ a ");
}
TEST_F(Decorators, PreconditionIsEvaluatedBeforeTheChildStarts) {
  tree = MakeTree(
      Main("<Precondition if=\"go == 1\" else=\"SKIPPED\">" + Say("RS") + "</Precondition>"),
      factory);
  ASSERT_TRUE(tree->board().Set("go", 0.0));
  EXPECT_EQ(Ticks(*tree, 1), "-");
  ASSERT_TRUE(tree->board().Set("go", 1.0));
  EXPECT_EQ(Ticks(*tree, 1), "R");
  ASSERT_TRUE(tree->board().Set("go", 0.0));
  EXPECT_EQ(Ticks(*tree, 2), "S-");
}

TEST_F(Decorators, LoopsTakeEachValue) {
  tree =
      MakeTree(Main("<LoopInt queue=\"3;4;5\" value=\"{x}\">"
                    "<Script code=\"sum := (x == 3 ? 0 : sum) + x\"/></LoopInt>"));
  EXPECT_EQ(Ticks(*tree, 4), "RRRS");
  EXPECT_EQ(tree->board().Get<int>("sum").value(), 12);
  EXPECT_EQ(Ticks(*tree, 4), "RRRS");  // a fixed queue is full again
}
TEST_F(Decorators, LoopsEmptyASharedQueueAndReadAVector) {
  const std::string xml = Main(
      "<LoopString queue=\"{q}\" value=\"{x}\" if_empty=\"FAILURE\">"
      "<AlwaysSuccess/></LoopString>");
  tree = MakeTree(xml);
  const auto shared = std::make_shared<std::deque<std::string>>();
  *shared = {"a", "b"};
  ASSERT_TRUE(tree->board().Set("q", shared));
  EXPECT_EQ(Ticks(*tree, 4), "RRFF");
  EXPECT_TRUE(shared->empty());
  ASSERT_TRUE(tree->board().Set("q", std::vector<std::string>{"c"}));
  EXPECT_EQ(Ticks(*tree, 3), "RFR");
  EXPECT_EQ(tree->board().Get<std::string>("x").value(), "c");
}
TEST_F(Decorators, AFailedRoundEndsALoop) {
  EXPECT_EQ(Run("<LoopBool queue=\"1;0\" value=\"{x}\">" + Say("RF") + "</LoopBool>", 2),
            "RF a^ a ");
}

TEST_F(Decorators, SkipUnlessUpdatedAndWaitValueUpdateFollowAnEntry) {
  tree = MakeTree(Main("<SkipUnlessUpdated entry=\"{x}\">" + Say("RS") + "</SkipUnlessUpdated>"),
                  factory);
  EXPECT_EQ(Ticks(*tree, 1), "-");
  ASSERT_TRUE(tree->board().Set("x", 1.0));
  EXPECT_EQ(Ticks(*tree, 3), "RS-");
  tree =
      MakeTree(Main("<WaitValueUpdate entry=\"{x}\">" + Say("S") + "</WaitValueUpdate>"), factory);
  EXPECT_EQ(Ticks(*tree, 2), "RR");
  ASSERT_TRUE(tree->board().Set("x", 1.0));
  EXPECT_EQ(Ticks(*tree, 2), "SR");
}
TEST_F(Decorators, SkipUnlessUpdatedHaltsItsChild) {
  tree = MakeTree(Main("<SkipUnlessUpdated entry=\"{x}\">" + Say("R") + "</SkipUnlessUpdated>"),
                  factory);
  ASSERT_TRUE(tree->board().Set("x", 1.0));
  EXPECT_EQ(Ticks(*tree, 1), "R");
  ASSERT_TRUE(tree->Halt(At(10)));
  EXPECT_EQ(Take(), "a^ a! ");
}
TEST_F(Decorators, WasEntryUpdatedIsTrueOncePerChange) {
  tree = MakeTree(Main("<WasEntryUpdated entry=\"x\"/>"));
  EXPECT_EQ(Ticks(*tree, 1), "F");
  ASSERT_TRUE(tree->board().Set("x", 1.0));
  EXPECT_EQ(Ticks(*tree, 2), "SF");
}

TEST_F(Decorators, SleepTakesItsTime) {
  EXPECT_EQ(Run("<Sleep msec=\"20\"/>", 4), "RRSR ");
}
TEST_F(Decorators, SetAndUnsetBlackboard) {
  tree =
      MakeTree(Main("<Sequence><SetBlackboard value=\"7\" output_key=\"x\"/>"
                    "<SetBlackboard value=\"{x}\" output_key=\"{y}\"/>"
                    "<UnsetBlackboard key=\"x\"/></Sequence>"));
  EXPECT_EQ(Ticks(*tree, 1), "S");
  EXPECT_EQ(tree->board().Get<std::string>("y").value(), "7");
  EXPECT_FALSE(tree->board().Get<std::string>("x"));
}
TEST_F(Decorators, ATestNodeTakesThePlaceOfOthers) {
  factory.Substitute(
      "Main/*/a",
      {.result = Status::kFailure, .delay = Milliseconds(20), .failure_script = "failed := 1"});
  EXPECT_EQ(Run("<Sequence>" + Say("S") + "</Sequence>", 3), "RRF ");
  EXPECT_EQ(tree->board().Get<int>("failed").value(), 1);
}

// Of a robot: it forgets its child where its own clean-up throws.
class Careless : public tree::Decorator {
 public:
  explicit Careless(Setup&) {}

 private:
  Status OnTick(Tick& tick) override { return TickChild(tick); }
  void OnHalt(Tick&) override { throw std::runtime_error("the gripper is stuck"); }
};

struct BelowADecoratorThatThrowsInItsHalt : testing::Test, Logged {
  BelowADecoratorThatThrowsInItsHalt() { EXPECT_TRUE(factory.Add<Careless>("Careless")); }
  void ExpectStopped(const Tree& tree) {
    EXPECT_EQ(Take(), "a! ") << "halted once";
    for (NodeId id = 0; id < tree.size(); ++id) EXPECT_NE(tree.status(id), Status::kRunning) << id;
  }
};

// Ends after its second tick, whatever its child does; forgets it in a halt.
class EndsFirst : public tree::Decorator {
 public:
  explicit EndsFirst(Setup& setup) : ends_(setup.Input<std::string>("ends")) {}

 private:
  Status OnTick(Tick& tick) override {
    static_cast<void>(TickChild(tick));
    if (!std::exchange(second_, !second_)) return Status::kRunning;
    return ends_.Get() == "S" ? Status::kSuccess
                              : (ends_.Get() == "F" ? Status::kFailure : Status::kSkipped);
  }
  void OnHalt(Tick&) override { second_ = false; }

  InPort<std::string> ends_;
  bool second_ = false;
};

struct BelowADecoratorThatForgetsItsChild : testing::Test, Logged {
  BelowADecoratorThatForgetsItsChild() { EXPECT_TRUE(factory.Add<EndsFirst>("EndsFirst")); }
  static std::string Ending(const std::string& how, const std::string& child) {
    return "<EndsFirst ends=\"" + how + "\">" + child + "</EndsFirst>";
  }
};

TEST_F(BelowADecoratorThatForgetsItsChild, NothingRunsOnAfterItHasEnded) {
  for (const std::string how : {"S", "F", "-"}) {
    SCOPED_TRACE(how);
    const auto tree = MakeTree(
        Main("<Sequence>" + Ending(how, Leaf("a", "R")) + Leaf("b", "R") + "</Sequence>"), factory);
    EXPECT_EQ(Ticks(*tree, 2), how == "F" ? "RF" : "RR");
    EXPECT_EQ(Take(), how == "F" ? "a^ a a! " : "a^ a a! b^ ");
    EXPECT_FALSE(tree->status(2) == Status::kRunning);
  }
}

TEST_F(BelowADecoratorThatForgetsItsChild, NothingRunsOnAfterAHalt) {
  const auto tree =
      MakeTree(Main(Ending("S", "<Sequence>" + Leaf("a", "R") + "</Sequence>")), factory);
  EXPECT_EQ(Ticks(*tree, 1), "R");
  ASSERT_TRUE(tree->Halt(At(10)));
  EXPECT_EQ(Take(), "a^ a! ");
  EXPECT_EQ(Ticks(*tree, 1, 2), "R");
  EXPECT_EQ(Take(), "a^ ") << "it begins again";
}

TEST_F(BelowADecoratorThatForgetsItsChild, NothingRunsOnAfterItsParentHasHaltedIt) {
  const auto tree = MakeTree(Main("<Sequence><Timeout msec=\"5\">" + Ending("S", Leaf("a", "R")) +
                                  "</Timeout><AlwaysSuccess/></Sequence>"),
                             factory);
  EXPECT_EQ(Ticks(*tree, 2), "RF");
  EXPECT_EQ(Take(), "a^ a! ");
}

TEST_F(BelowADecoratorThatForgetsItsChild, AChildThatIsHaltedWithItIsHaltedOnce) {
  const auto tree = MakeTree(
      Main(Ending("S", Ending("S", "<Inverter>" + Leaf("a", "R") + "</Inverter>"))), factory);
  EXPECT_EQ(Ticks(*tree, 1), "R");
  ASSERT_TRUE(tree->Halt(At(10)));
  EXPECT_EQ(Take(), "a^ a! ");
}

constexpr const char* kCareless = "<Careless><Say name=\"a\" does=\"R\"/></Careless>";

TEST_F(BelowADecoratorThatThrowsInItsHalt, NothingRunsOnAfterAHalt) {
  const auto tree = MakeTree(Main(kCareless), factory);
  EXPECT_EQ(Ticks(*tree, 1), "R");
  Take();
  const Result<> halted = tree->Halt(At(100));
  ASSERT_FALSE(halted);
  EXPECT_THAT(halted.error().message, testing::HasSubstr("Main/Careless: the gripper is stuck"));
  ExpectStopped(*tree);
}

TEST_F(BelowADecoratorThatThrowsInItsHalt, NothingRunsOnAfterAnotherNodeHasThrown) {
  const auto tree = MakeTree(
      Main("<Parallel>" + std::string(kCareless) + "<Say name=\"b\" does=\"R!\"/></Parallel>"),
      factory);
  EXPECT_EQ(Ticks(*tree, 1), "R");
  Take();
  const Result<Status> ticked = tree->TickExactlyOnce(At(10));
  ASSERT_FALSE(ticked);
  EXPECT_THAT(ticked.error().message, testing::HasSubstr("it broke"));
  EXPECT_EQ(Take(), "a b b! a! ");
  EXPECT_FALSE(tree->status(2) == Status::kRunning);
}

TEST_F(BelowADecoratorThatThrowsInItsHalt, NothingRunsOnAfterItWasHaltedByItsParent) {
  const auto tree =
      MakeTree(Main("<Timeout msec=\"15\">" + std::string(kCareless) + "</Timeout>"), factory);
  EXPECT_EQ(Ticks(*tree, 2), "RR");
  Take();
  const Result<Status> ticked = tree->TickExactlyOnce(At(20));
  ASSERT_FALSE(ticked);
  EXPECT_THAT(ticked.error().message, testing::HasSubstr("the gripper is stuck"));
  ExpectStopped(*tree);
}

}  // namespace musher::tree::decorator_test
