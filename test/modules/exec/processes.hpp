#pragma once
// Waiting for events of processes, without sleeping for a guessed time.

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>

#include "musher/base/host.hpp"
#include "musher/test/support/wait.hpp"

namespace musher::exec {

// A timeout far longer than anything here takes; the awaited event ends the wait.
inline Time Soon() {
  return testing::In(std::chrono::seconds(120));
}

// Whether process `pid` has exited, at the latest Soon(). An unreaped process counts as exited.
inline bool HasExited(pid_t pid) {
  const auto pidfd = OpenPidfd(pid);
  if (!pidfd) return true;
  return testing::AwaitReadable(pidfd.value().get(), Soon());
}

// The number in `file` once its line is complete, 0 on a timeout.
inline pid_t ReadPid(const std::string& file) {
  std::string line;
  const bool complete =
      testing::AwaitChange(std::filesystem::path(file).parent_path().string(), [&] {
        std::ifstream stream(file);
        return std::getline(stream, line) && !stream.eof();
      });
  return complete ? std::stoi(line) : 0;
}

}  // namespace musher::exec
