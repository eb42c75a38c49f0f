#pragma once
// Waiting for events of processes, without sleeping for a guessed time.

#include <dirent.h>
#include <poll.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <string>

#include "musher/base/host.hpp"

namespace musher::exec {

// A timeout far longer than anything here takes; the awaited event ends the wait.
inline Time Soon() {
  return std::chrono::steady_clock::now() + std::chrono::seconds(20);
}

// Whether process `pid` has exited, at the latest Soon(). An unreaped process counts as exited.
inline bool HasExited(pid_t pid) {
  const auto pidfd = OpenPidfd(pid);
  if (!pidfd) return true;
  pollfd ended{pidfd.value().get(), POLLIN, 0};
  return poll(&ended, 1, 20'000) == 1;
}

// The number in `file` once its line is complete, 0 on a timeout.
inline pid_t ReadPid(const std::string& file) {
  for (const Time deadline = Soon(); std::chrono::steady_clock::now() < deadline;) {
    std::ifstream stream(file);
    std::string line;
    if (std::getline(stream, line) && !stream.eof()) return std::stoi(line);
    poll(nullptr, 0, 5);
  }
  return 0;
}

}  // namespace musher::exec
