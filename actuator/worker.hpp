#pragma once
// Where state callbacks run: beside the loop, so that the actuator answers and can be asked while
// one blocks.

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include "musher/lifecycle/result.hpp"

namespace musher {

class Worker {
 public:
  using Work = std::function<Result<>()>;
  using Done = std::function<void(Result<>)>;

  virtual ~Worker() = default;

  // Runs `work`, then `done` with its result. One at a time: the next Run() comes after `done`.
  // From the loop thread; `done` runs wherever the worker likes.
  virtual void Run(Work work, Done done) = 0;
};

// A thread of its own. Dropping it waits for work that runs.
class WorkerThread : public Worker {
 public:
  WorkerThread();
  ~WorkerThread() override;
  WorkerThread(const WorkerThread&) = delete;
  WorkerThread& operator=(const WorkerThread&) = delete;

  void Run(Work work, Done done) override;

 private:
  struct Job {
    Work work;
    Done done;
  };
  void Loop();

  std::mutex mutex_;
  std::condition_variable wake_;
  std::optional<Job> job_;
  bool ending_ = false;
  std::thread thread_;  // last: it uses all of the above
};

}  // namespace musher
