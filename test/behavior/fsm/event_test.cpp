// Events that carry data.

#include "musher/behavior/fsm/event.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/behavior/fsm/recorder.hpp"
#include "musher/behavior/fsm/replay.hpp"
#include "musher/behavior/fsm/toml/snapshot_toml.hpp"
#include "musher/test/behavior/fsm/hierarchy_fixture.hpp"

namespace musher::fsm::event_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

struct Photo {
  std::int64_t count = 1;
  double zoom = 1.5;
  bool flash = false;
  std::string of;

  void Persist(Archive& archive) {
    archive.Field("count", count);
    archive.Field("zoom", zoom);
    archive.Field("flash", flash);
    archive.Field("of", of);
  }
};

struct Speed {
  double mps = 0;
  void Persist(Archive& archive) { archive.Field("mps", mps); }
};

class EventTest : public HierarchyFixture {
 protected:
  // IDLE takes the photos that it is commanded to.
  void Make(Machine& machine) {
    machine.AddEvent<Photo>("photo");
    machine.AddEvent("go");
    auto idle = std::make_unique<LoggingState>("IDLE", log_);
    LoggingState* const state = idle.get();
    state->declare = [this](Transitions& transitions) { photo_ = transitions.On<Photo>("photo"); };
    state->check = [this](const Tick& tick) {
      const Photo* const photo = photo_.In(tick);
      if (photo == nullptr) return Next::Stay();
      taken_.push_back(std::to_string(photo->count) + " of " + photo->of +
                       (photo->flash ? " with flash" : ""));
      return Next::Handle();
    };
    machine.Add("IDLE", std::move(idle));
  }

  TypedEvent<Photo> photo_;
  std::vector<std::string> taken_;
};

TEST_F(EventTest, AStateGetsTheDataOfItsCommand) {
  Make(machine_);
  Start("IDLE");
  ASSERT_TRUE(machine_.Send("photo", Photo{.count = 3, .of = "Ann"}));
  ASSERT_TRUE(machine_.Send(photo_, Photo{.flash = true, .of = "Bo"}));
  Run(3);
  EXPECT_THAT(taken_, ElementsAre("3 of Ann", "1 of Bo with flash"));
}

TEST_F(EventTest, AnotherCommandHasNoData) {
  Make(machine_);
  Start("IDLE");
  ASSERT_TRUE(machine_.Send("go"));
  Run();
  EXPECT_THAT(taken_, IsEmpty());
  EXPECT_EQ(machine_.counts().unhandled, 1U);
}

TEST_F(EventTest, RefusesDataOfAnotherType) {
  Make(machine_);
  Start("IDLE");
  EXPECT_EQ(machine_.Send("photo").error().message,
            "show: event photo carries data, which is missing");
  EXPECT_EQ(machine_.Send("photo", Speed{}).error().message,
            "show: event photo carries other data");
  EXPECT_EQ(machine_.Send("go", Speed{}).error().message, "show: event go carries other data");
}

TEST_F(EventTest, AStateThatExpectsOtherDataIsAnErrorOfBuild) {
  machine_.AddEvent<Photo>("photo");
  Add("IDLE").declare = [](Transitions& transitions) { transitions.On<Speed>("photo"); };
  const Result<> built = machine_.Build("IDLE");
  ASSERT_FALSE(built);
  EXPECT_EQ(built.error().message,
            "show: IDLE: event photo carries other data than this state expects");
}

TEST_F(EventTest, KeepsItsDataWhileItIsKeptAndDeferred) {
  Make(machine_);
  Add("BUSY", {"IDLE"}).declare = [](Transitions& transitions) { transitions.Defer("photo"); };
  Start("IDLE");
  ASSERT_TRUE(machine_.Force("BUSY"));
  ASSERT_TRUE(machine_.Send("photo", Photo{.count = 2, .of = "Ann"}));
  ASSERT_TRUE(machine_.Send("go"));
  Run(3);
  ASSERT_TRUE(machine_.Force("IDLE"));
  Run();
  EXPECT_THAT(taken_, ElementsAre("2 of Ann"));
}

class NestedEventTest : public EventTest, public ::testing::WithParamInterface<bool> {};

TEST_P(NestedEventTest, PassesItsDataInside) {
  auto inside = NewMachine("inside");
  Make(*inside);
  machine_.AddEvent<Photo>("photo");
  AddNested(machine_, "SHOW", std::move(inside), "IDLE", {.inner_first = GetParam()});
  Start("SHOW");
  ASSERT_TRUE(machine_.Send("photo", Photo{.count = 2, .of = "Ann"}));
  Run();
  EXPECT_THAT(taken_, ElementsAre("2 of Ann"));
}

INSTANTIATE_TEST_SUITE_P(InnerFirst, NestedEventTest, ::testing::Bool());

TEST_F(EventTest, OtherDataInsideThanOutsideIsAnErrorOfBuild) {
  auto inside = NewMachine("inside");
  Make(*inside);
  machine_.AddEvent("photo");
  AddNested(machine_, "SHOW", std::move(inside), "IDLE");
  const Result<> built = machine_.Build("SHOW");
  ASSERT_FALSE(built);
  EXPECT_EQ(built.error().message,
            "show: SHOW: event photo of inside carries other data than around it");
}

TEST_F(EventTest, IsRecordedAndReplayed) {
  Make(machine_);
  std::string text;
  auto recorder =
      std::make_unique<Recorder>(machine_, [&](std::string_view line) { text += line; });
  Start("IDLE");
  ASSERT_TRUE(machine_.Send("photo", Photo{.count = 3, .flash = true, .of = "Ann B."}));
  Run();
  recorder.reset();
  EXPECT_THAT(text, HasSubstr("\ncommand photo count 3 zoom 1.5 flash true of \"Ann B.\"\n"));
  Machine other({.name = "show"});
  Make(other);
  ASSERT_TRUE(other.Build("IDLE"));
  const auto replay = [&](const std::string& recorded, Machine& machine) {
    const Result<Recording> recording = ReadRecording(recorded, "show.record");
    EXPECT_TRUE(recording);
    const auto replayed = Replay(recording.value(), machine, [](auto, auto) { return Ok(); });
    return replayed ? replayed.value().difference.value_or("same") : replayed.error().message;
  };
  EXPECT_EQ(replay(text, other), "same");
  EXPECT_THAT(taken_, ElementsAre("3 of Ann B. with flash", "3 of Ann B. with flash"));
  ASSERT_TRUE(other.Stop());
  text.replace(text.find("count 3"), 7, "count x");
  EXPECT_EQ(replay(text, other), "show.record:4: error: event photo carries no count of x");
}

TEST_F(EventTest, IsSavedAndRestored) {
  Make(machine_);
  Start("IDLE");
  ASSERT_TRUE(machine_.Send("go"));
  ASSERT_TRUE(machine_.Send("photo", Photo{.count = 3, .of = "Ann"}));
  const Result<Snapshot> saved = machine_.Save();
  ASSERT_TRUE(saved);
  const Result<std::string> text = WriteSnapshot(saved.value());
  ASSERT_TRUE(text);
  EXPECT_THAT(text.value(), HasSubstr("[command_data.1]\ncount = 3\n"));
  ASSERT_TRUE(machine_.Stop());
  ASSERT_TRUE(RestoreSnapshot(machine_, text.value(), "show.toml", now_));
  Run(2);
  EXPECT_THAT(taken_, ElementsAre("3 of Ann"));
  ASSERT_TRUE(machine_.Stop());
  std::string wrong = text.value();
  wrong.replace(wrong.find("count = 3"), 9, "coumt = 3");
  const Result<> restored = RestoreSnapshot(machine_, wrong, "show.toml", now_);
  ASSERT_FALSE(restored);
  EXPECT_THAT(restored.error().message,
              HasSubstr("there is no field coumt; did you mean 'count'?"));
}

}  // namespace musher::fsm::event_test
