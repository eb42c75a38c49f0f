#include <signal.h>

#include "musher/test/benchmark/common/observed_controller.hpp"
#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/test/benchmark/health/hand_started.hpp"
#include "musher/test/benchmark/health/parts.hpp"

namespace musher::benchmark {
namespace {

constexpr int kHangActuators = 4;
constexpr int kHangHz = 50;
constexpr Duration kCheckpoint = Milliseconds(200);

std::vector<double> Silences(ObservedController& controller, HandStarted& actuators, int rounds) {
  std::vector<double> times;
  for (int i = 0; i < rounds; ++i) {
    const ActuatorIndex actuator(static_cast<std::size_t>(i % kHangActuators));
    Board& board = actuators.board(actuator);
    AwaitCheckpoint(board);
    auto known = controller.Next(IsOnRecord(actuator, Health::kHung));
    board.silent = true;
    const Time at = MomentOf(known, "a silent thread");
    times.push_back(ToSeconds(at - FromBoard(board.checkpoint_at)) / ToSeconds(kCheckpoint));
    board.silent = false;
    controller.AwaitAllThere();
  }
  return times;
}

// In seconds.
std::vector<double> Stops(ObservedController& controller, HandStarted& actuators, int rounds) {
  std::vector<double> times;
  for (int i = 0; i < rounds; ++i) {
    const ActuatorIndex actuator(static_cast<std::size_t>(i % kHangActuators));
    auto known = controller.Next(IsOnRecord(actuator, Health::kHung));
    const Time stopped = std::chrono::steady_clock::now();
    kill(actuators.pid(actuator), SIGSTOP);
    times.push_back(ToSeconds(MomentOf(known, "a stopped process") - stopped));
    kill(actuators.pid(actuator), SIGCONT);
    controller.AwaitAllThere();
  }
  return times;
}

}  // namespace

void Hang(int rounds) {
  const Table table("A hang → hung, on this host");
  {
    const std::string key = "checkpoint_ms = " + std::to_string(ToMilliseconds(kCheckpoint)) + "\n";
    const Fleet fleet([&](const Fleet&, const std::string&) { return key; }, kHangActuators);
    HandStarted actuators(fleet, kHangHz);
    ObservedController controller(fleet.config_file());
    controller.AwaitAllThere();
    table.Row("no checkpoint any more, by checkpoint_ms", Silences(controller, actuators, rounds),
              "×", 2);
    std::vector<double> stops = Stops(controller, actuators, rounds);
    for (double& stop : stops) stop /= ToSeconds(kCheckpoint);
    table.Row("SIGSTOP, by checkpoint_ms", stops, "×", 2);
  }
  const Fleet fleet([](const Fleet&, const std::string&) { return ""; }, kHangActuators);
  HandStarted actuators(fleet);
  ObservedController controller(fleet.config_file());
  controller.AwaitAllThere();
  table.Row("SIGSTOP, without checkpoint_ms", Stops(controller, actuators, (rounds + 4) / 5), "s");
}

}  // namespace musher::benchmark
