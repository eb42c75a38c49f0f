#include "musher/controller/end_controller.hpp"

#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdint>
#include <fstream>
#include <sstream>
#include <string>

#include "musher/base/host.hpp"
#include "musher/base/scheduling.hpp"
#include "musher/base/words.hpp"
#include "musher/controller/controller.hpp"
#include "musher/controller/storage/state_store.hpp"

namespace musher {
namespace {

constexpr int kReleaseTimeoutMs = 1000;
constexpr int kEndTimeoutMs = 5000;

// SIGKILL is pending, or the process has begun to exit.
bool IsKilled(pid_t pid) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/status");
  constexpr std::uint64_t kKill = std::uint64_t{1} << (SIGKILL - 1);
  for (std::string key; status >> key; std::getline(status, key)) {
    std::uint64_t pending = 0;
    if (key != "SigPnd:" && key != "ShdPnd:") continue;
    if (status >> std::hex >> pending && (pending & kKill) != 0) return true;
  }
  std::ifstream stat("/proc/" + std::to_string(pid) + "/stat");
  std::string text;
  std::getline(stat, text);
  const std::size_t name_end = text.rfind(')');  // a name may contain anything
  if (name_end == std::string::npos) return true;
  std::istringstream rest(text.substr(name_end + 1));
  constexpr std::uint64_t kExiting = 4;  // PF_EXITING of linux/sched.h
  std::string state, skipped;
  std::uint64_t flags = 0;
  rest >> state;
  for (int i = 0; i < 5; ++i) rest >> skipped;
  rest >> flags;
  return state == "Z" || state == "X" || (flags & kExiting) != 0;
}

}  // namespace

bool AwaitKilled(pid_t pid) {
  auto process = OpenPidfd(pid);
  if (!process) return true;
  pollfd ended{process.value().get(), POLLIN, 0};
  return IsKilled(pid) && poll(&ended, 1, kEndTimeoutMs) == 1;
}

Result<> EndController(pid_t pid, const std::function<Result<>()>& is_it) {
  const std::string previous = "the previous controller (pid " + std::to_string(pid) + ")";
  auto process = OpenPidfd(pid);
  if (!process) return Ok();  // it has exited meanwhile
  if (auto proven = is_it(); !proven) return proven;
  pollfd ended{process.value().get(), POLLIN, 0};
  const auto send = [&](int signal) { return SendSignal(ended.fd, signal) || errno == ESRCH; };
  if (!send(kReleaseControlSignal)) return SystemError("can't end " + previous);
  if (poll(&ended, 1, kReleaseTimeoutMs) == 1) return Ok();
  if (!send(SIGKILL)) return SystemError("can't end " + previous);
  if (poll(&ended, 1, kEndTimeoutMs) == 1) return Ok();
  return Error{kCodeTimeout, previous + " does not exit, not even after SIGKILL"};
}

Result<> EndOwnerOf(const std::string& state_dir) {
  const pid_t owner = StateStore::OwnerOf(state_dir);
  return EndController(owner, [&]() -> Result<> {
    if (StateStore::IsOwner(state_dir, owner)) return Ok();
    return Error{kCodePermissionDenied,
                 state_dir + ": its lock file names process " + std::to_string(owner) +
                     ", which does not hold the lock or cannot be inspected; no process is ended; "
                     "`fuser " +
                     ShellWord(state_dir + "/controller.lock") + "` shows the holder"};
  });
}

std::string HowToReplace(pid_t pid) {
  if (RunStateOf(pid) != ProcessRunState::kStopped)
    return "`musher status` shows it, --takeover replaces it";
  return "it is stopped: `kill -CONT " + std::to_string(pid) +
         "` continues it, --takeover replaces it";
}

}  // namespace musher
