#pragma once
// Saves the sessions of the page, beside the loop: a disk that hangs holds up no emergency
// stop. A failed write is tried again until it succeeds.
//
// Threads: loop thread only, callbacks too.

#include <cstdint>
#include <functional>
#include <list>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/transport/disk_writer.hpp"
#include "musher/view/http/login.hpp"

namespace musher::view {

class SessionSaver {
 public:
  // Shorter than the time for which a page and `musher view --logout` wait.
  static constexpr Duration kAnswerWithin = std::chrono::seconds(2);

  // Runs on a thread of its own.
  using Write =
      std::function<Result<>(const std::vector<http::KeptSession>& sessions, std::int64_t wall_ms)>;
  using Then = std::function<void(const Result<>&)>;

  // Without `write` no session is kept. The loop must outlive it.
  SessionSaver(transport::EventLoop& loop, Write write, Duration answer_within = kAnswerWithin);

  // `then` runs once, never after this is dropped: when these sessions, or later ones, are on disk,
  // or with why they are not yet, `answer_within` later at the latest. Without `write` it runs at
  // once.
  void Save(std::vector<http::KeptSession> sessions, std::int64_t wall_ms, Then then = nullptr);

 private:
  struct WaitingAnswer {
    Then then;
    transport::LoopHandlePtr limit;
  };

  void Await(Then then);
  void OnKept(const Result<>& kept);

  transport::EventLoop& loop_;
  const Write write_;
  const Duration answer_within_;
  bool failed_ = false;  // it was logged
  std::list<WaitingAnswer> waiting_;
  transport::DiskWriter disk_;  // last: its callbacks use the rest
};

}  // namespace musher::view
