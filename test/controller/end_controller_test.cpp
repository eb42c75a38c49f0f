// A controller that is killed holds its locks until it has exited: the next one waits for that.

#include "musher/controller/end_controller.hpp"

#include <gtest/gtest.h>
#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <future>
#include <string>

#include "musher/base/host.hpp"

namespace musher::end_controller_test {

class AwaitKilledTest : public ::testing::Test {
 protected:
  // A process that holds a name until it is killed.
  void SetUp() override {
    name_ = "musher-test/" + std::to_string(getpid()) + "/killed";
    int ready[2];
    ASSERT_EQ(pipe(ready), 0);
    child_ = fork();
    ASSERT_GE(child_, 0);
    if (child_ == 0) {
      const auto lock = NameLock::Acquire(name_);
      if (!lock || write(ready[1], "x", 1) != 1) _exit(1);
      for (;;) pause();
    }
    char byte = 0;
    ASSERT_EQ(read(ready[0], &byte, 1), 1);
    close(ready[0]);
    close(ready[1]);
  }
  void TearDown() override {
    kill(child_, SIGKILL);
    waitpid(child_, nullptr, 0);
  }

  std::string name_;
  pid_t child_ = 0;
};

TEST_F(AwaitKilledTest, DoesNotWaitForAProcessThatRuns) {
  EXPECT_FALSE(AwaitKilled(child_));
  EXPECT_TRUE(NameLock::IsHeld(name_));
}

TEST_F(AwaitKilledTest, IsTrueForAProcessThatHasExited) {
  kill(child_, SIGKILL);
  siginfo_t info{};
  ASSERT_EQ(waitid(P_PID, static_cast<id_t>(child_), &info, WEXITED | WNOWAIT), 0);
  EXPECT_TRUE(AwaitKilled(child_)) << "a zombie";
  EXPECT_FALSE(NameLock::IsHeld(name_));
}

// A tracer stops it on its way out, where it still holds the name.
TEST_F(AwaitKilledTest, WaitsForAProcessThatIsKilledAndStillHoldsItsName) {
  if (ptrace(PTRACE_SEIZE, child_, nullptr, PTRACE_O_TRACEEXIT) != 0) {
    GTEST_SKIP() << "this user may not trace a process";
  }
  kill(child_, SIGKILL);
  int status = 0;
  ASSERT_EQ(waitpid(child_, &status, 0), child_);
  ASSERT_TRUE(WIFSTOPPED(status));
  ASSERT_TRUE(NameLock::IsHeld(name_));
  auto waited = std::async(std::launch::async, [&] { return AwaitKilled(child_); });
  ASSERT_EQ(ptrace(PTRACE_CONT, child_, nullptr, nullptr), 0);
  EXPECT_TRUE(waited.get());
  EXPECT_TRUE(NameLock::Acquire(name_).ok());
}

}  // namespace musher::end_controller_test
