// `musher up` as process 1 of a container: here of a pid namespace.

#include <sys/stat.h>

#include <csignal>

#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing::container_test {

std::vector<pid_t> ChildrenOf(pid_t pid) {
  const std::string number = std::to_string(pid);
  std::ifstream file("/proc/" + number + "/task/" + number + "/children");
  std::vector<pid_t> children;
  for (pid_t child = 0; file >> child;) children.push_back(child);
  return children;
}

// Those below `pid` that have ended and that no parent has taken off the kernel's books.
int ZombiesBelow(pid_t pid) {
  int zombies = 0;
  for (const pid_t child : ChildrenOf(pid)) {
    const std::string stat = ReadFile("/proc/" + std::to_string(child) + "/stat");
    const bool ended = stat.find(") Z ") != std::string::npos;
    zombies += (ended ? 1 : 0) + ZombiesBelow(child);
  }
  return zombies;
}

class Container : public MachineByCli {
 protected:
  static std::vector<std::string> Unshare(std::vector<std::string> words) {
    words.insert(words.begin(), {"unshare", "--pid", "--fork", "--kill-child", "--mount-proc"});
    return words;
  }
  void SetUp() override {
    if (RunToEnd(Unshare({"true"})).exit != 0) GTEST_SKIP() << "a pid namespace needs root";
  }
};

TEST_F(Container, ReapsWhatModulesLeaveBehindAndEndsAtSigtermWithTheRobotTornDown) {
  const std::string fifo = folder_ / "fifo";
  ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
  Does("voice",
       "[state.SetUp]\nshell = \"setsid -f sh -c 'echo > " + fifo + "'; cat " + fifo + "\"\n");
  Process up(Unshare(Command({"up", config_})));
  ASSERT_NE(up.LineWith("the machine is Active"), "");
  EXPECT_TRUE(Until([&up] { return ZombiesBelow(up.pid()) == 0; }));
  const auto first = ChildrenOf(up.pid());
  ASSERT_EQ(first.size(), 1U);
  kill(first.front(), SIGTERM);
  const Ended ended = up.Wait();
  EXPECT_EQ(ended.exit, 0);
  EXPECT_THAT(ended.out, ::testing::HasSubstr("the machine is stopped"));
}

}  // namespace musher::testing::container_test
