#include "musher/base/exit_status.hpp"

#include <sys/wait.h>

#include <cerrno>
#include <cstring>

namespace musher {
namespace {

std::optional<ExitStatus> Reap(pid_t pid, int options) {
  int status = 0;
  pid_t reaped = 0;
  do {
    reaped = waitpid(pid, &status, options);
  } while (reaped < 0 && errno == EINTR);
  return reaped == pid ? std::optional(ExitStatus::FromWait(status)) : std::nullopt;
}

}  // namespace

ExitStatus ExitStatus::FromWait(int status) {
  return WIFSIGNALED(status) ? ExitStatus{true, WTERMSIG(status)}
                             : ExitStatus{false, WEXITSTATUS(status)};
}

std::string ExitStatus::Text() const {
  if (*this == Unknown()) return "exit status unknown";
  if (!killed) return "exit code " + std::to_string(number);
  const char* name = sigabbrev_np(number);
  return "killed by " +
         (name != nullptr ? "SIG" + std::string(name) : "signal " + std::to_string(number));
}

std::optional<ExitStatus> ReapChild(pid_t pid) {
  return Reap(pid, 0);
}

std::optional<ExitStatus> ReapEndedChild(pid_t pid) {
  return Reap(pid, WNOHANG);
}

}  // namespace musher
