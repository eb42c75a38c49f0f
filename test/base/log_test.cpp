// Lines of the log, and how a flood of them is limited.

#include "musher/base/log.hpp"

#include <gmock/gmock.h>

#include <unistd.h>

#include <cstdlib>
#include <vector>

#include "musher/base/rate_limited_log.hpp"
#include "musher/test/support/full_pipe.hpp"

namespace musher::log_test {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::ExitedWithCode;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

TEST(LogLine, HasTheNameAndTheLevelUnlessItIsInfo) {
  EXPECT_EQ(LogLine(LogLevel::kInfo, "gripper", "grips"), "gripper: grips\n");
  EXPECT_EQ(LogLine(LogLevel::kDebug, "gripper", "12 N"), "gripper: debug: 12 N\n");
  EXPECT_EQ(LogLine(LogLevel::kWarning, "gripper", "hot"), "gripper: warning: hot\n");
  EXPECT_EQ(LogLine(LogLevel::kError, "gripper", "no jaw"), "gripper: error: no jaw\n");
}

TEST(LogLine, DoesNotRepeatTheWordOfADiagnostic) {
  EXPECT_EQ(LogLine(LogLevel::kError, "gripper", "robot.toml:3:7: error: unknown key"),
            "gripper: robot.toml:3:7: error: unknown key\n");
}

TEST(LogLine, IsReadBackWithoutTimeNameAndLevel) {
  const std::string time = "2026-03-01 13:00:05.250 ";
  EXPECT_EQ(TextOfLogLine(time + "gripper: error: no jaw", "gripper"), "no jaw");
  EXPECT_EQ(TextOfLogLine(time + "gripper: grips", "gripper"), "grips");
  EXPECT_EQ(TextOfLogLine(time + "musher-exec: warning: slow", "gripper"),
            "musher-exec: warning: slow");
  EXPECT_EQ(TextOfLogLine("gripper: error: no jaw", "gripper"), "gripper: error: no jaw");
  EXPECT_EQ(TextOfLogLine("2026-03-01", "gripper"), "2026-03-01");
}

TEST(LogLevels, HaveNames) {
  EXPECT_EQ(LogLevelNamed("debug"), LogLevel::kDebug);
  EXPECT_EQ(LogLevelNamed("info"), LogLevel::kInfo);
  EXPECT_EQ(LogLevelNamed("warning"), LogLevel::kWarning);
  EXPECT_EQ(LogLevelNamed("error"), LogLevel::kError);
  EXPECT_EQ(LogLevelNamed("Error"), std::nullopt);
  EXPECT_EQ(LogLevelNamed(""), std::nullopt);
}

// A line of each level, written by a new process whose MUSHER_LOG is `level`.
[[noreturn]] void WriteEach(const char* level) {
  if (level == nullptr) {
    unsetenv("MUSHER_LOG");
  } else {
    setenv("MUSHER_LOG", level, 1);
  }
  WriteLog(LogLevel::kDebug, "gripper", "12 N");
  WriteLog(LogLevel::kInfo, "gripper", "grips");
  WriteLog(LogLevel::kWarning, "gripper", "hot");
  WriteLog(LogLevel::kError, "gripper", "no jaw");
  std::exit(0);
}

class LogDeathTest : public ::testing::Test {
 protected:
  LogDeathTest() { GTEST_FLAG_SET(death_test_style, "threadsafe"); }
};

TEST_F(LogDeathTest, WritesInfoAndAboveByDefault) {
  EXPECT_EXIT(WriteEach(nullptr), ExitedWithCode(0),
              AllOf(HasSubstr("gripper: grips\ngripper: warning: hot\ngripper: error: no jaw\n"),
                    Not(HasSubstr("12 N"))));
}

TEST_F(LogDeathTest, BeginsEachLineWithTheTimeWhereItIsRequested) {
  const auto write = [] {
    setenv("MUSHER_LOG_TIME", "1", 1);
    WriteEach(nullptr);
  };
  EXPECT_EXIT(write(), ExitedWithCode(0),
              ::testing::ContainsRegex("20[0-9][0-9]-[0-9][0-9]-[0-9][0-9] [0-9:]{8}[.][0-9]{3} "
                                       "gripper: grips\n20.* gripper: warning: hot"));
}

TEST_F(LogDeathTest, WritesFromTheLevelInTheEnvironmentOn) {
  EXPECT_EXIT(WriteEach("debug"), ExitedWithCode(0), HasSubstr("gripper: debug: 12 N\n"));
  EXPECT_EXIT(
      WriteEach("error"), ExitedWithCode(0),
      AllOf(HasSubstr("gripper: error: no jaw\n"), Not(HasSubstr("hot")), Not(HasSubstr("grips"))));
}

TEST_F(LogDeathTest, ReportsAnUnknownLevelOnceAndWritesInfo) {
  EXPECT_EXIT(WriteEach("loud"), ExitedWithCode(0),
              HasSubstr("MUSHER_LOG is \"loud\": expected debug, info, warning or error; info is "
                        "used\ngripper: grips\n"));
}

// It held the loop of an actuator, and with it the emergency stop.
TEST_F(LogDeathTest, HoldsNoThreadOnADiskThatDoesNotAnswer) {
  const auto write = [] {
    const testing::FullPipe pipe;
    dup2(pipe.writer(), STDERR_FILENO);
    alarm(60);
    WriteLog(LogLevel::kError, "gripper", "no jaw");
    _exit(0);
  };
  EXPECT_EXIT(write(), ExitedWithCode(0), "");
}

class LimitedLog : public ::testing::Test {
 protected:
  static Time At(int milliseconds) { return Time(Milliseconds(milliseconds)); }

  std::vector<std::string> lines_;
  RateLimitedLog log_{[this](const std::string& line) { lines_.push_back(line); },
                      Milliseconds(1000)};
};

TEST_F(LimitedLog, WritesTheFirstLineOfEachKindAtOnce) {
  log_.Log("target", "too far", At(0));
  log_.Log("voice", "too loud", At(1));
  EXPECT_THAT(lines_, ElementsAre("too far", "too loud"));
}

TEST_F(LimitedLog, WritesAFloodOnceAPeriodWithTheNumberOfSuppressedLines) {
  for (int i = 0; i < 500; ++i) log_.Log("target", "line " + std::to_string(i), At(i));
  log_.Tick(At(999));
  EXPECT_THAT(lines_, ElementsAre("line 0"));
  log_.Tick(At(1000));
  EXPECT_THAT(lines_, ElementsAre("line 0", "line 499 (and 498 more)"));
  EXPECT_EQ(log_.total(), 500U);
  lines_.clear();
  log_.Tick(At(5000));
  EXPECT_THAT(lines_, IsEmpty());
}

}  // namespace musher::log_test
