// The controls: which children are ticked, in which order, and what is halted.
// "a^" is a's first tick, "a" a further one, "a!" its halt.

#include "musher/test/behavior/tree/trees.hpp"

namespace musher::tree::control_test {

std::string A(const std::string& does, const std::string& more = "") {
  return "<Say name=\"a\" does=\"" + does + "\" " + more + "/>";
}
std::string B(const std::string& does, const std::string& more = "") {
  return "<Say name=\"b\" does=\"" + does + "\" " + more + "/>";
}
std::string C(const std::string& does, const std::string& more = "") {
  return "<Say name=\"c\" does=\"" + does + "\" " + more + "/>";
}
std::string In(const std::string& control, const std::string& children) {
  return Main("<" + control + ">" + children + "</" + control.substr(0, control.find(' ')) + ">");
}

struct Control : testing::Test, Logged {
  // The letters of so many ticks, and the log of each.
  std::string Run(const std::string& xml, int ticks) {
    tree = MakeTree(xml, factory);
    std::string text;
    for (int i = 0; i < ticks; ++i) {
      text += i > 0 ? "| " : "";
      text += Letter(tree->TickExactlyOnce(At(10 * i)));
      text += ": " + Take();
    }
    return text;
  }
  std::string TicksAndLog(int times, int first = 0) {
    const std::string letters = Ticks(*tree, times, first);
    return letters + " " + Take();
  }
  std::unique_ptr<Tree> tree;
};

TEST_F(Control, SequenceGoesOnWhereItWas) {
  EXPECT_EQ(Run(In("Sequence", A("S") + B("RRS") + C("S")), 4),
            "R: a^ b^ | R: b | S: b c^ | R: a^ b^ ");
}
TEST_F(Control, SequenceBeginsAgainAfterAFailure) {
  EXPECT_EQ(Run(In("Sequence", A("S") + B("F") + C("S")), 2), "F: a^ b^ | F: a^ b^ ");
}
TEST_F(Control, SequenceWithMemoryRepeatsTheChildThatFailed) {
  EXPECT_EQ(Run(In("SequenceWithMemory", A("S") + B("FS") + C("S")), 6),
            "R: a^ | F: b^ | R: b^ | S: c^ | R: a^ | F: b^ ");
}
TEST_F(Control, SequenceWithMemoryKeepsItsPlaceWhenItIsHalted) {
  Run(In("SequenceWithMemory", A("S") + B("RS")), 2);
  ASSERT_TRUE(tree->Halt(At(20)));
  EXPECT_EQ(Take(), "b! ");
  EXPECT_EQ(Letter(tree->TickExactlyOnce(At(30))), 'S');
  EXPECT_EQ(Take(), "b^ ");
}
TEST_F(Control, AsyncSequenceGivesTheTreeATurnBetweenChildren) {
  EXPECT_EQ(Run(In("AsyncSequence", A("S") + B("S") + C("S")), 4),
            "R: a^ | R: b^ | S: c^ | R: a^ ");
  tree = MakeTree(In("AsyncSequence", A("S") + B("S") + C("S")), factory);
  EXPECT_EQ(Letter(tree->TickOnce(At(0))), 'S');
}
TEST_F(Control, FallbackTriesTheNextAndRemembersWhichRuns) {
  EXPECT_EQ(Run(In("Fallback", A("F") + B("RF") + C("S")), 3), "R: a^ b^ | S: b c^ | R: a^ b^ ");
  EXPECT_EQ(Run(In("Fallback", A("F") + B("F")), 1), "F: a^ b^ ");
}
TEST_F(Control, ReactiveSequenceHaltsWhatRunsWhenAConditionFails) {
  EXPECT_EQ(Run(In("ReactiveSequence", A("SSF") + B("R")), 4),
            "R: a^ b^ | R: a^ b | F: a^ b! | R: a^ b^ ");
}
TEST_F(Control, ReactiveSequenceHaltsTheChildBehindOneThatBeginsToRun) {
  EXPECT_EQ(Run(In("ReactiveSequence", A("SRS") + B("RRR")), 3), "R: a^ b^ | R: a^ b! | R: a b^ ");
}
TEST_F(Control, ReactiveFallbackHaltsWhatRunsWhenAnEarlierChildSucceeds) {
  EXPECT_EQ(Run(In("ReactiveFallback", A("FFS") + B("R")), 3), "R: a^ b^ | R: a^ b | S: a^ b! ");
}
TEST_F(Control, ParallelNeedsAllAndEndsWithTheFirstFailure) {
  EXPECT_EQ(Run(In("Parallel", A("RS") + B("RRS")), 3), "R: a^ b^ | R: a b | S: b ");
  EXPECT_EQ(Run(In("Parallel", A("RRS") + B("RF")), 2), "R: a^ b^ | F: a b a! ");
}
TEST_F(Control, ParallelHaltsWhatRunsOnceEnoughHaveSucceeded) {
  EXPECT_EQ(Run(In("Parallel success_count=\"1\" failure_count=\"2\"", A("RR") + B("RS")), 2),
            "R: a^ b^ | S: a b a! ");
}
TEST_F(Control, ParallelFailsWhenItCanNoLongerSucceed) {
  EXPECT_EQ(
      Run(In("Parallel success_count=\"2\" failure_count=\"3\"", A("F") + B("RF") + C("R")), 2),
      "R: a^ b^ c^ | F: b c! ");
}
TEST_F(Control, ParallelAllWaitsForAll) {
  EXPECT_EQ(Run(In("ParallelAll max_failures=\"2\"", A("F") + B("RRS") + C("S")), 3),
            "R: a^ b^ c^ | R: b | S: b ");
  EXPECT_EQ(Run(In("ParallelAll", A("F") + B("RS")), 2), "R: a^ b^ | F: b ");
}
TEST_F(Control, IfThenElseDecidesOnce) {
  EXPECT_EQ(Run(In("IfThenElse", A("SF") + B("RS") + C("S")), 3), "R: a^ b^ | S: b | S: a^ c^ ");
  EXPECT_EQ(Run(In("IfThenElse", A("F") + B("S")), 1), "F: a^ ");
}
TEST_F(Control, WhileDoElseDecidesInEachTick) {
  EXPECT_EQ(Run(In("WhileDoElse", A("SFS") + B("R") + C("R")), 3),
            "R: a^ b^ | R: a^ b! c^ | R: a^ c! b^ ");
  EXPECT_EQ(Run(In("WhileDoElse", A("SF") + B("R")), 2), "R: a^ b^ | F: a^ b! ");
}
TEST_F(Control, WhileDoElseHaltsItsBranchWhileItsConditionRuns) {
  EXPECT_EQ(Run(In("WhileDoElse", A("SRS") + B("R")), 3), "R: a^ b^ | R: a^ b! | R: a b^ ");
  EXPECT_EQ(Run(In("WhileDoElse", A("FRF") + B("R") + C("R")), 3),
            "R: a^ c^ | R: a^ c! | R: a c^ ");
}
TEST_F(Control, ASkippedConditionSkipsIfThenElseAndWhileDoElse) {
  const std::string skipped = A("S", "_skipIf=\"true\"");
  EXPECT_EQ(Run(In("IfThenElse", skipped + B("S")), 1), "-: ");
  EXPECT_EQ(Run(In("WhileDoElse", skipped + B("S")), 1), "-: ");
}

TEST_F(Control, SwitchTicksTheMatchingCaseAndHaltsTheOther) {
  tree = MakeTree(Main("<Switch2 variable=\"{v}\" case_1=\"1\" case_2=\"go\">" + A("R") + B("R") +
                       C("R") + "</Switch2>"),
                  factory);
  ASSERT_TRUE(tree->board().Set("v", "go"));
  EXPECT_EQ(TicksAndLog(2), "RR b^ b ");
  ASSERT_TRUE(tree->board().Set("v", 1.0));
  EXPECT_EQ(TicksAndLog(1, 2), "R b! a^ ");
  ASSERT_TRUE(tree->board().Set("v", "none"));
  EXPECT_EQ(TicksAndLog(1, 3), "R a! c^ ");
}
TEST_F(Control, SwitchTicksItsLastChildWhereTheVariableHasNoValue) {
  EXPECT_EQ(Run(Main("<Switch2 variable=\"{v}\" case_1=\"1\" case_2=\"2\">" + A("S") + B("S") +
                     C("S") + "</Switch2>"),
                1),
            "S: c^ ");
}
TEST_F(Control, SwitchComparesWithTheNamesOfEnums) {
  factory.AddEnum("RED", 2);
  tree = MakeTree(Main("<Switch2 variable=\"{v}\" case_1=\"RED\" case_2=\"3\">" + A("S") + B("S") +
                       C("S") + "</Switch2>"),
                  factory);
  ASSERT_TRUE(tree->board().Set("v", 2.0));
  EXPECT_EQ(TicksAndLog(1), "S a^ ");
}

TEST_F(Control, IsSkippedWhenAllItsChildrenAre) {
  const std::string skipped = A("S", "_skipIf=\"true\"") + B("S", "_skipIf=\"true\"");
  for (const char* name : {"Sequence", "Fallback", "ReactiveSequence", "ReactiveFallback",
                           "SequenceWithMemory", "Parallel", "ParallelAll"}) {
    EXPECT_EQ(Run(In(name, skipped), 1), "-: ") << name;
  }
}
TEST_F(Control, PassesOverASkippedChild) {
  const std::string skipped = A("S", "_skipIf=\"true\"");
  EXPECT_EQ(Run(In("Sequence", skipped + B("S")), 1), "S: b^ ");
  EXPECT_EQ(Run(In("Fallback", skipped + B("F")), 1), "F: b^ ");
  EXPECT_EQ(Run(In("Parallel", skipped + B("S")), 1), "S: b^ ");
}

TEST_F(Control, HaltReachesEachRunningNodeOnce) {
  Run(Main("<Parallel><Sequence>" + A("R") + "</Sequence><ReactiveSequence><AlwaysSuccess/>" +
           B("R") + "</ReactiveSequence><Delay delay_msec=\"0\"><Inverter>" + C("R") +
           "</Inverter></Delay></Parallel>"),
      2);
  Take();
  ASSERT_TRUE(tree->Halt(At(20)));
  EXPECT_EQ(Take(), "a! b! c! ");
  ASSERT_TRUE(tree->Halt(At(30)));
  EXPECT_EQ(Take(), "");
  for (NodeId id = 0; id < tree->size(); ++id) EXPECT_EQ(tree->status(id), Status::kIdle);
}

TEST_F(Control, ANodeThatThrowsHaltsTheOthersAndIsNamedWithItsPath) {
  tree = MakeTree(In("Parallel name=\"both\"", A("R") + B("R!R")), factory);
  EXPECT_EQ(Ticks(*tree, 1), "R");
  const Result<Status> failed = tree->TickExactlyOnce(At(10));
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().message, "t.xml:3:48: Main/both/b: it broke");
  EXPECT_EQ(Take(), "a^ b^ a b b! a! ") << "it ran, and may have set something in motion";
  EXPECT_EQ(Letter(tree->TickExactlyOnce(At(20))), 'R');  // begins again
  EXPECT_EQ(Take(), "a^ b^ ");
}
TEST_F(Control, ALeafThatThrowsWhenItStartsIsNotHalted) {
  tree = MakeTree(In("Parallel", A("R") + B("!")), factory);
  EXPECT_EQ(TicksAndLog(1), "! a^ b^ a! ");
}
TEST_F(Control, ALeafThatThrowsWhileItRunsRunsItsScriptOfAHaltOnce) {
  tree = MakeTree(Main(A("R!R", "_onHalted=\"halts := halts + 1\"")), factory);
  ASSERT_TRUE(tree->board().Set("halts", 0));
  EXPECT_EQ(TicksAndLog(2), "R! a^ a a! ");
  EXPECT_EQ(tree->board().Get<int>("halts").value(), 1);
}

// A text that is compared with a number throws.
TEST_F(Control, ARunningLeafWhoseConditionThrowsIsHaltedOnce) {
  tree = MakeTree(
      In("Parallel", A("R", "_while=\"n &gt; 1\" _onHalted=\"halts := halts + 1\"") + B("R")),
      factory);
  ASSERT_TRUE(tree->board().Set("halts", 0));
  ASSERT_TRUE(tree->board().Set("n", 2));
  EXPECT_EQ(TicksAndLog(1), "R a^ b^ ");
  ASSERT_TRUE(tree->board().Set("n", "far"));
  const Result<Status> failed = tree->TickExactlyOnce(At(10));
  ASSERT_FALSE(failed);
  EXPECT_THAT(failed.error().message, testing::StartsWith("t.xml:3:11: Main/Parallel/a: "));
  EXPECT_EQ(Take(), "a! b! ");
  EXPECT_EQ(tree->board().Get<int>("halts").value(), 1);
  ASSERT_TRUE(tree->Halt(At(20)));
  EXPECT_EQ(Take(), "") << "nothing runs any more";
}
TEST_F(Control, ARunningLeafWhoseConditionHasLostItsEntryIsHaltedOnce) {
  tree = MakeTree(Main(A("R", "_while=\"n &gt; 1\"")), factory);
  ASSERT_TRUE(tree->board().Set("n", 2));
  EXPECT_EQ(TicksAndLog(1), "R a^ ");
  tree->board().Find("n")->value.Clear();
  EXPECT_EQ(TicksAndLog(1, 1), "! a! ");
}
TEST_F(Control, TheChildrenOfANodeWhoseConditionThrowsAreHaltedOnce) {
  for (const std::string control : {"Sequence", "Parallel", "ReactiveSequence", "Inverter"}) {
    tree = MakeTree(Main("<" + control + " _while=\"n &gt; 1\">" + A("R") + "</" + control + ">"),
                    factory);
    ASSERT_TRUE(tree->board().Set("n", 2));
    EXPECT_EQ(TicksAndLog(1), "R a^ ") << control;
    ASSERT_TRUE(tree->board().Set("n", "far"));
    EXPECT_EQ(TicksAndLog(1, 1), "! a! ") << control;
    ASSERT_TRUE(tree->board().Set("n", 2));
    EXPECT_EQ(TicksAndLog(1, 2), "R a^ ") << control << " begins again";
  }
}
TEST_F(Control, ANodeWhoseConditionThrowsBeforeItStartsIsNotHalted) {
  for (const std::string condition : {"_failureIf", "_successIf", "_skipIf", "_while"}) {
    tree = MakeTree(Main("<Finally " + condition + "=\"n &gt; 1\" _onHalted=\"halts := 1\">" +
                         A("R") + B("S") + "</Finally>"),
                    factory);
    ASSERT_TRUE(tree->board().Set("n", "far"));
    EXPECT_EQ(TicksAndLog(1), "! ") << condition << ": it has nothing to clean up";
    EXPECT_TRUE(tree->board().Find("halts")->value.empty()) << condition;
  }
}
TEST_F(Control, ANodeWhoseScriptThrowsAfterItsEndIsNotHalted) {
  for (const std::string script : {"_onSuccess", "_post"}) {
    tree = MakeTree(
        Main("<TryCatch catch_on_halt=\"true\" " + script +
             "=\"unknown = 1\" _onHalted=\"halts := 1\">" + A("RS") + B("S") + "</TryCatch>"),
        factory);
    EXPECT_EQ(TicksAndLog(2), "R! a^ a ") << script << ": it has succeeded";
    EXPECT_TRUE(tree->board().Find("halts")->value.empty()) << script;
  }
}

// RUNNING until it is halted; then it throws.
class DoesNotStop : public StatefulAction {
  Status OnStart(const Tick&) override { return Status::kRunning; }
  Status OnRunning(const Tick&) override { return Status::kRunning; }
  void OnHalted(const Tick&) override { throw std::runtime_error("it does not stop"); }
};

TEST_F(Control, ANodeThatThrowsInItsHaltAlsoHaltsTheOthersAndIsNamedWithItsPath) {
  ASSERT_TRUE(factory.Add<DoesNotStop>("DoesNotStop"));
  tree = MakeTree(In("ReactiveFallback name=\"watch\"", A("FR") + "<DoesNotStop/>"), factory);
  EXPECT_EQ(Ticks(*tree, 1), "R");
  const Result<Status> failed = tree->TickExactlyOnce(At(10));
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().message, "t.xml:3:58: Main/watch/DoesNotStop: it does not stop");
  EXPECT_EQ(Take(), "a^ a^ a! ");
  EXPECT_EQ(tree->status(), Status::kIdle);
  EXPECT_EQ(Letter(tree->TickExactlyOnce(At(20))), 'R');  // begins again
  EXPECT_EQ(tree->Halt(At(30)).error().message,
            "t.xml:3:58: Main/watch/DoesNotStop: it does not stop");
}

TEST_F(Control, AnActionMustNotRun) {
  ASSERT_TRUE(factory.AddAction("Bad", [](const Tick&) { return Status::kIdle; }));
  tree = MakeTree(Main("<Bad/>"), factory);
  EXPECT_EQ(
      tree->TickExactlyOnce(At(0)).error().message,
      "t.xml:3:1: Main/Bad: its tick returned IDLE; expected SUCCESS, FAILURE, RUNNING or SKIPPED");
  ASSERT_TRUE(factory.AddAction("Slow", [](const Tick&) { return Status::kRunning; }));
  tree = MakeTree(Main("<Slow/>"), factory);
  EXPECT_THAT(tree->TickExactlyOnce(At(0)).error().message,
              testing::HasSubstr("an action must not return RUNNING"));
}

// Ticks the child whose name is in `which`.
class ByName : public tree::Control {
 public:
  explicit ByName(Setup& setup) : which_(setup.Input<std::string>("which")) {}

 private:
  Status OnTick(Tick& tick) override {
    for (std::size_t i = 0; i < children().size(); ++i) {
      if (child_names()[i] == which_.Get()) return children()[i]->Execute(tick);
    }
    return Status::kFailure;
  }
  InPort<std::string> which_;
};

// Its commands would go on behind a control that has moved on.
TEST_F(Control, AChildThatAProgramsControlLeavesRunningIsHalted) {
  ASSERT_TRUE(factory.Add<ByName>("ByName"));
  tree = MakeTree(Main("<ByName which=\"{which}\">" + A("R") + B("S") + "</ByName>"), factory);
  ASSERT_TRUE(tree->board().Set("which", std::string("a")));
  EXPECT_EQ(Ticks(*tree, 1), "R");
  ASSERT_TRUE(tree->board().Set("which", std::string("b")));
  EXPECT_EQ(Ticks(*tree, 1, 1), "S");
  EXPECT_EQ(Take(), "a^ b^ a! ");
}

TEST_F(Control, KnowsTheNamesOfItsChildren) {
  ASSERT_TRUE(factory.Add<ByName>("ByName"));
  EXPECT_EQ(Run(In("ByName which=\"b\"", A("S") + B("S")), 1), "S: b^ ");
  EXPECT_EQ(Run(In("ByName which=\"AlwaysSuccess\"", A("S") + "<AlwaysSuccess/>"), 1), "S: ");
}

// Throws at each change to RUNNING.
class Throwing : public ChangeListener {
  void OnChange(const Change& change) override {
    if (change.to == Status::kRunning) throw std::runtime_error("its disk is full");
  }
};
class Counting : public ChangeListener {
 public:
  int changes = 0;

 private:
  void OnChange(const Change&) override { ++changes; }
};
TEST_F(Control, AListenerThatThrowsGetsNothingMoreAndTheTreeHaltsWhatRuns) {
  tree = MakeTree(In("Sequence", A("S") + B("R")), factory);
  const auto throwing = std::make_shared<Throwing>();
  const auto counting = std::make_shared<Counting>();
  tree->Listen(throwing);
  tree->Listen(counting);
  EXPECT_EQ(TicksAndLog(2), "RR a^ b^ b ");
  EXPECT_EQ(counting->changes, 3) << "of a, of b, of the sequence";
  EXPECT_EQ(tree->dropped_listeners(), 1);
  ASSERT_TRUE(tree->Halt(At(20)));
  EXPECT_EQ(Take(), "b! ");
  EXPECT_EQ(counting->changes, 6);
}

struct Selecting : testing::Test, Logged {
  void Make(const std::string& ports = "") {
    tree = MakeTree(Main("<ManualSelector selection=\"{pick}\" " + ports +
                         "><Say name=\"a\" does=\"RS\"/><Say name=\"b\" does=\"F\"/>"
                         "</ManualSelector>"),
                    factory);
  }
  std::string Pick(const std::string& name, int ticks) {
    EXPECT_TRUE(tree->board().Set("pick", name));
    const std::string letters = Ticks(*tree, ticks);
    return letters + " " + Take();
  }
  std::unique_ptr<Tree> tree;
};

TEST_F(Selecting, AManualSelectorWaitsForANameAndTicksThatChildToItsEnd) {
  Make();
  EXPECT_EQ(Ticks(*tree, 2), "RR") << "nothing is selected";
  EXPECT_EQ(Pick("a", 3), "RSR a^ a ");
  EXPECT_EQ(tree->board().Get<std::string>("pick").value(), "");
  EXPECT_EQ(Pick("b", 1), "F b^ ");
  EXPECT_EQ(Pick("SUCCESS", 2), "SR ");
  EXPECT_EQ(Pick("FAILURE", 1), "F ");
  EXPECT_EQ(Pick("c", 2), "RR ") << "there is none";
  EXPECT_EQ(tree->board().Get<std::string>("pick").value(), "c") << "which stays to be seen";
}

TEST_F(Selecting, AManualSelectorForgetsItsChildWhenItIsHalted) {
  Make();
  EXPECT_EQ(Pick("a", 1), "R a^ ");
  ASSERT_TRUE(tree->Halt(At(100)));
  EXPECT_EQ(Ticks(*tree, 2), "RR");
  EXPECT_EQ(Take(), "a! ");
}

TEST_F(Selecting, AManualSelectorRepeatsTheLastSelectionOnRequest) {
  Make("repeat_last_selection=\"true\"");
  EXPECT_EQ(Ticks(*tree, 1), "R") << "there was none";
  EXPECT_EQ(Pick("b", 3), "FFF b^ b^ b^ ");
}

}  // namespace musher::tree::control_test
