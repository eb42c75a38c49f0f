#include "musher/behavior/fsm/machine.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "musher/test/behavior/fsm/machine_fixture.hpp"

namespace musher::fsm::machine_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

using MachineTest = MachineFixture;

TEST_F(MachineTest, EntersItsStartStateAndRunsItEachTick) {
  Add("IDLE");
  Start("IDLE");
  Run(2);
  EXPECT_THAT(log_, ElementsAre("IDLE enter", "IDLE run", "IDLE run"));
  EXPECT_EQ(machine_.ticks(), 2U);
  EXPECT_EQ(machine_.mode(), Mode::kNormal);
}

TEST_F(MachineTest, DecidesAndCompletesAnImmediateTransitionInOneTick) {
  LoggingState& idle = Add("IDLE", {"TRACKING"});
  Add("TRACKING", {"IDLE"});
  Start("IDLE");
  idle.Go("TRACKING");
  Run();
  EXPECT_EQ(Current(), "TRACKING");
  EXPECT_THAT(log_, ElementsAre("IDLE enter", "IDLE exit", "TRACKING enter"));
  Run();
  EXPECT_EQ(log_.back(), "TRACKING run");
}

TEST_F(MachineTest, TakesTheTimeThatAGradualTransitionHas) {
  LoggingState& idle = Add("IDLE", {"TRACKING"});
  Add("TRACKING", {"IDLE"});
  Start("IDLE");
  idle.Go("TRACKING", 2 * kStep);
  Run();
  EXPECT_EQ(machine_.mode(), Mode::kTransitioning);
  EXPECT_EQ(Current(), "IDLE");
  Run(2);
  EXPECT_EQ(machine_.mode(), Mode::kNormal);
  EXPECT_THAT(log_, ElementsAre("IDLE enter", "IDLE transition", "IDLE transition", "IDLE exit",
                                "TRACKING enter"));
}

TEST_F(MachineTest, CountsElapsedTimeFromTheFirstStateOnWhateverTheClockShows) {
  LoggingState& idle = Add("IDLE");
  Duration elapsed{-1};
  idle.on["run"] = [&](const Tick& tick) { elapsed = tick.elapsed; };
  Start("IDLE");
  Run(3);
  EXPECT_EQ(elapsed, 3 * kStep);
}

TEST_F(MachineTest, LetsNoTimePassWhileItIsPausedOrTimeGoesBack) {
  Add("IDLE");
  Start("IDLE");
  Run();
  now_ += std::chrono::hours(1);
  machine_.Pause();
  Run();
  now_ -= std::chrono::hours(2);
  Run();
  EXPECT_EQ(machine_.elapsed(), kStep);
}

TEST_F(MachineTest, KeepsACommandThatArrivesDuringATransitionForTheNextState) {
  machine_.AddEvent("photo");
  LoggingState& idle = Add("IDLE", {"TRACKING"});
  LoggingState& tracking = Add("TRACKING", {"PHOTO"});
  Add("PHOTO", {"IDLE"});
  Start("IDLE");
  const EventId photo = *machine_.FindEvent("photo");
  const StateId to = *machine_.FindState("PHOTO");
  tracking.check = [=](const Tick& tick) {
    return tick.command == photo ? Next::To(to) : Next::Stay();
  };
  idle.Go("TRACKING", 2 * kStep);
  Run();
  ASSERT_TRUE(machine_.Send(photo));
  Run(3);
  EXPECT_EQ(Current(), "PHOTO");
  EXPECT_EQ(machine_.history().back().command, photo);
}

// A command that was queued just before a pause, as by an emergency stop, was handled after it,
// hours later: it began to move by itself.
TEST_F(MachineTest, DropsQueuedCommandsWhenItIsPausedButNoUrgentOne) {
  machine_.AddEvent("go");
  machine_.AddEvent("stop", Urgency::kUrgent);
  std::vector<std::string> got;
  Add("IDLE").check = [&](const Tick& tick) {
    if (tick.command == kNoEvent) return Next::Stay();
    got.emplace_back(machine_.Name(tick.command));
    return Next::Handle();
  };
  Start("IDLE");
  EXPECT_TRUE(machine_.IsUrgent("stop"));
  EXPECT_FALSE(machine_.IsUrgent("go"));
  EXPECT_FALSE(machine_.IsUrgent("none"));
  ASSERT_TRUE(machine_.Send("go"));
  machine_.Pause();
  EXPECT_EQ(machine_.waiting_commands(), 0U);
  EXPECT_EQ(machine_.counts().superseded, 1U);
  for (const char* command : {"stop", "go"}) ASSERT_TRUE(machine_.Send(command));
  machine_.Pause();
  Run(3);
  EXPECT_THAT(got, ElementsAre("stop"));
  ASSERT_TRUE(machine_.Send("go"));
  Run();
  EXPECT_THAT(got, ElementsAre("stop", "go"));
}

TEST_F(MachineTest, DropsADeferredCommandWhenItIsPaused) {
  machine_.AddEvent("go");
  LoggingState& idle = Add("IDLE", {"TRACKING"});
  idle.declare = [](Transitions& transitions) { transitions.Defer("go"); };
  std::string got;
  Add("TRACKING", {"IDLE"}).check = [&](const Tick& tick) {
    got += machine_.Name(tick.command);
    return Next::Stay();
  };
  Start("IDLE");
  ASSERT_TRUE(machine_.Send("go"));
  Run(2);
  machine_.Pause();
  idle.Go("TRACKING");
  Run(3);
  EXPECT_EQ(Current(), "TRACKING");
  EXPECT_EQ(got, "");
}

TEST_F(MachineTest, CountsACommandThatNoStateHandled) {
  machine_.AddEvent("photo");
  Add("IDLE");
  Start("IDLE");
  ASSERT_TRUE(machine_.Send("photo"));
  Run();
  EXPECT_EQ(machine_.counts().unhandled, 1U);
  EXPECT_EQ(machine_.waiting_commands(), 0U);
}

TEST_F(MachineTest, RefusesCommandsWhenTheQueueIsFullButNeverAnUrgentOne) {
  machine_.AddEvent("photo");
  machine_.AddEvent("stop", Urgency::kUrgent);
  Add("IDLE");
  Start("IDLE");
  int refused = 0;
  for (int i = 0; i < 10'000; ++i) refused += machine_.Send("photo") ? 0 : 1;
  EXPECT_EQ(refused, 10'000 - 32);
  EXPECT_EQ(machine_.counts().refused, static_cast<std::uint64_t>(refused));
  EXPECT_TRUE(machine_.Send("stop"));
  EXPECT_EQ(machine_.waiting_commands(), 1U);
  EXPECT_EQ(machine_.counts().superseded, 32U);
}

TEST_F(MachineTest, GoesToItsSafeStateInTheTickInWhichSomethingIsUnsafe) {
  bool close = false;
  Add("IDLE");
  Add("SAFE_STOP", {"IDLE"}, Role::kSafe);
  machine_.AddSafetyCheck("distance", [&](const Tick&) { return !close; });
  Start("IDLE");
  close = true;
  Run();
  EXPECT_EQ(Current(), "SAFE_STOP");
  EXPECT_EQ(machine_.mode(), Mode::kSafeStop);
  EXPECT_EQ(machine_.unsafe(), "distance");
  EXPECT_THAT(log_, ElementsAre("IDLE enter", "IDLE exit", "SAFE_STOP enter"));
}

TEST_F(MachineTest, RunsItsSafeStateAndLeavesItOnlyWhenAllIsSafeAgain) {
  bool close = false;
  Add("IDLE");
  LoggingState& safe = Add("SAFE_STOP", {"IDLE"}, Role::kSafe);
  machine_.AddSafetyCheck("distance", [&](const Tick&) { return !close; });
  Start("IDLE");
  const StateId idle = *machine_.FindState("IDLE");
  safe.check = [=](const Tick&) { return Next::To(idle); };
  close = true;
  Run(3);
  EXPECT_EQ(Current(), "SAFE_STOP");
  EXPECT_EQ(log_.back(), "SAFE_STOP run");
  close = false;
  Run();
  EXPECT_EQ(Current(), "IDLE");
  EXPECT_EQ(machine_.mode(), Mode::kNormal);
  EXPECT_EQ(machine_.unsafe(), "");
}

TEST_F(MachineTest, GoesToItsSafeStateWhenAStateThrowsAndNamesStateAndFunction) {
  LoggingState& idle = Add("IDLE");
  Add("SAFE_STOP", {"IDLE"}, Role::kSafe);
  idle.on["run"] = [](const Tick&) { throw std::runtime_error("no arm"); };
  Start("IDLE");
  Run();
  EXPECT_EQ(Current(), "SAFE_STOP");
  ASSERT_TRUE(machine_.fault());
  EXPECT_EQ(machine_.Describe(*machine_.fault()), "IDLE: Run: no arm");
  EXPECT_THAT(log_, ElementsAre("IDLE enter", "IDLE run", "IDLE exit", "SAFE_STOP enter"));
}

TEST_F(MachineTest, StopsWhenItsSafeStateFailsToo) {
  LoggingState& idle = Add("IDLE");
  LoggingState& safe = Add("SAFE_STOP", {}, Role::kSafe);
  idle.on["run"] = [](const Tick&) { throw std::runtime_error("no arm"); };
  safe.on["enter"] = [](const Tick&) { throw std::runtime_error("no brake"); };
  Start("IDLE");
  Run(2);
  EXPECT_FALSE(machine_.running());
  EXPECT_EQ(machine_.Describe(*machine_.fault()), "SAFE_STOP: OnEnter: no brake");
}

TEST_F(MachineTest, TakesAnUndeclaredTransitionForAFault) {
  LoggingState& idle = Add("IDLE");
  Add("TRACKING", {"IDLE"});
  Add("SAFE_STOP", {}, Role::kSafe);
  Start("IDLE");
  const StateId tracking = *machine_.FindState("TRACKING");
  idle.check = [=](const Tick&) { return Next::To(tracking); };
  Run();
  EXPECT_EQ(Current(), "SAFE_STOP");
  EXPECT_THAT(machine_.fault()->what, HasSubstr("TRACKING, which it has not declared"));
}

TEST_F(MachineTest, AbortsATransitionThatDoesNotEnd) {
  LoggingState& idle = Add("IDLE", {"TRACKING"});
  Add("TRACKING", {"IDLE"});
  Add("SAFE_STOP", {}, Role::kSafe);
  Start("IDLE");
  idle.Go("TRACKING", std::chrono::hours(1));
  Run(static_cast<int>(std::chrono::seconds(10) / kStep) + 2);
  EXPECT_EQ(Current(), "SAFE_STOP");
}

class Watcher : public Listener {
 public:
  void OnChange(const Machine& machine, const Change& change) override {
    seen.push_back(std::string(machine.Name(change.from)) + "->" +
                   std::string(machine.Name(change.to)) + " " + std::string(Name(change.cause)));
    if (fails) throw std::runtime_error("listener");
  }
  std::vector<std::string> seen;
  bool fails = false;
};

TEST_F(MachineTest, NotifiesItsListenersOfAForcedTransitionToo) {
  Add("IDLE");
  Add("PHOTO");
  Watcher watcher;
  machine_.Listen(&watcher);
  Start("IDLE");
  ASSERT_TRUE(machine_.Force("PHOTO"));
  ASSERT_TRUE(machine_.Reset());
  EXPECT_THAT(watcher.seen,
              ElementsAre("->IDLE started", "IDLE->PHOTO forced", "PHOTO->IDLE reset"));
}

TEST_F(MachineTest, IsNotBrokenByAListenerThatThrows) {
  Add("IDLE");
  Add("PHOTO");
  Watcher bad;
  Watcher good;
  bad.fails = true;
  machine_.Listen(&bad);
  machine_.Listen(&good);
  Start("IDLE");
  ASSERT_TRUE(machine_.Force("PHOTO"));
  EXPECT_EQ(Current(), "PHOTO");
  EXPECT_EQ(good.seen.size(), 2U);
  EXPECT_EQ(machine_.counts().listener_faults, 2U);
}

TEST_F(MachineTest, CannotBeForcedOrStoppedFromInsideOfATick) {
  LoggingState& idle = Add("IDLE");
  Add("PHOTO");
  idle.on["run"] = [&](const Tick&) {
    EXPECT_FALSE(machine_.Force("PHOTO"));
    EXPECT_FALSE(machine_.Stop());
    EXPECT_FALSE(machine_.Reset());
  };
  Start("IDLE");
  Run();
  EXPECT_EQ(log_.back(), "IDLE run");
  EXPECT_EQ(Current(), "IDLE");
}

TEST_F(MachineTest, RefusesItsOwnTickInsideOfATickAlsoAfterOthersInWhichItOnlyStayed) {
  LoggingState& idle = Add("IDLE");
  Start("IDLE");
  Run(3);
  idle.on["run"] = [&](const Tick&) { EXPECT_THROW(machine_.RunOnce(now_), std::logic_error); };
  Run(2);
  EXPECT_EQ(machine_.ticks(), 5U);
  EXPECT_EQ(Current(), "IDLE");
}

// Sends a command at the beginning of a tick.
class Sender : public InputListener {
 public:
  explicit Sender(Machine& machine) : machine_(machine) {}
  void OnInput(const Machine&, const Input& input) override {
    if (input.kind != Input::Kind::kTick) return;
    EXPECT_TRUE(machine_.Send("photo"));
  }

 private:
  Machine& machine_;
};

TEST_F(MachineTest, HandlesACommandThatAListenerSendsAtTheBeginningOfATickInThatTick) {
  machine_.AddEvent("photo");
  LoggingState& idle = Add("IDLE", {"PHOTO"});
  Add("PHOTO", {"IDLE"});
  Start("IDLE");
  const EventId photo = *machine_.FindEvent("photo");
  const StateId to = *machine_.FindState("PHOTO");
  idle.check = [=](const Tick& tick) {
    return tick.command == photo ? Next::To(to) : Next::Stay();
  };
  Run(3);
  Sender sender(machine_);
  machine_.ListenToInputs(&sender);
  Run();
  machine_.ForgetInputs(&sender);
  EXPECT_EQ(Current(), "PHOTO");
  EXPECT_EQ(machine_.waiting_commands(), 0U);
}

TEST_F(MachineTest, RefusesAForceToAnUnknownStateAndKeepsItsState) {
  Add("IDLE");
  Start("IDLE");
  const Result<> forced = machine_.Force("IDEL");
  ASSERT_FALSE(forced);
  EXPECT_EQ(forced.error().message, "show: there is no state IDEL; did you mean 'IDLE'?");
  EXPECT_EQ(Current(), "IDLE");
}

TEST_F(MachineTest, LeavesItsStateWhenItIsStoppedAndCanBeStartedAgain) {
  Add("IDLE");
  Start("IDLE");
  ASSERT_TRUE(machine_.Stop());
  EXPECT_EQ(log_.back(), "IDLE exit");
  EXPECT_EQ(machine_.current(), kNoState);
  Run();
  EXPECT_EQ(log_.back(), "IDLE exit");
  ASSERT_TRUE(machine_.Start(now_));
  EXPECT_EQ(log_.back(), "IDLE enter");
}

TEST_F(MachineTest, IsNotBuiltWithErrorsAndReportsAllOfThem) {
  Add("IDLE", {"TRAKCING"});
  Add("IDLE");
  Add("TRACKING", {"IDLE"});
  machine_.AddSafetyCheck("distance", [](const Tick&) { return true; });
  const Result<> built = machine_.Build("IDLLE");
  ASSERT_FALSE(built);
  EXPECT_EQ(built.error().message,
            "show: IDLE: registered twice\n"
            "show: IDLE: there is no state TRAKCING; did you mean 'TRACKING'?\n"
            "show: the start state: there is no state IDLLE; did you mean 'IDLE'?\n"
            "show: the safety check distance has no safe state to go to");
  EXPECT_FALSE(machine_.Start(now_));
}

TEST_F(MachineTest, IsBuiltOnceTheStatesThatWereMissingAreAdded) {
  Add("IDLE", {"TRACKING", "PHOTO"});
  EXPECT_FALSE(machine_.Build("IDLE"));
  Add("TRACKING", {"IDLE"});
  const Result<> still = machine_.Build("IDLE");
  ASSERT_FALSE(still);
  EXPECT_EQ(still.error().message, "show: IDLE: there is no state PHOTO");
  Add("PHOTO", {"IDLE"});
  Start("IDLE");
  EXPECT_EQ(Current(), "IDLE");
  EXPECT_EQ(machine_.chart().transitions.size(), 4U);
}

TEST_F(MachineTest, IsNeverBuiltWithAStateThatIsRegisteredTwice) {
  Add("IDLE");
  Add("IDLE");
  for (int i = 0; i < 2; ++i) {
    const Result<> built = machine_.Build("IDLE");
    ASSERT_FALSE(built);
    EXPECT_EQ(built.error().message, "show: IDLE: registered twice");
  }
}

TEST(Machine, WithoutStatesIsNotBuilt) {
  Machine machine;
  EXPECT_FALSE(machine.Build("IDLE"));
}

TEST_F(MachineTest, KeepsAHistoryOfItsLastChanges) {
  LoggingState& a = Add("A", {"B"});
  LoggingState& b = Add("B", {"A"});
  Start("A");
  for (int i = 0; i < 50; ++i) {
    a.Go("B");
    Run();
    b.Go("A");
    Run();
  }
  EXPECT_EQ(machine_.counts().changes, 101U);
  ASSERT_EQ(machine_.history().size(), 64U);
  EXPECT_EQ(machine_.history().back().tick, 100U);
  EXPECT_EQ(machine_.history()[0].tick, 37U);
}

}  // namespace musher::fsm::machine_test
