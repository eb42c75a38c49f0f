#include "musher/view/record/disk_queue.hpp"

#include <pthread.h>

#include <utility>

namespace musher::view {

DiskQueue::DiskQueue(std::uint64_t max_bytes) : max_bytes_(max_bytes), thread_([this] { Run(); }) {
  pthread_setname_np(thread_.native_handle(), "record-disk");
}

DiskQueue::~DiskQueue() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

bool DiskQueue::Do(std::uint64_t bytes, std::function<void()> work) {
  {
    const std::lock_guard lock(mutex_);
    if (bytes > 0 && bytes_ > 0 && bytes_ + bytes > max_bytes_) return false;
    bytes_ += bytes;
    jobs_.push_back({bytes, std::move(work)});
  }
  changed_.notify_all();
  return true;
}

void DiskQueue::Drain() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return jobs_.empty() && !busy_; });
}

void DiskQueue::Run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return stop_ || !jobs_.empty(); });
    if (jobs_.empty()) return;
    const Job job = std::move(jobs_.front());
    jobs_.pop_front();
    busy_ = true;
    lock.unlock();
    job.work();
    lock.lock();
    busy_ = false;
    bytes_ -= job.bytes;
    changed_.notify_all();
  }
}

}  // namespace musher::view
