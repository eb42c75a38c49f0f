// The arm and the spear, pure, in virtual time.

#include "musher/modules/meilin/servers/tool.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <vector>

namespace musher::meilin::servers::tool_test {

class ToolTest : public ::testing::Test {
 protected:
  std::optional<Tool::End> After(std::int64_t ms) {
    now_ += Milliseconds(ms);
    return arm_.Update(now_);
  }

  Tool arm_{ArmKind(), Milliseconds(10'000)};
  Time now_{Milliseconds(1000)};
};

TEST_F(ToolTest, IsDoneWhenTheHardwareReportsIt) {
  arm_.OnReport(0);
  arm_.Begin(1, 0, now_);
  EXPECT_TRUE(arm_.running());
  EXPECT_FALSE(After(1000));
  arm_.OnReport(1);
  const auto end = After(10);
  ASSERT_TRUE(end);
  EXPECT_TRUE(end->success);
  EXPECT_EQ(end->message, "Arm command 1 done");
  EXPECT_EQ(arm_.state(), 10);
  EXPECT_EQ(arm_.Progress(now_), 1);
  EXPECT_TRUE(arm_.idle_and_well());
}

TEST_F(ToolTest, TakesNoOldDoneForItsOwn) {
  arm_.OnReport(1);
  arm_.Begin(2, 0, now_);
  arm_.OnReport(1);
  EXPECT_FALSE(After(100)) << "the done of the command before";
  arm_.OnReport(0);
  EXPECT_FALSE(After(100));
  arm_.OnReport(1);
  EXPECT_TRUE(After(100));
}

TEST_F(ToolTest, IsDoneAtTheFirstReportOfAHardwareThatHasReportedNothing) {
  arm_.Begin(3, 0, now_);
  arm_.OnReport(1);
  EXPECT_TRUE(After(100));
}

TEST_F(ToolTest, DoesNotTakeOtherNumbersForADone) {
  arm_.Begin(3, 0, now_);
  for (const double report : {0.5, 2.0, -1.0, 0.99}) arm_.OnReport(report);
  EXPECT_FALSE(After(100));
}

TEST_F(ToolTest, EndsAtTheLimitOfTheGoalOrAtItsOwn) {
  arm_.Begin(1, 2.5, now_);
  EXPECT_FALSE(After(2490));
  auto end = After(10);
  ASSERT_TRUE(end);
  EXPECT_FALSE(end->success);
  EXPECT_EQ(end->message, "Timeout");
  EXPECT_EQ(arm_.state(), -1);
  EXPECT_FALSE(arm_.idle_and_well());
  arm_.Begin(1, -3, now_);
  EXPECT_FALSE(After(9990));
  EXPECT_TRUE(After(10));
}

TEST_F(ToolTest, ReportsItsProgressByTheExpectedTime) {
  arm_.Begin(3, 0, now_);  // 1.5 s
  EXPECT_EQ(arm_.Progress(now_), 0);
  After(750);
  EXPECT_NEAR(arm_.Progress(now_), 0.5, 1e-9);
  After(5000);
  EXPECT_NEAR(arm_.Progress(now_), 0.99, 1e-9) << "not done";
}

TEST_F(ToolTest, IsDoneWithIdleAtOnce) {
  arm_.Begin(0, 0, now_);
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
  arm_.Begin(1, 0, now_);
  arm_.Stop();
  EXPECT_FALSE(arm_.running());
  EXPECT_EQ(arm_.state(), -1);
  arm_.OnReport(0);
  arm_.OnReport(1);
  EXPECT_FALSE(After(100));
  EXPECT_FALSE(arm_.idle_and_well());
}

RC_GTEST_PROP(ToolProperty, EndsWithinItsLimitAndOnlyByANewDone,
              (const std::vector<bool>& reports)) {
  Tool spear(SpearKind(), Milliseconds(5000));
  Time now{Milliseconds(1000)};
  const bool before = *rc::gen::arbitrary<bool>();
  spear.OnReport(before ? 1 : 0);
  spear.Begin(2, 1, now);
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
