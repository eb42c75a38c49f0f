#pragma once
// Runs state callbacks beside the loop, so that the actuator answers queries while one blocks.

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include "musher/base/result.hpp"

namespace musher {

class Worker {
 public:
  using Work = std::function<Result<>()>;
  using Done = std::function<void(Result<>)>;

  virtual ~Worker() = default;

  // Runs `work`, then `done` with its result. One at a time: call Run() again only after `done`.
  // Loop thread only; `done` runs on any thread.
  virtual void Run(Work work, Done done) = 0;
};

// Uses a thread of its own. Dropping it waits for running work.
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
