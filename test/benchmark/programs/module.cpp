// An actuator that is measured, with a board between it and the benchmark:
//
//   benchmark_module NAME BOARD [HZ]
//
// With HZ a thread of its own gives a checkpoint so often, as the cycle that moves a robot does,
// unless the board says to be silent.

#include <cstdlib>
#include <thread>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/test/benchmark/common/board.hpp"
#include "musher/test/benchmark/common/child.hpp"

namespace musher::benchmark {
namespace {

void Compute(std::int64_t milliseconds) {
  const auto end = std::chrono::steady_clock::now() + Milliseconds(milliseconds);
  while (std::chrono::steady_clock::now() < end) {
  }
}

void Cycle(MachineActuator& actuator, Board& board, int hz) {
  for (auto next = std::chrono::steady_clock::now();; next += Duration(1'000'000'000 / hz)) {
    std::this_thread::sleep_until(next);
    if (board.silent) continue;
    board.checkpoint_at = NowOnBoard();
    actuator.Checkpoint();
  }
}

int Main(const std::string& name, Board& board, int hz) {
  ActuatorRunner<MachineActuator> actuator(name);
  actuator.RegisterStateCallback([&board](const State& state) {
    ++board.callbacks;
    if (state == kSetUp || state == kSelfCheck) Compute(board.load_ms.exchange(0));
    return 0;
  });
  const auto begun = actuator.Init();
  const auto started = begun ? actuator.Start() : begun;
  if (!started) {
    actuator.Log(started.error());
    return 1;
  }
  board.set_up_at = NowOnBoard();
  if (hz > 0) std::thread([&] { Cycle(actuator, board, hz); }).detach();
  const int exit_code = actuator.Wait();
  std::_Exit(exit_code);  // the cycle still uses the actuator
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  if (argc < 3) return EXIT_FAILURE;
  musher::benchmark::DieWithParent();
  return musher::benchmark::Main(argv[1], musher::benchmark::OpenBoard(argv[2]),
                                 argc > 3 ? std::atoi(argv[3]) : 0);
}
