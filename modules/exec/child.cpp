#include "musher/modules/exec/child.hpp"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <climits>
#include <csignal>
#include <cstring>
#include <string_view>
#include <utility>

#include "musher/transport/host.hpp"

namespace musher::exec {
namespace {

class SpawnAttributes {
 public:
  SpawnAttributes() {
    posix_spawnattr_init(&attributes_);
    posix_spawnattr_setpgroup(&attributes_, 0);
    sigset_t none;
    sigset_t all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setsigdefault(&attributes_, &all);
    posix_spawnattr_setflags(
        &attributes_, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  }
  ~SpawnAttributes() { posix_spawnattr_destroy(&attributes_); }
  SpawnAttributes(const SpawnAttributes&) = delete;
  SpawnAttributes& operator=(const SpawnAttributes&) = delete;

  const posix_spawnattr_t* get() const { return &attributes_; }

 private:
  posix_spawnattr_t attributes_;
};

class SpawnFiles {
 public:
  SpawnFiles(const std::string& cwd, int output) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_addopen(&actions_, 0, "/dev/null", O_RDONLY, 0);
    if (output >= 0) {
      posix_spawn_file_actions_adddup2(&actions_, output, 1);
      posix_spawn_file_actions_adddup2(&actions_, output, 2);
    }
    posix_spawn_file_actions_addclosefrom_np(&actions_, 3);  // DDS sockets are not close-on-exec
    if (!cwd.empty()) posix_spawn_file_actions_addchdir_np(&actions_, cwd.c_str());
  }
  ~SpawnFiles() { posix_spawn_file_actions_destroy(&actions_); }
  SpawnFiles(const SpawnFiles&) = delete;
  SpawnFiles& operator=(const SpawnFiles&) = delete;

  const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_;
};

std::vector<char*> Pointers(const std::vector<std::string>& strings) {
  std::vector<char*> pointers;
  pointers.reserve(strings.size() + 1);
  for (const std::string& text : strings) pointers.push_back(const_cast<char*>(text.c_str()));
  pointers.push_back(nullptr);
  return pointers;
}

std::vector<std::string> Environment(const std::map<std::string, std::string>& extra) {
  std::vector<std::string> environment;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view text = *entry;
    if (!extra.contains(std::string(text.substr(0, text.find('=')))))
      environment.emplace_back(text);
  }
  for (const auto& [name, value] : extra) {
    environment.emplace_back(name).append("=").append(value);
  }
  return environment;
}

}  // namespace

std::string ExitStatus::Text() const {
  if (!killed) return "exit code " + std::to_string(number);
  const char* name = sigabbrev_np(number);
  return "killed by " +
         (name != nullptr ? "SIG" + std::string(name) : "signal " + std::to_string(number));
}

Result<Child> Child::Start(const ChildSpec& spec, const Keeper& keeper, int output) {
  const SpawnAttributes attributes;
  const SpawnFiles files(spec.cwd, output);
  const std::vector<std::string> environment = Environment(spec.env);
  pid_t pid = 0;
  const int error = posix_spawnp(&pid, spec.argv.front().c_str(), files.get(), attributes.get(),
                                 Pointers(spec.argv).data(), Pointers(environment).data());
  const std::string where = spec.cwd.empty() ? "" : " in " + spec.cwd;
  if (error != 0) return transport::SystemError("can't run " + spec.argv.front() + where, error);
  keeper.Add(pid);
  auto pidfd = transport::OpenPidfd(pid);
  Child child(pid, pidfd ? std::move(pidfd).value() : transport::UniqueFd(), keeper);
  if (!child.pidfd_.valid()) return transport::SystemError("can't watch " + spec.argv.front());
  return child;
}

Child::Child(Child&& other) noexcept
    : pid_(std::exchange(other.pid_, 0)),
      pidfd_(std::move(other.pidfd_)),
      keeper_(other.keeper_),
      reaped_(other.reaped_),
      status_(other.status_) {}

Child::~Child() {
  if (pid_ == 0 || reaped_) return;
  Signal(SIGKILL);
  Reap();
}

bool Child::EndedBy(Time deadline) const {
  if (reaped_) return true;
  pollfd ended{pidfd_.get(), POLLIN, 0};
  while (true) {
    const Time now = std::chrono::steady_clock::now();
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(std::max(deadline, now) - now);
    const auto timeout = std::min<std::int64_t>(left.count(), INT_MAX);
    const int ready = poll(&ended, 1, static_cast<int>(timeout));
    if (ready >= 0 || errno != EINTR) return ready > 0;
  }
}

void Child::Signal(int signal) const {
  if (!reaped_) kill(-pid_, signal);
}

ExitStatus Child::Reap() {
  if (reaped_) return status_;
  siginfo_t info{};
  while (waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOWAIT) != 0 && errno == EINTR) {
  }
  kill(-pid_, SIGKILL);  // before the leader is reaped, while the group's number is surely its own
  keeper_->Remove(pid_);
  while (waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED) != 0 && errno == EINTR) {
  }
  reaped_ = true;
  status_ = {info.si_code != CLD_EXITED, info.si_status};
  return status_;
}

ExitStatus Child::Stop(Duration stop_time) {
  Signal(SIGTERM);
  if (!EndedBy(std::chrono::steady_clock::now() + stop_time)) Signal(SIGKILL);
  return Reap();
}

}  // namespace musher::exec
