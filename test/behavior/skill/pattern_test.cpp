#include "musher/behavior/skill/pattern.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/behavior/skill/future.hpp"
#include "musher/behavior/skill/run.hpp"

namespace musher::skill::pattern_test {

using ::testing::ElementsAre;

TEST(AFuture, IsDoneWithTheFirstResult) {
  Source<int> source;
  const Future<int> future = source.future();
  EXPECT_FALSE(future.done());
  source.Finish(4);
  source.Fail("too late");
  ASSERT_TRUE(future.done());
  EXPECT_EQ(future.result().value(), 4);
}

TEST(AFuture, FailsWhenItsSourceIsGone) {
  Future<int> future;
  EXPECT_FALSE(future.valid());
  {
    Source<int> source;
    future = source.future();
    Source<int> moved = std::move(source);
    EXPECT_FALSE(future.done());
  }
  ASSERT_TRUE(future.done());
  EXPECT_EQ(future.result().error().message, "the work was abandoned");
}

TEST(AFuture, ShowsItsSourceWhetherItIsWanted) {
  Source<int> source;
  Future<int> future = source.future();
  EXPECT_TRUE(source.wanted());
  future.Drop();
  EXPECT_FALSE(source.wanted());
  Source<int> replaced;
  future = replaced.future();
  replaced = Source<int>();
  EXPECT_FALSE(future.result().ok()) << "an overwritten source has no result either";
}

class Grasp : public PatternSkill {
 public:
  using PatternSkill::Outcome;

  std::vector<std::string> log;
  Outcome execute = Outcome::Continue();
  Outcome prepare = Outcome::Done("planned");

 private:
  void Describe(Table& table) override {
    EXPECT_TRUE(table.SetLimit("PREPARING", std::chrono::seconds(15)));
  }
  Outcome Prepare(Tick&) override { return prepare; }
  Outcome Execute(Tick&) override { return execute; }
  Outcome Finalize(Tick& tick) override {
    log.emplace_back(tick.cancelling ? "opens" : "closes");
    return Outcome::Done();
  }
};

class APattern : public ::testing::Test {
 protected:
  APattern() {
    auto skill = std::make_unique<Grasp>();
    grasp_ = skill.get();
    run_ = std::make_unique<skill::Run>("grasp", std::move(skill));
    EXPECT_TRUE(run_->Begin({}));
  }
  std::string After(int steps) {
    for (int i = 0; i < steps; ++i) run_->Step(Milliseconds(100));
    return run_->Path();
  }

  Grasp* grasp_;
  std::unique_ptr<skill::Run> run_;
};

TEST_F(APattern, GoesThroughItsPhases) {
  EXPECT_EQ(After(0), "INITIALIZING");
  EXPECT_EQ(After(1), "PREPARING");
  EXPECT_EQ(After(1), "EXECUTING");
  EXPECT_EQ(After(5), "EXECUTING");
  grasp_->execute = Grasp::Outcome::Done("held");
  EXPECT_EQ(After(1), "FINALIZING");
  EXPECT_EQ(After(1), "SUCCEEDED");
  EXPECT_THAT(grasp_->log, ElementsAre("closes"));
}

TEST_F(APattern, RetriesFromTheBeginningAndReplansFromThePreparation) {
  After(2);
  grasp_->execute = Grasp::Outcome::Replan("the object moved");
  EXPECT_EQ(After(1), "PREPARING");
  grasp_->execute = Grasp::Outcome::Retry("slipped");
  EXPECT_EQ(After(2), "INITIALIZING");
  EXPECT_EQ(run_->retries(), 1);
  EXPECT_EQ(run_->replans(), 1);
}

TEST_F(APattern, CleansUpWhenItIsCancelledOnceItHasBegun) {
  run_->Cancel("");
  EXPECT_EQ(After(1), "CANCELLED") << "nothing to clean up yet";
  auto skill = std::make_unique<Grasp>();
  grasp_ = skill.get();
  run_ = std::make_unique<skill::Run>("grasp", std::move(skill));
  ASSERT_TRUE(run_->Begin({}));
  After(3);
  run_->Cancel("");
  EXPECT_EQ(After(1), "FINALIZING");
  EXPECT_EQ(After(1), "CANCELLED");
  EXPECT_THAT(grasp_->log, ElementsAre("opens"));
}

TEST_F(APattern, HasTheLimitsThatItsSkillDescribes) {
  grasp_->prepare = Grasp::Outcome::Continue();
  After(1);
  EXPECT_EQ(After(149), "PREPARING");
  EXPECT_EQ(After(1), "FAILED");
}

}  // namespace musher::skill::pattern_test
