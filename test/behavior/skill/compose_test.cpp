#include "musher/behavior/skill/compose.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "musher/behavior/fsm/graph.hpp"
#include "musher/behavior/skill/wait.hpp"
#include "musher/test/behavior/skill/skills.hpp"

namespace musher::skill::compose_test {

using testing::CompletesAfter;
using ::testing::HasSubstr;
using testing::InExecuting;
using testing::Script;
using testing::Scripted;

class AComposition : public ::testing::Test {
 protected:
  AComposition() {
    for (std::size_t i = 0; i < kNames.size(); ++i) {
      EXPECT_TRUE(registry_.Add<Scripted>(kNames[i], scripts_[i]));
      scripts_[i].step = InExecuting([](Tick&) { return Next::Stay(); });
    }
  }
  void Start(Order order, const std::vector<Part>& parts, const Values& parameters = {}) {
    const Result<> added = registry_.Add("all", Compose(order, registry_, parts));
    ASSERT_TRUE(added) << added.error().message;
    manager_ = std::make_unique<Manager>(registry_.All());
    const Result<> started = manager_->Start("all", parameters);
    ASSERT_TRUE(started) << started.error().message;
  }
  std::string ErrorOf(Order order, const std::vector<Part>& parts) {
    const Result<> added = registry_.Add("all", Compose(order, registry_, parts));
    return added ? "" : added.error().message;
  }
  std::string After(int steps) {
    for (int i = 0; i < steps; ++i) manager_->RunOnce(now_ += Milliseconds(100));
    return manager_->Find("all")->Path();
  }
  const Feedback& feedback() const { return manager_->Find("all")->feedback(); }
  const skill::Run& part(std::size_t i) const { return *manager_->Find("all")->inside()[i]; }

  static constexpr std::array<const char*, 3> kNames{"a", "b", "c"};
  std::array<Script, 3> scripts_;
  Registry registry_;
  std::unique_ptr<Manager> manager_;
  Time now_{};
};

TEST_F(AComposition, RunsSkillsInOrder) {
  scripts_[0].step = CompletesAfter(2);
  scripts_[1].step = CompletesAfter(2);
  Start(Order::kInOrder, {{"a"}, {"b"}});
  EXPECT_EQ(After(1), "RUNNING/a/EXECUTING");
  EXPECT_EQ(After(1), "RUNNING/a/EXECUTING");
  EXPECT_EQ(feedback().progress, 25);
  EXPECT_EQ(feedback().message, "a: step 1");
  EXPECT_EQ(After(1), "RUNNING/b/INITIALIZING");
  EXPECT_EQ(feedback().progress, 50);
  EXPECT_EQ(After(3), "SUCCEEDED");
  EXPECT_EQ(ToText(feedback()), "completed: Completed (100%)");
}

TEST_F(AComposition, FailsWithTheFirstFailureInOrderAndDoesNotBeginTheNext) {
  scripts_[0].step = InExecuting([](Tick&) { return Next::Fail("no path"); });
  Start(Order::kInOrder, {{"a"}, {"b"}});
  EXPECT_EQ(After(2), "FAILED");
  EXPECT_EQ(feedback().message, "a: failed: no path");
  EXPECT_EQ(part(1).state(), kIdle);
}

TEST_F(AComposition, RunsTheSameSkillTwiceInOrder) {
  scripts_[0].step = InExecuting([](Tick&) { return Next::Succeed(); });
  Start(Order::kInOrder, {{"a", {{"speed", 1.0}}}, {"a"}}, {{"a_2.speed", 2.0}});
  EXPECT_EQ(After(4), "SUCCEEDED");
  EXPECT_EQ(part(0).parameters().Number("speed"), 1.0);
  EXPECT_EQ(part(1).parameters().Number("speed"), 2.0);
}

TEST_F(AComposition, CompletesInParallelWithTheLast) {
  scripts_[0].step = CompletesAfter(1);
  scripts_[1].step = CompletesAfter(4);
  Start(Order::kParallel, {{"a"}, {"b"}});
  EXPECT_EQ(After(1), "RUNNING/[a/EXECUTING, b/EXECUTING]");
  EXPECT_EQ(After(1), "RUNNING/b/EXECUTING");
  EXPECT_EQ(feedback().progress, 62);
  EXPECT_EQ(After(3), "SUCCEEDED");
}

TEST_F(AComposition, CancelsTheOthersInParallelWhenOneFails) {
  scripts_[0].step = InExecuting([](Tick&) { return Next::Fail("no path"); });
  scripts_[1].cancel = [](Tick&) { return Next::Stay(); };
  scripts_[1].step = InExecuting([](Tick& tick) {
    return tick.cancelling && tick.elapsed >= Milliseconds(300) ? Next::Cancelled() : Next::Stay();
  });
  Start(Order::kParallel, {{"a"}, {"b"}});
  EXPECT_EQ(After(2), "STOPPING/b/EXECUTING");
  EXPECT_EQ(After(2), "FAILED");
  EXPECT_EQ(feedback().message, "a: failed: no path");
  EXPECT_EQ(part(1).feedback().status, Status::kCancelled);
}

TEST_F(AComposition, CompletesWithTheFirstToFinishAndCancelsTheOthers) {
  scripts_[0].step = InExecuting([](Tick&) { return Next::Fail("no path"); });
  scripts_[1].step = CompletesAfter(3);
  Start(Order::kFirstToFinish, {{"a"}, {"b"}, {"c"}});
  EXPECT_EQ(After(2), "RUNNING/[b/EXECUTING, c/EXECUTING]") << "a failure does not end it";
  EXPECT_EQ(After(2), "STOPPING/c/EXECUTING");
  EXPECT_EQ(After(1), "SUCCEEDED");
  EXPECT_EQ(feedback().message, "b: completed: done");
  EXPECT_EQ(part(2).feedback().status, Status::kCancelled);
}

TEST_F(AComposition, FailsWhenNoneFinishes) {
  for (Script& script : scripts_) {
    script.step = InExecuting([](Tick&) { return Next::Fail("no"); });
  }
  Start(Order::kFirstToFinish, {{"a"}, {"b"}});
  EXPECT_EQ(After(2), "FAILED");
  EXPECT_EQ(feedback().message, "a: failed: no; b: failed: no");
}

TEST_F(AComposition, CancelsAllSkillsInsideAndEndsWithTheLast) {
  for (const Order order : {Order::kInOrder, Order::kParallel, Order::kFirstToFinish}) {
    AComposition::TearDown();
    registry_ = Registry();
    for (std::size_t i = 0; i < kNames.size(); ++i) {
      ASSERT_TRUE(registry_.Add<Scripted>(kNames[i], scripts_[i]));
    }
    Start(order, {{"a"}, {"b"}});
    After(2);
    ASSERT_TRUE(manager_->Cancel("all", "a person"));
    After(2);
    EXPECT_EQ(ToText(feedback()), "cancelled: a person (0%)");
    EXPECT_FALSE(part(0).running() || part(1).running());
  }
}

TEST_F(AComposition, ReportsAFailureWithinItsCancellation) {
  scripts_[0].cancel = [](Tick&) { return Next::Fail("stuck"); };
  Start(Order::kInOrder, {{"a"}, {"b"}});
  After(1);
  ASSERT_TRUE(manager_->Cancel("all", ""));
  EXPECT_EQ(After(2), "FAILED");
  EXPECT_EQ(feedback().message, "a: failed: stuck");
}

TEST_F(AComposition, EndsEverySkillInsideAtOnce) {
  Start(Order::kParallel, {{"a"}, {"b"}});
  After(1);
  manager_->CancelAllNow("emergency stop");
  EXPECT_EQ(part(0).state(), kCancelled);
  EXPECT_EQ(part(1).state(), kCancelled);
  EXPECT_THAT(part(0).feedback().message, HasSubstr("emergency stop"));
}

TEST_F(AComposition, PausesTheSkillsInside) {
  Start(Order::kParallel, {{"a"}, {"b"}});
  After(1);
  manager_->Pause();
  now_ += std::chrono::hours(3);
  After(3);
  EXPECT_THAT(scripts_[0].log, ::testing::ElementsAre("OnPause", "OnResume"));
  EXPECT_EQ(ToMilliseconds(part(0).now()), 200);
}

TEST_F(AComposition, ShowsASkillInsideThatFailsInAPause) {
  scripts_[0].throws = {{"OnPause", "no brake"}};
  Start(Order::kParallel, {{"a"}, {"b"}});
  After(1);
  manager_->Pause();
  EXPECT_EQ(feedback().state, "RUNNING/b/EXECUTING");
  EXPECT_EQ(After(2), "FAILED");
  EXPECT_EQ(feedback().message, "a: failed: OnPause: no brake");
}

TEST_F(AComposition, HoldsItsSkillsForItself) {
  Start(Order::kInOrder, {{"a"}, {"b"}});
  After(1);
  EXPECT_EQ(manager_->Start("b").error().message, "b is running already, as a part of all");
  ASSERT_TRUE(manager_->Reset("all"));
  ASSERT_TRUE(manager_->Start("b"));
  EXPECT_EQ(manager_->Start("all").error().message, "b is running already; all needs it");
}

TEST_F(AComposition, UsesThePartsOfTheRobotThatItsSkillsUse) {
  scripts_[0].uses = {"base"};
  scripts_[1].uses = {"base"};
  scripts_[2].uses = {"camera"};
  EXPECT_EQ(ErrorOf(Order::kParallel, {{"a"}, {"b"}}),
            "all: a and b would use the base at the same time");
  EXPECT_EQ(ErrorOf(Order::kFirstToFinish, {{"a"}, {"b"}}),
            "all: a and b would use the base at the same time");
  Start(Order::kInOrder, {{"a"}, {"c"}});
  const Result<> beside = manager_->Start("b");
  ASSERT_FALSE(beside.ok());
  EXPECT_EQ(beside.error().message,
            "b needs the base, which all is using; cancel all first or wait for its end");
}

TEST_F(AComposition, IsRefusedWithWhatIsWrongWithIt) {
  EXPECT_EQ(ErrorOf(Order::kParallel, {{"a"}, {"a"}}), "all: a would run twice at once");
  EXPECT_THAT(ErrorOf(Order::kInOrder, {}), HasSubstr("all: has no skills"));
  EXPECT_EQ(ErrorOf(Order::kInOrder, {{"a"}, {"walk"}}),
            "all: there is no skill 'walk'; there are a, b and c");
  EXPECT_EQ(ErrorOf(Order::kInOrder, {{"a", {{"sped", 1.0}}}}),
            "all: a: there is no parameter sped; did you mean 'speed'?");
}

// One of its skills in turn with another one, and the other way round.
TEST_F(AComposition, MayRunASkillTwiceInOrderBesideAnother) {
  ASSERT_TRUE(registry_.Add("twice", Compose(Order::kInOrder, registry_, {{"a"}, {"a"}})));
  ASSERT_TRUE(registry_.Add("beside", Compose(Order::kParallel, registry_, {{"twice"}, {"b"}})));
  const Result<> added =
      registry_.Add("both", Compose(Order::kParallel, registry_, {{"beside"}, {"a"}}));
  ASSERT_FALSE(added.ok());
  EXPECT_EQ(added.error().message, "both: a would run twice at once");
}

TEST_F(AComposition, RunsCompositions) {
  scripts_[0].step = scripts_[1].step = scripts_[2].step = CompletesAfter(1);
  ASSERT_TRUE(registry_.Add("both", Compose(Order::kParallel, registry_, {{"a"}, {"b"}})));
  Start(Order::kInOrder, {{"both"}, {"c"}}, {{"both.a.speed", 3.0}});
  EXPECT_EQ(After(1), "RUNNING/both/RUNNING/[a/EXECUTING, b/EXECUTING]");
  EXPECT_EQ(part(0).inside()[0]->parameters().Number("speed"), 3.0);
  EXPECT_EQ(manager_->Start("a").error().message, "a is running already, as a part of all");
  EXPECT_EQ(After(6), "SUCCEEDED");
}

TEST_F(AComposition, IsDrawnWithTheSkillsInside) {
  ASSERT_TRUE(registry_.Add("wait", Wait()));
  Start(Order::kInOrder, {{"wait"}, {"a"}});
  After(1);
  const skill::Run& run = *manager_->Find("all");
  const std::string picture = fsm::ToMermaid(run.chart(), run.Path());
  EXPECT_THAT(picture, HasSubstr("state \"WAITING\" as s4_0_4\n"));
  EXPECT_THAT(picture, HasSubstr("s4_0 --> s4_1 : completed\n"));
  EXPECT_THAT(picture, HasSubstr("class s4_0_4 present\n"));
}

TEST(AWait, LastsAsLongAsItsParameterSays) {
  Registry registry;
  ASSERT_TRUE(registry.Add("wait", Wait()));
  Manager manager(registry.All());
  ASSERT_TRUE(manager.Start("wait", {{"duration_s", 2.0}}));
  Time now{};
  manager.RunOnce(now);
  manager.RunOnce(now += Milliseconds(500));
  EXPECT_EQ(ToText(manager.Find("wait")->feedback()), "processing: Waiting (25%)");
  EXPECT_EQ(manager.Find("wait")->feedback().details.Number("left_s"), 1.5);
  manager.RunOnce(now += Milliseconds(1500));
  EXPECT_EQ(manager.StateOf("wait"), "SUCCEEDED");
  ASSERT_TRUE(manager.Start("wait", {{"duration_s", -1.0}}));
  manager.RunOnce(now);
  EXPECT_EQ(manager.StateOf("wait"), "FAILED");
}

}  // namespace musher::skill::compose_test
