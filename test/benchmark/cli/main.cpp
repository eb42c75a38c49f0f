// The `musher` program as a person feels it: whole processes, from exec to exit.
//
//   benchmark_cli CONFIG [rounds]
//
// Every command that changes nothing, and `set`, beside a controller of eight actuators. Not those
// that need more than that: an application (behavior), skills, credentials, an upgrade root.

#include <cstdlib>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "musher/test/benchmark/common/child.hpp"
#include "musher/test/benchmark/common/fleet.hpp"
#include "musher/test/benchmark/common/statistics.hpp"

namespace musher::benchmark {
namespace {

using Clock = std::chrono::steady_clock;
using Words = std::vector<std::string>;

// The exit code of `musher doctor` on a computer that lacks something, and of `diff` for two
// configs that differ.
constexpr int kFindings = 1;

constexpr const char* kTree = R"(<root BTCPP_format="4"><BehaviorTree ID="Main">
  <Sequence><AlwaysSuccess/><Sleep msec="10"/></Sequence>
</BehaviorTree></root>
)";

struct Command {
  std::string name;
  Words arguments;
  double limit_ms;  // of the median; 0: none
};

std::vector<Command> Commands(const std::string& config, const Fleet& fleet,
                              const std::string& tree) {
  return {
      {"musher check", {"check", fleet.config_file()}, 20},
      {"musher check, whose programs check themselves, too", {"check", config}, 0},
      {"musher diff", {"diff", config, fleet.config_file()}, 20},
      {"musher graph", {"graph", config}, 20},
      {"musher simulate, one run", {"simulate", config, "--seeds", "1"}, 0},
      {"musher tree check", {"tree", "check", tree}, 20},
      {"musher completion bash", {"completion", "bash"}, 20},
      {"musher complete, a command", {"complete", "stat"}, 20},
      {"musher complete, an actuator", {"complete", "restart", "a"}, 50},
      {"musher --help", {"--help"}, 20},
      {"musher status", {"status"}, 50},
      {"musher describe", {"describe", "a3"}, 0},
      {"musher capabilities", {"capabilities"}, 50},
      {"musher plan", {"plan", "DeActive"}, 50},
      {"musher history", {"history"}, 50},
      {"musher history --why", {"history", "--why"}, 50},
      {"musher logs", {"logs", "a3", "--config", fleet.config_file()}, 50},
      {"musher replay", {"replay", fleet.folder() + "/state/journal.sqlite"}, 0},
      {"musher top --once, which samples for 0.5 s", {"top", "--once"}, 0},
      {"musher doctor", {"doctor", fleet.config_file()}, 0},
  };
}

// Milliseconds from exec to exit of `musher` with `arguments`.
double Run(Words arguments) {
  arguments.insert(arguments.begin(), Program("musher"));
  const auto begin = Clock::now();
  const int exit_code = Child(arguments, {}, Child::Output::kNowhere).Wait();
  const double time = ToSeconds(Clock::now() - begin) * 1000;
  const bool findings =
      exit_code == kFindings && (arguments[1] == "doctor" || arguments[1] == "diff");
  if (exit_code != 0 && !findings) {
    Fail("musher " + arguments[1] + " ended with exit code " + std::to_string(exit_code));
  }
  return time;
}

void Main(const std::string& config, int rounds) {
  setenv("ROS_DOMAIN_ID", std::to_string(Domain()).c_str(), 1);
  const Fleet fleet(8, true);
  const Child controller({Program("benchmark_controller"), fleet.config_file()}, {},
                         Child::Output::kPiped);
  controller.AwaitOutput();
  const std::string tree = fleet.folder() + "/tree.xml";
  std::ofstream(tree) << kTree;

  const std::vector<Command> commands = Commands(config, fleet, tree);
  std::map<std::string, std::vector<double>> times;
  std::vector<double> set;
  for (int i = 0; i < rounds; ++i) {
    for (const Command& command : commands) times[command.name].push_back(Run(command.arguments));
    set.push_back(Run({"set", i % 2 == 0 ? "DeActive" : "Active"}));
  }
  const Table table("The CLI, whole processes");
  for (const Command& command : commands) {
    table.Row(command.name, times[command.name], "ms", command.limit_ms);
  }
  table.Row("musher set", set, "ms", 50);
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  if (argc < 2) return EXIT_FAILURE;
  musher::benchmark::Main(argv[1], argc > 2 ? std::atoi(argv[2]) : 50);
}
