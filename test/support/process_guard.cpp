#include "musher/test/support/process_guard.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <stdexcept>

namespace musher::testing {
namespace {

// Waits until its input ends; then kills each process with the variable until none is left. A
// zombie has no environment.
constexpr const char* kKiller = R"(
  read -r _
  while
    found=$(grep -lsxzF "$1" /proc/[0-9]*/environ)
    [ -n "$found" ]
  do
    for file in $found; do
      process=${file#/proc/}
      kill -KILL "${process%/environ}" 2> /dev/null
    done
  done
)";

}  // namespace

ProcessGuard::ProcessGuard() {
  static int guards = 0;
  variable_ = "MUSHER_TEST_GUARD_" + std::to_string(++guards);
  const std::string value = std::to_string(getpid());
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("pipe2");
  alive_ = ends[1];
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[0], STDIN_FILENO);
  posix_spawnattr_t attributes;  // in a session of its own: an interrupt is not for it
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID);
  std::string shell = "sh";
  std::string option = "-c";
  std::string script = kKiller;
  std::string pattern = variable_ + "=" + value;
  std::array<char*, 6> words = {shell.data(), option.data(),  script.data(),
                                shell.data(), pattern.data(), nullptr};
  const int error = posix_spawnp(&killer_, "sh", &actions, &attributes, words.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[0]);
  if (error != 0) throw std::runtime_error("cannot run sh");
  setenv(variable_.c_str(), value.c_str(), 1);  // after the killer has begun, without it
}

ProcessGuard::~ProcessGuard() {
  unsetenv(variable_.c_str());
  close(alive_);
  waitpid(killer_, nullptr, 0);
}

}  // namespace musher::testing
