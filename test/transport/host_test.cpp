#include "musher/transport/host.hpp"

#include <gmock/gmock.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <string>

namespace musher::transport {
namespace {

using testing::HasSubstr;

std::string UniqueName(const std::string& name) {
  return NameLock::NameOf(0, "host_test_" + std::to_string(getpid()), name);
}

// A child that runs `work`, tells that it is done with it, and stays until it is killed.
class Child {
 public:
  template <typename Work>
  explicit Child(Work work) {
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) return;
    pid_ = fork();
    if (pid_ == 0) {
      [[maybe_unused]] const auto held = work();
      if (write(ends[1], "r", 1) == 1) pause();
      _exit(1);
    }
    char ready = 0;
    ready_ = read(ends[0], &ready, 1) == 1;
    close(ends[0]);
    close(ends[1]);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() { Kill(); }

  void Kill() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
    pid_ = -1;
  }

  pid_t pid() const { return pid_; }
  bool ready() const { return ready_; }

 private:
  pid_t pid_ = -1;
  bool ready_ = false;
};

TEST(HostId, IsTheSameInEveryProcessOfTheHost) {
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe(ends.data()), 0);
  const pid_t child = fork();
  if (child == 0) {
    const std::string id = HostId();
    _exit(write(ends[1], id.data(), id.size()) == static_cast<ssize_t>(id.size()) ? 0 : 1);
  }
  waitpid(child, nullptr, 0);
  std::array<char, 256> buffer{};
  const ssize_t size = read(ends[0], buffer.data(), buffer.size());
  close(ends[0]);
  close(ends[1]);
  ASSERT_GT(size, 36);  // a boot id alone
  EXPECT_EQ(HostId(), std::string(buffer.data(), static_cast<std::size_t>(size)));
}

TEST(Pidfd, BecomesReadableWhenTheProcessEnds) {
  Child child([] { return 0; });
  ASSERT_TRUE(child.ready());
  const auto fd = OpenPidfd(child.pid());
  ASSERT_TRUE(fd);
  pollfd watched{fd.value().get(), POLLIN, 0};
  EXPECT_EQ(poll(&watched, 1, 0), 0) << "it lives still";
  child.Kill();
  EXPECT_EQ(poll(&watched, 1, 20000), 1);
}

TEST(Pidfd, IsRefusedWhenThereIsNoSuchProcess) {
  Child child([] { return 0; });
  const pid_t pid = child.pid();
  child.Kill();
  const auto fd = OpenPidfd(pid);
  ASSERT_FALSE(fd);
  EXPECT_EQ(fd.error().message, "can't watch process " + std::to_string(pid) + ": No such process");
}

TEST(NameLock, IsHeldByOneAtATime) {
  const std::string name = UniqueName("motion");
  EXPECT_FALSE(NameLock::IsHeld(name));
  {
    const auto lock = NameLock::Acquire(name);
    ASSERT_TRUE(lock);
    EXPECT_TRUE(NameLock::IsHeld(name));
    const auto second = NameLock::Acquire(name);
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().code, kCodeTargetBusy);
    EXPECT_THAT(second.error().message, HasSubstr(name));
  }
  EXPECT_FALSE(NameLock::IsHeld(name));
  EXPECT_TRUE(NameLock::Acquire(name));
}

TEST(NameLock, KeepsOtherNamesDomainsAndNamespacesFree) {
  const auto lock = NameLock::Acquire(NameLock::NameOf(7, UniqueName("a"), "motion"));
  ASSERT_TRUE(lock);
  EXPECT_FALSE(NameLock::IsHeld(NameLock::NameOf(8, UniqueName("a"), "motion")));
  EXPECT_FALSE(NameLock::IsHeld(NameLock::NameOf(7, UniqueName("b"), "motion")));
  EXPECT_FALSE(NameLock::IsHeld(NameLock::NameOf(7, UniqueName("a"), "motion2")));
  EXPECT_FALSE(NameLock::IsHeld(NameLock::NameOf(7, UniqueName("a"), "motio")));
}

TEST(NameLock, IsFreedByTheKernelWhenItsHolderIsKilled) {
  const std::string name = UniqueName("audio");
  Child holder([&] { return NameLock::Acquire(name); });
  ASSERT_TRUE(holder.ready());
  EXPECT_TRUE(NameLock::IsHeld(name));
  holder.Kill();
  EXPECT_FALSE(NameLock::IsHeld(name));
  EXPECT_TRUE(NameLock::Acquire(name));
}

TEST(NameLock, TellsWhichProcessHoldsTheName) {
  const std::string name = UniqueName("legs");
  EXPECT_EQ(NameLock::HolderOf(name), 0);
  Child holder([&] { return NameLock::Acquire(name); });
  ASSERT_TRUE(holder.ready());
  EXPECT_EQ(NameLock::HolderOf(name), holder.pid());
  EXPECT_EQ(NameLock::HolderOf(name + "2"), 0);
  holder.Kill();
  EXPECT_EQ(NameLock::HolderOf(name), 0);
}

TEST(NameLock, RefusesANameThatIsTooLong) {
  EXPECT_TRUE(NameLock::Acquire(std::string(100, 'n')));
  const auto lock = NameLock::Acquire(std::string(101, 'n'));
  ASSERT_FALSE(lock);
  EXPECT_EQ(lock.error().code, kCodeParametersInvalid);
}

}  // namespace
}  // namespace musher::transport
