#include "musher/behavior/skill/snapshot.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "musher/behavior/skill/compose.hpp"
#include "musher/behavior/skill/toml/snapshot_toml.hpp"
#include "musher/behavior/skill/wait.hpp"

namespace musher::skill::snapshot_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Counts to 5 in its member and in its data, with a retry at 3.
class Counter : public Skill {
 public:
  void Declare(Table& table) override {
    counting_ = table.State("COUNTING", std::chrono::seconds(60));
    table.To(counting_, counting_, "again");
    table.To(counting_, kSucceeded, "5");
    table.Takes("goal", Numbers{1, 2}, "m");
    table.Takes("note", std::string("\"\n ü"), "");
  }
  Next Step(Tick& tick) override {
    tick.data.Set("twice", 2 * ++count_);
    tick.data.Set("share", static_cast<double>(count_) / 5);
    tick.Report(20.0 * static_cast<double>(count_), "at " + std::to_string(count_));
    if (count_ == 3) return Next::Retry(counting_, "three");
    return count_ == 5 ? Next::Succeed() : Next::Stay();
  }
  Next Cancel(Tick&) override { return Next::Stay(); }
  void Persist(fsm::Archive& archive) override { archive.Field("count", count_); }

 private:
  StateId counting_ = kIdle;
  std::int64_t count_ = 0;
};

class Saved : public ::testing::Test {
 protected:
  Saved() {
    EXPECT_TRUE(registry_.Add<Counter>("count"));
    EXPECT_TRUE(registry_.Add("wait", Wait()));
    EXPECT_TRUE(registry_.Add(
        "all", Compose(Order::kInOrder, registry_, {{"wait", {{"duration_s", 0.2}}}, {"count"}})));
  }
  static void Steps(Manager& manager, int count) {
    Time now{};
    for (int i = 0; i < count; ++i) manager.RunOnce(now += Milliseconds(100));
  }
  static std::string TextOf(const Manager& manager) {
    return WriteSnapshot(manager.Save().value()).value();
  }
  std::string ErrorOf(const std::string& text) {
    Manager manager(registry_.All());
    const Result<> restored = RestoreSnapshot(manager, text, "skills.toml");
    if (restored) return "";
    EXPECT_THAT(manager.Runs(), IsEmpty()) << "nothing has changed";
    return restored.error().message;
  }
  // The text of a run of `count`, with one change.
  std::string Changed(const std::string& from, const std::string& to) {
    Manager manager(registry_.All());
    EXPECT_TRUE(manager.Start("count"));
    Steps(manager, 2);
    std::string text = TextOf(manager);
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from << " is not in\n" << text;
    return at == std::string::npos ? text : text.replace(at, from.size(), to);
  }

  Registry registry_;
};

TEST_F(Saved, SkillsContinueInAnotherProcessAsInThisOneAfterEachNumberOfSteps) {
  for (const char* skill : {"count", "all"}) {
    for (int steps = 0; steps < 12; ++steps) {
      Manager first(registry_.All());
      ASSERT_TRUE(first.Start(skill));
      Steps(first, steps);
      if (steps == 4) {
        ASSERT_TRUE(first.Cancel(skill, "a \"person\""));
      }
      const std::string text = TextOf(first);
      Manager second(registry_.All());
      const Result<> restored = RestoreSnapshot(second, text, "skills.toml");
      ASSERT_TRUE(restored) << restored.error().message << "\n" << text;
      EXPECT_EQ(TextOf(second), text);
      EXPECT_EQ(ToText(second.Find(skill)->feedback()), ToText(first.Find(skill)->feedback()));
      first.Pause();
      Steps(first, 3);
      Steps(second, 3);
      EXPECT_EQ(second.Save().value().runs[0].message, first.Save().value().runs[0].message);
      EXPECT_EQ(second.StateOf(skill), first.StateOf(skill)) << skill << " after " << steps;
    }
  }
}

TEST_F(Saved, ParametersDataErrorsAndHistoryAreKept) {
  Manager first(registry_.All());
  ASSERT_TRUE(first.Start("count", {{"goal", Numbers{3, 4.5}}}));
  Steps(first, 3);
  Manager second(registry_.All());
  ASSERT_TRUE(RestoreSnapshot(second, TextOf(first), "skills.toml"));
  const skill::Run& run = *second.Find("count");
  EXPECT_EQ(run.parameters().Get<Numbers>("goal", {}), (Numbers{3, 4.5}));
  EXPECT_EQ(run.retries(), 1);
  EXPECT_EQ(run.errors()[0], (Failure{Milliseconds(200), "COUNTING", "three"}));
  EXPECT_EQ(run.history().back().cause, Cause::kRetried);
  EXPECT_EQ(second.Save().value(), first.Save().value());
}

TEST_F(Saved, AreRefusedWithPlaceAndNearestNameAndChangeNothing) {
  EXPECT_EQ(
      ErrorOf(Changed("skill = \"count\"", "skill = \"cuont\"")),
      "skills.toml:4:9: error: run[0].skill: there is no skill 'cuont'; did you mean 'count'? "
      "There are count, wait and all");
  EXPECT_THAT(ErrorOf(Changed("state = \"COUNTING\"", "state = \"COUNTIN\"")),
              HasSubstr("run[0].state: there is no state COUNTIN; did you mean 'COUNTING'?"));
  EXPECT_THAT(ErrorOf(Changed("progress = 40", "progress = 100")),
              HasSubstr("run[0].progress: has to be between 0 and 99"));
  EXPECT_THAT(ErrorOf(Changed("elapsed_ns = 1", "elapsed_ns = 9")), HasSubstr("run[0].elapsed"));
  EXPECT_THAT(ErrorOf(Changed("cancel_passed = false", "cancel_passed = true")),
              HasSubstr("without a request"));
  EXPECT_THAT(ErrorOf(Changed("goal = ", "gaol = ")), HasSubstr("did you mean 'goal'?"));
  EXPECT_THAT(ErrorOf(Changed("count = 2", "count = \"two\"")),
              HasSubstr("run[0].fields.count: has to be an integer, not a text"));
  EXPECT_THAT(ErrorOf(Changed("retries", "retry")), HasSubstr("unknown key \"retry\""));
  EXPECT_THAT(ErrorOf("x = "), HasSubstr("skills.toml:1:"));
  const std::string text = Changed("", "");
  EXPECT_THAT(ErrorOf(text + text.substr(text.find("[[run]]"))),
              HasSubstr("count is running already"));
}

TEST_F(Saved, AreNotRestoredOverASkillThatRuns) {
  const std::string text = Changed("", "");
  Manager manager(registry_.All());
  ASSERT_TRUE(manager.Start("wait"));
  EXPECT_THAT(RestoreSnapshot(manager, text, "skills.toml").error().message,
              HasSubstr("while none of them runs"));
  EXPECT_EQ(manager.StateOf("wait"), "WAITING");
}

TEST_F(Saved, TextsThatAreNoTomlAreReported) {
  Manager manager(registry_.All());
  ASSERT_TRUE(manager.Start("count", {{"note", std::string("\xff")}}));
  const Result<std::string> text = WriteSnapshot(manager.Save().value());
  ASSERT_FALSE(text);
  EXPECT_EQ(text.error().message,
            "the skills: note cannot be saved: it is not UTF-8, or has a NUL");
}

}  // namespace musher::skill::snapshot_test
