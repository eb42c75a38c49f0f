#include "musher/modules/exec/child.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <csignal>
#include <string>

#include "musher/test/modules/exec/processes.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::exec::child_test {

using ::testing::HasSubstr;

class ChildTest : public ::testing::Test {
 protected:
  Result<Child> Start(const ChildSpec& spec, int output = -1) {
    return Child::Start(spec, reaper_.value(), output);
  }
  Result<Child> Shell(const std::string& line) { return Start({{"sh", "-c", line}, "", {}}); }

  // The complete output of a command.
  std::string OutputOf(const ChildSpec& spec) {
    int ends[2];
    EXPECT_EQ(pipe2(ends, O_CLOEXEC), 0);
    const UniqueFd reader(ends[0]);
    UniqueFd writer(ends[1]);
    auto child = Start(spec, writer.get());
    EXPECT_TRUE(child);
    writer = UniqueFd();
    std::string text;
    char buffer[256];
    for (ssize_t got = 0; (got = read(reader.get(), buffer, sizeof(buffer))) > 0;) {
      text.append(buffer, static_cast<std::size_t>(got));
    }
    return text;
  }

  const TempFolder folder_;
  const Result<Reaper> reaper_ = Reaper::Start();
};

TEST_F(ChildTest, GivesItsExitCode) {
  auto child = Shell("exit 7");
  ASSERT_TRUE(child);
  ASSERT_TRUE(child.value().EndedBy(Soon()));
  EXPECT_EQ(child.value().Reap(), (ExitStatus{false, 7}));
  EXPECT_EQ(child.value().Reap().Text(), "exit code 7");
}

TEST_F(ChildTest, NamesTheSignalThatKilledIt) {
  auto child = Shell("kill -SEGV $$");
  ASSERT_TRUE(child);
  EXPECT_EQ(child.value().Reap().Text(), "killed by SIGSEGV");
}

// Its number must not be another process's while a command may still signal it.
TEST_F(ChildTest, IsEndedWithItsGroupAndKeepsItsNumberUntilItIsReaped) {
  auto child = Shell("trap '' TERM; sleep infinity & echo $! > " + (folder_ / "child") + "; wait");
  ASSERT_TRUE(child);
  const pid_t in_group = ReadPid(folder_ / "child");
  ASSERT_GT(in_group, 0);
  // So short a time of its own is no time in which a busy computer ends what SIGKILL was sent to.
  EXPECT_TRUE(child.value().End(Milliseconds(0)));
  EXPECT_TRUE(HasExited(in_group));
  EXPECT_EQ(kill(child.value().pid(), 0), 0);
  EXPECT_EQ(child.value().Reap(), (ExitStatus{true, SIGKILL}));
}

TEST_F(ChildTest, FailsToStartAMissingProgram) {
  const auto child = Start({{"no-such-program"}, "", {}});
  ASSERT_FALSE(child);
  EXPECT_EQ(child.error().message, "can't run no-such-program: No such file or directory");
  const auto nowhere = Start({{"true"}, "/no/such/folder", {}});
  ASSERT_FALSE(nowhere);
  EXPECT_THAT(nowhere.error().message, HasSubstr("can't run true in /no/such/folder"));
}

TEST_F(ChildTest, HasItsFolderAndItsOwnAndTheInheritedEnvironment) {
  setenv("CHILD_TEST", "ours", 1);
  EXPECT_EQ(OutputOf({{"sh", "-c", "echo $(pwd) $CHILD_TEST $EXTRA"}, "/tmp", {{"EXTRA", "more"}}}),
            "/tmp ours more\n");
  EXPECT_EQ(OutputOf({{"sh", "-c", "echo $CHILD_TEST"}, "", {{"CHILD_TEST", "its own"}}}),
            "its own\n");
}

TEST_F(ChildTest, InheritsNoDescriptor) {
  const int ours = dup(STDOUT_FILENO);  // not close-on-exec, as DDS's sockets are
  EXPECT_EQ(
      OutputOf(
          {{"sh", "-c", "test -e /proc/$$/fd/" + std::to_string(ours) + " || echo none"}, "", {}}),
      "none\n");
  close(ours);
}

TEST_F(ChildTest, TakesSignalsThatTheParentBlocksOrIgnores) {
  sigset_t term;
  sigemptyset(&term);
  sigaddset(&term, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &term, nullptr);
  auto child = Start({{"sleep", "infinity"}, "", {}});
  pthread_sigmask(SIG_UNBLOCK, &term, nullptr);
  ASSERT_TRUE(child);
  EXPECT_EQ(child.value().Stop(std::chrono::seconds(20)).Text(), "killed by SIGTERM");
}

TEST_F(ChildTest, IsKilledWhenItIgnoresSigterm) {
  auto child =
      Shell("trap '' TERM; echo $$ > " + folder_ / "ready" + "; while :; do sleep 1; done");
  ASSERT_TRUE(child);
  ASSERT_EQ(ReadPid(folder_ / "ready"), child.value().pid());
  EXPECT_EQ(child.value().Stop(Milliseconds(1)).Text(), "killed by SIGKILL");
}

TEST_F(ChildTest, KillsItsGroupWhenItExits) {
  auto child = Shell("sleep infinity & echo $! > " + folder_ / "grandchild");
  ASSERT_TRUE(child);
  const pid_t grandchild = ReadPid(folder_ / "grandchild");
  ASSERT_GT(grandchild, 0);
  EXPECT_TRUE(child.value().Reap().ok());
  EXPECT_TRUE(HasExited(grandchild));
}

TEST_F(ChildTest, IsKilledWhenItIsDestroyed) {
  pid_t pid = 0;
  {
    auto child = Start({{"sleep", "infinity"}, "", {}});
    ASSERT_TRUE(child);
    pid = child.value().pid();
    EXPECT_FALSE(child.value().Ended());
  }
  EXPECT_TRUE(HasExited(pid));
}

}  // namespace musher::exec::child_test
