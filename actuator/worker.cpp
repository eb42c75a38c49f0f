#include "musher/actuator/worker.hpp"

#include <utility>

namespace musher {

WorkerThread::WorkerThread() : thread_({.name = "callbacks"}) {}

void WorkerThread::Run(Work work, Done done) {
  thread_.Do([work = std::move(work), done = std::move(done)] { done(work()); });
}

}  // namespace musher
