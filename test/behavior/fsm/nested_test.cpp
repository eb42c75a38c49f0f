#include "musher/behavior/fsm/nested.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "musher/test/behavior/fsm/machine_fixture.hpp"

namespace musher::fsm::nested_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// IDLE, and SHOW with CONFIRM and TAKE and DONE inside. On command, SHOW goes to IDLE.
class NestedTest : public MachineFixture {
 protected:
  class Show : public Nested {
   public:
    Show(std::unique_ptr<Machine> inner, Options options)
        : Nested(std::move(inner), "CONFIRM", std::move(options)) {}
    void Declare(Transitions& transitions) override {
      Nested::Declare(transitions);
      idle_ = transitions.To("IDLE", "commanded");
      stop_ = transitions.Find("stop").value_or(kNoEvent);
    }
    Next Decide(const Tick& tick) override {
      if (tick.command != kNoEvent && tick.command == stop_) return Next::To(idle_);
      return std::exchange(leaves, false) ? Next::To(idle_, gradually) : Next::Stay();
    }
    bool leaves = false;
    Duration gradually{};

   private:
    StateId idle_ = kNoState;
    EventId stop_ = kNoEvent;
  };

  void Make(Nested::Options options = {}, bool inner_safe = true) {
    auto inner = std::make_unique<Machine>(Machine::Options{.name = "photo"});
    inner_ = inner.get();
    confirm_ = &Add(*inner_, "CONFIRM", {"TAKE"});
    take_ = &Add(*inner_, "TAKE", {"DONE", "CONFIRM"});
    Add(*inner_, "DONE", {}, Role::kFinal);
    if (inner_safe) Add(*inner_, "CALM", {"CONFIRM"}, Role::kSafe);
    for (const char* event : {"yes", "stop", "only inside"}) inner_->AddEvent(event);
    for (const char* event : {"no", "yes", "stop"}) machine_.AddEvent(event);
    idle_ = &Add("IDLE", {"SHOW"});
    auto show = std::make_unique<Show>(std::move(inner), std::move(options));
    show_ = show.get();
    machine_.Add("SHOW", std::move(show));
    Add("SAFE", {"IDLE"}, Role::kSafe);
    machine_.AddSafetyCheck("distance", [this](const Tick&) { return safe_; });
    Start("IDLE");
  }
  // To SHOW.
  void Enter() {
    idle_->Go("SHOW");
    Run();
  }

  Machine* inner_ = nullptr;
  LoggingState* idle_ = nullptr;
  Show* show_ = nullptr;
  LoggingState* confirm_ = nullptr;
  LoggingState* take_ = nullptr;
  bool safe_ = true;
};

TEST_F(NestedTest, StartsItsMachineWhenItIsEnteredAndTicksItWhileItStays) {
  Make();
  Enter();
  EXPECT_EQ(machine_.Path(), "SHOW/CONFIRM");
  Run(2);
  EXPECT_THAT(
      log_, ElementsAre("IDLE enter", "IDLE exit", "CONFIRM enter", "CONFIRM run", "CONFIRM run"));
  EXPECT_EQ(inner_->time(), 2 * kStep);
  EXPECT_EQ(inner_->ticks(), 2U);
}

TEST_F(NestedTest, DecidesOfTheInnerMachineByItself) {
  Make();
  Enter();
  confirm_->Go("TAKE");
  Run();
  EXPECT_EQ(machine_.Path(), "SHOW/TAKE");
  EXPECT_EQ(machine_.history().size(), 2U);
  EXPECT_EQ(inner_->history().size(), 2U);
}

TEST_F(NestedTest, HasTheInnerMachineInItsChart) {
  Make();
  const Chart::Node& show = machine_.chart().states[1];
  ASSERT_EQ(show.inside.size(), 1U);
  EXPECT_EQ(show.inside[0], inner_->chart());
  EXPECT_EQ(show.inside[0].states[1].name, "TAKE");
}

TEST_F(NestedTest, LeavesTheInnerStateHoweverItIsLeft) {
  Make();
  const auto left = [&](const std::function<void()>& leave) {
    Enter();
    log_.clear();
    leave();
    EXPECT_FALSE(inner_->running());
    return log_.empty() ? "" : log_.front();
  };
  EXPECT_EQ(left([&] {
              show_->leaves = true;
              Run();
            }),
            "CONFIRM exit");
  EXPECT_EQ(left([&] { EXPECT_TRUE(machine_.Force("IDLE")); }), "CONFIRM exit");
  EXPECT_EQ(left([&] { EXPECT_TRUE(machine_.Reset()); }), "CONFIRM exit");
  EXPECT_EQ(left([&] {
              safe_ = false;
              Run();
              safe_ = true;
              EXPECT_TRUE(machine_.Reset());
            }),
            "CONFIRM exit");
  EXPECT_EQ(left([&] { EXPECT_TRUE(machine_.Stop()); }), "CONFIRM exit");
}

TEST_F(NestedTest, IsPausedWhileTheOuterStateIsLeftGradually) {
  Make();
  Enter();
  show_->gradually = 2 * kStep;
  show_->leaves = true;
  Run(2);
  EXPECT_EQ(machine_.mode(), Mode::kTransitioning);
  EXPECT_EQ(inner_->ticks(), 0U);
  Run();
  EXPECT_EQ(Current(), "IDLE");
}

TEST_F(NestedTest, LetsNoTimePassInsideWhileTheOuterMachineIsPaused) {
  Make();
  Enter();
  machine_.Pause();
  now_ += std::chrono::hours(1);
  Run(2);
  EXPECT_EQ(inner_->elapsed(), kStep);
}

TEST_F(NestedTest, DropsTheCommandsThatWaitInsideWhenTheOuterMachineIsPaused) {
  Make();
  Enter();
  const EventId yes = *inner_->FindEvent("yes");
  confirm_->check = [=](const Tick& tick) {
    return tick.command == yes ? Next::Stay().KeepCommand() : Next::Stay();
  };
  ASSERT_TRUE(machine_.Send("yes"));
  Run(2);
  ASSERT_EQ(inner_->waiting_commands(), 1U);
  machine_.Pause();
  EXPECT_EQ(inner_->waiting_commands(), 0U);
}

TEST_F(NestedTest, PassesTheCommandsThatItDoesNotHandleToTheInnerMachine) {
  Make();
  Enter();
  const EventId yes = *inner_->FindEvent("yes");
  const StateId take = *inner_->FindState("TAKE");
  confirm_->check = [=](const Tick& tick) {
    return tick.command == yes ? Next::To(take) : Next::Stay();
  };
  ASSERT_TRUE(machine_.Send("yes"));
  Run();
  EXPECT_EQ(machine_.Path(), "SHOW/TAKE");
  EXPECT_EQ(machine_.counts().unhandled, 0U);
  EXPECT_EQ(inner_->Name(inner_->history().back().command), "yes");
}

TEST_F(NestedTest, HandlesACommandBeforeTheInnerMachineDoes) {
  Make();
  Enter();
  ASSERT_TRUE(machine_.Send("stop"));
  Run();
  EXPECT_EQ(Current(), "IDLE");
  EXPECT_EQ(inner_->counts().unhandled, 0U);
}

TEST_F(NestedTest, CountsACommandAsUnhandledWhereItEndsUp) {
  Make();
  Enter();
  ASSERT_TRUE(machine_.Send("no"));
  Run();
  EXPECT_EQ(machine_.counts().unhandled, 1U);
  ASSERT_TRUE(machine_.Send("yes"));
  Run();
  EXPECT_EQ(machine_.counts().unhandled, 1U);
  EXPECT_EQ(inner_->counts().unhandled, 1U);
}

TEST_F(NestedTest, ContinuesOnceTheInnerMachineHasFinishedAndKeepsTheCommandOfThatTick) {
  Make({.finished = "IDLE"});
  Enter();
  confirm_->Go("TAKE");
  Run();
  take_->Go("DONE");
  Run();
  EXPECT_EQ(machine_.Path(), "SHOW/DONE");
  ASSERT_TRUE(machine_.Send("yes"));
  Run();
  EXPECT_EQ(Current(), "IDLE");
  EXPECT_EQ(machine_.history().back().command, kNoEvent);
  EXPECT_EQ(machine_.waiting_commands(), 1U);
}

TEST_F(NestedTest, StaysInItsFinalStateWithoutTheFinishedOption) {
  Make();
  Enter();
  ASSERT_TRUE(inner_->Force("DONE"));
  Run(3);
  EXPECT_EQ(machine_.Path(), "SHOW/DONE");
}

TEST_F(NestedTest, LeavesAFaultToTheInnerMachineThatCanHandleIt) {
  Make();
  confirm_->on["run"] = [](const Tick&) { throw std::runtime_error("no arm"); };
  Enter();
  Run();
  EXPECT_EQ(machine_.Path(), "SHOW/CALM");
  EXPECT_EQ(machine_.counts().faults, 0U);
}

TEST_F(NestedTest, FailsWithThePathWhenTheInnerMachineIsStoppedByAFault) {
  Make({}, false);
  confirm_->on["run"] = [](const Tick&) { throw std::runtime_error("no arm"); };
  Enter();
  Run();
  EXPECT_EQ(Current(), "SAFE");
  ASSERT_TRUE(machine_.fault());
  EXPECT_EQ(machine_.Describe(*machine_.fault()), "SHOW/CONFIRM: Run: no arm");
  EXPECT_EQ(machine_.Name(machine_.fault()->state), "SHOW");
}

TEST_F(NestedTest, FailsWhenTheInnerMachineCannotBeStarted) {
  Make({}, false);
  confirm_->on["enter"] = [](const Tick&) { throw std::runtime_error("no arm"); };
  Enter();
  EXPECT_EQ(Current(), "SAFE");
  EXPECT_EQ(machine_.Describe(*machine_.fault()), "SHOW/CONFIRM: OnEnter: no arm");
}

TEST_F(NestedTest, FailsWhenTheInnerStateCannotBeLeft) {
  Make();
  confirm_->on["exit"] = [](const Tick&) { throw std::runtime_error("no arm"); };
  Enter();
  show_->leaves = true;
  Run();
  EXPECT_EQ(Current(), "SAFE");
  EXPECT_EQ(machine_.Describe(*machine_.fault()), "SHOW/CONFIRM: OnExit: no arm");
  Enter();
  const Result<> forced = machine_.Force("SHOW");
  ASSERT_TRUE(forced) << forced.error().message;
  const Result<> stopped = machine_.Stop();
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().message, "show: SHOW/CONFIRM: OnExit: no arm");
}

TEST_F(NestedTest, StartsFromTheBeginningEachTimeUnlessItResumes) {
  Make();
  Enter();
  ASSERT_TRUE(inner_->Force("TAKE"));
  ASSERT_TRUE(machine_.Force("IDLE"));
  ASSERT_TRUE(machine_.Force("SHOW"));
  EXPECT_EQ(machine_.Path(), "SHOW/CONFIRM");
}

TEST_F(NestedTest, ResumesInTheStateInWhichItWasLeft) {
  Make({.resumes = true});
  Enter();
  ASSERT_TRUE(inner_->Force("TAKE"));
  ASSERT_TRUE(machine_.Force("IDLE"));
  log_.clear();
  ASSERT_TRUE(machine_.Force("SHOW"));
  EXPECT_EQ(machine_.Path(), "SHOW/TAKE");
  EXPECT_THAT(log_, ElementsAre("IDLE exit", "TAKE enter"));
}

TEST_F(NestedTest, DoesNotResumeInAFinalOrASafeState) {
  Make({.resumes = true});
  for (const char* state : {"DONE", "CALM"}) {
    ASSERT_TRUE(machine_.Force("SHOW"));
    ASSERT_TRUE(inner_->Force("TAKE"));
    ASSERT_TRUE(machine_.Force("SHOW"));
    EXPECT_EQ(machine_.Path(), "SHOW/TAKE");
    ASSERT_TRUE(inner_->Force(state));
    ASSERT_TRUE(machine_.Force("IDLE"));
    ASSERT_TRUE(machine_.Force("SHOW"));
    EXPECT_EQ(machine_.Path(), "SHOW/CONFIRM");
  }
}

std::unique_ptr<Machine> Of(const std::string& name, std::unique_ptr<State> state,
                            const std::string& state_name) {
  auto machine = std::make_unique<Machine>(Machine::Options{.name = name});
  machine->Add(state_name, std::move(state));
  return machine;
}

TEST(DeeplyNested, ReportsPathsAndFaultsThroughAllLevels) {
  Log log;
  auto deepest = std::make_unique<LoggingState>("C", log);
  LoggingState* const c = deepest.get();
  const auto machine =
      Of("outer",
         std::make_unique<Nested>(
             Of("middle", std::make_unique<Nested>(Of("inner", std::move(deepest), "C"), "C"), "B"),
             "B"),
         "A");
  ASSERT_TRUE(machine->Build("A"));
  ASSERT_TRUE(machine->Start(Time{}));
  EXPECT_EQ(machine->Path(), "A/B/C");
  machine->RunOnce(Time(kStep));
  EXPECT_THAT(log, ElementsAre("C enter", "C run"));
  c->on["run"] = [](const Tick&) { throw std::runtime_error("no arm"); };
  machine->RunOnce(Time(2 * kStep));
  EXPECT_FALSE(machine->running());
  EXPECT_EQ(machine->Describe(*machine->fault()), "A/B/C: Run: no arm");
}

TEST(NestedBuild, ReportsAllErrorsOfTheInnerMachine) {
  Log log;
  auto inner = std::make_unique<Machine>(Machine::Options{.name = "photo"});
  inner->Add("A", std::make_unique<LoggingState>("A", log, std::vector<std::string>{"B", "X"}));
  inner->Add("B", std::make_unique<LoggingState>("B", log, std::vector<std::string>{"Y"}));
  const auto machine = Of("show", std::make_unique<Nested>(std::move(inner), "A"), "SHOW");
  const Result<> built = machine->Build("SHOW");
  ASSERT_FALSE(built);
  EXPECT_EQ(built.error().message,
            "show: SHOW: photo: A: there is no state X; did you mean 'A'?\n"
            "show: SHOW: photo: B: there is no state Y; did you mean 'A'?");
}

TEST(NestedBuild, BuildsAnInnerMachineOnceHoweverOftenTheOuterOneIsBuilt) {
  Log log;
  auto inner = Of("photo", std::make_unique<LoggingState>("A", log), "A");
  const auto machine = Of("show", std::make_unique<Nested>(std::move(inner), "A"), "SHOW");
  EXPECT_FALSE(machine->Build("SHOWW"));
  EXPECT_TRUE(machine->Build("SHOW"));
}

TEST(NestedBuild, RefusesATransitionForAnEndThatTheInnerMachineDoesNotHave) {
  Log log;
  const auto machine =
      Of("show",
         std::make_unique<Nested>(Of("photo", std::make_unique<LoggingState>("A", log), "A"), "A",
                                  Nested::Options{.finished = "SHOW"}),
         "SHOW");
  const Result<> built = machine->Build("SHOW");
  ASSERT_FALSE(built);
  EXPECT_EQ(built.error().message, "show: SHOW: never goes to SHOW: photo has no final state");
}

TEST(NestedBuild, ReportsWarningsOfTheInnerMachineWithTheirPath) {
  Log log;
  auto inner = Of("photo", std::make_unique<LoggingState>("A", log), "A");
  inner->Add("B", std::make_unique<LoggingState>("B", log));
  const auto machine = Of("show", std::make_unique<Nested>(std::move(inner), "A"), "SHOW");
  ASSERT_TRUE(machine->Build("SHOW"));
  EXPECT_THAT(machine->warnings(),
              ElementsAre("SHOW/B: only Force() reaches it: no transition leads to it"));
}

}  // namespace musher::fsm::nested_test
