#pragma once
// A process that publishes an emergency stop for a minute once the program that engages it asks for
// that, or has ended in any way: on Ctrl-C, with its terminal, or killed. It has a session of its
// own, so that no signal of the program's terminal reaches it.
//
//   waiting ──Begin(), the program has ended, or the time is over──▶ publishing ──▶ ended
//      └──────────────────────── Cancel() ───────────────────────────────┴──▶ ended
//
// It publishes by copies of itself. A copy uses the networks that are up when it joins, so another
// copy begins when a network comes, and after a copy that could not join.
//
// What the program finds out meanwhile, it notes for the process, which has no other source: the
// machine may be lost by then.
//
// Threads: one at a time.

#include <sys/types.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/base/unique_fd.hpp"

namespace musher {

class DetachedPublisher {
 public:
  static constexpr Duration kKeptPublished = std::chrono::minutes(1);

  static constexpr std::size_t kLongestNote = 1024;  // bytes; a longer one is dropped

  // The notes of the program, in the order of their calls.
  using Notes = std::vector<std::string>;
  // Runs in a new process, without a second thread, and is killed after kKeptPublished at the
  // latest. Publishes the stop until it is released; false: it cannot.
  using Publish = std::function<bool(const Notes& notes)>;

  // A copy of this process, which must not have a second thread yet. `timeout`: after that it
  // publishes unless it was cancelled.
  explicit DetachedPublisher(const Publish& publish,
                             std::optional<Duration> timeout = std::nullopt);
  // Another program, for a process with threads: it calls PublishWhenAsked() with its standard
  // input. Without it, as where no process can be started, the stop ends with this process.
  explicit DetachedPublisher(const std::vector<std::string>& program);
  DetachedPublisher(const DetachedPublisher&) = delete;
  DetachedPublisher& operator=(const DetachedPublisher&) = delete;
  // The process begins to publish, unless it was cancelled.
  ~DetachedPublisher();

  // Passes a note to the process, for Publish. No effect once the process publishes. Returns at
  // once.
  void Note(std::string_view note);
  void Begin();
  // Ends the process: every actuator has confirmed the stop, or the stop is released. Waits for one
  // second at most.
  void Cancel();
  pid_t pid() const { return std::max(pid_, 0); }  // 0: there is no such process

  // Called in the new process. `channel`: the channel from its program, the process `parent`.
  [[noreturn]] static void PublishWhenAsked(int channel, pid_t parent,
                                            std::optional<Duration> timeout,
                                            const Publish& publish);

 private:
  void Send(const std::string& packet);

  UniqueFd channel_;
  pid_t pid_ = -1;
};

}  // namespace musher
