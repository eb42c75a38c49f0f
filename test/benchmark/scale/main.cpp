// Many actuators on one host, all started in the same instant: how long until all are Active.
//
//   benchmark_scale [ACTUATORS PROCESSES]...
//
// As many processes as actuators: the controller starts them, each has a participant of its own.
// Fewer: they are started by hand, and those of a process share its participant.

#include <cstdlib>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/controller/machine_controller.hpp"
#include "musher/test/benchmark/common/child.hpp"
#include "musher/test/benchmark/common/fleet.hpp"
#include "musher/test/benchmark/common/statistics.hpp"

namespace musher::benchmark {
namespace {

using Clock = std::chrono::steady_clock;
using Processes = std::vector<std::unique_ptr<Child>>;

// The actuators of `fleet`, dealt to `count` processes.
Processes StartByHand(const Fleet& fleet, int count) {
  const std::size_t share = (fleet.names().size() + count - 1) / count;
  Processes processes;
  for (std::size_t first = 0; first < fleet.names().size(); first += share) {
    std::vector<std::string> argv = {Program("benchmark_actuator")};
    for (std::size_t i = first; i < std::min(first + share, fleet.names().size()); ++i) {
      argv.push_back(fleet.names()[i]);
    }
    processes.push_back(
        std::make_unique<Child>(argv, Child::Environment{{"MUSHER_CONFIG", fleet.config_file()}}));
  }
  return processes;
}

void Measure(int actuators, int processes, int number, const Table& table) {
  setenv("ROS_DOMAIN_ID", std::to_string(Domain(number)).c_str(), 1);
  const std::string what =
      std::to_string(actuators) + " actuators in " + std::to_string(processes) + " processes: ";
  const bool shared = processes < actuators;
  const Fleet fleet(actuators, !shared);
  const auto begin = Clock::now();
  const Processes by_hand = shared ? StartByHand(fleet, processes) : Processes();
  MachineController controller;
  if (!controller.Init(fleet.config_file())) Fail("no controller");
  if (!controller.AwaitSetUp()) Fail("not all are set up");
  table.Row(what + "all set up after", {ToSeconds(Clock::now() - begin)}, "s");
  MustBeDone(controller.Switch("SelfCheck"));
  MustBeDone(controller.Switch("Active"));
  table.Row(what + "all Active after", {ToSeconds(Clock::now() - begin)}, "s");
  std::vector<double> times;
  for (int i = 0; i < 40; ++i) {
    const auto switched = Clock::now();
    MustBeDone(controller.Switch(i % 2 == 0 ? kDeActive : kActive));
    times.push_back(ToSeconds(Clock::now() - switched) * 1000);
  }
  table.Row(what + "a switch of all", times, "ms");
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  std::vector<std::pair<int, int>> sizes;
  for (int i = 1; i + 1 < argc; i += 2) {
    sizes.emplace_back(std::atoi(argv[i]), std::atoi(argv[i + 1]));
  }
  if (sizes.empty()) sizes = {{100, 100}, {256, 32}};
  const musher::benchmark::Table table("Many actuators on one host");
  int number = 0;
  for (const auto& [actuators, processes] : sizes) {
    musher::benchmark::Measure(actuators, processes, number++, table);
  }
}
