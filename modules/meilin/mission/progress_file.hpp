#pragma once
// The file of the progress. A thread writes, so that a slow disk never delays a tick, and waits
// until each text is on the disk, in order: a power cut leaves the last or the one before.
//
// Threads: the loop's; `log` is called by the thread. Read() and the destructor wait for the disk.

#include <functional>
#include <string>
#include <utility>

#include "musher/base/files.hpp"
#include "musher/base/work_queue.hpp"

namespace musher::meilin {

class ProgressFile {
 public:
  using Log = std::function<void(const std::string&)>;

  explicit ProgressFile(Log log) : log_(std::move(log)) {}

  void Open(std::string path) { path_ = std::move(path); }
  const std::string& path() const { return path_; }  // empty: there is none

  // What was written last, also by an earlier process; empty: nothing.
  std::string Read() {
    if (path_.empty()) return "";
    thread_.Flush();
    return ReadFile(path_);
  }

  void Write(const std::string& text) {
    if (path_.empty()) return;
    thread_.Do([this, path = path_, text] {
      const Result<> written = ReplaceFile(path, text);
      if (!written && !failed_) log_("the progress is not saved: " + written.error().message);
      failed_ = !written;
    });
  }

 private:
  const Log log_;
  std::string path_;
  bool failed_ = false;                     // of the thread: a failure is logged once
  WorkQueue thread_{{.name = "progress"}};  // last: it uses the rest
};

}  // namespace musher::meilin
