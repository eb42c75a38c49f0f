#pragma once
// The log files of a robot: logs/<actuator>.log, which the actuators' processes write, and
// controller.log. Opens them, and keeps each and all of them together within their bounds.
//
// Processes write into the file itself, opened for appending: they outlive the controller, and
// neither block on a reader nor get SIGPIPE. When a live file is too large, its older part goes
// into <file>.<n>.gz, is synced, and is then taken off the front of the live file, which is
// appended to meanwhile. Where the filesystem can do that (ext4, xfs: FALLOC_FL_COLLAPSE_RANGE) not
// a byte is lost: `zcat` of the parts by their numbers, then the live file, is all that was
// printed. Elsewhere the file is copied and cut; what is printed between the two, some
// microseconds, is lost, and a line in the file says so. What a process prints faster than that can
// be kept (more than a fifth of its bound in a second), and what a full disk cannot take, is
// dropped with a line that says how much. A controller that dies between writing a part and taking
// it off leaves it twice.
//
// Looks once a second, ten times while a log grows fast. Without a controller nothing is rotated.
//
// Threads: calls from the loop's thread; none waits for the disk but the constructor. The files are
// looked after on a disk thread of low priority.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "musher/controller/disk_writer.hpp"
#include "musher/transport/event_loop.hpp"
#include "musher/transport/unique_fd.hpp"

namespace musher {

struct LogFile {
  std::string name;  // of what writes it
  std::string path;
  std::int64_t max_bytes = 50 << 20;  // with its compressed parts
  bool open = true;                   // to be made and opened here, for processes to write
};

struct LogFilesOptions {
  std::vector<LogFile> logs;
  std::int64_t max_total_bytes = 500 << 20;  // of all logs
  // What was dropped or could not be done; once for each spell. On the loop.
  std::function<void(const std::string&)> on_trouble;
  bool may_collapse = true;  // false: as if no filesystem could
};

class LogFiles {
 public:
  // Makes the files, with their folders. The loop must outlive this.
  LogFiles(transport::EventLoop& loop, LogFilesOptions options);
  ~LogFiles();

  // Where the process of this name is to write. Null while its file cannot be opened. A file that
  // was removed is made again within a second.
  std::shared_ptr<const transport::UniqueFd> Output(const std::string& name) const;

  // Looks now, on the calling thread. For tests, whose loop does not run.
  void LookNow();

 private:
  struct State;

  void LookLater();
  void Report();

  transport::EventLoop& loop_;
  const std::shared_ptr<State> state_;  // shared with the disk thread
  std::function<void(const std::string&)> on_trouble_;
  DiskWriter disk_;
  transport::LoopHandlePtr timer_;  // last: its callback uses all of the above
};

}  // namespace musher
