// Limits that are learned from what commands took.

#include "musher/cli/config/learned_times.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/cli/machine/command_times.hpp"
#include "musher/cli/render/times.hpp"
#include "musher/lifecycle/event_name.hpp"

namespace musher::cli::learned_times_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

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

// A slower robot was added to the fleet: neither of the two takes longer than before.
TEST_F(Learning, ARobotWhoseJournalBeginsLaterIsNoDrift) {
  Took(75, 200);
  Took(45, 420);
  for (std::size_t i = 75; i < commands_.size(); ++i) commands_[i].journal = "second.sqlite";
  EXPECT_FALSE(Active().drift);
  EXPECT_THAT(TimeWarnings({Active()}), IsEmpty());
}

TEST_F(Learning, NamesTheJournalOfTheRobotThatDrifts) {
  Took(100, 200);
  const std::size_t first = commands_.size();
  Took(75, 100);
  Took(25, 300);
  for (std::size_t i = first; i < commands_.size(); ++i) commands_[i].journal = "second.sqlite";
  const LearnedTime row = Active();
  ASSERT_TRUE(row.drift);
  EXPECT_EQ(row.drift->journal, "second.sqlite");
  EXPECT_NEAR(row.drift->factor, 3, 1e-9);
  EXPECT_THAT(TimesText({row}, config_, false), HasSubstr(" in second.sqlite"));
}

// They are recorded in whole milliseconds, and may be those of a busy computer.
TEST_F(Learning, AFewMillisecondsAreNoDrift) {
  Took(75, 0);
  Took(25, 1);
  EXPECT_FALSE(Active().drift);
  commands_.clear();
  Took(75, 2);
  Took(25, 12);
  EXPECT_FALSE(Active().drift);
}

TEST_F(Learning, SaysWhatTheProposedLimitWouldHaveChanged) {
  Took(1999, 200);
  Took(1, 900);
  const LearnedTime row = Active();
  EXPECT_EQ(row.proposed_ms, 300);
  EXPECT_EQ(row.beyond_proposed, 1U);
  EXPECT_THAT(
      TimesText({row}, config_, false),
      HasSubstr("propose 300; 1 command would have been overdue with it; a hang would be seen "
                "4700 ms sooner"));
}

TEST_F(Learning, WarnsOfWhatComesCloseToItsLimit) {
  Took(200, 4800);
  EXPECT_THAT(TimeWarnings({Active()}),
              ElementsAre("legs: Active comes close to its limit: 99.9 % of 200 commands took up "
                          "to 4800 of 5000 ms"));
  Took(1, 5000, /*overdue=*/true);
  EXPECT_THAT(TimeWarnings({Active()}),
              ElementsAre("legs: Active was overdue in 1 of 201 commands, its limit is 5000 ms"));
  commands_.clear();
  Took(99, 4800);
  EXPECT_THAT(TimeWarnings({Active()}), IsEmpty()) << "too few to say";
}

// The limit was raised after these.
TEST_F(Learning, DoesNotWarnOfCommandsThatWereOverdueWithAShorterLimit) {
  Took(200, 900);
  Took(3, 1000, /*overdue=*/true);
  EXPECT_THAT(TimeWarnings({Active()}), IsEmpty());
  EXPECT_THAT(TimesText({Active()}, config_, false), HasSubstr("3 overdue with a shorter limit"));
}

TEST_F(Learning, WarnsOfALongerTimeAndNotOfAShorterOne) {
  Took(75, 200);
  Took(25, 420);
  EXPECT_THAT(TimeWarnings({Active()}),
              ElementsAre(HasSubstr("legs: Active takes 2.1 times as long since ")));
  commands_.clear();
  Took(75, 420);
  Took(25, 200);
  EXPECT_TRUE(Active().drift);
  EXPECT_THAT(TimeWarnings({Active()}), IsEmpty());
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

// --- SetUp, which is no command ---

class LearningSetUp : public Learning {
 protected:
  void Add(std::int64_t ms, EventName event, const std::string& data = "", Epoch epoch = 1) {
    JournalEntry entry;
    entry.wall_ns = entry.steady_ns = ms * 1'000'000;
    entry.epoch = epoch;
    entry.actuator = "legs";
    entry.event = NameOf(event);
    entry.data = data;
    entries_.push_back(entry);
  }
  std::vector<CommandTime> Times() const { return CommandTimesOf(entries_, "a.sqlite"); }

  std::vector<JournalEntry> entries_;
};

TEST_F(LearningSetUp, TakesFromTheStartOfAProcessUntilItsActuatorIsPresent) {
  Add(1000, EventName::kProcessStarted);
  Add(1300, EventName::kActuatorPresent);
  Add(9000, EventName::kActuatorPresent);  // its connection was lost meanwhile
  ASSERT_EQ(Times().size(), 1U);
  EXPECT_EQ(Times()[0].actuator, "legs");
  EXPECT_EQ(Times()[0].state, "SetUp");
  EXPECT_EQ(Times()[0].took_ms, 300);
  EXPECT_FALSE(Times()[0].overdue);
  EXPECT_EQ(Times()[0].journal, "a.sqlite");
  const LearnedTime row = LearnTimes(Times(), config_, {}).at(0);
  EXPECT_EQ(row.limit_ms, 9000);
  EXPECT_THAT(TimesText({row}, config_, false), HasSubstr("99 more starts needed for a limit"));
}

TEST_F(LearningSetUp, IsOverdueAtItsLimit) {
  Add(1000, EventName::kProcessStarted);
  Add(9990, EventName::kNotAnnounced, R"({"arguments": {"within_ms": 9000}})");
  Add(9999, EventName::kActuatorPresent);  // too late
  ASSERT_EQ(Times().size(), 1U);
  EXPECT_TRUE(Times()[0].overdue);
  EXPECT_EQ(LearnTimes(Times(), config_, {}).at(0).overdue_at_limit, 1U);
  EXPECT_THAT(TimeWarnings(LearnTimes(Times(), config_, {})),
              ElementsAre("legs: SetUp was overdue in 1 of 1 start, its limit is 9000 ms"));
}

TEST_F(LearningSetUp, IsNotLearnedFromWhatHasNoBeginOrNoEnd) {
  Add(1000, EventName::kProcessStarted);
  Add(1200, EventName::kProcessExited);
  Add(1500, EventName::kActuatorPresent);  // started by hand
  Add(2000, EventName::kProcessStarted);
  Add(2500, EventName::kActuatorPresent, "", 2);  // of the next controller
  Add(3000, EventName::kProcessStarted);
  entries_.back().message = "legs runs on host arm already (pid 7)";
  Add(3100, EventName::kActuatorPresent);
  EXPECT_THAT(Times(), IsEmpty());
}

// Of the starts those after a boot are few, and the slow ones.
TEST_F(LearningSetUp, ProposesNoLimitBelowTheLongestStart) {
  for (int i = 0; i < 2000; ++i) {
    const std::int64_t begin = 20'000 * i;
    Add(begin + 1, EventName::kProcessStarted);
    Add(begin + 1 + (i == 700 ? 4000 : 200), EventName::kActuatorPresent);
  }
  const LearnedTime row = LearnTimes(Times(), config_, {}).at(0);
  EXPECT_EQ(row.p999_ms, 200);
  EXPECT_EQ(row.proposed_ms, 6000);
}

}  // namespace musher::cli::learned_times_test
