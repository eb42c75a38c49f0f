#pragma once
// The faults that the fault-injection suite sets for a module, in memory that both map: they act in
// every state of the module, and in the next process of it as well.
//
// Threads and processes: any.

#include <atomic>
#include <cstdint>
#include <string>

namespace musher::fault_injection {

// The states of the fault-injection suite's robots. A board names them by index.
inline constexpr const char* kStates[] = {"SetUp",    "SelfCheck", "Active", "Protected",
                                          "DeActive", "LowPower",  "Error",  "TearDown"};
// 0: no such state.
std::int32_t IndexOfState(const std::string& state);

enum class End : std::int32_t { kNot, kExit, kAbort, kSegfault, kAllocate };

struct Board {
  std::atomic<std::int32_t> hang_in;  // the state whose callback does not return
  std::atomic<std::int32_t> fail_in;  // the state whose callback fails
  std::atomic<std::int32_t> end_in;   // the state whose callback ends the process, as `end` says
  std::atomic<std::int32_t> callback_ms;  // how long a callback takes
  std::atomic<bool> silent;               // the work thread makes no checkpoints
  std::atomic<End> end;                   // how the process ends; with `end_in` 0 at once
  std::atomic<std::int32_t> exit_code;    // of End::kExit
  std::atomic<std::int32_t> checkpoints;  // of the work thread so far
  std::atomic<std::int32_t> starts;       // processes of this module so far
};

// The board in `file`; a new one is all zeros. Stays mapped until the process ends. Throws
// std::system_error.
Board& OpenBoard(const std::string& file);
// Clears all faults.
void ClearFaults(Board& board);

}  // namespace musher::fault_injection
