#pragma once
// The file of a recording. FILE of the run before is kept once as FILE.before.
//
// Threads: the one that writes, but for the atomics.

#include <atomic>
#include <chrono>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include "musher/base/unique_fd.hpp"

namespace musher {

class RecordingFile {
 public:
  explicit RecordingFile(std::string path) : path_(std::move(path)) {}

  // Begins an empty file. One that is there is kept, unless it has nothing but the line with which
  // each recording begins: a run in which nothing was recorded replaces no recording of a crash.
  bool Open();
  // Syncs once a second.
  bool Write(std::string_view text);
  const std::string& path() const { return path_; }

  std::atomic<std::size_t> pending = 0;  // bytes that wait for the disk
  std::atomic<bool> failed = false;

 private:
  const std::string path_;
  UniqueFd fd_;
  std::chrono::steady_clock::time_point synced_{};
};

}  // namespace musher
