#include "musher/cli/console/console.hpp"

#include <gtest/gtest.h>

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <sstream>

#include "musher/cli/console/output_reader.hpp"
#include "musher/cli/console/table.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::cli::console_test {

TEST(Console, ColoursOnlyOnATerminalByDefault) {
  setenv("TERM", "xterm", 1);
  unsetenv("NO_COLOR");
  EXPECT_TRUE(WantsColour(ColourWhen::kAuto, true));
  EXPECT_FALSE(WantsColour(ColourWhen::kAuto, false));
  EXPECT_TRUE(WantsColour(ColourWhen::kAlways, false));
  EXPECT_FALSE(WantsColour(ColourWhen::kNever, true));
  setenv("TERM", "dumb", 1);
  EXPECT_FALSE(WantsColour(ColourWhen::kAuto, true));
}

TEST(Console, RespectsNoColor) {
  setenv("TERM", "xterm", 1);
  setenv("NO_COLOR", "1", 1);
  EXPECT_FALSE(WantsColour(ColourWhen::kAuto, true));
  EXPECT_TRUE(WantsColour(ColourWhen::kAlways, true));
  setenv("NO_COLOR", "", 1);  // empty counts as not set
  EXPECT_TRUE(WantsColour(ColourWhen::kAuto, true));
  unsetenv("NO_COLOR");
}

TEST(Console, LetsNoMessageDriveTheTerminal) {
  EXPECT_EQ(Printable("a\x1b[2Jb\nc\x7f\td\u00e9"), "a [2Jb c  d\u00e9");
}

TEST(Console, PrintsAFailureOnceAsTextAndOnceAsJson) {
  std::ostringstream out;
  std::ostringstream err;
  Console people(out, err, {});
  EXPECT_EQ(people.Fail({ExitCode::kNoController, {105, "no\nanswer"}}), ExitCode::kNoController);
  EXPECT_EQ(out.str(), "");
  EXPECT_EQ(err.str(), "musher: no answer\n");

  Console programs(out, err, {true, false, false});
  EXPECT_EQ(programs.Fail({ExitCode::kNoAnswer, {107, "silence"}, 12}), ExitCode::kNoAnswer);
  EXPECT_EQ(out.str(), "{\"error\":\"silence\",\"code\":107,\"switch\":12,\"diagnostics\":[]}\n");
}

// A stream whose reader or disk is gone: every write fails with that errno.
class Failing : public std::streambuf {
 public:
  explicit Failing(int reason) : reason_(reason) {}

 private:
  int_type overflow(int_type) override {
    errno = reason_;
    return traits_type::eof();
  }
  int sync() override {
    errno = reason_;
    return -1;
  }
  const int reason_;
};

TEST(Console, ACommandWhoseOutputTheDiskDoesNotTakeFailsWithTheReason) {
  Failing full(ENOSPC);
  std::ostream out(&full);
  std::ostringstream err;
  Console console(out, err, {});
  console.Print("a result");
  EXPECT_FALSE(console.HasReader());
  EXPECT_EQ(console.lost(), "No space left on device");
  EXPECT_EQ(console.AfterOutput(ExitCode::kDone), ExitCode::kUsage);
  EXPECT_EQ(err.str(), "musher: output lost: No space left on device\n");
  EXPECT_EQ(console.AfterOutput(ExitCode::kNotDone), ExitCode::kNotDone);
  console.TakeLost();
  EXPECT_EQ(console.AfterOutput(ExitCode::kDone), ExitCode::kDone);
}

TEST(Console, AReaderThatHasExitedIsNoFailureOfTheCommand) {
  Failing closed(EPIPE);
  std::ostream out(&closed);
  std::ostringstream err;
  Console console(out, err, {});
  console.Print("a result");
  EXPECT_EQ(console.lost(), "its reader has exited");
  EXPECT_EQ(console.AfterOutput(ExitCode::kDone), ExitCode::kDone);
  EXPECT_EQ(err.str(), "");
}

TEST(Console, TheReaderOfAPipeIsWatchedThatOfAFileIsNot) {
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe(ends.data()), 0);
  const UniqueFd reader = TakeReaderOf(ends[1]);
  transport::LinuxEventLoop loop;
  bool exited = false;
  const auto watch = loop.WhenReadable(reader.get(), [&] { exited = true; });
  loop.RunUntil([&] { return exited; }, loop.Now());
  EXPECT_FALSE(exited);
  close(ends[0]);
  EXPECT_TRUE(loop.RunUntil([&] { return exited; }, loop.Now() + std::chrono::seconds(120)));
  EXPECT_FALSE(TakeReaderOf(UniqueFd(open("/dev/null", O_WRONLY)).get()).valid());
  close(ends[1]);
}

TEST(Table, AlignsColumnsByCharactersAndEndsLinesWithoutSpaces) {
  Table table({"NAME", "STATE", "NOTE"});
  table.Add({{"a"}, {"Active", Style::kGood}, {""}});
  table.Add({{"b\u00e9e"}, {""}, {"x"}});
  EXPECT_EQ(table.Text(false),
            "NAME  STATE   NOTE\n"
            "a     Active\n"
            "b\u00e9e           x\n");
}

TEST(Table, WrapsTheLastColumnToTheWidthOfTheTerminal) {
  Table table({"NAME", "NOTE"});
  table.Add({{"audio"}, {"crashed: its process was killed; restarting", Style::kBad}});
  FitTables(30);
  const std::string narrow = table.Text(false);
  FitTables(12);
  const std::string hopeless = table.Text(false);
  FitTables(0);
  EXPECT_EQ(narrow,
            "NAME   NOTE\n"
            "audio  crashed: its process\n"
            "       was killed; restarting\n");
  EXPECT_EQ(hopeless, table.Text(false)) << "no room for a column of words";
}

TEST(Table, ColoursTextButNotTheSpacesAroundIt) {
  Table table({"N", "S"});
  table.Add({{"a"}, {"b", Style::kBad}});
  EXPECT_EQ(table.Text(true), "\x1b[2mN\x1b[0m  \x1b[2mS\x1b[0m\na  \x1b[31mb\x1b[0m\n");
}

}  // namespace musher::cli::console_test
