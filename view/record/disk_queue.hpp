#pragma once
// Runs work that waits for a disk on a thread of its own, in order, with a limit of the bytes that
// wait. Unlike transport::DiskWriter it runs every job.
//
// Threads: Do() from one thread. The destructor runs what is waiting.

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace musher::view {

class DiskQueue {
 public:
  explicit DiskQueue(std::uint64_t max_bytes);
  ~DiskQueue();
  DiskQueue(const DiskQueue&) = delete;
  DiskQueue& operator=(const DiskQueue&) = delete;

  // False: too many bytes wait; the work is not run. Work of 0 bytes is always accepted.
  bool Do(std::uint64_t bytes, std::function<void()> work);
  // Waits until everything given so far has run.
  void Drain();

 private:
  struct Job {
    std::uint64_t bytes;
    std::function<void()> work;
  };

  void Run();

  const std::uint64_t max_bytes_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Job> jobs_;
  std::uint64_t bytes_ = 0;
  bool busy_ = false;
  bool stop_ = false;
  std::thread thread_;  // last: it uses the rest
};

}  // namespace musher::view
