#include "musher/behavior/fsm/toml/snapshot_toml.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <limits>

#include "musher/test/behavior/fsm/random_states.hpp"

namespace musher::fsm::snapshot_toml_test {

// A show of IDLE and SHOW; SHOW holds PHOTO, which persists its count.
class Photo : public State {
 public:
  void Declare(Transitions& transitions) override { done_ = transitions.To("DONE", "taken"); }
  Next CheckTransition(const Tick& tick) override {
    return tick.command != kNoEvent ? Next::To(done_, Milliseconds(100)) : Next::Stay();
  }
  void Persist(Archive& archive) override {
    archive.Field("taken", taken);
    archive.Field("of whom", whom);
    archive.Field("share", share);
  }
  std::int64_t taken = 2;
  std::string whom = "Ada \"A\"\n\x01ß";
  double share = 1;

 private:
  StateId done_ = kNoState;
};

class GoesTo : public State {
 public:
  explicit GoesTo(std::string to) : to_(std::move(to)) {}
  void Declare(Transitions& transitions) override { target_ = transitions.To(to_, "requested"); }
  Next CheckTransition(const Tick& tick) override {
    return tick.command != kNoEvent ? Next::To(target_) : Next::Stay();
  }

 private:
  const std::string to_;
  StateId target_ = kNoState;
};

struct Show {
  Show() : machine({.name = "show"}) {
    machine.AddEvent("go");
    auto inner = std::make_unique<Machine>(Machine::Options{.name = "photo"});
    inner->AddEvent("go");
    auto photo_state = std::make_unique<Photo>();
    photo = photo_state.get();
    inner->Add("PHOTO", std::move(photo_state));
    inner->Add("DONE", std::make_unique<State>(), Role::kFinal);
    machine.Add("IDLE", std::make_unique<GoesTo>("SHOW"));
    machine.Add("SHOW", std::make_unique<Nested>(std::move(inner), "PHOTO",
                                                 Nested::Options{.finished = "IDLE"}));
    machine.AddData("robot", [this](Archive& archive) { archive.Field("ready", ready); });
    EXPECT_TRUE(machine.Build("IDLE"));
  }
  Machine machine;
  Photo* photo;
  bool ready = true;
};

constexpr const char* kSaved =
    R"(# A state machine between two ticks. Times are nanoseconds of machine time.
machine = "show"
running = true
paused = false
mode = "NORMAL"
state = "SHOW"
ticks = 2
time_ns = 40000000
step_ns = 20000000
elapsed_ns = 20000000
unsafe = ""
commands = ["go"]
history = [
  { tick = 0, at_ns = 0, from = "", to = "IDLE", cause = "started" },
  { tick = 1, at_ns = 20000000, from = "IDLE", to = "SHOW", cause = "decided", command = "go" },
]

[counts]
changes = 2
unhandled = 0
superseded = 0
refused = 0
faults = 0
listener_faults = 0

[data.robot]
ready = true

[states.SHOW]
left_in = ""

[inside.SHOW]
machine = "photo"
running = true
paused = false
mode = "TRANSITIONING"
state = "PHOTO"
ticks = 1
time_ns = 20000000
step_ns = 20000000
elapsed_ns = 20000000
unsafe = ""
commands = []
history = [
  { tick = 0, at_ns = 0, from = "", to = "PHOTO", cause = "started" },
]

[inside.SHOW.counts]
changes = 1
unhandled = 0
superseded = 0
refused = 0
faults = 0
listener_faults = 0

[inside.SHOW.transition]
to = "DONE"
command = "go"
elapsed_ns = 0
time_ns = 100000000

[inside.SHOW.states.PHOTO]
taken = 2
"of whom" = "Ada \"A\"\n\u0001ß"
share = 1.0
)";

std::string SavedShow() {
  Show show;
  EXPECT_TRUE(show.machine.Start(Time{}));
  for (int i = 1; i <= 2; ++i) {
    EXPECT_TRUE(show.machine.Send("go"));
    show.machine.RunOnce(Time(Milliseconds(20 * i)));
  }
  EXPECT_TRUE(show.machine.Send("go"));
  const auto text = WriteSnapshot(show.machine.Save().value());
  EXPECT_TRUE(text) << text.error().message;
  return text ? text.value() : "";
}

TEST(SnapshotToml, IsATextThatAPersonCanRead) {
  EXPECT_EQ(SavedShow(), kSaved);
}

TEST(SnapshotToml, RestoresAMachineWithTheOneInside) {
  Show show;
  show.photo->taken = 0;
  show.photo->whom = "";
  show.ready = false;
  const Result<> restored = RestoreSnapshot(show.machine, kSaved, "show.toml", Time{});
  ASSERT_TRUE(restored) << restored.error().message;
  EXPECT_EQ(show.machine.Path(), "SHOW/PHOTO");
  EXPECT_EQ(show.photo->taken, 2);
  EXPECT_EQ(show.photo->whom, "Ada \"A\"\n\x01ß");
  EXPECT_TRUE(show.ready);
  EXPECT_EQ(WriteSnapshot(show.machine.Save().value()).value(), kSaved);
}

std::string FaultOf(const std::string& from, const std::string& to) {
  std::string text = kSaved;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  Show show;
  show.photo->taken = 9;
  const Result<> restored = RestoreSnapshot(show.machine, text, "show.toml", Time{});
  EXPECT_EQ(show.machine.running(), restored.ok());
  EXPECT_EQ(show.photo->taken, restored.ok() ? 2 : 9);
  return restored ? "none" : restored.error().message;
}

TEST(SnapshotToml, ReportsWhereItNamesAnotherMachine) {
  EXPECT_EQ(FaultOf("\"show\"", "\"race\""),
            "show.toml:2:11: error: machine: it was saved from race, not from show");
  EXPECT_EQ(FaultOf("state = \"SHOW\"", "state = \"SHOV\""),
            "show.toml:6:9: error: state: there is no state SHOV; did you mean 'SHOW'?");
  EXPECT_EQ(FaultOf("[data.robot]", "[data.robto]"),
            "show.toml:26:7: error: data.robto: there is no data robto; did you mean 'robot'?");
  EXPECT_EQ(FaultOf("[states.SHOW]\nleft_in = \"\"\n", ""),
            "show.toml:1:1: error: states.SHOW: is missing");
  EXPECT_EQ(
      FaultOf("from = \"IDLE\"", "from = \"IDEL\""),
      "show.toml:15:40: error: history[1].from: there is no state IDEL; did you mean 'IDLE'?");
}

TEST(SnapshotToml, ReportsWhereTheMachineInsideIsInvalid) {
  EXPECT_EQ(FaultOf("taken = 2", "taken = \"two\""),
            "show.toml:63:1: error: inside.SHOW.states.PHOTO.taken: has to be an integer, not a "
            "text");
  EXPECT_EQ(
      FaultOf("to = \"DONE\"", "to = \"DOEN\""),
      "show.toml:57:6: error: inside.SHOW.transition.to: there is no state DOEN; did you mean "
      "'DONE'?");
}

TEST(SnapshotToml, ReportsAllErrorsOfATextThatIsNotASnapshotAtOnce) {
  EXPECT_EQ(FaultOf("ticks = 2\n", "tikcs = -2\n"),
            "show.toml:1:1: error: the key \"ticks\" is missing; expected what a saved machine has "
            "there\n"
            "show.toml:7:1: error: unknown key \"tikcs\"; did you mean \"ticks\"?");
  EXPECT_EQ(FaultOf("mode = \"NORMAL\"", "mode = \"NORMAAL\""),
            "show.toml:5:8: error: mode: expected one of NORMAL, TRANSITIONING and "
            "SAFE_STOP, found \"NORMAAL\"; did you mean \"NORMAL\"?");
  EXPECT_EQ(FaultOf("ready = true", "ready = 2020-01-01"),
            "show.toml:27:9: error: data.robot.ready: expected a bool, a number or a string");
  EXPECT_THAT(FaultOf("time_ns = 40000000", "time_ns ="), ::testing::StartsWith("show.toml:8:"));
}

TEST(SnapshotToml, CannotHoldATextThatIsNotUtf8) {
  Snapshot snapshot;
  snapshot.machine = "show";
  snapshot.states.push_back({"A", {{"name", std::string("\xff")}}});
  EXPECT_EQ(WriteSnapshot(snapshot).error().message,
            "show: name cannot be saved: it is not UTF-8, or has a NUL");
}

RC_GTEST_PROP(SnapshotToml, RestoresEverySavedMachineExactly, (std::uint64_t seed)) {
  Facts facts;
  const auto machine = RandomMachine(seed, facts, 2);
  RC_ASSERT(machine->Build("A").ok());
  Time now(std::chrono::hours(5));
  (void)machine->Start(now).ok();
  for (const RandomInput& step : AnyInputs())
    ApplyTo(*machine, step, now, facts, [](std::int64_t) {});
  const Snapshot saved = machine->Save().value();
  const Result<std::string> text = WriteSnapshot(saved);
  RC_ASSERT(text.ok());

  Facts other_facts;
  const auto other = RandomMachine(seed, other_facts, 2);
  RC_ASSERT(other->Build("A").ok());
  const Result<> restored = RestoreSnapshot(*other, text.value(), "random.toml", now);
  RC_LOG() << (restored ? "" : restored.error().message) << std::endl;
  RC_ASSERT(restored.ok());
  RC_ASSERT(other->Save().value() == saved);
}

RC_GTEST_PROP(SnapshotToml, KeepsAnyNumber, (double number)) {
  double value = *rc::gen::elementOf(
      std::vector<double>{number, 1e300 * number, std::numeric_limits<double>::infinity(),
                          std::numeric_limits<double>::denorm_min(), -0.0, 1e20});
  const auto make = [](double& kept) {
    auto machine = std::make_unique<Machine>();
    machine->Add("A", std::make_unique<State>());
    machine->AddData("d", [&kept](Archive& archive) { archive.Field("v", kept); });
    RC_ASSERT(machine->Build("A").ok());
    return machine;
  };
  double again = 0.5;
  const std::string text = WriteSnapshot(make(value)->Save().value()).value();
  RC_ASSERT(RestoreSnapshot(*make(again), text, "d.toml", Time{}).ok());
  RC_ASSERT(again == value);
}

}  // namespace musher::fsm::snapshot_toml_test
