#pragma once
// Background work of a robot, on a thread of its own.
//
// Threads: Do() and the destructor on the loop; the work on the thread of this object.

#include <memory>

#include "musher/base/work_queue.hpp"
#include "musher/modules/navigation/server/background.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::navigation {

class ThreadBackground : public Background {
 public:
  // The loop must outlive it.
  explicit ThreadBackground(transport::EventLoop& loop) : loop_(loop) {}
  // Waits for the present work; drops the rest.
  ~ThreadBackground() override;
  ThreadBackground(const ThreadBackground&) = delete;
  ThreadBackground& operator=(const ThreadBackground&) = delete;

  void Do(std::function<std::function<void()>()> work) override;

 private:
  transport::EventLoop& loop_;
  const std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);  // used on the loop only
  // Last: it uses the rest.
  musher::WorkQueue thread_{
      {.name = "background", .at_end = musher::WorkQueueOptions::AtEnd::kDrop}};
};

}  // namespace musher::navigation
