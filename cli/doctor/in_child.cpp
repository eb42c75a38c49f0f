#include "musher/cli/doctor/in_child.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <utility>

#include "musher/base/exit_status.hpp"
#include "musher/base/files.hpp"
#include "musher/base/host.hpp"

namespace musher::cli {

Result<InChild> InChild::Start(const std::function<std::string()>& function) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) return SystemError("pipe");
  UniqueFd output(ends[0]);
  const UniqueFd input(ends[1]);
  const pid_t pid = fork();
  if (pid < 0) return SystemError("fork");
  if (pid == 0) {
    output = {};
    WriteAll(input.get(), function());
    _exit(0);
  }
  return InChild(pid, std::move(output));
}

InChild::InChild(InChild&& other) noexcept
    : pid_(std::exchange(other.pid_, 0)), output_(std::move(other.output_)) {}

InChild::~InChild() {
  if (pid_ == 0) return;
  kill(pid_, SIGKILL);
  // A child that a disk holds is left to the init process.
  ReapEndedChild(pid_);
}

Result<std::string> InChild::Await(Time deadline) {
  std::string text;
  std::array<char, 4096> part{};
  for (;;) {
    const Duration left = deadline - std::chrono::steady_clock::now();
    pollfd readable{output_.get(), POLLIN, 0};
    const int ready =
        poll(&readable, 1, static_cast<int>(std::max<std::int64_t>(ToMilliseconds(left), 0)));
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0) return Error{kCodeTimeout, "no result in time"};
    const ssize_t count = read(output_.get(), part.data(), part.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    text.append(part.data(), static_cast<std::size_t>(count));
  }
  const auto status = ReapChild(std::exchange(pid_, 0));
  if (!status || status->killed) return Error{kCodeFailed, "the process that checked it crashed"};
  return text;
}

}  // namespace musher::cli
