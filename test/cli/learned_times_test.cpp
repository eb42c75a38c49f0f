// Limits that are learned from what commands took.

#include "musher/cli/config/learned_times.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/cli/render/times.hpp"

namespace musher::cli::learned_times_test {

using ::testing::HasSubstr;

class Learning : public ::testing::Test {
 protected:
  Learning() {
    ActuatorConfig legs;
    legs.name = "legs";
    legs.states = {State("SetUp"), State("Active")};
    legs.times = {Milliseconds(9000), Milliseconds(5000)};
    config_.actuators = {legs};
    config_.file = "robot.toml";
  }
  // `count` commands that took `took_ms`, one a second.
  void Took(int count, double took_ms, bool overdue = false) {
    for (int i = 0; i < count; ++i) {
      const auto at = static_cast<std::int64_t>(commands_.size()) * 1'000'000'000;
      commands_.push_back({"legs", State("Active"), at, took_ms, overdue});
    }
  }
  LearnedTime Active() const { return LearnTimes(commands_, config_, {}).at(0); }

  MachineConfig config_;
  std::vector<CommandTime> commands_;
};

TEST_F(Learning, ProposesALimitWithAMarginAboveNearlyAll) {
  Took(998, 200);
  Took(2, 400);
  const LearnedTime row = Active();
  EXPECT_EQ(row.median_ms, 200);
  EXPECT_EQ(row.p999_ms, 400);
  EXPECT_EQ(row.proposed_ms, 600);
  EXPECT_EQ(ProposedTimes(config_.actuators[0], {row}), "times = [9000, 600]");
  EXPECT_THAT(TimesText({row}, config_, false),
              HasSubstr("[actuator.legs]\n-times = [9000, 5000]\n+times = [9000, 600]\n"));
}

TEST_F(Learning, SaysHowManyCommandsAreMissingInsteadOfGuessing) {
  Took(99, 200);
  EXPECT_EQ(Active().proposed_ms, std::nullopt);
  EXPECT_EQ(Active().missing, 1U);
  EXPECT_THAT(TimesText({Active()}, config_, false), HasSubstr("1 more command needed"));
}

TEST_F(Learning, LeavesALimitThatIsNearlyRight) {
  Took(200, 3000);
  EXPECT_EQ(Active().proposed_ms, std::nullopt) << "4500 beside 5000";
}

TEST_F(Learning, RaisesALimitThatIsClose) {
  Took(200, 4800);
  EXPECT_EQ(Active().proposed_ms, 7200);
}

TEST_F(Learning, NeverLowersALimitThatWasExceeded) {
  Took(200, 200);
  Took(1, 5000, /*overdue=*/true);
  EXPECT_EQ(Active().proposed_ms, std::nullopt);
  EXPECT_EQ(Active().overdue, 1U);
  EXPECT_EQ(Active().longest_ms, 200) << "how long the overdue one would have taken is not known";
}

TEST_F(Learning, NamesADrift) {
  Took(75, 200);
  Took(25, 420);
  const LearnedTime row = Active();
  ASSERT_TRUE(row.drift);
  EXPECT_NEAR(row.drift->factor, 2.1, 1e-9);
  EXPECT_EQ(row.drift->since_wall_ns, 75'000'000'000);
  commands_.clear();
  Took(100, 200);
  EXPECT_FALSE(Active().drift);
}

TEST_F(Learning, OfAStateThatTheConfigDoesNotListProposesNothing) {
  commands_.assign(200, {"arm", State("Active"), 0, 10, false});
  EXPECT_EQ(Active().limit_ms, std::nullopt);
  EXPECT_EQ(Active().proposed_ms, std::nullopt);
  EXPECT_EQ(TimesText({}, config_, false), "no command has ended in these journals\n");
}

TEST_F(Learning, TakesARestOfZeroMilliseconds) {
  Took(200, 0);
  EXPECT_EQ(Active().proposed_ms, 100) << "the least margin";
}

}  // namespace musher::cli::learned_times_test
