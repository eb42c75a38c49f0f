#include "musher/cli/render/log_lines.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <ctime>

#include "musher/cli/console/wall_time.hpp"

namespace musher::cli::log_lines_test {

using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::Not;

class Lines : public ::testing::Test {
 protected:
  Lines() {
    setenv("TZ", "UTC", 1);
    tzset();
  }
  static std::int64_t At(const std::string& time) { return ParseSince(time, 0).value(); }
  static std::vector<std::string> TextsOf(const std::vector<LogEntry>& entries) {
    std::vector<std::string> texts;
    texts.reserve(entries.size());
    for (const LogEntry& e : entries) texts.push_back(e.source + " " + e.text);
    return texts;
  }

  LogLines legs_{"legs"};
};

TEST_F(Lines, OfMushersProcessesHaveTimeLevelAndText) {
  const auto time = At("2026-03-01T13:00:05.250");
  EXPECT_EQ(legs_.Take({"2026-03-01 13:00:05.250 legs: warning: hot"}),
            (LogEntry{"legs", time, LogLevel::kWarning, "warning: hot"}));
  EXPECT_EQ(legs_.Take({"2026-03-01 13:00:05.250 legs: walks"}),
            (LogEntry{"legs", time, LogLevel::kInfo, "walks"}));
  EXPECT_EQ(LogLines("controller").Take({"2026-03-01 13:00:05.250 info: the machine is Active"}),
            (LogEntry{"controller", time, LogLevel::kInfo, "the machine is Active"}));
}

TEST_F(Lines, OfRos2NodesAndOtherProgramsAreRead) {
  EXPECT_EQ(legs_.Take({"[WARN] [1772366405.250000000] [talker]: slow"}),
            (LogEntry{"legs", 1'772'366'405'250'000'000, LogLevel::kWarning, "[talker]: slow"}));
  EXPECT_EQ(legs_.Take({"[2026-03-01 13:00:05.250] [legs] [error] stuck"}),
            (LogEntry{"legs", At("2026-03-01T13:00:05.250"), LogLevel::kError, "stuck"}));
  EXPECT_EQ(legs_.Take({"2026-03-01 13:00:05,250 python line"}).wall_ns,
            At("2026-03-01T13:00:05.250"));
}

TEST_F(Lines, MayNameTheTimeZoneOfTheirTime) {
  const auto time = At("2026-03-01T13:00:05.250Z");
  setenv("TZ", "Europe/Berlin", 1);
  tzset();
  for (const char* line :
       {"2026-03-01T13:00:05.250Z hello", "2026-03-01 15:00:05.250+02:00 hello",
        "2026-03-01T08:30:05,250-0430 hello", "[2026-03-01T13:00:05.250Z] hello"}) {
    EXPECT_EQ(legs_.Take({line}), (LogEntry{"legs", time, LogLevel::kInfo, "hello"})) << line;
  }
  EXPECT_EQ(legs_.Take({"2026-03-01 13:00:05-x"}).text, "-x");
}

// They had the time of the last line with one: what was printed a second ago was shown as old, and
// `--since 5s` left it out.
TEST_F(Lines, WithoutATimeHaveTheTimeAtWhichTheyWereWritten) {
  const auto begun = legs_.Take({"2026-03-01 13:00:05.250 legs: error: failed in"});
  EXPECT_EQ(legs_.Take({"    frame 1", 7}), (LogEntry{"legs", 7, LogLevel::kError, "    frame 1"}));
  EXPECT_EQ(legs_.Take({"plain", 8}), (LogEntry{"legs", 8, LogLevel::kInfo, "plain"}));
  EXPECT_EQ(legs_.Take({"plain", 0}).wall_ns, 0) << "not known, and not that of another line";
  EXPECT_EQ(legs_.Take({"2026-03-01 13:00:05.250 legs: x", 9}).wall_ns, begun.wall_ns);
}

TEST_F(Lines, ThatOnlyLookLikeATimeAreText) {
  for (const char* line : {"2026-03-01", "2026-03-01 13:00", "[1.5] x", "[", "[]", "", "legs"}) {
    EXPECT_EQ(legs_.Take({line}), (LogEntry{"legs", 0, LogLevel::kInfo, line})) << line;
  }
}

TEST_F(Lines, AreMergedByTimeAndEachLogKeepsItsOrder) {
  const auto legs = LogEntriesOf("legs", {{"start"}, {"2026-03-01 13:00:02 legs: b"}, {"c"}});
  const auto eyes =
      LogEntriesOf("eyes", {{"2026-03-01 13:00:01 eyes: a"}, {"2026-03-01 13:00:03 d"}});
  EXPECT_THAT(TextsOf(Merge({legs, eyes})),
              ElementsAre("eyes a", "legs start", "legs b", "legs c", "eyes d"));
}

TEST_F(Lines, StayInOrderWhenTheClockIsSetBack) {
  const auto legs = LogEntriesOf(
      "legs", {{"2026-03-01 13:00:05 legs: first"}, {"2026-03-01 12:00:00 legs: second"}});
  const auto merged = Merge({legs});
  EXPECT_THAT(TextsOf(merged), ElementsAre("legs first", "legs second"));
  EXPECT_EQ(merged[1].wall_ns, At("2026-03-01T12:00:00")) << "the time that was written is shown";
}

TEST_F(Lines, AreFilteredByLevelAndTime) {
  LogFilter filter{At("2026-03-01T13:00"), LogLevel::kWarning};
  const auto entry = [](std::int64_t time, LogLevel level) {
    return LogEntry{"a", time, level, ""};
  };
  EXPECT_TRUE(filter.Shows(entry(filter.since_ns, LogLevel::kError)));
  EXPECT_TRUE(filter.Shows(entry(0, LogLevel::kWarning))) << "without a time it stays";
  EXPECT_FALSE(filter.Shows(entry(filter.since_ns, LogLevel::kInfo)));
  EXPECT_FALSE(filter.Shows(entry(filter.since_ns - 1, LogLevel::kError)));
}

TEST_F(Lines, AreShownWithTheirSourceWhereThereAreSeveral) {
  const LogEntry entry = legs_.Take({"2026-03-01 13:00:05.250 legs: warning: hot"});
  EXPECT_EQ(LogText(entry, 0, false), "2026-03-01 13:00:05.250  warning: hot\n");
  EXPECT_EQ(LogText(entry, 6, false), "2026-03-01 13:00:05.250  legs    warning: hot\n");
  EXPECT_EQ(LogText({"legs", 0, LogLevel::kInfo, "x"}, 0, false), std::string(25, ' ') + "x\n");
  EXPECT_THAT(LogText(entry, 0, true), HasSubstr("\x1b[33mwarning: hot\x1b[0m"));
  EXPECT_EQ(LogJson(entry),
            R"({"time":"2026-03-01T13:00:05.250Z","actuator":"legs","level":"warning",)"
            R"("message":"warning: hot"})");
}

TEST_F(Lines, CannotControlTheTerminal) {
  const LogEntry entry =
      legs_.Take({"\x1b[31mred\x1b[0m \x1b]0;title\x07 \xc2\x9b"
                  "2J"});
  const std::string text = LogText(entry, 6, false);
  EXPECT_THAT(text, Not(HasSubstr("\x1b")));
  EXPECT_THAT(text, Not(HasSubstr("\x07")));
  EXPECT_THAT(text, Not(HasSubstr("\xc2\x9b")));
  EXPECT_THAT(text, HasSubstr("red "));
}

}  // namespace musher::cli::log_lines_test
