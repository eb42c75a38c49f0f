#include "musher/actuator/exit_guard.hpp"

#include <unistd.h>

#include <atomic>
#include <cstdlib>

#include "musher/base/log.hpp"

namespace musher {
namespace {

std::atomic<const std::string*> newest = nullptr;
std::atomic<int> guards = 0;
std::atomic<pid_t> guarded = 0;  // a child that a callback forks is none

void EndAsFailed(int exit_code, void*) {
  if (exit_code != EXIT_SUCCESS || guards == 0 || guarded != getpid()) return;
  if (const std::string* actuator = newest) {
    WriteLog(LogLevel::kError, *actuator,
             "the process exits in the middle of its TearDown: the exit code is 1 instead of 0");
  }
  std::exit(EXIT_FAILURE);  // glibc goes on with what the program does at its exit
}

[[maybe_unused]] const int registered = on_exit(&EndAsFailed, nullptr);

}  // namespace

ExitGuard::ExitGuard(const std::string& actuator) : actuator_(actuator) {
  guarded = getpid();
  newest = &actuator_;
  ++guards;
}

ExitGuard::~ExitGuard() {
  --guards;
  const std::string* own = &actuator_;
  newest.compare_exchange_strong(own, nullptr);
}

}  // namespace musher
