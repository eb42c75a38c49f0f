#pragma once
// The controller process's log: a text file for people, beside the journal. Lines wait for the disk
// in a buffer of 1 MiB; lines that do not fit are dropped, and one line reports how many.
//
// The file is appended to; log_files.hpp enforces its size limit. It also receives the process's
// stdout and stderr: the output of libraries and of a crash.
//
// Threads: Write() runs on the loop thread and never waits for the disk. The disk thread writes the
// file.

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "musher/base/code.hpp"
#include "musher/transport/disk_writer.hpp"

namespace musher::cli {

class ControllerLog {
 public:
  // The first line opens the file. The disk must outlive the log. A link is followed only where it
  // `may_be_link`, and no other user can put one there.
  ControllerLog(transport::DiskWriter& disk, std::string path, bool may_be_link = false);

  // A `code` other than 0 makes the line a warning. An unusable file is reported once on stderr.
  void Write(std::string_view line, std::int32_t code = kCodeOk);

 private:
  struct State;

  transport::DiskWriter& disk_;
  const std::shared_ptr<State> state_;  // shared with the disk thread
};

}  // namespace musher::cli
