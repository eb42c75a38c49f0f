#include "musher/base/work_queue.hpp"

#include <pthread.h>
#include <sys/resource.h>

#include <algorithm>
#include <condition_variable>
#include <csignal>
#include <deque>
#include <iterator>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace musher {
namespace {

struct QueuedWork {
  std::function<std::optional<Time>()> run;
  Work how;
  std::uint64_t number = 0;  // grows with each turn
  bool again = false;        // it has run, and is to run once more
};

Time Now() {
  return std::chrono::steady_clock::now();
}

}  // namespace

// `mutex` guards all that follows it.
struct WorkQueue::Shared {
  using Lock = std::unique_lock<std::mutex>;

  explicit Shared(WorkQueueOptions given) : options(std::move(given)) {}

  Given Add(QueuedWork work);
  void Run();
  std::optional<QueuedWork> Take(Lock& lock);
  bool Has(const std::string& key) const;
  // Whether all work up to `last` has run.
  bool HasRun(std::uint64_t last) const;

  const WorkQueueOptions options;
  std::mutex mutex;
  std::condition_variable given;  // the thread waits for it
  std::condition_variable done;   // Flush() and End() wait for it
  std::deque<QueuedWork> waiting;
  std::uint64_t size = 0;         // of what waits or runs
  std::uint64_t last_number = 0;  // given
  std::uint64_t running = 0;      // the number of the work under way; 0: none
  bool ending = false;
  bool ended = false;
  std::thread thread;
};

WorkQueue::Given WorkQueue::Shared::Add(QueuedWork work) {
  std::vector<QueuedWork> replaced;  // destroyed without the lock: what it owns may call the queue
  const Lock lock(mutex);
  if (ending) return Given::kRefused;
  const std::uint64_t more = work.how.size;
  if (more > 0 && size > 0 && (size > options.most || more > options.most - size)) {
    return Given::kRefused;
  }
  Given result = Given::kAccepted;
  if (!work.how.key.empty()) {
    for (auto other = waiting.begin(); other != waiting.end();) {
      if (other->how.key != work.how.key) {
        ++other;
        continue;
      }
      if (!other->again) result = Given::kReplaced;
      size -= other->how.size;
      replaced.push_back(std::move(*other));
      other = waiting.erase(other);
    }
  }
  work.number = ++last_number;
  size += more;
  waiting.push_back(std::move(work));
  given.notify_one();
  return result;
}

bool WorkQueue::Shared::Has(const std::string& key) const {
  return !key.empty() && std::any_of(waiting.begin(), waiting.end(),
                                     [&](const QueuedWork& work) { return work.how.key == key; });
}

bool WorkQueue::Shared::HasRun(std::uint64_t last) const {
  const bool under_way = running != 0 && running <= last;
  return !under_way && std::none_of(waiting.begin(), waiting.end(),
                                    [&](const QueuedWork& work) { return work.number <= last; });
}

// Waits for work that is due; nullopt: the end.
std::optional<QueuedWork> WorkQueue::Shared::Take(Lock& lock) {
  while (true) {
    const Time now = Now();
    const auto due = std::find_if(waiting.begin(), waiting.end(), [&](const QueuedWork& work) {
      return ending || work.how.not_before <= now;
    });
    if (due != waiting.end()) {
      QueuedWork work = std::move(*due);
      waiting.erase(due);
      return work;
    }
    if (ending) return std::nullopt;
    const auto next = std::min_element(waiting.begin(), waiting.end(),
                                       [](const QueuedWork& a, const QueuedWork& b) {
                                         return a.how.not_before < b.how.not_before;
                                       });
    if (next == waiting.end()) {
      given.wait(lock);
    } else {
      given.wait_until(lock, Time(next->how.not_before));
    }
  }
}

// On the thread.
void WorkQueue::Shared::Run() {
  pthread_setname_np(pthread_self(), options.name.c_str());
  if (options.niceness != 0) setpriority(PRIO_PROCESS, 0, options.niceness);
  Lock lock(mutex);
  while (auto work = Take(lock)) {
    running = work->number;
    lock.unlock();
    const std::optional<Time> again = work->run();
    lock.lock();
    running = 0;
    if (again && !ending && !Has(work->how.key)) {
      work->how.not_before = *again;
      work->number = ++last_number;
      work->again = true;
      waiting.push_back(std::move(*work));
    } else {
      size -= work->how.size;
    }
    done.notify_all();
    lock.unlock();
    work.reset();
    lock.lock();
  }
  ended = true;
  done.notify_all();
}

WorkQueue::WorkQueue(WorkQueueOptions options)
    : shared_(std::make_shared<Shared>(std::move(options))) {
  sigset_t before;
  if (!shared_->options.takes_signals) {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
  }
  shared_->thread = std::thread([shared = shared_] { shared->Run(); });
  if (!shared_->options.takes_signals) pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

WorkQueue::~WorkQueue() {
  End();
}

WorkQueue::Given WorkQueue::Do(std::function<void()> work, Work how) {
  return DoUntilDone(
      [work = std::move(work)]() -> std::optional<Time> {
        work();
        return std::nullopt;
      },
      std::move(how));
}

WorkQueue::Given WorkQueue::DoUntilDone(std::function<std::optional<Time>()> work, Work how) {
  return shared_->Add({std::move(work), std::move(how)});
}

bool WorkQueue::Flush(std::optional<Duration> timeout) {
  Shared::Lock lock(shared_->mutex);
  const std::uint64_t last = shared_->last_number;
  for (QueuedWork& work : shared_->waiting) work.how.not_before = {};
  shared_->given.notify_one();
  const auto has_run = [&] { return shared_->HasRun(last); };
  if (timeout) return shared_->done.wait_for(lock, *timeout, has_run);
  shared_->done.wait(lock, has_run);
  return true;
}

void WorkQueue::End() {
  std::deque<QueuedWork> dropped;  // as in Add()
  Shared::Lock lock(shared_->mutex);
  if (!std::exchange(shared_->ending, true)) {
    dropped = std::exchange(shared_->waiting, {});
    if (shared_->options.at_end == WorkQueueOptions::AtEnd::kRun) {
      const auto once = std::stable_partition(dropped.begin(), dropped.end(),
                                              [](const QueuedWork& work) { return work.again; });
      std::move(once, dropped.end(), std::back_inserter(shared_->waiting));
      dropped.erase(once, dropped.end());
    }
    shared_->given.notify_one();
  }
  if (!shared_->thread.joinable()) return;
  const auto has_ended = [&] { return shared_->ended; };
  if (!shared_->options.end_timeout) {
    shared_->done.wait(lock, has_ended);
  } else if (!shared_->done.wait_for(lock, *shared_->options.end_timeout, has_ended)) {
    return shared_->thread.detach();
  }
  std::thread thread = std::move(shared_->thread);
  lock.unlock();
  if (thread.joinable()) thread.join();
}

}  // namespace musher
