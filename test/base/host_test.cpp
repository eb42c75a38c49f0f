#include "musher/base/host.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <poll.h>
#include <pwd.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <utility>

#include "musher/base/scheduling.hpp"
#include "musher/base/user.hpp"

namespace musher::transport::host_test {

using ::testing::HasSubstr;

std::string UniqueName(const std::string& name) {
  return NameLock::NameOf(0, "host_test_" + std::to_string(getpid()), name);
}

// A child that runs `work`, reports its end, and stays until it is killed.
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

TEST(UserAtHost, IsTheSameWithoutTheDatabaseOfUsers) {
  EXPECT_EQ(UserAtHostAtOnce(), UserAtHost());
  EXPECT_THAT(UserAtHostAtOnce(), HasSubstr("@" + HostName()));
}

// UserAtHostAtOnce() in a process of that user, whose LOGNAME is `login`; null: it has none.
std::string NameOfUser(uid_t user, const char* login) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) return "no pipe";
  const pid_t child = fork();
  if (child == 0) {
    unsetenv("LOGNAME");
    if (login != nullptr) setenv("LOGNAME", login, 1);
    if (setuid(user) != 0) _exit(1);
    const std::string name = UserAtHostAtOnce();
    _exit(write(ends[1], name.data(), name.size()) < 0 ? 1 : 0);
  }
  close(ends[1]);
  std::array<char, 256> name{};
  const ssize_t size = read(ends[0], name.data(), name.size());
  close(ends[0]);
  waitpid(child, nullptr, 0);
  return {name.data(), static_cast<std::size_t>(std::max<ssize_t>(size, 0))};
}

// As one of LDAP, or of a container that runs with a number only.
TEST(UserAtHost, OfOneWhoIsNotInTheFileIsTheLoginOrTheNumberWhereItMustNotWait) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can be another user";
  constexpr uid_t kUnknown = 64123;
  ASSERT_EQ(getpwuid(kUnknown), nullptr);
  EXPECT_EQ(NameOfUser(kUnknown, "alice"), "alice@" + HostName());
  EXPECT_EQ(NameOfUser(kUnknown, ""), "64123@" + HostName());
  EXPECT_EQ(NameOfUser(kUnknown, nullptr), "64123@" + HostName());
  EXPECT_EQ(NameOfUser(0, "alice"), UserAtHost()) << "the file is before the environment";
}

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

TEST(Process, IsStoppedFromSigstopToSigcont) {
  Child child([] { return 0; });
  ASSERT_TRUE(child.ready());
  EXPECT_EQ(RunStateOf(child.pid()), ProcessRunState::kRunning);
  kill(child.pid(), SIGSTOP);
  int status = 0;
  ASSERT_EQ(waitpid(child.pid(), &status, WUNTRACED), child.pid());
  EXPECT_EQ(RunStateOf(child.pid()), ProcessRunState::kStopped);
  kill(child.pid(), SIGCONT);
  ASSERT_EQ(waitpid(child.pid(), &status, WCONTINUED), child.pid());
  EXPECT_EQ(RunStateOf(child.pid()), ProcessRunState::kRunning);
}

TEST(Pidfd, BecomesReadableWhenTheProcessEnds) {
  Child child([] { return 0; });
  ASSERT_TRUE(child.ready());
  const auto fd = OpenPidfd(child.pid());
  ASSERT_TRUE(fd);
  pollfd watched{fd.value().get(), POLLIN, 0};
  EXPECT_EQ(poll(&watched, 1, 0), 0) << "it still runs";
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

TEST(NameLock, HandsMessagesToItsHolder) {
  const std::string name = UniqueName("motion");
  const std::array<std::byte, 3> message{std::byte{1}, std::byte{0}, std::byte{2}};
  EXPECT_FALSE(NameLock::Send(name, message)) << "no process holds it";
  auto lock = NameLock::Acquire(name);
  ASSERT_TRUE(lock);
  EXPECT_FALSE(lock.value().Receive());
  EXPECT_TRUE(NameLock::IsHeld(name)) << "which sends nothing";
  EXPECT_TRUE(NameLock::Send(name, message));
  EXPECT_TRUE(NameLock::Send(name, {}));
  const auto received = lock.value().Receive();
  ASSERT_TRUE(received);
  EXPECT_TRUE(std::ranges::equal(*received, message));
  ASSERT_TRUE(lock.value().Receive());
  EXPECT_FALSE(lock.value().Receive());
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

TEST(NameLock, ReportsWhichProcessHoldsTheName) {
  const std::string name = UniqueName("legs");
  EXPECT_EQ(NameLock::HolderOf(name).pid, 0);
  Child holder([&] { return NameLock::Acquire(name); });
  ASSERT_TRUE(holder.ready());
  EXPECT_EQ(NameLock::HolderOf(name).pid, holder.pid());
  EXPECT_TRUE(NameLock::HolderOf(name).trusted);
  EXPECT_EQ(NameLock::HolderOf(name + "2").pid, 0);
  holder.Kill();
  EXPECT_EQ(NameLock::HolderOf(name).pid, 0);
}

TEST(NameLock, ReportsTheHoldersOfAllNamesBelowAPrefixAtOnce) {
  const std::string prefix = UniqueName("pack") + "/";
  EXPECT_TRUE(NameLock::HoldersBelow(prefix).empty());
  Child legs([&] { return NameLock::Acquire(prefix + "legs"); });
  Child others([&] {
    return std::pair(NameLock::Acquire(prefix + "arm"), NameLock::Acquire(prefix + "eyes"));
  });
  Child deeper([&] { return NameLock::Acquire(prefix + "musher/controller"); });
  ASSERT_TRUE(legs.ready() && others.ready() && deeper.ready());
  const auto holders = NameLock::HoldersBelow(prefix);
  ASSERT_EQ(holders.size(), 3U);
  EXPECT_EQ(holders.at("legs").pid, legs.pid());
  EXPECT_EQ(holders.at("arm").pid, others.pid());
  EXPECT_EQ(holders.at("eyes").pid, others.pid());
  EXPECT_TRUE(holders.at("eyes").trusted);
}

// As one that is passed to another process, and that no process has open at the moment.
TEST(NameLock, ReportsAlsoANameWhoseHolderIsNotFound) {
  std::array<int, 2> ends{};
  ASSERT_EQ(socketpair(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0, ends.data()), 0);
  const std::string prefix = UniqueName("passed") + "/";
  {
    const auto lock = NameLock::Acquire(prefix + "legs");
    ASSERT_TRUE(lock);
    char byte = 'x';
    iovec part{&byte, 1};
    alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
    msghdr header{};
    header.msg_iov = &part;
    header.msg_iovlen = 1;
    header.msg_control = control.data();
    header.msg_controllen = control.size();
    cmsghdr* passed = CMSG_FIRSTHDR(&header);
    passed->cmsg_level = SOL_SOCKET;
    passed->cmsg_type = SCM_RIGHTS;
    passed->cmsg_len = CMSG_LEN(sizeof(int));
    const int fd = lock.value().fd();
    std::memcpy(CMSG_DATA(passed), &fd, sizeof(fd));
    ASSERT_EQ(sendmsg(ends[0], &header, 0), 1);
  }
  const auto holders = NameLock::HoldersBelow(prefix);
  ASSERT_EQ(holders.size(), 1U);
  EXPECT_EQ(holders.at("legs").pid, 0);
  for (const int end : ends) close(end);
}

TEST(NameLock, ReportsTheProcessAndTheUserThatHoldTheName) {
  const std::string name = UniqueName("motion");
  Child holder([&] { return NameLock::Acquire(name); });
  ASSERT_TRUE(holder.ready());
  const auto second = NameLock::Acquire(name);
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().message, HasSubstr("process " + std::to_string(holder.pid()) +
                                                " of user " + std::to_string(getuid())));
}

TEST(NameLock, ProvesAProcessOnlyByTheNameThatItHolds) {
  const std::string name = UniqueName("motion");
  Child holder([&] { return NameLock::Acquire(name); });
  Child other([&] { return NameLock::Acquire(name + "2"); });
  ASSERT_TRUE(holder.ready() && other.ready());
  EXPECT_TRUE(NameLock::CheckHolder(name, holder.pid()));
  EXPECT_EQ(NameLock::CheckHolder(name, other.pid()).error().code, kCodePermissionDenied);
  EXPECT_EQ(NameLock::CheckHolder(name, getpid()).error().code, kCodePermissionDenied);
  EXPECT_EQ(NameLock::CheckHolder(UniqueName("arm"), holder.pid()).error().code,
            kCodePermissionDenied);
  const pid_t pid = other.pid();
  other.Kill();
  EXPECT_EQ(NameLock::CheckHolder(name, pid).error().code, kCodeStateInvalid);
  EXPECT_FALSE(NameLock::CheckHolder(name, 0));
  EXPECT_FALSE(NameLock::CheckHolder(name, -1));
}

TEST(NameLock, DoesNotProveAProcessOfAnotherUser) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can be another user";
  constexpr uid_t kOtherUid = 65534;
  const std::string name = UniqueName("motion");
  Child holder([&] {
    const bool other_user = setresuid(kOtherUid, kOtherUid, kOtherUid) == 0;
    return std::make_unique<Result<NameLock>>(
        NameLock::Acquire(other_user ? name : "could not become another user"));
  });
  ASSERT_TRUE(holder.ready());
  const NameLock::Holder found = NameLock::HolderOf(name);
  EXPECT_EQ(found.pid, holder.pid());
  EXPECT_EQ(found.uid, kOtherUid);
  EXPECT_FALSE(found.trusted);
  const auto proven = NameLock::CheckHolder(name, holder.pid());
  ASSERT_FALSE(proven);
  EXPECT_THAT(proven.error().message, HasSubstr("of user 65534"));
}

// The lock is another user's, even if a process of this user has its descriptor.
TEST(NameLock, DoesNotProveAProcessThatHoldsTheNameOfAnotherUser) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can be another user";
  constexpr uid_t kOtherUid = 65534;
  const std::string name = UniqueName("motion");
  Child holder([&] {
    const bool other_user = seteuid(kOtherUid) == 0;
    auto lock = std::make_unique<Result<NameLock>>(
        NameLock::Acquire(other_user ? name : "could not become another user"));
    return seteuid(0) == 0 ? std::move(lock) : nullptr;
  });
  ASSERT_TRUE(holder.ready());
  EXPECT_FALSE(NameLock::CheckHolder(name, holder.pid()));
}

TEST(FileLock, IsProvenOfTheProcessThatHoldsIt) {
  const std::string path = ::testing::TempDir() + "host_test_" + std::to_string(getpid());
  for (const bool of_open_file : {false, true}) {
    const auto lock = [&] {
      UniqueFd file(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600));
      struct flock whole {};
      whole.l_type = F_WRLCK;
      const bool locked = of_open_file ? fcntl(file.get(), F_OFD_SETLK, &whole) == 0
                                       : flock(file.get(), LOCK_EX | LOCK_NB) == 0;
      return locked ? std::move(file) : UniqueFd();
    };
    Child holder(lock);
    Child reader([&] { return UniqueFd(open(path.c_str(), O_RDWR | O_CLOEXEC)); });
    ASSERT_TRUE(holder.ready() && reader.ready());
    EXPECT_TRUE(HoldsLockOn(holder.pid(), path));
    EXPECT_FALSE(HoldsLockOn(reader.pid(), path)) << "it has the file open, and no lock";
    EXPECT_FALSE(HoldsLockOn(getpid(), path));
    EXPECT_FALSE(HoldsLockOn(0, path));
    const pid_t pid = holder.pid();
    holder.Kill();
    EXPECT_FALSE(HoldsLockOn(pid, path));
  }
  EXPECT_FALSE(HoldsLockOn(getpid(), path + "2"));
  unlink(path.c_str());
}

TEST(NameLock, RefusesANameThatIsTooLong) {
  EXPECT_TRUE(NameLock::Acquire(std::string(100, 'n')));
  const auto lock = NameLock::Acquire(std::string(101, 'n'));
  ASSERT_FALSE(lock);
  EXPECT_EQ(lock.error().code, kCodeParametersInvalid);
}

TEST(SendSignal, ReachesTheProcessOfThePidfdOnly) {
  Child child([] { return 0; });
  ASSERT_TRUE(child.ready());
  const auto process = OpenPidfd(child.pid());
  ASSERT_TRUE(process.ok());
  EXPECT_TRUE(SendSignal(process.value().get(), 0));
  EXPECT_TRUE(SendSignal(process.value().get(), SIGKILL));
  child.Kill();
  EXPECT_FALSE(SendSignal(process.value().get(), 0));
  EXPECT_EQ(errno, ESRCH);
}

}  // namespace musher::transport::host_test
