#include <cstdio>
#include <thread>

#include "musher/test/benchmark/common/observed_controller.hpp"
#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/test/benchmark/health/hand_started.hpp"
#include "musher/test/benchmark/health/parts.hpp"

namespace musher::benchmark {
namespace {

constexpr int kActuators = 32;
// For so long after the adoption no actuator may be commanded.
constexpr Duration kAfterwards = Milliseconds(500);

std::int64_t Callbacks(const HandStarted& actuators) {
  std::int64_t sum = 0;
  for (const ActuatorIndex i : actuators.Indices()) sum += actuators.board(i).callbacks;
  return sum;
}

}  // namespace

void Adoption(int rounds) {
  const Fleet fleet([](const Fleet&, const std::string&) { return ""; }, kActuators);
  const HandStarted actuators(fleet);
  std::vector<double> times;
  std::vector<double> disturbed;
  for (int i = 0; i < rounds; ++i) {
    {
      const Child first({Program("benchmark_controller"), fleet.config_file()}, {},
                        Child::Output::kPiped);
      first.AwaitOutput();
    }  // kill -9
    const std::int64_t before = Callbacks(actuators);
    const Time begin = std::chrono::steady_clock::now();
    ObservedController second(fleet.config_file());
    second.AwaitAllThere();
    times.push_back(ToSeconds(std::chrono::steady_clock::now() - begin) * 1000);
    std::this_thread::sleep_for(kAfterwards);
    disturbed.push_back(static_cast<double>(Callbacks(actuators) - before));
    if (second.Snapshot().state != kActive) Fail("the machine is not where it was");
  }
  const Table table("A new controller adopts 32 actuators in Active");
  table.Row("its start → all present, at rest, machine running", times, "ms");
  table.Row("callbacks that ran meanwhile", disturbed, "");
  if (Quantile(disturbed, 1) > 0) Fail("the adoption has disturbed an actuator");
}

}  // namespace musher::benchmark
