#pragma once
// The log files of a robot: logs/<actuator>.log, which the actuators' processes write, and
// controller.log. Opens them and enforces the size limits of each and of all together.
//
// Processes write into the file itself, opened for appending: they survive the controller, and
// neither block on a reader nor get SIGPIPE. If a live file is too large, its older part is written
// to <file>.<n>.gz, synced, and then removed from the front of the live file, while processes
// append. If the filesystem supports that (ext4, xfs: FALLOC_FL_COLLAPSE_RANGE), no byte is lost:
// `zcat` of the parts in order, then the live file, is the whole output. Otherwise the file is
// copied and truncated; output between the two, some microseconds, is lost, and a line in the file
// says so. Output that is too fast (more than a fifth of the limit in a second), or that a full
// disk cannot take, is dropped with a line that reports how much. A controller that crashes between
// writing a part and removing it leaves it twice.
//
// A `logs` folder that is a link is not followed, nor is a log that is one: before the state folder
// became ours, another user may have put it there.
//
// Checks once a second, ten times a second while a log grows fast, and marks when each log has
// grown (log_times.hpp). Without a controller nothing is rotated or marked.
//
// Threads: calls from the loop's thread; only the constructor waits for the disk. A disk thread of
// low priority does the work.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "musher/base/unique_fd.hpp"
#include "musher/transport/disk_writer.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher {

struct LogFile {
  std::string name;  // of its writer
  std::string path;
  std::int64_t max_bytes = 50 << 20;  // with its compressed parts
  bool open = true;                   // create and open it here, for processes to write
  bool may_be_link = false;           // else no link is followed to it
};

struct LogFilesOptions {
  std::vector<LogFile> logs;
  std::int64_t max_total_bytes = 500 << 20;  // of all logs
  // Reports dropped output and failures, once for each period of trouble. On the loop.
  std::function<void(const std::string&)> on_trouble;
  bool may_collapse = true;  // false: as if no filesystem supported it
};

class LogFiles {
 public:
  // Creates the files with their folders. The loop must outlive this.
  LogFiles(transport::EventLoop& loop, LogFilesOptions options);
  ~LogFiles();

  // The file for the output of the process of this name; null while it cannot be opened. A removed
  // file is created again within a second.
  std::shared_ptr<const UniqueFd> Output(const std::string& name) const;

  // Checks now, on the calling thread. For tests, whose loop does not run.
  void LookNow();

 private:
  struct State;

  void LookLater();
  void Watch();
  void MarkLater();
  void Report();

  transport::EventLoop& loop_;
  const std::shared_ptr<State> state_;  // shared with the disk thread
  std::function<void(const std::string&)> on_trouble_;
  transport::DiskWriter disk_;
  UniqueFd changes_;  // inotify
  // Last: their callbacks use all of the above.
  transport::LoopHandlePtr timer_;
  transport::LoopHandlePtr growth_;  // the next change of a log, or a pause after one
};

}  // namespace musher
