#include "musher/behavior/skill/run.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/test/behavior/skill/skills.hpp"

namespace musher::skill::run_test {

using testing::CompletesAfter;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::InExecuting;
using testing::kExecuting;
using testing::kInitializing;
using testing::Script;
using testing::Scripted;

class ARun : public ::testing::Test {
 protected:
  skill::Run& Begun() {
    run_ = std::make_unique<skill::Run>("walk", std::make_unique<Scripted>(script_));
    const Result<> begun = run_->Begin({});
    EXPECT_TRUE(begun) << begun.error().message;
    return *run_;
  }
  void Steps(int count, Duration step = Milliseconds(100)) {
    for (int i = 0; i < count; ++i) run_->Step(step);
  }
  std::string Shown() const { return run_->feedback().state + " " + ToText(run_->feedback()); }
  std::vector<std::string> Changes() const {
    std::vector<std::string> lines;
    for (std::size_t i = 0; i < run_->history().size(); ++i) {
      const Change& change = run_->history()[i];
      lines.push_back(std::string(run_->table().Name(change.to)) + " " +
                      std::string(Name(change.cause)));
    }
    return lines;
  }

  Script script_;
  std::unique_ptr<skill::Run> run_;
};

TEST_F(ARun, GoesFromItsRequestToItsSuccessAndStaysThere) {
  script_.step = CompletesAfter(3);
  skill::Run& run = Begun();
  EXPECT_EQ(run.state(), kInitializing);
  Steps(2);
  EXPECT_EQ(Shown(), "EXECUTING processing: step 1 (33%)");
  Steps(2);
  EXPECT_EQ(Shown(), "SUCCEEDED completed: done (100%)");
  EXPECT_THAT(Changes(),
              ElementsAre("INITIALIZING requested", "EXECUTING decided", "SUCCEEDED decided"));
  const Feedback last = run.feedback();
  Steps(20, std::chrono::hours(1));
  run.Cancel("too late");
  run.CancelNow("too late");
  run.Pause();
  Steps(1);
  EXPECT_EQ(run.feedback(), last);
  EXPECT_FALSE(run.Begin({})) << "each request has a run of its own";
  EXPECT_THAT(script_.log, ElementsAre("OnEnd completed"));
  EXPECT_THAT(run.errors().size(), 0U);
}

TEST_F(ARun, PassesTheTimeInTheRunAndInTheStateButNoneBeforeItsFirstStep) {
  std::vector<std::int64_t> times;
  script_.step = InExecuting([&](Tick& tick) {
    times = {ToMilliseconds(tick.now), ToMilliseconds(tick.step), ToMilliseconds(tick.elapsed)};
    return Next::Stay();
  });
  Begun();
  Steps(1, std::chrono::hours(7));
  Steps(3);
  EXPECT_THAT(times, ElementsAre(300, 100, 300));
  Steps(1, -Milliseconds(900));
  EXPECT_THAT(times, ElementsAre(300, 0, 300)) << "time that runs back is no time";
  run_->Pause();
  Steps(1, std::chrono::hours(7));
  EXPECT_THAT(times, ElementsAre(300, 0, 300)) << "nor is a pause";
}

TEST_F(ARun, KnowsTheFirstStepInAState) {
  std::string entered;
  script_.step = [&](Tick& tick) {
    entered += tick.entered ? "1" : "0";
    if (tick.state == kInitializing) return Next::To(kExecuting);
    return entered.size() == 4 ? Next::Replan(kExecuting, "moved") : Next::Stay();
  };
  Begun();
  Steps(6);
  EXPECT_EQ(entered, "110010");
}

TEST_F(ARun, FailsWithTheReasonOfTheSkill) {
  script_.step = InExecuting([](Tick&) { return Next::Fail("no path"); });
  Begun();
  Steps(2);
  EXPECT_EQ(Shown(), "FAILED failed: no path (0%)");
  ASSERT_EQ(run_->errors().size(), 1U);
  EXPECT_EQ(run_->errors()[0], (Failure{Milliseconds(100), "EXECUTING", "no path"}));
  EXPECT_THAT(script_.log, ElementsAre("OnEnd failed"));
}

TEST_F(ARun, FailsWhenASkillThrows) {
  script_.step = [](Tick&) -> Next { throw std::runtime_error("no map"); };
  Begun();
  Steps(1);
  EXPECT_EQ(Shown(), "FAILED failed: Step: no map (0%)");
  script_.step = [](Tick&) -> Next { throw 7; };
  Begun();
  Steps(1);
  EXPECT_THAT(Shown(), HasSubstr("threw something that is not a std::exception"));
}

TEST_F(ARun, FailsByATransitionThatIsNotDeclared) {
  script_.step = [](Tick&) { return Next::Succeed("already"); };
  Begun();
  Steps(1);
  EXPECT_EQ(
      Shown(),
      "FAILED failed: it has not declared its transition from INITIALIZING to SUCCEEDED (0%)");
  for (const Next& next : {Next::To(StateId{99}), Next::To(kIdle), Next::To(kSucceeded),
                           Next::Retry(kInitializing, "x"), Next::Replan(StateId{99}, "x")}) {
    script_.step = [&](Tick&) { return next; };
    Begun();
    Steps(1);
    EXPECT_EQ(run_->state(), kFailed);
    EXPECT_THAT(Changes(), Contains("FAILED fault"));
  }
  script_.step = InExecuting([](Tick&) { return Next::To(kSucceeded); });
  Begun();
  Steps(2);
  EXPECT_EQ(run_->state(), kFailed) << "only Succeed() succeeds";
}

TEST_F(ARun, RetriesUpToItsLimitAndKeepsTheErrors) {
  script_.step = InExecuting([](Tick&) { return Next::Retry(kInitializing, "slipped"); });
  Begun();
  Steps(2);
  EXPECT_EQ(Shown(), "INITIALIZING processing: Retrying (1/2) (0%)");
  Steps(20);
  EXPECT_EQ(Shown(), "FAILED failed: gives up after 2 retries: slipped (0%)");
  EXPECT_EQ(run_->retries(), 2);
  EXPECT_EQ(run_->errors().size(), 4U) << "three slips, and the end";
  EXPECT_EQ(run_->errors()[0].what, "slipped");
}

TEST_F(ARun, ReplansWithoutCounting) {
  script_.step = InExecuting([](Tick& tick) {
    return tick.replans < 50 ? Next::Replan(kExecuting, "blocked") : Next::Succeed();
  });
  Begun();
  Steps(60, Milliseconds(1));
  EXPECT_EQ(run_->state(), kSucceeded);
  EXPECT_EQ(run_->replans(), 50);
  EXPECT_EQ(run_->retries(), 0);
}

TEST_F(ARun, ReplansForEverOnlyUntilItsTimeIsOver) {
  script_.step = InExecuting([](Tick&) { return Next::Replan(kExecuting, "blocked"); });
  Begun();
  Steps(102);
  EXPECT_EQ(Shown(), "FAILED failed: not done after 10 s (0%)");
}

TEST_F(ARun, FailsWhenItsStateTakesTooLong) {
  script_.step = InExecuting([](Tick&) { return Next::Stay(); });
  Begun();
  Steps(10);
  EXPECT_EQ(run_->state(), kExecuting);
  Steps(1);
  EXPECT_EQ(Shown(), "FAILED failed: not done after 1 s (0%)");
  EXPECT_THAT(Changes(), Contains("FAILED limit"));
}

TEST_F(ARun, LetsTheSkillDecideAtTheLimitOfAState) {
  script_.step = InExecuting([](Tick&) { return Next::Stay(); });
  script_.on_limit = [](Tick&) { return Next::Retry(kInitializing, "slow"); };
  Begun();
  Steps(11);
  EXPECT_EQ(run_->state(), kInitializing);
  EXPECT_EQ(run_->retries(), 1);
}

TEST_F(ARun, TakesAResultThatIsThereInTheStepInWhichItsTimeIsOver) {
  script_.step = InExecuting([](Tick& tick) {
    return tick.elapsed > Duration{} ? Next::Succeed("in time") : Next::Stay();
  });
  Begun();
  Steps(2);
  Steps(1, std::chrono::hours(24));
  EXPECT_EQ(run_->state(), kSucceeded) << "the clock jumped, the robot is there";
}

TEST_F(ARun, IsCancelledInEveryState) {
  for (int steps = 0; steps < 2; ++steps) {
    script_ = Script{};
    script_.step = InExecuting([](Tick&) { return Next::Stay(); });
    Begun();
    Steps(steps);
    run_->Cancel("by a person");
    EXPECT_TRUE(run_->running()) << "until the next step";
    Steps(1);
    EXPECT_EQ(Shown(), "CANCELLED cancelled: by a person (0%)");
    EXPECT_THAT(script_.log, ElementsAre("Cancel", "OnEnd cancelled"));
  }
}

TEST_F(ARun, IsCancelledInAnOrderlyWayWhereTheSkillWantsItAndNeverSucceedsAfterwards) {
  script_.step = InExecuting([](Tick& tick) {
    return tick.cancelling && tick.elapsed >= Milliseconds(500) ? Next::Succeed("there anyway")
                                                                : Next::Stay();
  });
  script_.cancel = [](Tick&) { return Next::Stay(); };
  Begun();
  Steps(2);
  run_->Cancel("by a person");
  run_->Cancel("once more");
  Steps(3);
  EXPECT_TRUE(run_->cancelling());
  Steps(1);
  EXPECT_EQ(Shown(), "CANCELLED cancelled: by a person (0%)");
  EXPECT_THAT(script_.log, ElementsAre("Cancel", "OnEnd cancelled")) << "called once";
}

TEST_F(ARun, EndsACancellationThatTakesTooLong) {
  script_.cancel = [](Tick&) { return Next::Stay(); };
  Begun();
  Steps(1);
  run_->Cancel("by a person");
  Steps(19);
  EXPECT_TRUE(run_->running());
  Steps(1);
  EXPECT_EQ(Shown(), "CANCELLED cancelled: its cancellation was not done after 2 s (0%)");
}

TEST_F(ARun, ReportsAFailureDuringACancellationAsAFailure) {
  script_.cancel = [](Tick&) { return Next::Fail("the gripper is stuck"); };
  Begun();
  run_->Cancel("by a person");
  Steps(1);
  EXPECT_EQ(Shown(), "FAILED failed: the gripper is stuck (0%)");
}

TEST_F(ARun, DoesNotRetryDuringACancellation) {
  script_.step = InExecuting([](Tick&) { return Next::Retry(kInitializing, "slipped"); });
  script_.cancel = [](Tick&) { return Next::Stay(); };
  Begun();
  Steps(1);
  run_->Cancel("");
  Steps(2);
  EXPECT_EQ(Shown(), "CANCELLED cancelled: no reason was given (0%)");
  EXPECT_EQ(run_->errors()[0].what, "slipped");
}

TEST_F(ARun, EndsAtOnceWhereThatIsAsked) {
  Begun();
  run_->CancelNow("emergency stop");
  EXPECT_EQ(Shown(), "CANCELLED cancelled: emergency stop (0%)");
  EXPECT_THAT(script_.log, ElementsAre("OnEnd cancelled"));
}

TEST_F(ARun, IsNoSuccessWhenItsEndFails) {
  script_.step = CompletesAfter(1);
  script_.throws = {{"OnEnd", "the motor does not stop"}};
  Begun();
  Steps(2);
  EXPECT_EQ(Shown(), "FAILED failed: OnEnd: the motor does not stop (99%)");
}

TEST_F(ARun, KeepsTheReasonOfItsFailureWhenItsEndFailsToo) {
  script_.step = [](Tick&) { return Next::Fail("no path"); };
  script_.throws = {{"OnEnd", "the motor does not stop"}};
  Begun();
  Steps(1);
  EXPECT_EQ(run_->feedback().message, "no path");
  EXPECT_EQ(run_->errors()[0].what, "OnEnd: the motor does not stop");
}

TEST_F(ARun, PassesAPauseToTheSkillOnce) {
  Begun();
  Steps(1);
  run_->Pause();
  run_->Pause();
  Steps(2);
  EXPECT_THAT(script_.log, ElementsAre("OnPause", "OnResume"));
  script_.throws = {{"OnPause", "no brake"}};
  run_->Pause();
  EXPECT_EQ(Shown(), "FAILED failed: OnPause: no brake (0%)");
}

TEST_F(ARun, ReportsThatItIsPaused) {
  script_.step = InExecuting([](Tick& tick) {
    tick.Report(30, "Moving");
    return Next::Stay();
  });
  Begun();
  Steps(2);
  run_->Pause();
  EXPECT_EQ(ToText(run_->feedback()), "processing: paused: Moving (30%)");
  Steps(1);
  EXPECT_EQ(ToText(run_->feedback()), "processing: Moving (30%)");
  run_->Pause();
  run_->CancelNow("a person");
  EXPECT_EQ(ToText(run_->feedback()), "cancelled: a person (30%)");
}

TEST_F(ARun, MovesProgressIntoItsRange) {
  const std::vector<std::pair<double, int>> reported{{-5, 0},     {41.9, 41},         {100, 99},
                                                     {1e300, 99}, {std::nan(""), 99}, {7, 7}};
  for (const auto& [progress, shown] : reported) {
    const double percent = progress;
    script_.step = [percent](Tick& tick) {
      tick.Report(percent, "walking");
      return Next::Stay();
    };
    if (!run_) Begun();
    Steps(1, {});
    EXPECT_EQ(run_->feedback().progress, shown) << progress;
  }
}

TEST_F(ARun, KeepsItsMessageAndDropsItsDetailsWithTheNextStep) {
  script_.step = [](Tick& tick) {
    if (tick.entered) {
      tick.Report(10, "walking");
      tick.Detail("distance_to_goal", 5.2);
    }
    return Next::Stay();
  };
  Begun();
  Steps(1);
  EXPECT_EQ(run_->feedback().details.Number("distance_to_goal"), 5.2);
  Steps(1);
  EXPECT_TRUE(run_->feedback().details.empty());
  EXPECT_EQ(run_->feedback().message, "walking");
}

TEST_F(ARun, RefusesInvalidParametersBeforeItBegins) {
  skill::Run run("walk", std::make_unique<Scripted>(script_));
  const Result<> begun = run.Begin({{"sped", 1.0}, {"goal", 3.0}});
  EXPECT_EQ(begun.error().message,
            "walk: there is no parameter sped; did you mean 'speed'?\n"
            "parameter goal: expected a list of numbers, found 3");
  EXPECT_EQ(run.state(), kIdle);
  EXPECT_EQ(run.feedback().state, "IDLE");
}

TEST_F(ARun, DoesNotBeginWithATableThatHasErrors) {
  const auto endless = [](Table& table) { table.State("A"); };
  const auto stay = [](Tick&) { return Next::Stay(); };
  skill::Run run("x", std::make_unique<StepFunction>(endless, stay));
  EXPECT_FALSE(run.built());
  EXPECT_EQ(run.Begin({}).error().message, "x: A: no declared transitions lead from it to an end");
  script_.throws = {{"Declare", "no robot"}};
  skill::Run throws("y", std::make_unique<Scripted>(script_));
  EXPECT_EQ(throws.Begin({}).error().message, "y: Declare: no robot");
}

TEST_F(ARun, KeepsTheDataOfAStepFunctionApartFromItsState) {
  const auto declare = [](Table& table) { table.To(table.State("COUNTING"), kSucceeded, "3"); };
  const auto count = [](Tick& tick) {
    const auto counted = tick.data.Get<std::int64_t>("count", 0) + 1;
    tick.data.Set("count", counted);
    return counted == 3 ? Next::Succeed() : Next::Stay();
  };
  skill::Run first("count", std::make_unique<StepFunction>(declare, count));
  skill::Run second("count", std::make_unique<StepFunction>(declare, count));
  ASSERT_TRUE(first.Begin({}) && second.Begin({}));
  for (int i = 0; i < 3; ++i) first.Step({});
  EXPECT_EQ(first.state(), kSucceeded);
  EXPECT_TRUE(second.running());
}

}  // namespace musher::skill::run_test
