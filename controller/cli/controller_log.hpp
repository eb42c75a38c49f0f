#pragma once
// The controller process's log: a text file for people, beside the journal. Lines wait in a buffer
// of 1 MiB for the disk; what does not fit is dropped, and a line says how much that was.
//
// The file is appended to, and kept within its bound with the others (log_files.hpp). It also takes
// the process's stdout and stderr: what libraries and a crash print.
//
// Threads: the loop's, which waits for no disk. The file is written on the disk thread.

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "musher/controller/disk_writer.hpp"
#include "musher/lifecycle/code.hpp"

namespace musher::cli {

class ControllerLog {
 public:
  // Opened by the first line. The disk must outlive the log.
  ControllerLog(DiskWriter& disk, std::string path);

  // `code` other than 0 makes it a warning. Without a usable file, that is said once on stderr.
  void Write(std::string_view line, std::int32_t code = kCodeOk);

 private:
  struct State;

  DiskWriter& disk_;
  const std::shared_ptr<State> state_;  // shared with the disk thread
};

}  // namespace musher::cli
