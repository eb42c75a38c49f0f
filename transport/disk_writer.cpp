#include "musher/transport/disk_writer.hpp"

#include <chrono>
#include <exception>
#include <mutex>
#include <optional>
#include <set>
#include <utility>

namespace musher::transport {
namespace {

Result<> Try(const DiskWriter::Work& work) {
  try {
    return work();
  } catch (const std::exception& error) {
    return Error{kCodeFailed, error.what()};
  }
}

}  // namespace

struct DiskWriter::Job {
  std::string key;
  std::uint64_t number = 0;
  Work work;
  bool reported = false;  // that it has failed
};

// `mutex` guards all members below it.
struct DiskWriter::Shared {
  // On the thread: tries the job; returns when to try it once more. Once the writer is destroyed
  // nothing is reported.
  std::optional<Time> Attempt(Job& job);

  const Duration retry_period;
  std::mutex mutex;
  // Posts the result of a job to the loop. Empty once the writer is destroyed.
  std::function<void(const Job&, const Result<>&)> report;
  std::uint64_t last_number = 0;
  std::map<std::string, std::uint64_t> newest;  // numbers of jobs, by key
  std::set<std::string> failed;                 // keys whose newest job waits for another attempt
};

std::optional<Time> DiskWriter::Shared::Attempt(Job& job) {
  const Result<> result = Try(job.work);
  const std::lock_guard lock(mutex);
  const bool known = !result && job.reported;
  if (report && !known) report(job, result);
  job.reported = !result;
  if (newest[job.key] != job.number) return std::nullopt;
  failed.erase(job.key);
  if (result) return std::nullopt;
  failed.insert(job.key);
  return std::chrono::steady_clock::now() + retry_period;
}

DiskWriter::DiskWriter(EventLoop& loop, DiskWriterOptions options)
    : loop_(loop),
      shared_(new Shared{options.retry_period, {}, {}, 0, {}, {}}),
      alive_(std::make_shared<DiskWriter*>(this)),
      thread_({.name = options.name,
               .niceness = options.niceness,
               .takes_signals = false,
               .end_timeout = options.timeout}) {
  const std::lock_guard lock(shared_->mutex);
  shared_->report = [&loop, weak = std::weak_ptr(alive_)](const Job& job, const Result<>& result) {
    loop.Post([weak, key = job.key, number = job.number, result] {
      if (const auto writer = weak.lock()) (*writer)->Ended(key, number, result);
    });
  };
}

DiskWriter::~DiskWriter() {
  thread_.End();
  const std::lock_guard lock(shared_->mutex);
  shared_->report = nullptr;  // the loop may be destroyed from now on
}

void DiskWriter::Do(const std::string& key, Work work, Done done) {
  const std::lock_guard lock(shared_->mutex);
  const std::uint64_t number = ++shared_->last_number;
  shared_->newest[key] = number;
  shared_->failed.erase(key);
  awaited_[key] = {number, std::move(done)};
  thread_.DoUntilDone(
      [shared = shared_, job = Job{key, number, std::move(work)}]() mutable {
        return shared->Attempt(job);
      },
      {.key = key});
}

void DiskWriter::Ended(const std::string& key, std::uint64_t number, const Result<>& result) {
  const auto awaited = awaited_.find(key);
  if (awaited == awaited_.end() || awaited->second.number != number) return;
  const Done done = awaited->second.done;  // a copy: it may hand over the next job
  if (result) awaited_.erase(awaited);
  if (done) done(result);
}

bool DiskWriter::Flush(Duration timeout) {
  if (!thread_.Flush(timeout)) return false;
  const std::lock_guard lock(shared_->mutex);
  return shared_->failed.empty();
}

}  // namespace musher::transport
