#include <signal.h>

#include "musher/test/benchmark/common/observed_controller.hpp"
#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/test/benchmark/health/hand_started.hpp"
#include "musher/test/benchmark/health/parts.hpp"

namespace musher::benchmark {
namespace {

constexpr int kCrashActuators = 4;

// Milliseconds until it is on record.
double Kill(ObservedController& controller, ActuatorIndex actuator) {
  const pid_t pid = controller.Snapshot().actuators[actuator].report.pid;
  auto known = controller.Next(IsOnRecord(actuator, Health::kCrashed));
  const Time killed = std::chrono::steady_clock::now();
  kill(pid, SIGKILL);
  return ToSeconds(MomentOf(known, "a crash") - killed) * 1000;
}

std::vector<double> OfChildren(int rounds) {
  const Fleet fleet(
      [](const Fleet& self, const std::string& name) {
        return CommandKey(self.Module(name, 0)) + kUnlimitedRestartKeys + "restart_delay_ms = 0\n";
      },
      kCrashActuators);
  ObservedController controller(fleet.config_file());
  std::vector<double> times;
  for (int i = 0; i < rounds; ++i) {
    const ActuatorIndex actuator(static_cast<std::size_t>(i % kCrashActuators));
    controller.AwaitAllThere();
    times.push_back(Kill(controller, actuator));
  }
  return times;
}

std::vector<double> OfOthers(int rounds) {
  const Fleet fleet([](const Fleet&, const std::string&) { return kUnlimitedRestartKeys; },
                    kCrashActuators);
  HandStarted actuators(fleet);
  ObservedController controller(fleet.config_file());
  std::vector<double> times;
  for (int i = 0; i < rounds; ++i) {
    const ActuatorIndex actuator(static_cast<std::size_t>(i % kCrashActuators));
    controller.AwaitAllThere();
    times.push_back(Kill(controller, actuator));
    actuators.Start(actuator);
  }
  return times;
}

}  // namespace

void Crash(int rounds) {
  const Table table("kill -9 → crashed, on this host");
  table.Row("a child of the controller", OfChildren(rounds), "ms");
  table.Row("started by hand", OfOthers(rounds), "ms");
}

}  // namespace musher::benchmark
