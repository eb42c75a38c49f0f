#pragma once
// SIGTERM and SIGINT as descriptors, so that a robot stands before its controller exits. Construct
// it before the program has other threads. Threads: each call on one thread; End() on any.

#include "musher/base/unique_fd.hpp"

namespace musher::navigation {

class EndSignals {
 public:
  EndSignals();

  // Readable when a signal has come.
  int fd() const { return fd_.get(); }
  // Ends the process by the signal that has come.
  void End() const;

 private:
  UniqueFd fd_;
};

}  // namespace musher::navigation
