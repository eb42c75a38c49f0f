#pragma once
// What the fault-injection suite tells a module to suffer from, in memory that both map: it reaches
// the module in whatever state that is, and the successor of one that died finds it, too.
//
// Threads and processes: any.

#include <atomic>
#include <cstdint>
#include <string>

namespace musher::fault_injection {

// The states of the fault-injection suite's robots. A board names them by index.
inline constexpr const char* kStates[] = {"SetUp",    "SelfCheck", "Active", "Protected",
                                          "DeActive", "LowPower",  "Error",  "TearDown"};
// 0 is no state.
std::int32_t IndexOfState(const std::string& state);

enum class End : std::int32_t { kNot, kExit, kAbort, kSegfault, kAllocate };

struct Board {
  std::atomic<std::int32_t> hang_in;  // the state whose callback does not come back
  std::atomic<std::int32_t> fail_in;  // the state whose callback fails
  std::atomic<std::int32_t> end_in;   // the state whose callback ends the process, as `end` says
  std::atomic<std::int32_t> callback_ms;  // so long a callback takes
  std::atomic<bool> silent;               // the cycle gives no more checkpoints
  std::atomic<End> end;                   // how the process ends; with `end_in` 0 at once
  std::atomic<std::int32_t> exit_code;    // of End::kExit
  std::atomic<std::int32_t> checkpoints;  // given by the cycle so far
  std::atomic<std::int32_t> starts;       // processes of this module so far
};

// The board in `file`; a new one is all zeros. Stays mapped until the process ends. Throws
// std::system_error.
Board& OpenBoard(const std::string& file);
// Nothing to suffer from any more.
void Relieve(Board& board);

}  // namespace musher::fault_injection
