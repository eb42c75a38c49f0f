// The order in which queued commands are handled: several in a tick, deferred ones, and by which
// state of a hierarchy.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/behavior/fsm/graph.hpp"
#include "musher/test/behavior/fsm/hierarchy_fixture.hpp"

namespace musher::fsm::command_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class Kept : public Listener {
 public:
  void OnKept(const Machine& machine, EventId command, StateId state) override {
    lines.push_back(std::string(machine.Name(state)) + " " + std::string(machine.Name(command)));
  }
  std::vector<std::string> lines;
};

class CommandTest : public HierarchyFixture {
 protected:
  // The states log the commands that they get, and handle them.
  void LogCommands(LoggingState& state, const std::string& name) {
    state.check = [this, name](const Tick& tick) {
      if (tick.command == kNoEvent) return Next::Stay();
      got_.push_back(name + " " + std::string(machine_.Name(tick.command)));
      return Next::Handle();
    };
  }
  void Send(std::initializer_list<const char*> commands) {
    for (const char* command : commands) ASSERT_TRUE(machine_.Send(command)) << command;
  }
  static Next GoTo(LoggingState& state, const std::string& target) {
    state.Go(target);
    return state.CheckTransition({});
  }

  std::vector<std::string> got_;
};

class DrainTest : public CommandTest {
 protected:
  void Make(std::size_t commands_per_tick) {
    drained_ = std::make_unique<Machine>(
        Machine::Options{.name = "drained", .commands_per_tick = commands_per_tick});
    for (const char* event : {"one", "two", "three", "go"}) drained_->AddEvent(event);
    a_ = &Add(*drained_, "A", {"B"});
    b_ = &Add(*drained_, "B", {"A"});
    for (LoggingState* state : {a_, b_}) {
      const std::string name = state == a_ ? "A " : "B ";
      state->check = [this, name](const Tick& tick) {
        if (tick.command == kNoEvent) return Next::Stay();
        got_.push_back(name + std::string(drained_->Name(tick.command)));
        return Next::Handle();
      };
    }
    ASSERT_TRUE(drained_->Build("A"));
    ASSERT_TRUE(drained_->Start(now_));
    log_.clear();
  }
  void SendAndTick(std::initializer_list<const char*> commands) {
    for (const char* command : commands) ASSERT_TRUE(drained_->Send(command));
    TickDrained();
  }
  void TickDrained() { drained_->RunOnce(now_ += kStep); }

  std::unique_ptr<Machine> drained_;
  LoggingState* a_ = nullptr;
  LoggingState* b_ = nullptr;
};

TEST_F(DrainTest, ATickHandlesOneCommandUnlessItMayHandleMore) {
  Make(1);
  SendAndTick({"one", "two"});
  EXPECT_THAT(got_, ElementsAre("A one"));
}

TEST_F(DrainTest, ATickHandlesUpToThatManyInOrder) {
  Make(2);
  SendAndTick({"one", "two", "three"});
  EXPECT_THAT(got_, ElementsAre("A one", "A two"));
  TickDrained();
  EXPECT_THAT(got_, ElementsAre("A one", "A two", "A three"));
}

TEST_F(DrainTest, TheStateThatACommandLeadsToGetsTheNextOneInTheSameTick) {
  Make(3);
  a_->check = [this](const Tick& tick) {
    return tick.command == kNoEvent ? Next::Stay() : GoTo(*a_, "B");
  };
  SendAndTick({"go", "one"});
  EXPECT_THAT(got_, ElementsAre("B one"));
  EXPECT_THAT(log_, ElementsAre("A exit", "B enter", "B run"));
}

TEST_F(DrainTest, FurtherCommandsTakeNoTime) {
  Make(3);
  Duration ran{};
  a_->on["run"] = [&](const Tick& tick) { ran += tick.step; };
  SendAndTick({"one", "two", "three"});
  EXPECT_EQ(ran, kStep);
  EXPECT_EQ(drained_->time(), kStep);
  EXPECT_EQ(drained_->ticks(), 1U);
}

TEST_F(DrainTest, WaitsForTheEndOfAGradualTransition) {
  Make(3);
  a_->check = [this](const Tick& tick) {
    if (tick.command == kNoEvent) return Next::Stay();
    a_->Go("B", kStep);
    return a_->CheckTransition({});
  };
  SendAndTick({"go", "one"});
  EXPECT_THAT(got_, IsEmpty());
  TickDrained();  // the transition ends, and B gets the command in the same tick
  EXPECT_THAT(got_, ElementsAre("B one"));
}

TEST_F(DrainTest, DoesNotOfferAKeptCommandAgainInTheSameTick) {
  Make(3);
  int offered = 0;
  a_->check = [&](const Tick&) {
    ++offered;
    return Next::Stay().KeepCommand();
  };
  SendAndTick({"one"});
  EXPECT_EQ(offered, 1);
}

class DeferTest : public CommandTest {
 protected:
  void Make() {
    for (const char* event : {"photo", "louder", "go"}) machine_.AddEvent(event);
    busy_ = &Add("BUSY", {"IDLE"});
    busy_->declare = [](Transitions& transitions) { transitions.Defer("photo"); };
    idle_ = &Add("IDLE", {"BUSY"});
    idle_->declare = [](Transitions& transitions) { transitions.On("photo"); };
    LogCommands(*busy_, "BUSY");
    LogCommands(*idle_, "IDLE");
    Start("BUSY");
  }
  LoggingState* busy_ = nullptr;
  LoggingState* idle_ = nullptr;
};

TEST_F(DeferTest, ADeferredCommandWaitsAndOthersPassIt) {
  Make();
  Send({"photo", "louder"});
  Run(3);
  EXPECT_THAT(got_, ElementsAre("BUSY louder"));
  EXPECT_EQ(machine_.waiting_commands(), 1U);
}

TEST_F(DeferTest, ADeferredCommandComesFirstInAStateThatDoesNotDeferIt) {
  Make();
  Send({"photo", "louder", "photo"});
  Run();
  busy_->Go("IDLE");
  Run();
  Send({"go"});
  Run(3);
  EXPECT_THAT(got_, ElementsAre("BUSY louder", "IDLE photo", "IDLE photo", "IDLE go"));
  EXPECT_EQ(machine_.counts().unhandled, 0U);
}

TEST_F(DeferTest, IsDrawn) {
  Make();
  EXPECT_THAT(ToDot(machine_.chart()), HasSubstr("s0 [label=\"BUSY\\nphoto / defer\"]"));
  EXPECT_THAT(ToMermaid(machine_.chart()), HasSubstr("state \"BUSY, photo / defer\" as s0"));
}

TEST_F(CommandTest, AStateThatHandlesAndDefersAnEventIsAnErrorOfBuild) {
  machine_.AddEvent("photo");
  Add("IDLE").declare = [](Transitions& transitions) {
    transitions.On("photo");
    transitions.Defer("photo");
  };
  const Result<> built = machine_.Build("IDLE");
  ASSERT_FALSE(built);
  EXPECT_EQ(built.error().message, "show: IDLE: both handles and defers photo");
}

TEST_F(CommandTest, ADeferredEventThatNoStateHandlesIsAWarning) {
  machine_.AddEvent("photo");
  Add("IDLE").declare = [](Transitions& transitions) { transitions.Defer("photo"); };
  Start("IDLE");
  EXPECT_THAT(machine_.warnings(),
              ElementsAre("IDLE: defers photo, which no state declares to handle"));
}

// SHOW with ASK inside; both log their commands.
class InnerFirstTest : public CommandTest {
 protected:
  void Make(bool inner_first) {
    auto inside = NewMachine("inside");
    inside->AddEvent("go");
    machine_.AddEvent("go");
    inner_ = inside.get();
    ask_ = &Add(*inside, "ASK", {"TELL"});
    tell_ = &Add(*inside, "TELL", {"ASK"});
    show_ = &AddNested(machine_, "SHOW", std::move(inside), "ASK", {.inner_first = inner_first});
    show_->declare = [this](Transitions& transitions) {
      idle_ = transitions.To("IDLE", "commanded");
    };
    Add("IDLE", {"SHOW"});
    show_->decide = [this](const Tick& tick) {
      return leaves_ || tick.command != kNoEvent ? Next::To(idle_) : Next::Stay();
    };
    Start("SHOW");
    log_.clear();
  }
  void AskHandles(Next next) {
    ask_->check = [next](const Tick& tick) {
      return tick.command == kNoEvent ? Next::Stay() : next;
    };
  }

  Machine* inner_ = nullptr;
  LoggingState* ask_ = nullptr;
  LoggingState* tell_ = nullptr;
  LoggingNested* show_ = nullptr;
  StateId idle_ = kNoState;
  bool leaves_ = false;
};

TEST_F(InnerFirstTest, TheOuterStateComesFirstByDefault) {
  Make(false);
  AskHandles(Next::Handle());
  Send({"go"});
  Run();
  EXPECT_EQ(machine_.Path(), "IDLE");
}

TEST_F(InnerFirstTest, TheInnerStateComesFirstAsAnOption) {
  Make(true);
  AskHandles(Next::Handle());
  Send({"go"});
  EXPECT_THAT(TickLog(), ElementsAre("ASK run"));
  EXPECT_EQ(machine_.Path(), "SHOW/ASK");
  EXPECT_EQ(machine_.counts().unhandled, 0U);
}

TEST_F(InnerFirstTest, TheOuterStateGetsWhatTheInnerOneDoesNotHandle) {
  Make(true);
  Send({"go"});
  EXPECT_THAT(TickLog(), ElementsAre("ASK exit", "SHOW exit", "IDLE enter"));
  EXPECT_EQ(inner_->counts().unhandled, 0U);
  EXPECT_EQ(machine_.Name(machine_.history().back().command), "go");
}

TEST_F(InnerFirstTest, AnInnerTransitionComesBeforeOneOfTheOuterState) {
  Make(true);
  leaves_ = true;
  ask_->Go("TELL");
  EXPECT_THAT(TickLog(), ElementsAre("ASK exit", "TELL enter"));
  EXPECT_THAT(TickLog(), ElementsAre("TELL exit", "SHOW exit", "IDLE enter"));
}

TEST_F(InnerFirstTest, ACommandThatTheInnerStateKeepsStaysQueuedOutside) {
  Make(true);
  AskHandles(Next::Stay().KeepCommand());
  Send({"go"});
  Run(2);
  EXPECT_EQ(machine_.Path(), "SHOW/ASK");
  EXPECT_EQ(machine_.waiting_commands(), 1U);
  EXPECT_EQ(inner_->waiting_commands(), 0U);
}

TEST_F(InnerFirstTest, ACommandThatNoStateHandlesIsCountedOnceOutside) {
  Make(true);
  show_->decide = nullptr;
  Send({"go"});
  Run();
  EXPECT_EQ(machine_.counts().unhandled, 1U);
  EXPECT_EQ(inner_->counts().unhandled, 0U);
}

TEST_F(InnerFirstTest, ACommandWaitsOutsideDuringAGradualTransitionInside) {
  Make(true);
  ask_->Go("TELL", 2 * kStep);
  Run();
  Send({"go"});
  Run();
  EXPECT_EQ(machine_.waiting_commands(), 1U);
  Run(2);
  EXPECT_EQ(machine_.Path(), "IDLE");
}

TEST_F(CommandTest, AStayThatKeepsACommandIsReportedOnce) {
  machine_.AddEvent("photo");
  Add("IDLE").check = [](const Tick&) { return Next::Stay().KeepCommand(); };
  Kept kept;
  machine_.Listen(&kept);
  Start("IDLE");
  Run();
  EXPECT_THAT(kept.lines, IsEmpty());
  Send({"photo"});
  Run(5);
  EXPECT_THAT(kept.lines, ElementsAre("IDLE photo"));
  machine_.Forget(&kept);
}

TEST_F(CommandTest, ATickInsideOfATickIsAFaultOfTheState) {
  Add("IDLE").on["run"] = [this](const Tick&) { machine_.RunOnce(now_); };
  Start("IDLE");
  Run();
  EXPECT_FALSE(machine_.running());
  EXPECT_EQ(machine_.Describe(*machine_.fault()),
            "IDLE: Run: RunOnce() of show inside of its own tick does nothing");
}

TEST_F(CommandTest, ATickInsideOfDeclareIsAnErrorOfBuild) {
  Add("IDLE").declare = [this](Transitions&) { machine_.RunOnce(now_); };
  const Result<> built = machine_.Build("IDLE");
  ASSERT_FALSE(built);
  EXPECT_EQ(built.error().message,
            "show: IDLE: Declare: RunOnce() of show inside of its own tick does nothing");
}

}  // namespace musher::fsm::command_test
