#include "musher/modules/exec/child.hpp"

#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <climits>
#include <csignal>
#include <utility>

#include "musher/base/host.hpp"
#include "musher/transport/ros_environment.hpp"

namespace musher::exec {
namespace {

constexpr Duration kExitsWithin = Milliseconds(2000);  // after SIGKILL, on a busy computer

}  // namespace

Result<Child> Child::Start(const ChildSpec& spec, const Reaper& reaper, int output) {
  ProgramSpec program;
  program.argv = spec.argv;
  program.cwd = spec.cwd;
  program.env = spec.env;
  program.output = output;
  // The child registers with the reaper before it executes the program: from then on it is killed
  // when this process exits or crashes.
  program.after_fork = [&reaper](char* const*) {
    setpgid(0, 0);
    reaper.Add(getpid());
  };
  const auto forked = ForkProgram(program);
  if (!forked) return forked.error();
  const pid_t pid = forked.value().pid();
  setpgid(pid, pid);  // the child does so too; either call creates the group
  auto pidfd = OpenPidfd(pid);
  Child child(pid, pidfd ? std::move(pidfd).value() : UniqueFd(), reaper);
  if (!child.pidfd_.valid()) return SystemError("can't watch " + spec.argv.front());
  const auto failure = forked.value().Failure();
  if (!failure) return child;
  Error error = failure->error;
  if (failure->missing) error.message += transport::MissingProgramHint(spec.argv.front());
  return error;
}

Child::Child(Child&& other) noexcept
    : pid_(std::exchange(other.pid_, 0)),
      pidfd_(std::move(other.pidfd_)),
      reaper_(other.reaper_),
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
  kill(-pid_, SIGKILL);  // before the leader is reaped, while the group's number cannot be reused
  reaper_->Remove(pid_);
  status_ = ReapChild(pid_).value_or(ExitStatus::Unknown());
  reaped_ = true;
  return status_;
}

Result<> Child::End(Duration stop_time) const {
  Signal(SIGTERM);
  EndedBy(std::chrono::steady_clock::now() + stop_time);
  Signal(SIGKILL);
  if (EndedBy(std::chrono::steady_clock::now() + std::max(stop_time, kExitsWithin))) return Ok();
  return Error{kCodeFailed, "process " + std::to_string(pid_) + " does not end by SIGKILL"};
}

ExitStatus Child::Stop(Duration stop_time) {
  static_cast<void>(End(stop_time));
  return Reap();
}

}  // namespace musher::exec
