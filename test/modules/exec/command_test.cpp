#include "musher/modules/exec/command.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <string>

#include "musher/test/modules/exec/processes.hpp"
#include "musher/test/support/full_pipe.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::exec::command_test {

using ::testing::HasSubstr;

class CommandTest : public ::testing::Test {
 protected:
  Result<CommandEnd> Run(
      const std::string& line, const std::function<Wanted()>& wanted = [] { return Wanted::kYes; },
      Duration stop_time = std::chrono::seconds(20)) {
    return RunCommand({{"sh", "-c", line}, "", {}}, reaper_.value(), stop_time, wanted);
  }

  // No longer wanted as soon as the command has written its pid into `file`.
  static std::function<Wanted()> UntilReady(const std::string& file, Wanted then) {
    return [file, then] { return ReadPid(file) > 0 ? then : Wanted::kYes; };
  }

  const TempFolder folder_;
  const Result<Reaper> reaper_ = Reaper::Start();
};

TEST_F(CommandTest, GivesTheExitCodeAndTheLastLine) {
  const auto end = Run("echo first; echo the reason >&2; exit 9");
  ASSERT_TRUE(end);
  EXPECT_EQ(end.value().status, (ExitStatus{false, 9}));
  EXPECT_EQ(end.value().last_line, "the reason");
  EXPECT_FALSE(end.value().stopped);
}

TEST_F(CommandTest, PassesTheOutputOn) {
  ::testing::internal::CaptureStdout();
  ASSERT_TRUE(Run("echo out; echo err >&2"));
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "out\nerr\n");
}

TEST_F(CommandTest, HandlesMoreOutputThanAPipeHolds) {
  ::testing::internal::CaptureStdout();
  const auto end =
      Run("i=0; while [ $i -lt 20000 ]; do echo 0123456789; i=$((i+1)); done; echo end");
  const std::string output = ::testing::internal::GetCapturedStdout();
  ASSERT_TRUE(end);
  EXPECT_EQ(output.size(), 20'000U * 11 + 4);
  EXPECT_EQ(end.value().last_line, "end");
}

// A stop that said what it does ended no program while the disk of the log did not answer.
TEST_F(CommandTest, EndsAlsoWhereNothingTakesItsOutput) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto run = [this] {
    const testing::FullPipe pipe;
    dup2(pipe.writer(), STDOUT_FILENO);
    alarm(60);
    const auto end = Run("echo stops");
    _exit(end && end.value().last_line == "stops" ? 0 : 1);
  };
  EXPECT_EXIT(run(), ::testing::ExitedWithCode(0), "");
}

TEST_F(CommandTest, GetsSigtermWhenItIsNoLongerNeeded) {
  const std::string ready = folder_ / "ready";
  const auto end =
      Run("trap 'echo bye; exit 3' TERM; echo $$ > " + ready + "; while :; do sleep 0.01; done",
          UntilReady(ready, Wanted::kNo));
  ASSERT_TRUE(end);
  EXPECT_TRUE(end.value().stopped);
  EXPECT_EQ(end.value().status, (ExitStatus{false, 3}));
  EXPECT_EQ(end.value().last_line, "bye");
}

TEST_F(CommandTest, GetsSigkillWhenSigtermDoesNotHelp) {
  const std::string ready = folder_ / "ready";
  const auto end = Run("trap '' TERM; echo $$ > " + ready + "; while :; do sleep 0.01; done",
                       UntilReady(ready, Wanted::kNo), Milliseconds(50));
  ASSERT_TRUE(end);
  EXPECT_TRUE(end.value().stopped);
  EXPECT_EQ(end.value().status.Text(), "killed by SIGKILL");
}

TEST_F(CommandTest, IsKilledAtOnceWhenItMustEnd) {
  const std::string ready = folder_ / "ready";
  const auto end = Run("trap 'exit 3' TERM; echo $$ > " + ready + "; while :; do sleep 0.01; done",
                       UntilReady(ready, Wanted::kGetDone));
  ASSERT_TRUE(end);
  EXPECT_EQ(end.value().status.Text(), "killed by SIGKILL");
}

TEST_F(CommandTest, DoesNotWaitForProcessesItLeavesBehind) {
  const auto end = Run("sleep infinity & echo done");
  ASSERT_TRUE(end);
  EXPECT_TRUE(end.value().status.ok());
  EXPECT_EQ(end.value().last_line, "done");
}

TEST_F(CommandTest, ThatCannotBeRunIsAnError) {
  const auto end = RunCommand({{"/no/such/program"}, "", {}}, reaper_.value(), Milliseconds(1),
                              [] { return Wanted::kYes; });
  ASSERT_FALSE(end);
  EXPECT_THAT(end.error().message, HasSubstr("can't run /no/such/program: No such file"));
}

TEST(LastLine, IsTheLastOneThatIsNotBlank) {
  LastLine line;
  EXPECT_EQ(line.Get(), "");
  line.Add("one\ntwo\n\n  \n");
  EXPECT_EQ(line.Get(), "two");
  line.Add("thr");
  line.Add("ee");
  EXPECT_EQ(line.Get(), "three");
}

TEST(LastLine, IsValidUtf8WithoutControlCharacters) {
  LastLine line;
  line.Add("\x1b[31mr\xC3\xA4u\xFFm\x07\r\n");
  EXPECT_EQ(line.Get(), "[31mr\xC3\xA4u?m");
}

TEST(LastLine, IsShortenedBetweenCharacters) {
  LastLine line;
  line.Add(std::string(199, 'x') + "\xC3\xA4\n");
  EXPECT_EQ(line.Get(), std::string(199, 'x'));
}

}  // namespace musher::exec::command_test
