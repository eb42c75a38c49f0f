#include "musher/modules/exec/reaper.hpp"

#include <gmock/gmock.h>
#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <string>

#include "musher/modules/exec/child.hpp"
#include "musher/test/modules/exec/processes.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::exec::reaper_test {

// A process that leads a group of its own and does nothing.
pid_t PausingGroup() {
  const pid_t pid = fork();
  if (pid == 0) {
    setpgid(0, 0);
    pause();
    _exit(0);
  }
  setpgid(pid, pid);
  return pid;
}

TEST(Reaper, KillsChildrenAndGrandchildrenWhenTheParentIsKilled) {
  const TempFolder folder;
  const std::string line = "sleep infinity & echo $! > " + folder / "grandchild" + "; echo $$ > " +
                           folder / "child" + "; wait";
  const pid_t parent = fork();
  if (parent == 0) {
    const auto reaper = Reaper::Start();
    const auto child = Child::Start({{"sh", "-c", line}, "", {}}, reaper.value());
    std::ofstream(folder / "parent") << getpid() << std::endl;
    pause();
    _exit(1);
  }
  const pid_t child = ReadPid(folder / "child");
  const pid_t grandchild = ReadPid(folder / "grandchild");
  ASSERT_GT(child, 0);
  ASSERT_GT(grandchild, 0);
  ASSERT_EQ(ReadPid(folder / "parent"), parent) << "the reaper has registered the child";
  kill(parent, SIGKILL);
  waitpid(parent, nullptr, 0);
  EXPECT_TRUE(HasExited(child));
  EXPECT_TRUE(HasExited(grandchild));
}

// A point in the start of a program.
enum class Moment { kForked, kExecuted };

// Runs a process that has a reaper and starts a program, kills it by SIGKILL at that point of the
// start, and lets the program continue. Returns the program's pid; 0: processes cannot be traced
// here.
pid_t KillTheParentAt(Moment moment) {
  const pid_t parent = fork();
  if (parent == 0) {
    const auto reaper = Reaper::Start();
    if (ptrace(PTRACE_TRACEME, 0, nullptr, nullptr) != 0) _exit(1);
    raise(SIGSTOP);
    const auto child = Child::Start({{"sleep", "infinity"}, "", {}}, reaper.value());
    pause();
    _exit(1);
  }
  int status = 0;
  waitpid(parent, &status, 0);
  constexpr long kOptions =
      PTRACE_O_TRACEFORK | PTRACE_O_TRACEVFORK | PTRACE_O_TRACECLONE | PTRACE_O_TRACEEXEC;
  if (!WIFSTOPPED(status) || ptrace(PTRACE_SETOPTIONS, parent, nullptr, kOptions) != 0) return 0;
  ptrace(PTRACE_CONT, parent, nullptr, nullptr);
  pid_t child = 0;
  while (true) {
    const pid_t stopped = waitpid(-1, &status, __WALL);
    if (stopped < 0 || !WIFSTOPPED(status)) return 0;
    const bool executed = status >> 8 == (SIGTRAP | (PTRACE_EVENT_EXEC << 8));
    if (stopped != parent) {
      child = stopped;
      if (executed == (moment == Moment::kExecuted)) break;
    }
    ptrace(PTRACE_CONT, stopped, nullptr, nullptr);
  }
  kill(parent, SIGKILL);
  while (waitpid(parent, &status, __WALL) == parent && !WIFSIGNALED(status)) {
  }
  ptrace(PTRACE_DETACH, child, nullptr, nullptr);
  return child;
}

class ReaperInTheMiddleOfAStart : public ::testing::TestWithParam<Moment> {};

TEST_P(ReaperInTheMiddleOfAStart, KillsTheProgramWhenTheParentIsKilledRightAfterTheFork) {
  const pid_t program = KillTheParentAt(GetParam());
  if (program == 0) GTEST_SKIP() << "processes cannot be traced here";
  EXPECT_TRUE(HasExited(program));
  kill(program, SIGKILL);
}

INSTANTIATE_TEST_SUITE_P(Moments, ReaperInTheMiddleOfAStart,
                         ::testing::Values(Moment::kForked, Moment::kExecuted),
                         [](const auto& moment) -> std::string {
                           return moment.param == Moment::kForked ? "Forked" : "Executed";
                         });

TEST(Reaper, LeavesAGroupAloneAfterRemove) {
  const pid_t removed = PausingGroup();
  const pid_t kept = PausingGroup();
  {
    const auto reaper = Reaper::Start();
    ASSERT_TRUE(reaper);
    reaper.value().Add(removed);
    reaper.value().Add(kept);
    reaper.value().Remove(removed);
  }
  EXPECT_EQ(waitpid(kept, nullptr, 0), kept);  // the reaper has done its work
  EXPECT_EQ(waitpid(removed, nullptr, WNOHANG), 0);
  kill(removed, SIGKILL);
  waitpid(removed, nullptr, 0);
}

}  // namespace musher::exec::reaper_test
