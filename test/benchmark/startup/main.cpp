// From the start of the processes to all active: ROS 2 managed nodes under a Musher controller and
// under a manager like nav2's (one node after the other, without bonds), in turns, and as many
// Musher actuators.
//
//   benchmark_startup [NODES [TURNS]]

#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "musher/controller/machine_controller.hpp"
#include "musher/test/benchmark/common/child.hpp"
#include "musher/test/benchmark/common/fleet.hpp"
#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/test/contract/plain_lifecycle_manager.hpp"

namespace musher::benchmark {
namespace {

using Clock = std::chrono::steady_clock;

int g_domain = 0;

// Each turn has a DDS domain of its own.
int NextDomain() {
  const int domain = Domain(g_domain++);
  setenv("ROS_DOMAIN_ID", std::to_string(domain).c_str(), 1);
  return domain;
}

double UnderMusher(const Fleet& fleet) {
  NextDomain();
  const auto begin = Clock::now();
  MachineController controller;
  if (!controller.MachineControllerInit(fleet.config_file())) Fail("no controller");
  if (!controller.WaitActuatorsSetUp()) Fail("not all are set up");
  MustBeDone(controller.Switch("SelfCheck"));
  MustBeDone(controller.Switch("Active"));
  const double took = Seconds(Clock::now() - begin);
  static_cast<void>(controller.Switch("TearDown").done());  // ends its processes
  return took;
}

double UnderNav2(const std::vector<std::string>& nodes) {
  const int domain = NextDomain();
  const Child::Environment environment = {{"CYCLONEDDS_URI", testing::kLoopback},
                                          {"RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp"}};
  const auto begin = Clock::now();
  std::vector<std::unique_ptr<Child>> processes;
  for (const std::string& node : nodes) {
    processes.push_back(std::make_unique<Child>(
        std::vector<std::string>{Program("ros_server_peer"), "nav/" + node}, environment));
  }
  testing::PlainNav2Manager manager(domain, "nav", nodes);
  if (!manager.Startup()) Fail("the plain manager: " + manager.errors().front());
  return Seconds(Clock::now() - begin);
}

void Measure(int count, int turns) {
  const Table table(std::to_string(count) + " processes, from their start to all active");
  const auto node = [](const Fleet&, const std::string& name) {
    return "protocol = \"ros2_lifecycle\"\n" + CommandKey({Program("ros_server_peer"), name});
  };
  std::vector<double> musher, nav2, actuators;
  for (int turn = 0; turn < turns; ++turn) {
    const Fleet nodes(node, count);
    musher.push_back(UnderMusher(nodes));
    nav2.push_back(UnderNav2(nodes.names()));
    actuators.push_back(UnderMusher(Fleet(count, true)));
  }
  table.Row("ROS 2 nodes, Musher", musher, "s");
  table.Row("ROS 2 nodes, a manager like nav2's", nav2, "s");
  table.Row("Musher / the other manager", Ratios(musher, nav2), "×");
  table.Row("Musher actuators", actuators, "s");
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  musher::benchmark::Measure(argc > 1 ? std::atoi(argv[1]) : 32, argc > 2 ? std::atoi(argv[2]) : 5);
}
