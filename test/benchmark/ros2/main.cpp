// What a machine costs beside ROS 2: the datagrams that a switch of many managed nodes sends,
// under a Musher controller and under a manager like nav2's; and the memory that a controller
// has after many observers (as `ros2 topic echo`) have come and gone.
//
//   benchmark_ros2 [NODES [SWITCHES [OBSERVERS]]]
//
// Datagrams are counted by the kernel in a network namespace of its own, in which only this runs;
// where the user may not make one, that part is left out.

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <limits>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "musher/controller/machine_controller.hpp"
#include "musher/test/benchmark/common/child.hpp"
#include "musher/test/benchmark/common/fleet.hpp"
#include "musher/test/benchmark/common/process.hpp"
#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/test/contract/plain_lifecycle_manager.hpp"
#include "musher/test/fault_injection/host/isolation.hpp"
#include "musher/test/support/wait.hpp"

namespace musher::benchmark {
namespace {

using Clock = std::chrono::steady_clock;

// What this network namespace has sent: UDP, so without what is lost on the way.
std::int64_t SentDatagrams() {
  std::ifstream file("/proc/self/net/snmp");
  std::vector<std::string> names;
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("Udp:")) continue;
    std::istringstream stream(line);
    std::vector<std::string> words;
    for (std::string word; stream >> word;) words.push_back(word);
    if (names.empty()) {
      names = words;
      continue;
    }
    for (std::size_t i = 1; i < words.size() && i < names.size(); ++i) {
      if (names[i] == "OutDatagrams") return std::stoll(words[i]);
    }
  }
  Fail("/proc/self/net/snmp has no OutDatagrams");
}

// Of a switch, for each node, without what an idle machine sends.
using Datagrams = std::vector<double>;

// Waits until no fewer are sent in a second than in the one before: what has begun is over. What an
// idle machine sends in a second.
double AwaitRest() {
  auto begun = Clock::now();
  std::int64_t at_begin = SentDatagrams();
  double before = std::numeric_limits<double>::infinity(), per_s = 0;
  const bool rests = testing::Until([&] {
    if (Clock::now() - begun < std::chrono::seconds(1)) return false;
    const std::int64_t sent = SentDatagrams();
    const auto now = Clock::now();
    per_s = static_cast<double>(sent - std::exchange(at_begin, sent)) /
            ToSeconds(now - std::exchange(begun, now));
    return std::exchange(before, per_s) <= 1.1 * per_s;
  });
  if (!rests) Fail("the machine does not come to rest");
  return per_s;
}

// `count` switches at once.
void Count(const std::function<void(int)>& switch_all, int nodes, int count, Datagrams& datagrams) {
  AwaitRest();  // discovery and the start are over
  const auto begun = Clock::now();
  const std::int64_t before = SentDatagrams();
  for (int i = 0; i < count; ++i) switch_all(i);
  const double idle_per_s = AwaitRest();  // acknowledgements and status have been sent
  const double idle = idle_per_s * ToSeconds(Clock::now() - begun);
  const double of_switches = static_cast<double>(SentDatagrams() - before) - idle;
  datagrams.push_back(of_switches / (static_cast<double>(nodes) * count));
}

void UnderMusher(const Fleet& fleet, int count, Datagrams& datagrams) {
  NextDomain();
  MachineController controller;
  if (!controller.Init(fleet.config_file())) Fail("no controller");
  if (!controller.AwaitSetUp()) Fail("not all are set up");
  MustBeDone(controller.Switch("SelfCheck"));
  MustBeDone(controller.Switch("Active"));
  Count([&](int i) { MustBeDone(controller.Switch(i % 2 == 0 ? kDeActive : kActive)); },
        static_cast<int>(fleet.names().size()), count, datagrams);
  static_cast<void>(controller.Switch("TearDown").done());  // ends its processes
}

void UnderNav2(const std::vector<std::string>& nodes, int count, Datagrams& datagrams) {
  const int domain = NextDomain();
  const Child::Environment environment = {{"CYCLONEDDS_URI", testing::kLoopback},
                                          {"RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp"}};
  std::vector<std::unique_ptr<Child>> processes;
  for (const std::string& node : nodes) {
    processes.push_back(std::make_unique<Child>(
        std::vector<std::string>{Program("ros_server_peer"), "nav/" + node}, environment));
  }
  testing::PlainNav2Manager manager(domain, "nav", nodes);
  if (!manager.Startup()) Fail("the plain manager: " + manager.errors().front());
  Count(
      [&](int i) {
        if (!(i % 2 == 0 ? manager.Pause() : manager.Resume())) Fail("a switch");
      },
      static_cast<int>(nodes.size()), count, datagrams);
}

void MeasureTraffic(int nodes, int switches) {
  const Table table("A switch of " + std::to_string(nodes) + " nodes: datagrams for each node");
  const auto node = [](const Fleet&, const std::string& name) {
    return "protocol = \"ros2_lifecycle\"\n" + CommandKey({Program("ros_server_peer"), name});
  };
  Datagrams musher, nav2, actuators;
  for (int turn = 0; turn < 3; ++turn) {
    const Fleet fleet(node, nodes);
    UnderMusher(fleet, switches, musher);
    UnderNav2(fleet.names(), switches, nav2);
    UnderMusher(Fleet(nodes, true), switches, actuators);
  }
  table.Row("ROS 2 nodes, Musher", musher, " ");
  table.Row("ROS 2 nodes, a manager like nav2's", nav2, " ");
  table.Row("Musher actuators", actuators, " ");
}

// Waits until the memory of the process has been the same for so long.
Cost AwaitSteady(pid_t pid, Duration time) {
  Cost cost = CostOf(pid);
  auto since = Clock::now();
  const bool steady = testing::Until([&] {
    const Cost now = CostOf(pid);
    if (now.resident_mb != cost.resident_mb) since = Clock::now();
    cost = now;
    return Clock::now() - since >= time;
  });
  if (!steady) Fail("the memory of the controller does not come to rest");
  return cost;
}

// Ten at a time, each with readers of what people look at and an answered query.
void ComeAndGo(int domain, int observers) {
  using Status = musher_msgs_msg_dds__MachineStatus_;
  constexpr int kAtOnce = 10;
  for (int come = 0; come < observers; come += kAtOnce) {
    std::vector<std::unique_ptr<testing::PlainParticipant>> there;
    for (int i = 0; i < kAtOnce; ++i) {
      there.push_back(std::make_unique<testing::PlainParticipant>(domain));
      there.back()->Read<Status>(musher_msgs_msg_dds__MachineStatus__desc,
                                 "rt/musher/machine_status", [](const Status&) {});
      there.back()->Read<diagnostic_msgs_msg_dds__DiagnosticArray_>(
          diagnostic_msgs_msg_dds__DiagnosticArray__desc, "rt/diagnostics", [](const auto&) {});
      testing::PlainLifecycleClient client(*there.back(), "musher");
      if (client.GetState().empty()) Fail("an observer has no answer");
    }
  }
}

void MeasureMemory(int observers) {
  const int domain = NextDomain();
  const Fleet fleet(8, true);
  Child controller({Program("benchmark_controller"), fleet.config_file()}, {},
                   Child::Output::kPiped);
  controller.AwaitOutput();
  std::printf(
      "\n## A controller of 8 actuators, with observers that come and go, ten at a time\n\n"
      "| observers so far | RSS | PSS |\n|---|---|---|\n");
  const auto print = [&](const std::string& what, Duration steady = std::chrono::seconds(3)) {
    const Cost cost = AwaitSteady(controller.pid(), steady);
    std::printf("| %s | %.1f MB | %.1f MB |\n", what.c_str(), cost.resident_mb,
                cost.proportional_mb);
    std::fflush(stdout);
  };
  print("0");
  for (int times = 1; times <= 5; ++times) {
    ComeAndGo(domain, observers);
    print(std::to_string(times * observers));
  }
  print("the same, once it has not changed for 30 s", std::chrono::seconds(30));
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  namespace benchmark = musher::benchmark;
  const int nodes = argc > 1 ? std::atoi(argv[1]) : 32;
  const int switches = argc > 2 ? std::atoi(argv[2]) : 50;
  const int observers = argc > 3 ? std::atoi(argv[3]) : 200;
  const auto isolation = musher::fault_injection::Isolate();
  if (isolation.own_network) {
    benchmark::MeasureTraffic(nodes, switches);
  } else {
    std::printf("datagrams are not counted: %s\n", isolation.no_network.c_str());
  }
  benchmark::MeasureMemory(observers);
}
