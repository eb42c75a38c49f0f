#pragma once
// The controller process's log: a text file for people, beside the journal.
//
// Threads: loop thread only.

#include <memory>
#include <string>
#include <string_view>

#include "musher/lifecycle/code.hpp"

namespace spdlog {
class logger;
}

namespace musher::cli {

class ControllerLog {
 public:
  // Opened by the first line. It then also takes the process's stdout and stderr.
  explicit ControllerLog(std::string path) : path_(std::move(path)) {}
  ~ControllerLog();

  // `code` other than 0 makes it a warning. Without a usable file, says so once on stderr.
  void Write(std::string_view line, std::int32_t code = kCodeOk);

 private:
  void Open();

  std::string path_;
  bool opened_ = false;
  std::shared_ptr<spdlog::logger> logger_;
};

}  // namespace musher::cli
