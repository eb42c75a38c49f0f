// Faults that were found in machines inside of states and fixed.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "musher/behavior/fsm/nested.hpp"
#include "musher/behavior/fsm/snapshot.hpp"
#include "musher/test/behavior/fsm/machine_fixture.hpp"

namespace musher::fsm::nested_found_test {

using ::testing::ElementsAre;

void NoArm(const Tick& /*tick*/) {
  throw std::runtime_error("no arm");
}

// IDLE, and SHOW with CONFIRM, TAKE and DONE inside, which has no safe state.
class NestedFound : public MachineFixture {
 protected:
  class Show : public Nested {
   public:
    Show(std::unique_ptr<Machine> inner, Options options, Log& log)
        : Nested(std::move(inner), "CONFIRM", std::move(options)), log_(log) {}
    void Declare(Transitions& transitions) override {
      Nested::Declare(transitions);
      transitions.To("IDLE", "commanded");
    }
    void OnEnter(const Tick& tick) override {
      Nested::OnEnter(tick);
      Do("enter");
    }
    void OnExit(const Tick& tick) override {
      Do("exit");
      Nested::OnExit(tick);
    }
    Next Decide(const Tick& /*tick*/) override { return decision; }

    Next decision = Next::Stay();
    std::string fails_to;  // once

   private:
    void Do(const std::string& what) {
      log_.push_back("SHOW " + what);
      if (fails_to != what) return;
      fails_to.clear();
      throw std::runtime_error("no light");
    }
    Log& log_;
  };

  void Make(Nested::Options options = {}) {
    auto inner = std::make_unique<Machine>(Machine::Options{.name = "photo"});
    inner_ = inner.get();
    confirm_ = &Add(*inner_, "CONFIRM", {"TAKE", "DONE"});
    take_ = &Add(*inner_, "TAKE", {"DONE", "CONFIRM"});
    Add(*inner_, "DONE", {}, Role::kFinal);
    inner_->AddEvent("yes");
    machine_.AddEvent("yes");
    idle_ = &Add("IDLE", {"SHOW"});
    auto show = std::make_unique<Show>(std::move(inner), std::move(options), log_);
    show_ = show.get();
    machine_.Add("SHOW", std::move(show));
    Add("SAFE", {"IDLE"}, Role::kSafe);
    Start("IDLE");
  }
  // To SHOW, with an empty log.
  void Enter() {
    idle_->Go("SHOW");
    Run();
    log_.clear();
  }

  Machine* inner_ = nullptr;
  LoggingState* idle_ = nullptr;
  Show* show_ = nullptr;
  LoggingState* confirm_ = nullptr;
  LoggingState* take_ = nullptr;
};

// The phase of the inner fault was used for the outer state, which then counted as left.
TEST_F(NestedFound, LeavesTheOuterStateWhenAnInnerOneCannotBeEntered) {
  Make();
  take_->on["enter"] = NoArm;
  Enter();
  confirm_->Go("TAKE");
  Run();
  EXPECT_THAT(log_, ElementsAre("CONFIRM exit", "TAKE enter", "SHOW exit", "SAFE enter"));
  EXPECT_EQ(machine_.Describe(*machine_.fault()), "SHOW/TAKE: OnEnter: no arm");
}

TEST_F(NestedFound, LeavesTheOuterStateWhenAnInnerOneCannotBeLeft) {
  Make();
  confirm_->on["exit"] = NoArm;
  Enter();
  confirm_->Go("TAKE");
  Run();
  EXPECT_THAT(log_, ElementsAre("CONFIRM exit", "SHOW exit", "SAFE enter"));
  EXPECT_EQ(machine_.Describe(*machine_.fault()), "SHOW/CONFIRM: OnExit: no arm");
}

// The machine inside ran on, and the next entry took "runs already" for a start.
TEST_F(NestedFound, StopsTheInnerMachineWhenTheOuterStateFailsToBeEntered) {
  Make();
  idle_->Go("SHOW");
  show_->fails_to = "enter";
  Run();
  EXPECT_THAT(log_, ElementsAre("IDLE enter", "IDLE exit", "CONFIRM enter", "SHOW enter",
                                "CONFIRM exit", "SAFE enter"));
  EXPECT_FALSE(inner_->running());
  Run(5);
  ASSERT_TRUE(machine_.Force("IDLE"));
  Enter();
  EXPECT_EQ(machine_.Path(), "SHOW/CONFIRM");
  EXPECT_EQ(inner_->ticks(), 0U);
}

TEST_F(NestedFound, StopsTheInnerMachineWhenTheOuterStateFailsToBeLeft) {
  Make();
  Enter();
  show_->fails_to = "exit";
  ASSERT_FALSE(machine_.Force("IDLE"));
  EXPECT_THAT(log_, ElementsAre("SHOW exit", "CONFIRM exit", "SAFE enter"));
  EXPECT_FALSE(inner_->running());
  ASSERT_TRUE(machine_.Force("SHOW"));
  show_->fails_to = "exit";
  ASSERT_FALSE(machine_.Stop());
  EXPECT_FALSE(inner_->running());
}

// It was queued inside, and the inner machine was stopped before it handled it.
TEST_F(NestedFound, LosesNoCommandThatComesInTheInnerMachinesLastTransition) {
  Make({.finished = "IDLE"});
  Enter();
  confirm_->Go("DONE", 3 * kStep);
  Run();
  ASSERT_TRUE(machine_.Send("yes"));
  Run();
  EXPECT_EQ(machine_.waiting_commands(), 1U);
  Run(5);
  EXPECT_EQ(Current(), "IDLE");
  EXPECT_EQ(machine_.counts().unhandled, 1U);
  EXPECT_EQ(inner_->waiting_commands(), 0U);
}

TEST_F(NestedFound, DoesNotKeepACommandThatItHandledAsTheInnerMachineHadFinished) {
  Make({.finished = "IDLE"});
  Enter();
  ASSERT_TRUE(inner_->Force("DONE"));
  show_->decision = Next::Handle();
  ASSERT_TRUE(machine_.Send("yes"));
  Run();
  EXPECT_EQ(Current(), "IDLE");
  EXPECT_EQ(machine_.waiting_commands(), 0U);
  EXPECT_EQ(machine_.counts().unhandled, 0U);
}

TEST_F(NestedFound, GivesTheInnerMachineNoCommandThatTheOuterStateKeeps) {
  Make();
  Enter();
  show_->decision = Next::Stay().KeepCommand();
  ASSERT_TRUE(machine_.Send("yes"));
  Run(3);
  EXPECT_EQ(machine_.waiting_commands(), 1U);
  EXPECT_EQ(inner_->counts().unhandled, 0U);
}

// They were restored, into a state that could never be left and a machine that ran undetected.
TEST_F(NestedFound, RefusesASnapshotThatRunsInsideOtherThanOutside) {
  Make();
  Enter();
  const Snapshot saved = machine_.Save().value();
  ASSERT_TRUE(machine_.Stop());
  const auto fault_of = [&](const Snapshot& snapshot) {
    const std::vector<SnapshotFault> faults = machine_.Restore(snapshot, now_);
    EXPECT_EQ(faults.size(), 1U);
    EXPECT_FALSE(machine_.running());
    return faults.empty() ? "" : faults[0].key + ": " + faults[0].what;
  };
  Snapshot rests = saved;
  rests.inside[0].machine.running = false;
  rests.inside[0].machine.state = "";
  EXPECT_EQ(fault_of(rests),
            "inside.SHOW.running: is false, though the state around it is the present one");
  Snapshot runs = saved;
  runs.state = "IDLE";
  EXPECT_EQ(fault_of(runs),
            "inside.SHOW.running: is true, though the state around it is not the present one");
  EXPECT_TRUE(machine_.Restore(saved, now_).empty());
}

}  // namespace musher::fsm::nested_found_test
