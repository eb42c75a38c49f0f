#include "musher/base/exit_status.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

namespace musher::exit_status_test {

pid_t ChildThatExitsWith(int code) {
  const pid_t pid = fork();
  if (pid == 0) _exit(code);
  return pid;
}

pid_t ChildThatWaits() {
  const pid_t pid = fork();
  while (pid == 0) pause();
  return pid;
}

TEST(ExitStatus, HasOneTextForACodeAndForASignal) {
  EXPECT_EQ((ExitStatus{false, 3}.Text()), "exit code 3");
  EXPECT_EQ((ExitStatus{true, SIGKILL}.Text()), "killed by SIGKILL");
  EXPECT_EQ((ExitStatus{true, SIGRTMIN + 3}.Text()),
            "killed by signal " + std::to_string(SIGRTMIN + 3));
}

// A parent that ignores SIGCHLD, or another thread, may have reaped it.
TEST(ExitStatus, IsNotOkWhenItIsUnknown) {
  EXPECT_FALSE(ExitStatus::Unknown().ok());
  EXPECT_EQ(ExitStatus::Unknown().Text(), "exit status unknown");
}

TEST(ExitStatus, IsOkForExitCodeZeroOnly) {
  EXPECT_TRUE((ExitStatus{false, 0}.ok()));
  EXPECT_FALSE((ExitStatus{false, 1}.ok()));
  EXPECT_FALSE((ExitStatus{true, 0}.ok()));
}

TEST(ExitStatus, IsReadFromWhatWaitpidGives) {
  EXPECT_EQ(ExitStatus::FromWait(W_EXITCODE(3, 0)), (ExitStatus{false, 3}));
  EXPECT_EQ(ExitStatus::FromWait(W_EXITCODE(0, SIGTERM)), (ExitStatus{true, SIGTERM}));
  EXPECT_EQ(ExitStatus::FromWait(W_EXITCODE(0, SIGABRT) | WCOREFLAG), (ExitStatus{true, SIGABRT}));
}

TEST(ReapChild, WaitsForTheEndAndReapsOnce) {
  const pid_t pid = ChildThatExitsWith(7);
  EXPECT_EQ(ReapChild(pid), (ExitStatus{false, 7}));
  EXPECT_EQ(ReapChild(pid), std::nullopt);
}

TEST(ReapChild, NamesTheSignalThatKilledTheChild) {
  const pid_t pid = ChildThatWaits();
  kill(pid, SIGKILL);
  EXPECT_EQ(ReapChild(pid), (ExitStatus{true, SIGKILL}));
}

TEST(ReapChild, RefusesWhatIsNoChild) {
  EXPECT_EQ(ReapChild(getpid()), std::nullopt);
}

TEST(ReapEndedChild, DoesNotWaitForAChildThatRuns) {
  const pid_t pid = ChildThatWaits();
  EXPECT_EQ(ReapEndedChild(pid), std::nullopt);
  kill(pid, SIGKILL);
  siginfo_t ended{};
  ASSERT_EQ(waitid(P_PID, static_cast<id_t>(pid), &ended, WEXITED | WNOWAIT), 0);
  EXPECT_EQ(ReapEndedChild(pid), (ExitStatus{true, SIGKILL}));
}

}  // namespace musher::exit_status_test
