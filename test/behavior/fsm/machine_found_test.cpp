// Faults that were found in the machine and fixed.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "musher/test/behavior/fsm/machine_fixture.hpp"

namespace musher::fsm::machine_found_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

class Counting : public Listener {
 public:
  void OnChange(const Machine& machine, const Change& change) override {
    seen.emplace_back(Name(change.cause));
    if (during) during(machine);
  }
  void OnFault(const Machine& machine, const Fault& fault) override {
    faults.push_back(machine.Describe(fault));
  }
  void OnUnhandled(const Machine& machine, EventId command, StateId state) override {
    unhandled.push_back(std::string(machine.Name(command)) + " in " +
                        std::string(machine.Name(state)));
  }
  std::vector<std::string> seen;
  std::vector<std::string> unhandled;
  std::vector<std::string> faults;
  std::function<void(const Machine&)> during;
};

using MachineFound = MachineFixture;

TEST_F(MachineFound, NotifiesItsStopOnce) {
  Add("IDLE");
  Counting listener;
  machine_.Listen(&listener);
  Start("IDLE");
  ASSERT_TRUE(machine_.Stop());
  EXPECT_THAT(listener.seen, ElementsAre("started", "stopped"));
}

TEST_F(MachineFound, ReportsAStateThatFailsDuringAStop) {
  LoggingState& idle = Add("IDLE");
  idle.on["exit"] = [](const Tick&) { throw std::runtime_error("no brake"); };
  Counting listener;
  machine_.Listen(&listener);
  Start("IDLE");
  const Result<> stopped = machine_.Stop();
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().message, "show: IDLE: OnExit: no brake");
  EXPECT_THAT(listener.faults, ElementsAre("IDLE: OnExit: no brake"));
  EXPECT_FALSE(machine_.running());
}

// It stopped in the second tick, with no state left to hold the robot still.
TEST_F(MachineFound, StaysInItsSafeStateWhileACheckThrows) {
  bool broken = true;
  Add("IDLE");
  LoggingState& safe = Add("SAFE_STOP", {"IDLE"}, Role::kSafe);
  machine_.AddSafetyCheck("distance", [&](const Tick&) {
    if (broken) throw std::runtime_error("no sensor");
    return true;
  });
  Counting listener;
  machine_.Listen(&listener);
  Start("IDLE");
  safe.check = [&](const Tick&) { return Next::To(*machine_.FindState("IDLE")); };
  Run(5);
  EXPECT_EQ(Current(), "SAFE_STOP");
  EXPECT_EQ(machine_.unsafe(), "distance");
  EXPECT_THAT(listener.faults, ElementsAre("IDLE: safety check: distance: no sensor"));
  EXPECT_THAT(listener.seen, ElementsAre("started", "fault"));
  broken = false;
  Run();
  EXPECT_EQ(Current(), "IDLE");
}

TEST_F(MachineFound, LetsAListenerRemoveItselfDuringANotification) {
  Add("IDLE");
  Add("PHOTO");
  Counting once;
  Counting other;
  Counting third;
  for (Counting* listener : {&once, &other, &third}) machine_.Listen(listener);
  once.during = [&](const Machine&) { machine_.Forget(&once); };
  Start("IDLE");
  ASSERT_TRUE(machine_.Force("PHOTO"));
  EXPECT_THAT(once.seen, ElementsAre("started"));
  EXPECT_THAT(other.seen, ElementsAre("started", "forced"));
  EXPECT_THAT(third.seen, ElementsAre("started", "forced"));
}

TEST_F(MachineFound, LetsAListenerAddAnotherDuringANotification) {
  Add("IDLE");
  Add("PHOTO");
  Counting first;
  std::vector<Counting> others(50);
  machine_.Listen(&first);
  first.during = [&](const Machine&) {
    if (first.seen.size() > 1) return;
    for (Counting& other : others) machine_.Listen(&other);
  };
  Start("IDLE");
  ASSERT_TRUE(machine_.Force("PHOTO"));
  EXPECT_THAT(others.back().seen, ElementsAre("forced"));
}

TEST_F(MachineFound, RefusesACommandThatItsStartWouldDrop) {
  machine_.AddEvent("photo");
  Add("IDLE");
  ASSERT_TRUE(machine_.Build("IDLE"));
  const Result<> sent = machine_.Send("photo");
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().message, "show: does not run");
}

TEST_F(MachineFound, RefusesNamesThatAPathOrALineCannotHold) {
  machine_.AddEvent("pho\nto");
  machine_.AddEvent("");
  Add("A/B");
  Add("");
  const Result<> built = machine_.Build("A/B");
  ASSERT_FALSE(built);
  EXPECT_EQ(built.error().message,
            "show: event pho\nto: a name has no slash and no control characters\n"
            "show: an event has no name\n"
            "show: state A/B: a name has no slash and no control characters\n"
            "show: a state has no name");
}

TEST_F(MachineFound, IsNotBuiltWhenAStateThrowsWhileItDeclares) {
  class Throwing : public State {
    void Declare(Transitions&) override { throw std::runtime_error("no file"); }
  };
  machine_.Add("IDLE", std::make_unique<Throwing>());
  const Result<> built = machine_.Build("IDLE");
  ASSERT_FALSE(built);
  EXPECT_EQ(built.error().message, "show: IDLE: Declare: no file");
}

// It was taken for the cause of any transition of that tick, and so was lost.
TEST_F(MachineFound, KeepsACommandForTheNextStateWhenATransitionIsNotBecauseOfIt) {
  machine_.AddEvent("photo");
  LoggingState& idle = Add("IDLE", {"TRACKING"});
  LoggingState& tracking = Add("TRACKING", {"IDLE"});
  Start("IDLE");
  const StateId to = *machine_.FindState("TRACKING");
  EventId seen = kNoEvent;
  idle.check = [=](const Tick&) { return Next::To(to).KeepCommand(); };
  tracking.check = [&](const Tick& tick) {
    seen = tick.command;
    return Next::Handle();
  };
  ASSERT_TRUE(machine_.Send("photo"));
  Run();
  EXPECT_EQ(machine_.history().back().command, kNoEvent);
  EXPECT_EQ(machine_.waiting_commands(), 1U);
  Run();
  EXPECT_EQ(seen, *machine_.FindEvent("photo"));
  EXPECT_EQ(machine_.counts().unhandled, 0U);
}

TEST_F(MachineFound, KeepsCommandsInTheirOrderWhenOneIsQueuedAgain) {
  machine_.AddEvent("one");
  machine_.AddEvent("two");
  LoggingState& idle = Add("IDLE");
  Start("IDLE");
  int given_back = 0;
  std::vector<std::string> seen;
  idle.check = [&](const Tick& tick) {
    if (given_back++ == 0) return Next::Stay().KeepCommand();
    seen.emplace_back(machine_.Name(tick.command));
    return Next::Handle();
  };
  for (const char* command : {"one", "two"}) ASSERT_TRUE(machine_.Send(command));
  Run(3);
  EXPECT_THAT(seen, ElementsAre("one", "two"));
}

TEST_F(MachineFound, DoesNotQueueACommandAgainThatAnUrgentOneDropped) {
  machine_.AddEvent("photo");
  machine_.AddEvent("stop", Urgency::kUrgent);
  LoggingState& idle = Add("IDLE");
  Start("IDLE");
  idle.check = [&](const Tick&) {
    EXPECT_TRUE(machine_.Send("stop"));
    return Next::Stay().KeepCommand();
  };
  ASSERT_TRUE(machine_.Send("photo"));
  Run();
  EXPECT_EQ(machine_.waiting_commands(), 1U);
  EXPECT_EQ(machine_.counts().superseded, 1U);
}

TEST_F(MachineFound, CountsNoCommandAsUnhandledThatAStateHandlesAndStays) {
  machine_.AddEvent("louder");
  LoggingState& idle = Add("IDLE");
  Start("IDLE");
  idle.check = [](const Tick&) { return Next::Handle(); };
  ASSERT_TRUE(machine_.Send("louder"));
  Run();
  EXPECT_EQ(machine_.counts().unhandled, 0U);
  EXPECT_EQ(machine_.waiting_commands(), 0U);
}

// Three cases of an unhandled command that was not reported.
TEST_F(MachineFound, ReportsACommandWhoseTransitionWasAbortedOrWhoseCheckFailed) {
  bool safe = true;
  machine_.AddEvent("photo");
  LoggingState& idle = Add("IDLE", {"PHOTO"});
  LoggingState& photo = Add("PHOTO", {"IDLE"});
  Add("SAFE_STOP", {"IDLE"}, Role::kSafe);
  machine_.AddSafetyCheck("distance", [&](const Tick&) { return safe; });
  Counting listener;
  machine_.Listen(&listener);
  Start("IDLE");
  idle.check = [&](const Tick& tick) {
    if (tick.command == kNoEvent) return Next::Stay();
    return Next::To(*machine_.FindState("PHOTO"), 5 * kStep);
  };
  ASSERT_TRUE(machine_.Send("photo"));
  Run(2);
  safe = false;
  Run();
  EXPECT_EQ(Current(), "SAFE_STOP");
  EXPECT_THAT(listener.unhandled, ElementsAre("photo in IDLE"));

  safe = true;
  ASSERT_TRUE(machine_.Force("PHOTO"));
  photo.check = [](const Tick&) -> Next { throw std::runtime_error("no camera"); };
  ASSERT_TRUE(machine_.Send("photo"));
  Run();
  EXPECT_THAT(listener.unhandled, ElementsAre("photo in IDLE", "photo in PHOTO"));

  ASSERT_TRUE(machine_.Force("IDLE"));
  ASSERT_TRUE(machine_.Send("photo"));
  Run();
  ASSERT_EQ(machine_.mode(), Mode::kTransitioning);
  ASSERT_TRUE(machine_.Stop());
  EXPECT_EQ(machine_.counts().unhandled, 3U);
}

TEST_F(MachineFound, CountsACommandThatEndsItsTransitionOnlyInTheHistory) {
  machine_.AddEvent("photo");
  LoggingState& idle = Add("IDLE", {"PHOTO"});
  Add("PHOTO", {"IDLE"});
  Start("IDLE");
  idle.check = [&](const Tick& tick) {
    if (tick.command == kNoEvent) return Next::Stay();
    return Next::To(*machine_.FindState("PHOTO"), 2 * kStep);
  };
  ASSERT_TRUE(machine_.Send("photo"));
  Run(3);
  EXPECT_EQ(Current(), "PHOTO");
  ASSERT_TRUE(machine_.Force("IDLE"));
  EXPECT_EQ(machine_.counts().unhandled, 0U);
}

TEST_F(MachineFound, CountsTheCommandsThatAResetOrAStopDrops) {
  machine_.AddEvent("photo");
  Add("IDLE");
  Start("IDLE");
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(machine_.Send("photo"));
  ASSERT_TRUE(machine_.Reset());
  EXPECT_EQ(machine_.counts().superseded, 3U);
  for (int i = 0; i < 2; ++i) ASSERT_TRUE(machine_.Send("photo"));
  ASSERT_TRUE(machine_.Stop());
  EXPECT_EQ(machine_.waiting_commands(), 0U);
  EXPECT_EQ(machine_.counts().superseded, 5U);
}

// The sum overflowed, which is undefined, and was negative.
TEST_F(MachineFound, StopsMachineTimeAtItsMaximum) {
  Add("IDLE");
  ASSERT_TRUE(machine_.Build("IDLE"));
  ASSERT_TRUE(machine_.Start(Time::min()));
  machine_.RunOnce(Time::max());
  EXPECT_EQ(machine_.time(), Duration(kFarthestNs));
  machine_.RunOnce(Time::min());
  machine_.RunOnce(Time::max());
  EXPECT_EQ(machine_.time(), Duration(kFarthestNs));
  EXPECT_EQ(machine_.elapsed(), Duration(kFarthestNs));
}

}  // namespace musher::fsm::machine_found_test
