#include "musher/actuator/worker.hpp"

#include <utility>

#include "musher/base/check.hpp"

namespace musher {

WorkerThread::WorkerThread() : thread_([this] { Loop(); }) {}

WorkerThread::~WorkerThread() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void WorkerThread::Run(Work work, Done done) {
  {
    const std::lock_guard lock(mutex_);
    MUSHER_CHECK(!job_);
    job_ = Job{std::move(work), std::move(done)};
  }
  wake_.notify_one();
}

void WorkerThread::Loop() {
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return job_ || ending_; });
    if (!job_) return;
    const Job job = std::move(*std::exchange(job_, std::nullopt));
    lock.unlock();
    job.done(job.work());
    lock.lock();
  }
}

}  // namespace musher
