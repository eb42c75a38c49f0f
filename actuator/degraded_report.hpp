#pragma once
// Passes a self-check's report of a failed part from its thread to the loop.

#include <mutex>
#include <utility>

#include "musher/base/code.hpp"
#include "musher/base/result.hpp"

namespace musher {

// Threads: any.
class DegradedReport {
 public:
  // The last one counts.
  void Put(const Error& why) {
    const std::lock_guard lock(mutex_);
    why_ = why;
  }
  // The report put since the last call; code 0: none.
  Error Take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(why_, Error{kCodeOk, ""});
  }

 private:
  std::mutex mutex_;
  Error why_{kCodeOk, ""};
};

}  // namespace musher
