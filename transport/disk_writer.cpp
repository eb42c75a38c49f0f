#include "musher/transport/disk_writer.hpp"

#include <pthread.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

namespace musher::transport {
namespace {

using SteadyTime = std::chrono::steady_clock::time_point;

struct Job {
  std::string key;
  std::uint64_t number = 0;
  DiskWriter::Work work;
  SteadyTime not_before{};  // after a failed attempt
  bool failed = false;      // its last attempt
  bool reported = false;    // that it has failed
};

Result<> Try(const DiskWriter::Work& work) {
  try {
    return work();
  } catch (const std::exception& error) {
    return Error{kCodeFailed, error.what()};
  }
}

}  // namespace

// `mutex` guards all members.
struct DiskWriter::Queue {
  using Lock = std::unique_lock<std::mutex>;
  // Runs on the thread, with the lock: posts the result of a job to the loop. Empty once the writer
  // is destroyed.
  std::function<void(const Job&, const Result<>&)> report;
  DiskWriterOptions options;

  std::mutex mutex;
  std::condition_variable changed;
  std::deque<Job> waiting;
  std::uint64_t last_job = 0;
  std::uint64_t running = 0;  // number of the job under way; 0: none
  bool failed = false;        // the last attempt of any
  bool stop = false;
  bool ended = false;

  // Whether each of the jobs up to `last` has been tried.
  bool HasTried(std::uint64_t last) const {
    const bool begun = running == 0 || running > last;
    return begun && std::none_of(waiting.begin(), waiting.end(), [last](const Job& job) {
             return job.number <= last && !job.failed;
           });
  }
  // Waits for a due job and takes it; nullopt: stop.
  std::optional<Job> Take(Lock& lock) {
    while (true) {
      const auto now = std::chrono::steady_clock::now();
      const auto due = std::find_if(waiting.begin(), waiting.end(), [&](const Job& job) {
        return stop ? !job.failed : job.not_before <= now;
      });
      if (due != waiting.end()) {
        Job job = std::move(*due);
        waiting.erase(due);
        return job;
      }
      if (stop) return std::nullopt;
      const auto next =
          std::min_element(waiting.begin(), waiting.end(),
                           [](const Job& a, const Job& b) { return a.not_before < b.not_before; });
      if (next == waiting.end()) {
        changed.wait(lock);
      } else {
        changed.wait_until(lock, next->not_before);
      }
    }
  }
  bool HasNewer(const Job& job) const {
    return std::any_of(waiting.begin(), waiting.end(),
                       [&](const Job& other) { return other.key == job.key; });
  }
};

DiskWriter::DiskWriter(EventLoop& loop, DiskWriterOptions options)
    : loop_(loop),
      options_(std::move(options)),
      queue_(std::make_shared<Queue>()),
      alive_(std::make_shared<DiskWriter*>(this)) {
  queue_->options = options_;
  queue_->report = [&loop = loop_, weak = std::weak_ptr(alive_)](const Job& job,
                                                                 const Result<>& result) {
    loop.Post([weak, key = job.key, number = job.number, result] {
      if (const auto writer = weak.lock()) (*writer)->Ended(key, number, result);
    });
  };
  // No signal is delivered to the thread.
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  std::thread([queue = queue_] { Run(queue); }).detach();
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

DiskWriter::~DiskWriter() {
  Queue::Lock lock(queue_->mutex);
  queue_->stop = true;
  queue_->changed.notify_all();
  queue_->changed.wait_for(lock, options_.timeout, [this] { return queue_->ended; });
  queue_->report = nullptr;  // the loop may be destroyed from now on
}

void DiskWriter::Do(const std::string& key, Work work, Done done) {
  const Queue::Lock lock(queue_->mutex);
  const std::uint64_t number = ++queue_->last_job;
  std::erase_if(queue_->waiting, [&](const Job& job) { return job.key == key; });
  queue_->waiting.push_back({key, number, std::move(work)});
  awaited_[key] = {number, std::move(done)};
  queue_->changed.notify_all();
}

void DiskWriter::Ended(const std::string& key, std::uint64_t number, const Result<>& result) {
  const auto awaited = awaited_.find(key);
  if (awaited == awaited_.end() || awaited->second.number != number) return;
  const Done done = awaited->second.done;  // a copy: it may hand over the next job
  if (result) awaited_.erase(awaited);
  if (done) done(result);
}

bool DiskWriter::Flush(Duration timeout) {
  Queue::Lock lock(queue_->mutex);
  const std::uint64_t last = queue_->last_job;
  // Retries failed jobs at once.
  for (Job& job : queue_->waiting) {
    job.failed = false;
    job.not_before = {};
  }
  queue_->changed.notify_all();
  const bool tried =
      queue_->changed.wait_for(lock, timeout, [&] { return queue_->HasTried(last); });
  return tried && std::none_of(queue_->waiting.begin(), queue_->waiting.end(),
                               [](const Job& job) { return job.failed; });
}

// Runs on the thread. Once the writer is destroyed it only finishes the waiting jobs.
void DiskWriter::Run(const std::shared_ptr<Queue>& queue) {
  pthread_setname_np(pthread_self(), queue->options.name.c_str());
  if (queue->options.niceness != 0) setpriority(PRIO_PROCESS, 0, queue->options.niceness);
  Queue::Lock lock(queue->mutex);
  while (auto job = queue->Take(lock)) {
    queue->running = job->number;
    lock.unlock();
    const Result<> result = Try(job->work);
    lock.lock();
    queue->running = 0;
    const bool known = !result && job->reported;
    if (queue->report && !known) queue->report(*job, result);
    if (!result && !queue->HasNewer(*job)) {
      job->failed = true;
      job->reported = true;
      job->not_before = std::chrono::steady_clock::now() + queue->options.retry_period;
      queue->waiting.push_back(std::move(*job));
    }
    queue->changed.notify_all();
  }
  queue->ended = true;
  queue->changed.notify_all();
}

}  // namespace musher::transport
