#include "musher/cli/start/repetitions.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/lifecycle/event_name.hpp"

namespace musher::cli::repetitions_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

class RepeatedLines : public ::testing::Test {
 protected:
  std::vector<std::string> Say(const std::string& message, const std::string& actuator = "legs",
                               const std::string& kind = "process",
                               EventName event = EventName::kNone) {
    Progress progress;
    progress.event = NameOf(event);
    progress.wall_ns = now_ns_;
    progress.kind = kind;
    progress.actuator = actuator;
    progress.message = message;
    std::vector<std::string> lines;
    for (const Progress& line : repetitions_.Take(progress)) lines.push_back(line.message);
    return lines;
  }
  // What is printed while it is started, ends and is started again.
  std::vector<std::string> Crash(int restart) {
    std::vector<std::string> lines;
    const std::string n = std::to_string(restart);
    const std::vector<std::pair<EventName, std::string>> said{
        {EventName::kProcessStarted, "legs started (pid 40" + n + ")"},
        {EventName::kActuatorCrashed, "legs is degraded: crashed: exit code 1"},
        {EventName::kRestartScheduled, "legs: restarting in " + n + "00 ms (" + n + " of 5)"}};
    for (const auto& [event, message] : said) {
      for (const std::string& line : Say(message, "legs", "process", event)) lines.push_back(line);
    }
    return lines;
  }

  std::vector<std::string> Started(int pid) {
    return Say("legs started (pid " + std::to_string(pid) + ")", "legs", "process",
               EventName::kProcessStarted);
  }

  std::int64_t now_ns_ = 1'000'000'000'000;
  Repetitions repetitions_;
};

TEST_F(RepeatedLines, OfARepeatedlyCrashingActuatorAreCountedUntilAnotherLine) {
  EXPECT_THAT(Crash(1),
              ElementsAre("legs started (pid 401)", "legs is degraded: crashed: exit code 1",
                          "legs: restarting in 100 ms (1 of 5)"));
  for (const int restart : {2, 3, 4, 5}) EXPECT_THAT(Crash(restart), IsEmpty());
  EXPECT_THAT(Started(406), IsEmpty());
  EXPECT_THAT(Say("legs is degraded: given up after 5 restarts"),
              ElementsAre("legs: repeated 4 times", "legs is degraded: given up after 5 restarts"));
  EXPECT_THAT(Started(407), ElementsAre("legs started (pid 407)")) << "by hand";
}

TEST_F(RepeatedLines, OfAnotherEndOrAnotherActuatorArePrinted) {
  Crash(1);
  EXPECT_THAT(Say("arm is degraded: crashed: exit code 1", "arm"),
              ElementsAre("arm is degraded: crashed: exit code 1"));
  EXPECT_THAT(Say("legs is degraded: crashed: exit code 3"),
              ElementsAre("legs is degraded: crashed: exit code 3"));
}

TEST_F(RepeatedLines, AreKnownByTheirEventAndNotByTheirSentence) {
  Crash(1);
  const auto say = [this](EventName event, const std::string& message) {
    return Say(message, "legs", "process", event);
  };
  EXPECT_THAT(say(EventName::kProcessStarted, "legs runs again as 402"), IsEmpty());
  EXPECT_THAT(say(EventName::kActuatorHung, "legs is degraded: crashed: exit code 1"),
              ElementsAre("legs is degraded: crashed: exit code 1"))
      << "another event with the same words";
}

TEST_F(RepeatedLines, WithoutARestartArePrintedEachTime) {
  for (int i = 0; i < 3; ++i) {
    EXPECT_THAT(Say("legs: Active done after 3 ms"), ElementsAre("legs: Active done after 3 ms"));
  }
}

TEST_F(RepeatedLines, OfASwitchArePrintedEachTime) {
  Crash(1);
  Say("legs: Active done after 3 ms");
  EXPECT_THAT(Say("switch 5 begins", "", "switch"), ElementsAre("switch 5 begins"));
  EXPECT_THAT(Say("legs: Active done after 2 ms"), ElementsAre("legs: Active done after 2 ms"));
}

TEST_F(RepeatedLines, OfAnEndlessLoopAreReportedAtPowersOfTen) {
  Crash(1);
  int printed = 0;
  for (int restart = 2; restart <= 201; ++restart) {
    for (const std::string& line : Crash(restart)) {
      EXPECT_EQ(line, printed == 0 ? "legs: repeated 10 times" : "legs: repeated 100 times");
      ++printed;
    }
  }
  EXPECT_EQ(printed, 2);
}

TEST_F(RepeatedLines, AreNewsAfterHalfAMinute) {
  Crash(1);
  EXPECT_THAT(Crash(2), IsEmpty());
  now_ns_ += 31'000'000'000;
  EXPECT_THAT(Crash(1).size(), 3U);
}

TEST_F(RepeatedLines, NameAReasonOnceAndReferToItWhileItIsInSight) {
  const std::string why = "exit code 2: robot.toml has no actuator 'lesg'; did you mean 'legs'?";
  EXPECT_THAT(Say("legs is degraded: " + why), ElementsAre("legs is degraded: " + why));
  EXPECT_THAT(Say("legs is degraded: " + why + "; not restarted automatically"),
              ElementsAre("legs is degraded: as above; not restarted automatically"));
  const std::string whole = "legs: " + why + "; not restarted automatically";
  EXPECT_THAT(Say("switch 1 is done-degraded: " + whole, "", "switch"),
              ElementsAre("switch 1 is done-degraded: legs: as above"));
  EXPECT_THAT(Say("arm is degraded: exit code 1", "arm"),
              ElementsAre("arm is degraded: exit code 1"));
  EXPECT_THAT(Say("the machine is Active, degraded: arm: exit code 1", "", "machine"),
              ElementsAre("the machine is Active, degraded: arm: exit code 1"))
      << "a short one costs less than to look above";
  EXPECT_THAT(Say("arm is degraded: " + why, "arm"), ElementsAre("arm is degraded: " + why))
      << "of another actuator";
  now_ns_ += 11'000'000'000;
  EXPECT_THAT(Say("switch 2 is done-degraded: " + whole, "", "switch"),
              ElementsAre("switch 2 is done-degraded: " + whole));
}

}  // namespace musher::cli::repetitions_test
