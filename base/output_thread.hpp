#pragma once
// A descriptor that a thread writes to: a disk that does not answer holds that thread, not the
// caller, which may have to stop a robot.
//
//   StandardError().Write("gripper: grips\n");
//
// WriteLog() writes so, Cyclone's log is written so, and musher-exec so passes on what its commands
// print. What a module prints by itself waits for the disk.
//
// Threads: any. A forked copy of the process writes by itself.

#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>

#include "musher/base/time.hpp"
#include "musher/base/work_queue.hpp"

namespace musher {

class OutputThread {
 public:
  explicit OutputThread(int descriptor);

  // In one piece. Returns once it is written, as a process that crashes next expects it, but after
  // 100 ms at the latest, and without waiting while an earlier text is that late. What waits is
  // limited; a line says how much was dropped.
  void Write(std::string text);
  // Waits until all is written, at most so long.
  void Flush(Duration most);

 private:
  const int descriptor_;
  const pid_t process_;
  std::atomic<std::uint64_t> waiting_ = 0;  // texts
  std::atomic<std::uint64_t> dropped_ = 0;  // bytes
  std::atomic<bool> late_ = false;
  std::optional<WorkQueue> queue_;  // none: no thread could be started
};

// The output threads of this process, usable also at its very end.
OutputThread& StandardOutput();
OutputThread& StandardError();

}  // namespace musher
