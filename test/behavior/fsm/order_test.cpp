// The order in which states are entered, run and left: the exact log of each case.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "musher/test/behavior/fsm/machine_fixture.hpp"

namespace musher::fsm::order_test {

using ::testing::ElementsAre;
using ::testing::ElementsAreArray;
using ::testing::IsEmpty;

struct Failure {
  const char* in;                // the function of A that fails; A goes to B gradually
  std::vector<std::string> log;  // from the start, where there is a safe state
  const char* message;
};

void PrintTo(const Failure& failure, std::ostream* out) {
  *out << failure.in;
}

class FailureTest : public MachineFixture, public ::testing::WithParamInterface<Failure> {
 protected:
  // Four ticks of A, going to B from the second to the fourth; A fails where it has to.
  void Play(bool with_safe_state, bool safe_state_fails = false) {
    LoggingState& a = Add("A", {"B"});
    Add("B", {"A"});
    if (with_safe_state) {
      LoggingState& safe = Add("SAFE", {"A"}, Role::kSafe);
      if (safe_state_fails) safe.on["enter"] = [](const Tick&) { throw std::runtime_error("two"); };
    }
    const auto fail = [](const Tick&) { throw std::runtime_error("one"); };
    if (std::string(GetParam().in) == "check") {
      a.check = [](const Tick&) -> Next { throw std::runtime_error("one"); };
    } else {
      a.on[GetParam().in] = fail;
    }
    const Result<> built = machine_.Build("A");
    ASSERT_TRUE(built) << built.error().message;
    (void)machine_.Start(now_).ok();
    Run();
    a.Go("B", kStep);
    Run(2);
  }
};

TEST_P(FailureTest, LeadsToTheSafeState) {
  Play(true);
  EXPECT_THAT(std::vector<std::string>(log_.begin(), log_.begin() + GetParam().log.size()),
              ElementsAreArray(GetParam().log));
  EXPECT_EQ(Current(), "SAFE");
  EXPECT_EQ(machine_.mode(), Mode::kSafeStop);
  EXPECT_EQ(machine_.Describe(*machine_.fault()), GetParam().message);
  EXPECT_EQ(machine_.counts().faults, 1U);
  EXPECT_EQ(machine_.history().back().cause, Cause::kFault);
}

TEST_P(FailureTest, StopsTheMachineWhereThereIsNoSafeState) {
  Play(false);
  EXPECT_FALSE(machine_.running());
  EXPECT_EQ(machine_.current(), kNoState);
  EXPECT_EQ(machine_.mode(), Mode::kSafeStop);
  EXPECT_EQ(machine_.Describe(*machine_.fault()), GetParam().message);
  EXPECT_EQ(machine_.Name(machine_.history().back().to), "");
  const std::size_t calls = log_.size();
  Run();
  EXPECT_EQ(log_.size(), calls);
}

TEST_P(FailureTest, StopsTheMachineWhenTheSafeStateFailsToo) {
  Play(true, true);
  EXPECT_FALSE(machine_.running());
  EXPECT_EQ(machine_.Describe(*machine_.fault()), "SAFE: OnEnter: two");
  EXPECT_EQ(machine_.counts().faults, 2U);
  EXPECT_EQ(log_.back(), "SAFE enter");
}

// OnExit is not called after a failed OnEnter, nor again after a failed OnExit.
INSTANTIATE_TEST_SUITE_P(
    In, FailureTest,
    ::testing::Values(
        Failure{"enter", {"A enter", "SAFE enter", "SAFE run"}, "A: OnEnter: one"},
        Failure{"run", {"A enter", "A run", "A exit", "SAFE enter", "SAFE run"}, "A: Run: one"},
        Failure{
            "check", {"A enter", "A exit", "SAFE enter", "SAFE run"}, "A: CheckTransition: one"},
        Failure{"transition",
                {"A enter", "A run", "A transition", "A exit", "SAFE enter", "SAFE run"},
                "A: Transition: one"},
        Failure{"exit",
                {"A enter", "A run", "A transition", "A exit", "SAFE enter"},
                "A: OnExit: one"}),
    ::testing::PrintToStringParamName());

class OrderTest : public MachineFixture {
 protected:
  // A and B lead to each other; SAFE leads to A.
  void Make() {
    a_ = &Add("A", {"A", "B"});
    b_ = &Add("B", {"A"});
    safe_state_ = &Add("SAFE", {"A", "SAFE"}, Role::kSafe);
    stop_ = machine_.AddEvent("stop", Urgency::kUrgent);
    machine_.AddEvent("photo");
    machine_.AddSafetyCheck("distance", [this](const Tick&) { return safe_; });
    Start("A");
    log_.clear();
  }
  LoggingState* a_ = nullptr;
  LoggingState* b_ = nullptr;
  LoggingState* safe_state_ = nullptr;
  EventId stop_ = kNoEvent;
  bool safe_ = true;
};

TEST_F(OrderTest, AForceAbortsATransition) {
  Make();
  a_->Go("B", 10 * kStep);
  Run();
  ASSERT_TRUE(machine_.Force("A"));
  EXPECT_THAT(log_, ElementsAre("A transition", "A exit", "A enter"));
  EXPECT_EQ(machine_.mode(), Mode::kNormal);
  Run();
  EXPECT_EQ(log_.back(), "A run");
}

TEST_F(OrderTest, AFailedSafetyCheckAbortsATransition) {
  Make();
  a_->Go("B", 10 * kStep);
  Run();
  safe_ = false;
  Run();
  EXPECT_THAT(log_, ElementsAre("A transition", "A exit", "SAFE enter"));
  EXPECT_EQ(machine_.history().back().cause, Cause::kUnsafe);
}

TEST_F(OrderTest, ASafetyCheckThatFailsInATickLeadsToTheSafeStateInTheSameTick) {
  Make();
  a_->on["run"] = [this](const Tick&) { safe_ = false; };
  Run();
  EXPECT_THAT(log_, ElementsAre("A run", "A exit", "SAFE enter"));
}

TEST_F(OrderTest, AnUnsafeStateThatWasJustEnteredIsLeftInTheSameTick) {
  Make();
  b_->on["enter"] = [this](const Tick&) { safe_ = false; };
  a_->Go("B");
  Run();
  EXPECT_THAT(log_, ElementsAre("A exit", "B enter", "B exit", "SAFE enter"));
}

TEST_F(OrderTest, AResetEndsASafeStopAndTheNextTickChecksAgain) {
  Make();
  safe_ = false;
  Run(2);
  ASSERT_TRUE(machine_.Reset());
  EXPECT_EQ(machine_.unsafe(), "");
  Run();
  EXPECT_THAT(log_, ElementsAre("A exit", "SAFE enter", "SAFE run", "SAFE exit", "A enter",
                                "A exit", "SAFE enter"));
}

TEST_F(OrderTest, AResetClearsCommandsAndTheFault) {
  Make();
  a_->on["run"] = [](const Tick&) { throw std::runtime_error("one"); };
  Run();
  ASSERT_TRUE(machine_.Send("photo"));
  ASSERT_TRUE(machine_.fault());
  ASSERT_TRUE(machine_.Reset());
  EXPECT_FALSE(machine_.fault());
  EXPECT_EQ(machine_.waiting_commands(), 0U);
}

TEST_F(OrderTest, ATransitionOutOfTheSafeStateIsAbortedWhenASafetyCheckFailsAgain) {
  Make();
  ASSERT_TRUE(machine_.Force("SAFE"));
  safe_state_->Go("A", 10 * kStep);
  Run();
  EXPECT_EQ(machine_.mode(), Mode::kTransitioning);
  safe_ = false;
  log_.clear();
  Run(2);
  EXPECT_THAT(log_, ElementsAre("SAFE exit", "SAFE enter", "SAFE run"));
  EXPECT_EQ(machine_.unsafe(), "distance");
}

TEST_F(OrderTest, AnUrgentCommandWaitsForTheEndOfATransitionAloneAndFirst) {
  Make();
  a_->Go("B", 2 * kStep);
  Run();
  ASSERT_TRUE(machine_.Send("photo"));
  ASSERT_TRUE(machine_.Send("stop"));
  EXPECT_EQ(machine_.waiting_commands(), 1U);
  EventId seen = kNoEvent;
  b_->check = [&](const Tick& tick) {
    seen = tick.command;
    return Next::Handle();
  };
  Run(3);
  EXPECT_EQ(seen, stop_);
  EXPECT_THAT(log_, ElementsAre("A transition", "A transition", "A exit", "B enter", "B run"));
}

TEST_F(OrderTest, ATransitionToItselfLeavesAndReenters) {
  Make();
  Run(2);
  a_->Go("A");
  Run();
  EXPECT_THAT(log_, ElementsAre("A run", "A run", "A exit", "A enter"));
  EXPECT_EQ(machine_.elapsed(), Duration{});
}

TEST_F(OrderTest, AGradualTransitionGivesStatesItsTargetAndProgress) {
  Make();
  std::vector<double> progress;
  a_->on["transition"] = [&](const Tick& tick) {
    EXPECT_EQ(tick.target, *machine_.FindState("B"));
    progress.push_back(tick.progress());
  };
  a_->on["exit"] = a_->on["transition"];
  a_->Go("B", 4 * kStep);
  Run(5);
  EXPECT_THAT(progress, ElementsAre(0, 0.25, 0.5, 0.75, 1));
  EXPECT_EQ(Current(), "B");
}

TEST_F(OrderTest, ATransitionIsOverInOneTickThatIsAnHourLong) {
  Make();
  a_->Go("B", std::chrono::seconds(5));
  Run();
  now_ += std::chrono::hours(1);
  Run();
  EXPECT_EQ(Current(), "B");
  EXPECT_EQ(machine_.elapsed(), Duration{});
  EXPECT_FALSE(machine_.fault());
}

TEST_F(OrderTest, ATransitionDoesNotGoBackWithTheClock) {
  Make();
  a_->Go("B", 2 * kStep);
  Run(2);
  now_ -= std::chrono::hours(2);
  Run();
  EXPECT_EQ(machine_.mode(), Mode::kTransitioning);
  Run();
  EXPECT_EQ(Current(), "B");
}

TEST_F(OrderTest, ATransitionMayTakeAsLongAsTheLongestOne) {
  Make();
  const Duration longest = Machine::Options().longest_transition;
  a_->Go("B", longest + kStep);
  Run(static_cast<int>(longest / kStep) + 2);
  EXPECT_EQ(Current(), "B");
  EXPECT_FALSE(machine_.fault());
}

TEST_F(OrderTest, AForcedStateThatFailsIsReportedToTheCallerOfForce) {
  Make();
  b_->on["enter"] = [](const Tick&) { throw std::runtime_error("one"); };
  const Result<> forced = machine_.Force("B");
  ASSERT_FALSE(forced);
  EXPECT_EQ(forced.error().message, "show: B: OnEnter: one");
  EXPECT_THAT(log_, ElementsAre("A exit", "B enter", "SAFE enter"));
}

TEST_F(OrderTest, AFailureWhileAFailedStateIsLeftIsCountedAndTheFirstIsReported) {
  Make();
  a_->on["run"] = [](const Tick&) { throw std::runtime_error("one"); };
  a_->on["exit"] = [](const Tick&) { throw 2; };
  Run();
  EXPECT_EQ(machine_.Describe(*machine_.fault()), "A: Run: one");
  EXPECT_EQ(machine_.counts().faults, 2U);
  EXPECT_EQ(Current(), "SAFE");
}

TEST_F(OrderTest, AThrownObjectThatIsNotAStdExceptionIsAFaultToo) {
  Make();
  a_->on["run"] = [](const Tick&) { throw 1; };
  Run();
  EXPECT_EQ(machine_.Describe(*machine_.fault()),
            "A: Run: threw something that is not a std::exception");
}

TEST_F(OrderTest, AnUnknownTargetIsAFault) {
  Make();
  a_->check = [](const Tick&) { return Next::To(StateId{99}); };
  Run();
  EXPECT_EQ(machine_.Describe(*machine_.fault()),
            "A: CheckTransition: it went to an unknown state, which it has not declared");
}

TEST_F(OrderTest, AListenerMaySendACommandAndTheNewStateSeesItInTheNextTick) {
  class Sender : public Listener {
   public:
    explicit Sender(Machine& machine) : machine_(machine) {}
    void OnChange(const Machine&, const Change&) override { (void)machine_.Send("photo").ok(); }

   private:
    Machine& machine_;
  } sender(machine_);
  Make();
  machine_.Listen(&sender);
  EventId seen = kNoEvent;
  b_->check = [&](const Tick& tick) {
    seen = tick.command;
    return Next::Handle();
  };
  a_->Go("B");
  Run();
  EXPECT_EQ(seen, kNoEvent);
  Run();
  EXPECT_EQ(machine_.Name(seen), "photo");
  machine_.Forget(&sender);
}

// More states than fit into one word of the table of transitions.
TEST_F(MachineFixture, DistinguishesManyStates) {
  constexpr int kStates = 130;
  std::vector<LoggingState*> states;
  for (int i = 0; i < kStates; ++i) {
    states.push_back(&Add("S" + std::to_string(i), {"S" + std::to_string((i + 1) % kStates)}));
  }
  Add("SAFE", {"S0"}, Role::kSafe);
  Start("S0");
  for (int i = 0; i < kStates; ++i) {
    states[static_cast<std::size_t>(i)]->Go("S" + std::to_string((i + 1) % kStates));
    Run();
    ASSERT_EQ(Current(), "S" + std::to_string((i + 1) % kStates));
  }
  for (const int wrong : {2, 63, 64, 65, 66, 129}) {
    ASSERT_TRUE(machine_.Force("S0"));
    states[0]->check = [=](const Tick&) { return Next::To(static_cast<StateId>(wrong)); };
    Run();
    EXPECT_EQ(Current(), "SAFE") << wrong;
  }
}

}  // namespace musher::fsm::order_test
