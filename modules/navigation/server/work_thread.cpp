#include "musher/modules/navigation/server/work_thread.hpp"

#include <utility>

namespace musher::navigation {

WorkThread::WorkThread(transport::EventLoop& loop) : loop_(loop), thread_([this] { Run(); }) {}

WorkThread::~WorkThread() {
  *alive_ = false;
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_one();
  thread_.join();
}

void WorkThread::Do(std::function<std::function<void()>()> work) {
  {
    const std::lock_guard lock(mutex_);
    work_.push_back(std::move(work));
  }
  changed_.notify_one();
}

void WorkThread::Run() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return ending_ || !work_.empty(); });
    if (ending_) return;
    auto work = std::move(work_.front());
    work_.pop_front();
    lock.unlock();
    loop_.Post([alive = alive_, then = work()] {
      if (*alive && then) then();
    });
    work = nullptr;
    lock.lock();
  }
}

}  // namespace musher::navigation
