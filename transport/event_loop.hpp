#pragma once
// The event loop of a process. The thread that runs the loop handles everything of a node - timers,
// samples, file descriptors, posted work - one at a time, in the order in which it became due.
//
// Two kinds: the real one (epoll, in linux_event_loop.hpp) and the simulated one (virtual time, in
// sim/). Code that takes an EventLoop& runs on either.
//
// Threads: only Post() and Stop() may be called from other threads than the loop's. Handles must be
// dropped before their loop. A callback may drop any handle, its own too, but must not run the
// loop.

#include <atomic>
#include <functional>
#include <memory>
#include <thread>

#include "musher/base/check.hpp"
#include "musher/base/time.hpp"

namespace musher::transport {

// Holds a timer or a file descriptor watch; dropping it ends the timer or watch. After that its
// callback never runs, even if it was already due.
class [[nodiscard]] LoopHandle {
 public:
  virtual ~LoopHandle() = default;
};
using LoopHandlePtr = std::unique_ptr<LoopHandle>;

class EventLoop {
 public:
  virtual ~EventLoop() = default;

  virtual Time Now() const = 0;

  // How long this computer was suspended since its boot: Now() and the timers do not count it. 0:
  // the loop does not know.
  virtual Duration TimeSuspended() const { return {}; }

  // Runs `work` on the loop as soon as possible. From any thread.
  virtual void Post(std::function<void()> work) = 0;

  // Runs `callback` once, at `when` or as soon as possible after it.
  virtual LoopHandlePtr At(Time when, std::function<void()> callback) = 0;

  // Runs `callback` every `period`, first one period from now. Skips missed periods.
  virtual LoopHandlePtr Every(Duration period, std::function<void()> callback) = 0;

  // Runs `callback` while `fd` is readable (a pidfd, a pipe, a signalfd). The caller keeps the fd,
  // which must outlive the handle. On a simulated loop, which has no file descriptors, it never
  // runs.
  virtual LoopHandlePtr WhenReadable(int fd, std::function<void()> callback) = 0;

  // Runs the loop on the calling thread until Stop().
  virtual void Run() = 0;

  // Runs the loop until `done` holds (checked after every event) or the deadline is over; returns
  // whether it held. For programs that wait for one thing, and for tests.
  virtual bool RunUntil(const std::function<bool()>& done, Time deadline) = 0;

  // Makes Run() return; RunUntil() continues. From any thread, also before Run().
  virtual void Stop() = 0;

  // Ends the process when another thread runs the loop. Called where "loop thread only" is written,
  // but for handles that are dropped.
  void CheckThread() const {
    const std::thread::id runner = runner_.load(std::memory_order_relaxed);
    MUSHER_CHECK(runner == std::thread::id() || runner == std::this_thread::get_id(),
                 "called on another thread than the loop's; Post() it");
  }

 protected:
  // The calling thread runs the loop as long as this exists.
  class RunScope {
   public:
    explicit RunScope(EventLoop& loop)
        : loop_(loop), before_(loop.runner_.exchange(std::this_thread::get_id())) {}
    ~RunScope() { loop_.runner_ = before_; }
    RunScope(const RunScope&) = delete;
    RunScope& operator=(const RunScope&) = delete;

   private:
    EventLoop& loop_;
    std::thread::id before_;
  };

 private:
  std::atomic<std::thread::id> runner_;
};

}  // namespace musher::transport
