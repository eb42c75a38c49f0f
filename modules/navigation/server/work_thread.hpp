#pragma once
// A thread that does the work of a robot, one piece after the other.
//
// Threads: Do() and the destructor on the loop; the work on the thread of this object.

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>

#include "musher/modules/navigation/server/background.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::navigation {

class WorkThread : public Background {
 public:
  // The loop must outlive it.
  explicit WorkThread(transport::EventLoop& loop);
  // Waits for the present work; drops the rest.
  ~WorkThread() override;
  WorkThread(const WorkThread&) = delete;
  WorkThread& operator=(const WorkThread&) = delete;

  void Do(std::function<std::function<void()>()> work) override;

 private:
  void Run();

  transport::EventLoop& loop_;
  const std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);  // used on the loop only
  std::mutex mutex_;                                                  // guards what follows
  std::condition_variable changed_;
  std::deque<std::function<std::function<void()>()>> work_;
  bool ending_ = false;
  std::thread thread_;  // last: it uses the rest
};

}  // namespace musher::navigation
