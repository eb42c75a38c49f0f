#pragma once
// A thread that runs what it is given, one after the other: the plainest hand-off there is.

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace musher::benchmark {

class ThreadQueue {
 public:
  ThreadQueue() : thread_([this] { Run(); }) {}
  ~ThreadQueue() {
    Give({});
    thread_.join();
  }
  ThreadQueue(const ThreadQueue&) = delete;
  ThreadQueue& operator=(const ThreadQueue&) = delete;

  void Give(std::function<void()> work) {
    {
      const std::lock_guard lock(mutex_);
      work_.push_back(std::move(work));
    }
    wake_.notify_one();
  }

 private:
  void Run() {
    std::unique_lock lock(mutex_);
    while (true) {
      wake_.wait(lock, [this] { return !work_.empty(); });
      const auto work = std::move(work_.front());
      work_.pop_front();
      if (!work) return;
      lock.unlock();
      work();
      lock.lock();
    }
  }

  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<std::function<void()>> work_;
  std::thread thread_;  // last: it uses all of the above
};

}  // namespace musher::benchmark
