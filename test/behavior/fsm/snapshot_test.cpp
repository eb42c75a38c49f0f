#include "musher/behavior/fsm/snapshot.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "musher/test/behavior/fsm/machine_fixture.hpp"
#include "musher/test/behavior/fsm/random_states.hpp"

namespace musher::fsm {

void PrintTo(const SnapshotFault& fault, std::ostream* out) {
  *out << fault.key << ": " << fault.what;
}

namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

enum class Gesture { kNone, kHeart };

class PersistingState : public LoggingState {
 public:
  using LoggingState::LoggingState;
  void Persist(Archive& archive) override {
    archive.Field("greeted", greeted);
    archive.Field("guests", guests);
    archive.Field("share", share);
    archive.Field("last", last);
    archive.Field("lost_for", lost_for);
    archive.Field("gesture", gesture);
    if (fails) throw std::runtime_error("no disk");
  }
  bool greeted = false;
  std::int64_t guests = 0;
  double share = 0;
  std::string last;
  Duration lost_for{};
  Gesture gesture = Gesture::kNone;
  bool fails = false;
};

// IDLE, TRACKING and SAFE_STOP; TRACKING persists its data.
struct Show {
  explicit Show(const std::string& name = "show") : machine({.name = name, .commands = 2}) {
    machine.AddEvent("photo");
    auto idle_state =
        std::make_unique<LoggingState>("IDLE", log, std::vector<std::string>{"TRACKING"});
    auto tracking_state =
        std::make_unique<PersistingState>("TRACKING", log, std::vector<std::string>{"IDLE"});
    idle = idle_state.get();
    tracking = tracking_state.get();
    machine.Add("IDLE", std::move(idle_state));
    machine.Add("TRACKING", std::move(tracking_state));
    machine.Add("SAFE_STOP",
                std::make_unique<LoggingState>("SAFE_STOP", log, std::vector<std::string>{"IDLE"}),
                Role::kSafe);
    machine.AddSafetyCheck("distance", [this](const Tick&) { return safe; });
    EXPECT_TRUE(machine.Build("IDLE"));
  }
  Snapshot Save() const {
    const Result<Snapshot> saved = machine.Save();
    EXPECT_TRUE(saved) << saved.error().message;
    return saved ? saved.value() : Snapshot{};
  }
  void Run(int ticks = 1) {
    for (int i = 0; i < ticks; ++i) machine.RunOnce(now += kStep);
  }

  Log log;
  LoggingState* idle;
  PersistingState* tracking;
  bool safe = true;
  Machine machine;
  Time now{};
};

TEST(Snapshot, BringsAnotherMachineToTheSameStateWithoutEnteringIt) {
  Show show;
  ASSERT_TRUE(show.machine.Start(show.now));
  show.idle->Go("TRACKING");
  show.Run(3);
  show.tracking->greeted = true;
  show.tracking->guests = -7;
  show.tracking->share = 0.25;
  show.tracking->last = "Ada";
  show.tracking->lost_for = Milliseconds(80);
  show.tracking->gesture = Gesture::kHeart;
  ASSERT_TRUE(show.machine.Send("photo"));

  Show other;
  ASSERT_THAT(other.machine.Restore(show.Save(), Time(std::chrono::hours(3))), IsEmpty());
  EXPECT_THAT(other.log, IsEmpty());
  EXPECT_EQ(other.machine.Path(), "TRACKING");
  EXPECT_EQ(other.machine.elapsed(), 2 * kStep);
  EXPECT_EQ(other.machine.time(), 3 * kStep);
  EXPECT_EQ(other.machine.ticks(), 3U);
  EXPECT_EQ(other.machine.waiting_commands(), 1U);
  EXPECT_EQ(other.machine.history().size(), 2U);
  EXPECT_TRUE(other.tracking->greeted);
  EXPECT_EQ(other.tracking->guests, -7);
  EXPECT_EQ(other.tracking->share, 0.25);
  EXPECT_EQ(other.tracking->last, "Ada");
  EXPECT_EQ(other.tracking->lost_for, Milliseconds(80));
  EXPECT_EQ(other.tracking->gesture, Gesture::kHeart);
  EXPECT_EQ(other.Save(), show.Save());
  other.machine.RunOnce(Time(std::chrono::hours(3)) + kStep);
  EXPECT_EQ(other.machine.elapsed(), 3 * kStep);
}

TEST(Snapshot, ContinuesWithATransitionWhereItWas) {
  Show show;
  ASSERT_TRUE(show.machine.Start(show.now));
  show.idle->Go("TRACKING", 3 * kStep);
  show.Run(2);
  const Snapshot saved = show.Save();
  ASSERT_TRUE(saved.transition);
  EXPECT_EQ(saved.transition->to, "TRACKING");
  EXPECT_EQ(saved.transition->elapsed, kStep);

  Show other;
  ASSERT_THAT(other.machine.Restore(saved, Time{}), IsEmpty());
  EXPECT_EQ(other.machine.mode(), Mode::kTransitioning);
  other.Run(2);
  EXPECT_THAT(other.log, ElementsAre("IDLE transition", "IDLE exit", "TRACKING enter"));
}

TEST(Snapshot, KeepsASafeStopWithItsReasonAndAMachineThatAFaultStopped) {
  Show show;
  ASSERT_TRUE(show.machine.Start(show.now));
  show.safe = false;
  show.Run();
  Show other;
  ASSERT_THAT(other.machine.Restore(show.Save(), Time{}), IsEmpty());
  EXPECT_EQ(other.machine.mode(), Mode::kSafeStop);
  EXPECT_EQ(other.machine.unsafe(), "distance");

  show.idle->on["enter"] = [](const Tick&) { throw std::runtime_error("no arm"); };
  show.safe = true;
  ASSERT_FALSE(show.machine.Force("IDLE"));
  EXPECT_EQ(show.machine.Path(), "SAFE_STOP");
  Show third;
  ASSERT_THAT(third.machine.Restore(show.Save(), Time{}), IsEmpty());
  EXPECT_EQ(third.machine.Describe(*third.machine.fault()), "IDLE: OnEnter: no arm");
}

TEST(Snapshot, OfAMachineThatDoesNotRunGivesOneThatDoesNotRun) {
  const Show show;
  Show other;
  ASSERT_THAT(other.machine.Restore(show.Save(), Time{}), IsEmpty());
  EXPECT_FALSE(other.machine.running());
  EXPECT_TRUE(other.machine.Start(Time{}));
}

TEST(Snapshot, KeepsThatAMachineWasPaused) {
  Show show;
  ASSERT_TRUE(show.machine.Start(show.now));
  show.machine.Pause();
  Show other;
  ASSERT_THAT(other.machine.Restore(show.Save(), Time{}), IsEmpty());
  other.machine.RunOnce(Time(std::chrono::hours(1)));
  EXPECT_EQ(other.machine.time(), Duration{});
}

// The errors of Restore() for a snapshot in TRACKING that `change` has damaged.
std::vector<std::string> FaultsOf(const std::function<void(Snapshot&)>& change) {
  Show show;
  EXPECT_TRUE(show.machine.Start(show.now));
  show.idle->Go("TRACKING");
  show.Run(2);
  show.tracking->guests = 3;
  Snapshot saved = show.Save();
  change(saved);
  Show other;
  other.tracking->guests = 5;
  std::vector<std::string> faults;
  for (const SnapshotFault& fault : other.machine.Restore(saved, Time{})) {
    faults.push_back(fault.key + ": " + fault.what);
  }
  EXPECT_EQ(other.machine.running(), faults.empty());
  EXPECT_EQ(other.tracking->guests, faults.empty() ? 3 : 5) << "a part was restored";
  return faults;
}

TEST(Snapshot, IsRefusedWithAllItsErrors) {
  EXPECT_THAT(FaultsOf([](Snapshot&) {}), IsEmpty());
  EXPECT_THAT(FaultsOf([](Snapshot& s) { s.machine = "race"; }),
              ElementsAre("machine: it was saved from race, not from show"));
  EXPECT_THAT(FaultsOf([](Snapshot& s) { s.state = "TRAKCING"; }),
              ElementsAre("state: there is no state TRAKCING; did you mean 'TRACKING'?"));
  EXPECT_THAT(FaultsOf([](Snapshot& s) { s.state = ""; }), ElementsAre("state: is missing"));
  EXPECT_THAT(FaultsOf([](Snapshot& s) { s.running = false; }),
              ElementsAre("state: is set, although the machine does not run"));
  EXPECT_THAT(FaultsOf([](Snapshot& s) { s.mode = Mode::kSafeStop; }),
              ElementsAre("mode: SAFE_STOP is not that of TRACKING"));
  EXPECT_THAT(FaultsOf([](Snapshot& s) { s.mode = Mode::kTransitioning; }),
              ElementsAre("mode: TRANSITIONING has a transition, which is missing"));
  EXPECT_THAT(FaultsOf([](Snapshot& s) { s.transition.emplace(); }),
              ElementsAre("mode: NORMAL has no transition"));
  EXPECT_THAT(FaultsOf([](Snapshot& s) {
                s.mode = Mode::kTransitioning;
                s.transition = {"IDEL", "phot", Milliseconds(30), Duration{}};
              }),
              ElementsAre("transition.to: there is no state IDEL; did you mean 'IDLE'?",
                          "transition.command: there is no event phot; did you mean 'photo'?",
                          "transition.elapsed: has to be between 0 and 20000000 ns"));
  EXPECT_THAT(FaultsOf([](Snapshot& s) { s.elapsed = s.time + Duration(1); }),
              ElementsAre("elapsed: has to be between 0 and 40000000 ns"));
  EXPECT_THAT(FaultsOf([](Snapshot& s) { s.step = Duration(-1); }),
              ElementsAre("step: has to be between 0 and 40000000 ns"));
  EXPECT_THAT(FaultsOf([](Snapshot& s) {
                s.commands = {"photo", "photo", "photo"};
              }),
              ElementsAre("commands: more than 2 cannot wait"));
  EXPECT_THAT(FaultsOf([](Snapshot& s) { s.commands = {"phot"}; }),
              ElementsAre("commands: there is no event phot; did you mean 'photo'?"));
  EXPECT_THAT(FaultsOf([](Snapshot& s) { s.unsafe = "heat"; }),
              ElementsAre("unsafe: there is no safety check heat"));
  EXPECT_THAT(FaultsOf([](Snapshot& s) { s.history[0].to = "IDEL"; }),
              ElementsAre("history[0].to: there is no state IDEL; did you mean 'IDLE'?"));
  EXPECT_THAT(FaultsOf([](Snapshot& s) {
                s.fault = {"IDEL", Phase::kRun, {}, "", ""};
              }),
              ElementsAre("fault.state: there is no state IDEL; did you mean 'IDLE'?"));
}

// It was restored, and the first tick that used the missing name crashed.
TEST(Snapshot, IsRefusedWhereATransitionOrACommandHasNoName) {
  EXPECT_THAT(FaultsOf([](Snapshot& s) {
                s.mode = Mode::kTransitioning;
                s.transition = {"", "", Duration{}, Milliseconds(100)};
              }),
              ElementsAre("transition.to: is missing"));
  EXPECT_THAT(FaultsOf([](Snapshot& s) {
                s.commands = {"photo", ""};
              }),
              ElementsAre("commands: one has no name"));
}

TEST(Snapshot, IsRefusedWithTheErrorsOfItsParts) {
  EXPECT_THAT(FaultsOf([](Snapshot& s) { s.states.clear(); }),
              ElementsAre("states.TRACKING: is missing"));
  EXPECT_THAT(FaultsOf([](Snapshot& s) {
                s.states.push_back({"PHOTO", {}});
              }),
              ElementsAre("states.PHOTO: there is no state PHOTO"));
  EXPECT_THAT(FaultsOf([](Snapshot& s) {
                s.data.push_back({"robot", {}});
              }),
              ElementsAre("data.robot: there is no data robot"));
  EXPECT_THAT(
      FaultsOf([](Snapshot& s) { s.states[0].fields[1].name = "guest"; }),
      ElementsAre("states.TRACKING.guest: there is no field guest; did you mean 'guests'?"));
  EXPECT_THAT(FaultsOf([](Snapshot& s) { s.states[0].fields[0].value = std::string("yes"); }),
              ElementsAre("states.TRACKING.greeted: has to be true or false, not a text"));
  EXPECT_THAT(FaultsOf([](Snapshot& s) { s.states[0].fields[1].value = 0.5; }),
              ElementsAre("states.TRACKING.guests: has to be an integer, not a number"));
  EXPECT_THAT(FaultsOf([](Snapshot& s) { s.states[0].fields[2].value = std::int64_t{1}; }),
              IsEmpty());
  EXPECT_THAT(FaultsOf([](Snapshot& s) {
                s.inside.push_back({"TRACKING", {}});
              }),
              ElementsAre("inside.TRACKING: TRACKING holds no machine"));
  EXPECT_THAT(FaultsOf([](Snapshot& s) {
                s.inside.push_back({"PHOTO", {}});
              }),
              ElementsAre("inside.PHOTO: there is no state PHOTO"));
}

TEST(Snapshot, IsRefusedByAMachineThatRunsOrIsNotBuilt) {
  Show show;
  const Snapshot saved = show.Save();
  ASSERT_TRUE(show.machine.Start(show.now));
  EXPECT_THAT(show.machine.Restore(saved, Time{}),
              ElementsAre(SnapshotFault{"running", "show runs already"}));
  Machine unbuilt;
  EXPECT_FALSE(unbuilt.Save());
  EXPECT_EQ(unbuilt.Restore(saved, Time{}).size(), 1U);
}

TEST(Snapshot, CannotBeTakenWhereAStateFailsToPersistOrGivesAFieldTwice) {
  Show show;
  show.tracking->fails = true;
  EXPECT_EQ(show.machine.Save().error().message, "show: TRACKING: Persist: no disk");

  Machine machine({.name = "show"});
  Log log;
  machine.Add("IDLE", std::make_unique<LoggingState>("IDLE", log));
  machine.AddData("robot", [](Archive& archive) {
    bool twice = false;
    archive.Field("a", twice);
    archive.Field("a", twice);
  });
  ASSERT_TRUE(machine.Build("IDLE"));
  EXPECT_EQ(machine.Save().error().message, "show: robot: Persist: the field a occurs twice");
}

TEST(Snapshot, UndoesWhatItHadRestoredWhenALaterStateFails) {
  Show show;
  ASSERT_TRUE(show.machine.Start(show.now));
  show.tracking->last = "Ada";
  Snapshot saved = show.Save();
  saved.states[0].fields.push_back({"lost", true});
  Show other;
  other.tracking->last = "Bea";
  EXPECT_EQ(other.machine.Restore(saved, Time{}).size(), 1U);
  EXPECT_EQ(other.tracking->last, "Bea");
}

RC_GTEST_PROP(Snapshot, LetsAnotherMachineContinueAlikeWheneverItIsTaken, (std::uint64_t seed)) {
  const std::vector<RandomInput> before = AnyInputs();
  const std::vector<RandomInput> after = AnyInputs();
  const auto ignore = [](std::int64_t) {};
  Facts facts;
  const auto machine = RandomMachine(seed, facts, 2, 20);
  RC_ASSERT(machine->Build("A").ok());
  Time now(std::chrono::hours(5));
  (void)machine->Start(now).ok();
  for (const RandomInput& step : before) ApplyTo(*machine, step, now, facts, ignore);

  const Result<Snapshot> saved = machine->Save();
  RC_ASSERT(saved.ok());
  Facts other_facts;
  const auto other = RandomMachine(seed, other_facts, 2, 20);
  RC_ASSERT(other->Build("A").ok());
  const auto faults = other->Restore(saved.value(), now);
  RC_LOG() << (faults.empty() ? "" : faults[0].key + ": " + faults[0].what) << std::endl;
  RC_ASSERT(faults.empty());
  RC_ASSERT(other_facts.number == facts.number);

  Time other_now = now;
  for (const RandomInput& step : after) {
    ApplyTo(*machine, step, now, facts, ignore);
    ApplyTo(*other, step, other_now, other_facts, ignore);
    RC_ASSERT(other->Save().value() == machine->Save().value());
  }
}

}  // namespace
}  // namespace musher::fsm
