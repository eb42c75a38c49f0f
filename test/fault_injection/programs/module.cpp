// A module of the fault-injection suite's robots, with the faults of its board:
//
//   fault_injection_module NAME BOARD HZ
//
// A work thread, in place of the one that would move the robot, makes a checkpoint HZ times a
// second.

#include <poll.h>
#include <signal.h>

#include <cstdlib>
#include <thread>
#include <vector>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/test/fault_injection/robot/board.hpp"

namespace musher::fault_injection {
namespace {

constexpr std::int32_t kFailure = 42;
constexpr int kPollMs = 5;  // of a hanging callback, for the end of the fault

void LetPass(int milliseconds) {
  poll(nullptr, 0, milliseconds);
}

// Allocates until no memory is left.
[[noreturn]] void Allocate() {
  constexpr std::size_t kChunk = 1 << 20;
  static std::vector<std::vector<char>> held;
  while (true) held.emplace_back(kChunk, 'x');
}

void EndAs(const Board& board) {
  switch (board.end.load()) {
    case End::kNot:
      return;
    case End::kExit:
      _Exit(board.exit_code);
    case End::kAbort:
      std::abort();
    case End::kSegfault:
      raise(SIGSEGV);  // as the kernel sends it; an invalid access might be optimised away
      return;
    case End::kAllocate:
      Allocate();
  }
}

std::int32_t Callback(const Board& board, std::int32_t state) {
  LetPass(board.callback_ms);
  if (board.end_in == state) EndAs(board);
  while (board.hang_in == state) LetPass(kPollMs);
  return board.fail_in == state ? kFailure : 0;
}

void Cycle(MachineActuator& actuator, Board& board, int hz) {
  while (true) {
    LetPass(1000 / hz);
    if (board.end_in == 0) EndAs(board);
    if (board.silent) continue;
    actuator.Checkpoint();
    ++board.checkpoints;
  }
}

int Main(const std::string& name, Board& board, int hz) {
  ++board.starts;
  ActuatorRunner<MachineActuator> actuator(name);
  actuator.RegisterStateCallback(
      [&board](const State& state) { return Callback(board, IndexOfState(state)); });
  const auto begun = actuator.Init();
  const auto started = begun ? actuator.Start() : begun;
  if (!started) {
    actuator.Log(started.error());
    return EXIT_FAILURE;
  }
  std::thread([&] { Cycle(actuator, board, hz); }).detach();
  const int exit_code = actuator.Wait();
  std::_Exit(exit_code);  // the cycle still uses the actuator
}

}  // namespace
}  // namespace musher::fault_injection

int main(int argc, char** argv) {
  if (argc != 4) return EXIT_FAILURE;
  return musher::fault_injection::Main(argv[1], musher::fault_injection::OpenBoard(argv[2]),
                                       std::atoi(argv[3]));
}
