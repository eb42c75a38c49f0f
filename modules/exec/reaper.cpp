#include "musher/modules/exec/reaper.hpp"

#include <fcntl.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <set>

#include "musher/base/exit_status.hpp"
#include "musher/base/host.hpp"

namespace musher::exec {
namespace {

// In the reaper's process. `pipe` delivers the number of a group that runs, or its negative for
// one that has ended; it closes when the writing process exits.
[[noreturn]] void Keep(int pipe) {
  setsid();  // signals to the parent's group or terminal must not reach the reaper
  prctl(PR_SET_NAME, "exec-reaper");
  for (const int signal : {SIGTERM, SIGINT, SIGHUP, SIGQUIT}) {
    static_cast<void>(std::signal(signal, SIG_IGN));
  }
  dup2(pipe, 0);
  close_range(1, ~0U, 0);
  std::set<pid_t> groups;
  while (true) {
    pid_t number = 0;
    const ssize_t got = read(0, &number, sizeof(number));
    if (got < 0 && errno == EINTR) continue;
    if (got != sizeof(number)) break;
    if (number > 0) groups.insert(number);
    if (number < 0) groups.erase(-number);
  }
  for (const pid_t group : groups) kill(-group, SIGKILL);
  _exit(0);
}

// A write of so few bytes is atomic. The error is ignored: a reaper that was killed cannot be
// notified.
void Notify(int pipe, pid_t number) {
  [[maybe_unused]] const ssize_t written = write(pipe, &number, sizeof(number));
}

}  // namespace

Result<Reaper> Reaper::Start() {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return SystemError("can't make a pipe");
  UniqueFd reader(ends[0]);
  UniqueFd writer(ends[1]);
  const pid_t pid = fork();
  if (pid < 0) return SystemError("can't fork");
  if (pid == 0) Keep(reader.get());
  return Reaper(pid, std::move(writer));
}

Reaper::~Reaper() {
  if (pid_ == 0) return;
  pipe_ = UniqueFd();
  ReapChild(pid_);
}

void Reaper::Add(pid_t group) const {
  Notify(pipe_.get(), group);
}
void Reaper::Remove(pid_t group) const {
  Notify(pipe_.get(), -group);
}

}  // namespace musher::exec
