// The `musher` program as a person feels it: whole processes, from exec to exit.
//
//   benchmark_cli CONFIG [rounds]
//
// `musher check` runs on CONFIG; `status` and `set` call a controller of eight actuators.

#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "musher/test/benchmark/common/child.hpp"
#include "musher/test/benchmark/common/fleet.hpp"
#include "musher/test/benchmark/common/statistics.hpp"

namespace musher::benchmark {
namespace {

using Clock = std::chrono::steady_clock;

// Milliseconds from exec to exit of `musher` with `arguments`.
double Run(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), Program("musher"));
  const auto begin = Clock::now();
  const int exit_code = Child(arguments, {}, Child::Output::kNowhere).Wait();
  const double time = ToSeconds(Clock::now() - begin) * 1000;
  if (exit_code != 0) {
    Fail("musher " + arguments[1] + " ended with exit code " + std::to_string(exit_code));
  }
  return time;
}

void Main(const std::string& config, int rounds) {
  setenv("ROS_DOMAIN_ID", std::to_string(Domain()).c_str(), 1);
  const Fleet fleet(8, false);
  std::vector<std::unique_ptr<Child>> actuators;
  for (const std::string& name : fleet.names()) {
    actuators.push_back(
        std::make_unique<Child>(std::vector<std::string>{Program("benchmark_actuator"), name},
                                Child::Environment{{"MUSHER_CONFIG", fleet.config_file()}}));
  }
  const Child controller({Program("benchmark_controller"), fleet.config_file()}, {},
                         Child::Output::kPiped);
  controller.AwaitOutput();

  std::vector<double> check;
  std::vector<double> status;
  std::vector<double> set;
  for (int i = 0; i < rounds; ++i) {
    check.push_back(Run({"check", config}));
    status.push_back(Run({"status"}));
    set.push_back(Run({"set", i % 2 == 0 ? "DeActive" : "Active"}));
  }
  const Table table("The CLI, whole processes");
  table.Row("musher check", check, "ms", 20);
  table.Row("musher status", status, "ms", 50);
  table.Row("musher set", set, "ms", 50);
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  if (argc < 2) return EXIT_FAILURE;
  musher::benchmark::Main(argv[1], argc > 2 ? std::atoi(argv[2]) : 50);
}
