#pragma once
// Runs an actuator's Python emergency-stop function on a thread of its own: the loop, which
// receives the stop, must not wait for the GIL.
//
// Threads: Request() from any, without waiting. The destructor waits for a running function; call
// it without the GIL.

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>

namespace musher::python {

class StopThread {
 public:
  explicit StopThread(std::function<void()> stop)
      : stop_(std::move(stop)), thread_([this] { Loop(); }) {}
  ~StopThread() {
    {
      const std::lock_guard lock(mutex_);
      ending_ = true;
    }
    wake_.notify_one();
    thread_.join();
  }
  StopThread(const StopThread&) = delete;
  StopThread& operator=(const StopThread&) = delete;

  void Request() {
    {
      const std::lock_guard lock(mutex_);
      requested_ = true;
    }
    wake_.notify_one();
  }

 private:
  // A request that came before the end is still served.
  void Loop() {
    std::unique_lock lock(mutex_);
    while (true) {
      wake_.wait(lock, [this] { return requested_ || ending_; });
      if (!std::exchange(requested_, false)) return;
      lock.unlock();
      stop_();
      lock.lock();
    }
  }

  const std::function<void()> stop_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool requested_ = false;
  bool ending_ = false;
  std::thread thread_;  // last: it uses all of the above
};

}  // namespace musher::python
