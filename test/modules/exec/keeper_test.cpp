#include "musher/modules/exec/keeper.hpp"

#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <string>

#include "musher/modules/exec/child.hpp"
#include "musher/test/controller/temp_folder.hpp"
#include "musher/test/modules/exec/processes.hpp"

namespace musher::exec {
namespace {

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

TEST(Keeper, KillsWhatWeStartedAndItsChildrenWhenWeAreKilled) {
  const TempFolder folder;
  const std::string line = "sleep infinity & echo $! > " + folder / "grandchild" + "; echo $$ > " +
                           folder / "child" + "; wait";
  const pid_t parent = fork();
  if (parent == 0) {
    const auto keeper = Keeper::Start();
    const auto child = Child::Start({{"sh", "-c", line}, "", {}}, keeper.value());
    std::ofstream(folder / "parent") << getpid() << std::endl;
    pause();
    _exit(1);
  }
  const pid_t child = ReadPid(folder / "child");
  const pid_t grandchild = ReadPid(folder / "grandchild");
  ASSERT_GT(child, 0);
  ASSERT_GT(grandchild, 0);
  ASSERT_EQ(ReadPid(folder / "parent"), parent) << "the keeper knows of the child from here on";
  kill(parent, SIGKILL);
  waitpid(parent, nullptr, 0);
  EXPECT_TRUE(Gone(child));
  EXPECT_TRUE(Gone(grandchild));
}

TEST(Keeper, LeavesAGroupAloneThatHasEndedForUs) {
  const pid_t removed = PausingGroup();
  const pid_t kept = PausingGroup();
  {
    const auto keeper = Keeper::Start();
    ASSERT_TRUE(keeper);
    keeper.value().Add(removed);
    keeper.value().Add(kept);
    keeper.value().Remove(removed);
  }
  EXPECT_EQ(waitpid(kept, nullptr, 0), kept);  // the keeper has done its work
  EXPECT_EQ(waitpid(removed, nullptr, WNOHANG), 0);
  kill(removed, SIGKILL);
  waitpid(removed, nullptr, 0);
}

}  // namespace
}  // namespace musher::exec
