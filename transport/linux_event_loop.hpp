#pragma once
// The event loop of a real process: epoll for file descriptors, an eventfd for work from other
// threads, one timerfd armed for the next timer. An idle loop does not wake up.
//
// A turn of the loop runs the due timers, then the work posted before the turn, then the callbacks
// of readable file descriptors, so that none of the three can starve the others.

#include <array>
#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>

#include "musher/base/unique_fd.hpp"
#include "musher/transport/event_loop.hpp"
#include "musher/transport/timer_queue.hpp"

namespace musher::transport {

class LinuxEventLoop : public EventLoop {
 public:
  // Throws std::system_error if the process has no file descriptors left.
  LinuxEventLoop();
  LinuxEventLoop(const LinuxEventLoop&) = delete;
  LinuxEventLoop& operator=(const LinuxEventLoop&) = delete;

  Time Now() const override { return std::chrono::steady_clock::now(); }
  Duration TimeSuspended() const override;
  void Post(std::function<void()> work) override;
  LoopHandlePtr At(Time when, std::function<void()> callback) override;
  LoopHandlePtr Every(Duration period, std::function<void()> callback) override;
  LoopHandlePtr WhenReadable(int fd, std::function<void()> callback) override;
  void Run() override;
  bool RunUntil(const std::function<bool()>& done, Time deadline) override;
  void Stop() override;

 private:
  struct Watch {
    int fd;
    std::function<void()> callback;
  };
  class WatchHandle;
  using Done = std::function<bool()>;

  // Waits for work and runs it; returns whether `done` held after one item.
  bool Turn(const Done& done);
  bool RunDueTimers(const Done& done);
  bool RunPosted(const Done& done);
  bool RunReadable(const Done& done);

  int Poll();
  bool MayBlock();
  void ArmTimer(std::optional<Time> when);

  UniqueFd epoll_;
  UniqueFd wake_;
  UniqueFd timer_;
  std::optional<Time> armed_for_;

  TimerQueue timers_;
  std::map<std::uint64_t, std::shared_ptr<Watch>> watches_;
  std::uint64_t next_watch_;
  static constexpr int kMaxReady = 16;
  std::array<std::uint64_t, kMaxReady> ready_{};  // readable watches of the last poll
  int ready_count_ = 0;

  std::deque<std::function<void()>> batch_;  // posted work that this turn runs
  std::atomic<bool> stop_ = false;
  std::mutex mutex_;                          // guards the members below
  std::deque<std::function<void()>> posted_;  // work for the next turn
  bool asleep_ = false;                       // the loop waits: Post() must wake it
};

}  // namespace musher::transport
