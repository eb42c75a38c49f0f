#pragma once
// Threads that block in devices and files. After a stop request a thread may stay in a device for
// seconds before it returns: the loop does not wait for it, the exit of the program does.
//
// Threads: any, one at a time.

#include <atomic>
#include <functional>
#include <list>
#include <memory>
#include <thread>

namespace musher::camera {

class CaptureThreads {
 public:
  CaptureThreads() = default;
  CaptureThreads(const CaptureThreads&) = delete;
  CaptureThreads& operator=(const CaptureThreads&) = delete;
  // Waits for all of them.
  ~CaptureThreads() { Reap(true); }

  void Start(std::function<void()> work) {
    Reap(false);
    CaptureThread& running = threads_.emplace_back();
    running.thread = std::thread([work = std::move(work), ended = running.ended] {
      work();
      *ended = true;
    });
  }

 private:
  struct CaptureThread {
    std::shared_ptr<std::atomic<bool>> ended = std::make_shared<std::atomic<bool>>(false);
    std::thread thread;
  };

  void Reap(bool all) {
    threads_.remove_if([all](CaptureThread& running) {
      if (!all && !*running.ended) return false;
      running.thread.join();
      return true;
    });
  }

  std::list<CaptureThread> threads_;
};

}  // namespace musher::camera
