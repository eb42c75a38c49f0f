#pragma once
// A few words between a benchmark and a module that it measures, in memory that both map: no
// message that could be late, and what was written outlives kill -9.
//
// Threads and processes: any. Times are nanoseconds of the steady clock, which the processes of a
// host share.

#include <atomic>
#include <cstdint>
#include <string>

#include "musher/base/time.hpp"

namespace musher::benchmark {

struct Board {
  // From the module.
  std::atomic<std::int64_t> callbacks;      // begun so far, by all its processes
  std::atomic<std::int64_t> set_up_at;      // when Start() came back, 0 before
  std::atomic<std::int64_t> checkpoint_at;  // of its cycle, the last one
  // To the module.
  std::atomic<bool> silent;           // the cycle gives no more checkpoints
  std::atomic<std::int64_t> load_ms;  // the next callback of SetUp or SelfCheck computes so long
};

// The board in `file`; a new one is all zeros. Stays mapped until the process ends.
Board& OpenBoard(const std::string& file);

// Waits until the cycle has given a checkpoint from now on: a callback that ends makes it
// forgotten.
void AwaitCheckpoint(const Board& board);

inline std::int64_t NowOnBoard() {
  return std::chrono::steady_clock::now().time_since_epoch().count();
}
inline Time FromBoard(const std::atomic<std::int64_t>& time) {
  return Time(Duration(time.load()));
}

}  // namespace musher::benchmark
