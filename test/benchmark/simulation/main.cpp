// How many ten-minute runs of a robot of twelve actuators are simulated in a second: a start, then
// a switch every five simulated seconds, with the real controller and the real actuators.

#include <benchmark/benchmark.h>

#include <cstdint>
#include <cstdlib>
#include <string>

#include "musher/simulation/robot.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"

namespace musher::testing {
namespace {

using simulation::SimRobot;

constexpr int kActuators = 12;

bool RunTenMinutes(std::uint64_t seed, const transport::sim::LinkFaults& faults) {
  MachineConfig config = MachineOf(kActuators);
  for (ActuatorConfig& actuator : config.actuators) actuator.command = {"run", actuator.name};
  SimRobot robot(seed, std::move(config));
  robot.network().SetFaults(faults);
  robot.StartController();
  if (!robot.RunUntil([&] { return robot.machine().phase == Phase::kRunning; })) return false;
  const State targets[] = {State("LowPower"),  State("Active"), State("DeActive"),
                           State("Protected"), State("OTA"),    State("Active")};
  const Time end = robot.network().now() + std::chrono::minutes(10);
  for (std::size_t i = 0; robot.network().now() < end; ++i) {
    if (!robot.Set(targets[i % std::size(targets)])) return false;
    robot.RunFor(std::chrono::seconds(5));
  }
  return true;
}

void Run(benchmark::State& state, const transport::sim::LinkFaults& faults) {
  std::uint64_t seed = 0;
  for (auto _ : state) {
    if (!RunTenMinutes(++seed, faults)) return state.SkipWithError("a switch has no end");
  }
  state.counters["runs"] =
      benchmark::Counter(static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}

void TenMinutes(benchmark::State& state) {
  Run(state, {});
}

void TenMinutesOverALossyNetwork(benchmark::State& state) {
  transport::sim::LinkFaults faults;
  faults.loss = 0.05;
  faults.duplication = 0.05;
  faults.reordering = 0.05;
  faults.delay_max = Milliseconds(5);
  Run(state, faults);
}

BENCHMARK(TenMinutes)->Unit(benchmark::kMillisecond);
BENCHMARK(TenMinutesOverALossyNetwork)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace musher::testing

BENCHMARK_MAIN();
