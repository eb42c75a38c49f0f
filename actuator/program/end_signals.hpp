#pragma once
// SIGTERM and SIGINT as events of the loop: a robot is brought to a stand before the process ends
// by the signal.
//
// Threads: construct it before the program has other threads; Watch() on the loop's.

#include <functional>

#include "musher/base/unique_fd.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::program {

class EndSignals {
 public:
  // Both signals wait for Watch() from now on.
  EndSignals();
  ~EndSignals();  // they end the process again
  EndSignals(const EndSignals&) = delete;
  EndSignals& operator=(const EndSignals&) = delete;

  // At a signal: runs `stop`, which must return at once, and ends the process by that signal. This
  // object must outlive the handle.
  transport::LoopHandlePtr Watch(transport::EventLoop& loop, std::function<void()> stop) const;

 private:
  void End() const;

  UniqueFd fd_;
};

}  // namespace musher::program
