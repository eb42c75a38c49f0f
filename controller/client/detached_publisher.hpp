#pragma once
// A process that publishes an emergency stop for a minute once the program that engages it asks for
// that, or has ended in any way: on Ctrl-C, with its terminal, or killed. It has a session of its
// own, so that no signal of the program's terminal reaches it.
//
//   waiting ──Begin(), the program has ended, or the time is over──▶ publishing ──▶ ended
//      └──Cancel()──▶ ended
//
// Threads: one at a time.

#include <sys/types.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/base/unique_fd.hpp"

namespace musher {

class DetachedPublisher {
 public:
  static constexpr Duration kKeptPublished = std::chrono::minutes(1);

  // Runs in the new process; publishes the stop for kKeptPublished, unless it is released.
  using Publish = std::function<void()>;

  // A copy of this process, which must not have a second thread yet. `timeout`: after which it
  // publishes unless it was cancelled.
  explicit DetachedPublisher(const Publish& publish,
                             std::optional<Duration> timeout = std::nullopt);
  // Another program, for a process with threads: it calls PublishWhenAsked() with its standard
  // input. Without it, as where no process can be started, the stop ends with this process.
  explicit DetachedPublisher(const std::vector<std::string>& program);
  DetachedPublisher(const DetachedPublisher&) = delete;
  DetachedPublisher& operator=(const DetachedPublisher&) = delete;
  // Unless it was cancelled, the process publishes.
  ~DetachedPublisher();

  void Begin() { Send('p'); }
  // Every actuator has confirmed the stop, or it is released.
  void Cancel();
  pid_t pid() const { return std::max(pid_, 0); }  // 0: there is no such process

  // In the new process. `pipe`: from its program, the process `parent`.
  [[noreturn]] static void PublishWhenAsked(int pipe, pid_t parent, std::optional<Duration> timeout,
                                            const Publish& publish);

 private:
  void Send(char word);

  UniqueFd pipe_;
  pid_t pid_ = -1;
  bool begun_ = false;
};

}  // namespace musher
