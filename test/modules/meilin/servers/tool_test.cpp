// The arm and the spear, pure, in virtual time.

#include "musher/modules/meilin/servers/tool.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <vector>

namespace musher::meilin::servers::tool_test {

class ToolTest : public ::testing::Test {
 protected:
  void Begin(std::uint8_t command, double limit_s) {
    arm_.Begin(command, limit_s, now_);
    EXPECT_TRUE(arm_.TakeDue(now_));
    EXPECT_FALSE(arm_.TakeDue(now_)) << "it is sent once";
  }
  std::optional<Tool::End> After(std::int64_t ms) {
    now_ += Milliseconds(ms);
    return arm_.Update(now_);
  }

  Tool arm_{ArmKind(), Milliseconds(10'000)};
  Time now_{Milliseconds(1000)};
};

TEST_F(ToolTest, IsDoneWhenTheHardwareReportsIt) {
  arm_.OnReport(0);
  Begin(1, 0);
  EXPECT_TRUE(arm_.running());
  EXPECT_FALSE(After(1000));
  arm_.OnReport(1);
  const auto end = After(10);
  ASSERT_TRUE(end);
  EXPECT_TRUE(end->success);
  EXPECT_EQ(end->message, "Arm command 1 done");
  EXPECT_EQ(arm_.state(), 10);
  EXPECT_EQ(arm_.Progress(now_), 1);
  EXPECT_TRUE(arm_.IsIdleAndWell(now_));
}

TEST_F(ToolTest, TakesNoOldDoneForItsOwn) {
  arm_.OnReport(1);
  Begin(2, 0);
  arm_.OnReport(1);
  EXPECT_FALSE(After(100)) << "the done of the command before";
  arm_.OnReport(0);
  EXPECT_FALSE(After(100));
  arm_.OnReport(1);
  EXPECT_TRUE(After(100));
}

// It may be that of a command of a process before this one: the hardware repeats its last report.
TEST_F(ToolTest, TakesNoDoneOfAHardwareThatHasReportedNothingBefore) {
  Begin(3, 0);
  arm_.OnReport(1);
  EXPECT_FALSE(After(100));
  arm_.OnReport(0);
  arm_.OnReport(1);
  EXPECT_TRUE(After(100));
}

// The command of the process before ended while the first one of this process was under way.
TEST_F(ToolTest, SendsItsFirstCommandOnceTheHardwareHasSettled) {
  EXPECT_FALSE(arm_.IsIdleAndWell(now_));
  arm_.OnReport(0);  // it still works
  arm_.AwaitIdle(now_);
  arm_.Begin(1, 0, now_);
  EXPECT_FALSE(arm_.TakeDue(now_));
  arm_.OnReport(1);
  EXPECT_TRUE(arm_.TakeDue(now_));
  arm_.OnReport(1);
  EXPECT_FALSE(After(100));
  arm_.OnReport(0);
  arm_.OnReport(1);
  EXPECT_TRUE(After(100));
}

TEST_F(ToolTest, IsIdleAndWellWithoutACommandOnceItHasSettled) {
  arm_.AwaitIdle(now_);
  EXPECT_FALSE(arm_.IsIdleAndWell(now_));
  EXPECT_TRUE(arm_.IsIdleAndWell(now_ + Tool::kSettle)) << "of which no done is reported";
  arm_.OnReport(1);
  EXPECT_FALSE(arm_.IsIdleAndWell(now_)) << "an old one is repeated";
  arm_.OnReport(0);
  arm_.OnReport(1);
  EXPECT_TRUE(arm_.IsIdleAndWell(now_));
}

TEST_F(ToolTest, DoesNotTakeOtherNumbersForADone) {
  Begin(3, 0);
  for (const double report : {0.5, 2.0, -1.0, 0.99}) arm_.OnReport(report);
  EXPECT_FALSE(After(100));
}

TEST_F(ToolTest, EndsAtTheLimitOfTheGoalOrAtItsOwn) {
  Begin(1, 2.5);
  EXPECT_FALSE(After(2490));
  auto end = After(10);
  ASSERT_TRUE(end);
  EXPECT_FALSE(end->success);
  EXPECT_EQ(end->message, "Timeout");
  EXPECT_EQ(arm_.state(), -1);
  EXPECT_FALSE(arm_.IsIdleAndWell(now_ + Tool::kSettle));
  arm_.Begin(1, -3, now_);
  EXPECT_FALSE(After(1000));
  EXPECT_TRUE(arm_.TakeDue(now_));
  EXPECT_FALSE(After(9990));
  EXPECT_TRUE(After(10));
}

// It ended with "Timeout" and was never sent.
TEST_F(ToolTest, CountsAShortLimitFromWhenItIsSentAfterOneThatWasStopped) {
  Begin(1, 0);
  arm_.Stop(now_);
  arm_.Begin(2, 0.5, now_);
  EXPECT_FALSE(arm_.TakeDue(now_)) << "the hardware settles";
  EXPECT_FALSE(After(900));
  EXPECT_FALSE(After(100));
  EXPECT_TRUE(arm_.TakeDue(now_));
  EXPECT_FALSE(After(490));
  EXPECT_TRUE(After(10));
}

TEST_F(ToolTest, ReportsItsProgressByTheExpectedTime) {
  Begin(3, 0);  // 1.5 s
  EXPECT_EQ(arm_.Progress(now_), 0);
  After(750);
  EXPECT_NEAR(arm_.Progress(now_), 0.5, 1e-9);
  After(5000);
  EXPECT_NEAR(arm_.Progress(now_), 0.99, 1e-9) << "not done";
}

TEST_F(ToolTest, IsDoneWithIdleAtOnce) {
  Begin(0, 0);
  const auto end = After(20);
  ASSERT_TRUE(end);
  EXPECT_TRUE(end->success);
}

TEST_F(ToolTest, HasTheStatesOfTheActions) {
  const std::vector<int> arm = {0, 2, 3, 3, 1, 4, 4};
  for (std::size_t i = 0; i < arm.size(); ++i) EXPECT_EQ(ArmKind().commands[i].state, arm[i]);
  const std::vector<int> spear = {0, 1, 2, 5, 6};
  for (std::size_t i = 0; i < spear.size(); ++i) EXPECT_EQ(SpearKind().commands[i].state, spear[i]);
}

TEST_F(ToolTest, StopsWithoutAnEnd) {
  Begin(1, 0);
  arm_.Stop(now_);
  EXPECT_FALSE(arm_.running());
  EXPECT_EQ(arm_.state(), -1);
  arm_.OnReport(0);
  arm_.OnReport(1);
  EXPECT_FALSE(After(100));
  EXPECT_FALSE(arm_.IsIdleAndWell(now_));
}

// A grasp that had timed out was tried again, and "done" was that of the command 0 between them.
TEST_F(ToolTest, TakesNoDoneOfAStopForThatOfTheNextCommand) {
  Begin(1, 0);
  arm_.OnReport(0);
  EXPECT_TRUE(After(10'000)) << "timeout";
  arm_.Begin(1, 0, now_);
  EXPECT_FALSE(arm_.TakeDue(now_));
  arm_.OnReport(1);
  EXPECT_FALSE(After(20));
  EXPECT_TRUE(arm_.TakeDue(now_));
  arm_.OnReport(1);
  EXPECT_FALSE(After(20)) << "it is repeated";
  arm_.OnReport(0);
  arm_.OnReport(1);
  const auto end = After(20);
  ASSERT_TRUE(end);
  EXPECT_TRUE(end->success);
}

// A grasp was sent at once, and "done" was that of the command 0 before it.
TEST_F(ToolTest, TakesNoDoneFromBeforeAStopForThatOfTheStop) {
  arm_.OnReport(1);
  Begin(1, 0);
  arm_.OnReport(1);
  arm_.Stop(now_);
  arm_.Begin(2, 0, now_);
  EXPECT_FALSE(arm_.TakeDue(now_));
  arm_.OnReport(1);
  EXPECT_FALSE(arm_.TakeDue(now_)) << "it is repeated";
  arm_.OnReport(0);
  EXPECT_FALSE(arm_.TakeDue(now_));
  arm_.OnReport(1);
  EXPECT_TRUE(arm_.TakeDue(now_)) << "that is the done of the stop";
  arm_.OnReport(1);
  EXPECT_FALSE(After(20));
}

TEST_F(ToolTest, SendsTheNextCommandSoonAfterAStopOfWhichNoDoneIsReported) {
  Begin(1, 0);
  arm_.Stop(now_);
  arm_.Begin(2, 0, now_);
  EXPECT_FALSE(After(990));
  EXPECT_FALSE(arm_.TakeDue(now_));
  EXPECT_FALSE(After(10));
  EXPECT_TRUE(arm_.TakeDue(now_));
  arm_.Stop(now_);
  arm_.Begin(0, 0, now_);
  EXPECT_TRUE(arm_.TakeDue(now_)) << "a stop does not wait";
}

RC_GTEST_PROP(ToolProperty, EndsWithinItsLimitAndOnlyByANewDone,
              (const std::vector<bool>& reports)) {
  Tool spear(SpearKind(), Milliseconds(5000));
  Time now{Milliseconds(1000)};
  const bool before = *rc::gen::arbitrary<bool>();
  spear.OnReport(before ? 1 : 0);
  spear.Begin(2, 1, now);
  RC_ASSERT(spear.TakeDue(now));
  bool armed = !before;
  bool expected = false;
  std::optional<Tool::End> end;
  for (std::size_t i = 0; !end; ++i) {
    RC_ASSERT(i <= 10U);
    const bool done = i < reports.size() ? reports[i] : false;
    expected = expected || (done && armed);
    armed = armed || !done;
    spear.OnReport(done ? 1 : 0);
    now += Milliseconds(100);
    end = spear.Update(now);
  }
  RC_ASSERT(end->success == expected);
}

}  // namespace musher::meilin::servers::tool_test
