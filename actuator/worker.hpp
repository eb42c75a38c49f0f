#pragma once
// Runs state callbacks beside the loop, so that the actuator answers queries while one blocks.

#include <functional>

#include "musher/base/result.hpp"
#include "musher/base/work_queue.hpp"

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
  void Run(Work work, Done done) override;

 private:
  WorkQueue thread_;
};

}  // namespace musher
