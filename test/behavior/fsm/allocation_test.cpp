// A tick does not allocate, unless there is a fault.

#include <gtest/gtest.h>

#include "musher/behavior/fsm/nested.hpp"
#include "musher/behavior/fsm/recorder.hpp"
#include "musher/test/behavior/fsm/counting_new.hpp"

namespace musher::fsm::allocation_test {

// Goes to the next state on a command, and every third tick, gradually.
class Rover : public State {
 public:
  explicit Rover(std::string next) : next_name_(std::move(next)) {}
  void Declare(Transitions& transitions) override {
    next_ = transitions.To(next_name_, "it is time");
    go_ = transitions.On("go");
  }
  Next CheckTransition(const Tick& tick) override {
    if (tick.command == go_) return Next::To(next_);
    if (tick.command != kNoEvent) return Next::Stay();
    if (tick.elapsed < Milliseconds(60)) return Next::Stay();
    return Next::To(next_, Milliseconds(40)).KeepCommand();
  }

 private:
  const std::string next_name_;
  StateId next_ = kNoState;
  EventId go_ = kNoEvent;
};

std::unique_ptr<Machine> Roving(int depth) {
  auto machine = std::make_unique<Machine>(Machine::Options{.name = "rover", .commands = 4});
  machine->AddEvent("go");
  machine->AddEvent("nothing");
  machine->AddEvent("stop", Urgency::kUrgent);
  machine->Add("ONE STATE WITH A NAME THAT IS LONG", std::make_unique<Rover>("TWO"));
  if (depth > 0) {
    class Outer : public Nested {
     public:
      using Nested::Nested;
      void Declare(Transitions& transitions) override {
        Nested::Declare(transitions);
        back_ = transitions.To("ONE STATE WITH A NAME THAT IS LONG", "later");
      }
      Next Decide(const Tick& tick) override {
        return tick.elapsed > Milliseconds(200) ? Next::To(back_) : Next::Stay();
      }

     private:
      StateId back_ = kNoState;
    };
    machine->Add("TWO",
                 std::make_unique<Outer>(Roving(depth - 1), "ONE STATE WITH A NAME THAT IS LONG"));
  } else {
    machine->Add("TWO", std::make_unique<Rover>("ONE STATE WITH A NAME THAT IS LONG"));
  }
  return machine;
}

class Watcher : public Listener {
 public:
  void OnChange(const Machine&, const Change&) override { ++changes; }
  void OnUnhandled(const Machine&, EventId, StateId) override { ++unhandled; }
  int changes = 0;
  int unhandled = 0;
};

TEST(Tick, TakesNoMemory) {
  const auto machine = Roving(2);
  bool safe = true;
  machine->Add("SAFE", std::make_unique<Rover>("TWO"), Role::kSafe);
  machine->AddSafetyCheck("safe", [&safe](const Tick&) { return safe; });
  Watcher watcher;
  machine->Listen(&watcher);
  std::size_t written = 0;
  Recorder recorder(*machine, [&written](std::string_view line) { written += line.size(); });
  ASSERT_TRUE(machine->Build("ONE STATE WITH A NAME THAT IS LONG"));
  ASSERT_TRUE(machine->Start(Time{}));
  const EventId events[] = {*machine->FindEvent("go"), *machine->FindEvent("nothing"),
                            *machine->FindEvent("stop")};
  // The longest line has been written once.
  ASSERT_TRUE(machine->Force("ONE STATE WITH A NAME THAT IS LONG"));
  recorder.Input("face", "here is something of some length, as a face may have it in a text");

  const std::size_t before = testing::AllocationsOfNew().times;
  for (int i = 1; i < 5000; ++i) {
    if (i % 7 == 0) {
      ASSERT_TRUE(machine->Send(events[i / 7 % 3]));
    }
    if (i % 100 == 0) recorder.Input("face", "here");
    safe = i % 400 > 5;
    machine->RunOnce(Time(Milliseconds(20 * i)));
  }
  EXPECT_EQ(testing::AllocationsOfNew().times - before, 0U);
  EXPECT_GT(watcher.changes, 300);
  EXPECT_GT(watcher.unhandled, 50);
  EXPECT_GT(written, 100'000U);
}

// The counter counts.
TEST(Build, TakesMemory) {
  const std::size_t before = testing::AllocationsOfNew().times;
  const auto machine = Roving(0);
  EXPECT_GT(testing::AllocationsOfNew().times, before + 5);
}

}  // namespace musher::fsm::allocation_test
