#include <net/if.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <numeric>
#include <sstream>
#include <thread>

#include "musher/test/benchmark/common/fleet.hpp"
#include "musher/test/benchmark/common/process.hpp"
#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/test/benchmark/health/hand_started.hpp"
#include "musher/test/benchmark/health/parts.hpp"
#include "musher/transport/dds/settings.hpp"

namespace musher::benchmark {
namespace {

constexpr int kIdleActuators = 12;

// A network of this process and its children alone, so that all traffic on it is theirs.
bool EnterOwnNetwork() {
  if (unshare(CLONE_NEWNET) != 0 && unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) return false;
  const int any = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  ifreq loopback{};
  std::snprintf(loopback.ifr_name, sizeof(loopback.ifr_name), "lo");
  loopback.ifr_flags = IFF_UP | IFF_LOOPBACK | IFF_RUNNING;
  const bool up = ioctl(any, SIOCSIFFLAGS, &loopback) == 0;
  close(any);
  return up;
}

struct Traffic {
  double bytes = 0;
  double packets = 0;
};

// Sent on the loopback interface since its creation.
Traffic TrafficOnLoopback() {
  std::ifstream file("/proc/thread-self/net/dev");
  for (std::string line; std::getline(file, line);) {
    const auto name = line.find("lo:");
    if (name == std::string::npos) continue;
    std::istringstream numbers(line.substr(name + 3));
    Traffic traffic;
    numbers >> traffic.bytes >> traffic.packets;
    return traffic;
  }
  Fail("no loopback interface");
}

struct Figures {
  std::vector<double> cpu_percent;  // of a core, for each process
  double switches = 0;              // a second, all together
  Traffic traffic;                  // a second

  double cpu() const { return std::accumulate(cpu_percent.begin(), cpu_percent.end(), 0.0); }
};

Figures Measure(const std::vector<pid_t>& pids, double seconds) {
  std::this_thread::sleep_for(std::chrono::seconds(2));  // until all are at rest
  std::vector<Cost> before;
  before.reserve(pids.size());
  for (const pid_t pid : pids) before.push_back(CostOf(pid));
  const Traffic traffic = TrafficOnLoopback();
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  const Traffic traffic_after = TrafficOnLoopback();
  Figures figures;
  for (std::size_t i = 0; i < pids.size(); ++i) {
    const Cost after = CostOf(pids[i]);
    figures.cpu_percent.push_back(ToSeconds(after.cpu - before[i].cpu) / seconds * 100);
    figures.switches +=
        static_cast<double>(after.context_switches - before[i].context_switches) / seconds;
  }
  figures.traffic = {(traffic_after.bytes - traffic.bytes) / seconds,
                     (traffic_after.packets - traffic.packets) / seconds};
  return figures;
}

// As many processes on the same middleware with the same settings, that say nothing.
Figures OfBareParticipants(double seconds) {
  const std::string uri = transport::dds::SettingsXml(TransportProfile::kLocal, std::nullopt);
  std::vector<Child> children;
  std::vector<pid_t> pids;
  for (int i = 0; i <= kIdleActuators; ++i) {
    children.emplace_back(
        std::vector<std::string>{Program("benchmark_bare_participant"), std::to_string(Domain(1))},
        Child::Environment{{"CYCLONEDDS_URI", uri}});
    pids.push_back(children.back().pid());
  }
  return Measure(pids, seconds);
}

// The controller's comes last.
Figures OfMachine(const std::string& keys, int domain, double seconds) {
  setenv("ROS_DOMAIN_ID", std::to_string(Domain(domain)).c_str(), 1);
  const Fleet fleet([&](const Fleet&, const std::string&) { return keys; }, kIdleActuators);
  const HandStarted actuators(fleet);
  const Child controller({Program("benchmark_controller"), fleet.config_file()}, {},
                         Child::Output::kPiped);
  controller.AwaitOutput();
  std::vector<pid_t> pids;
  for (const ActuatorIndex i : actuators.Indices()) pids.push_back(actuators.pid(i));
  pids.push_back(controller.pid());
  return Measure(pids, seconds);
}

void Print(const Table& table, const std::string& what, const Figures& figures) {
  std::vector<double> actuators = figures.cpu_percent;
  const double controller = actuators.back();
  actuators.pop_back();
  table.Row(what + ", CPU of one actuator", actuators, "% of a core");
  table.Row(what + ", CPU of the controller", {controller}, "% of a core");
  table.Row(what + ", CPU of all", {figures.cpu()}, "% of a core");
  table.Row(what + ", context switches", {figures.switches}, "/s");
  table.Row(what + ", packets", {figures.traffic.packets}, "/s");
  table.Row(what + ", traffic", {figures.traffic.bytes / 1000}, "kB/s");
}

}  // namespace

void Idle(int seconds) {
  const bool own_network = EnterOwnNetwork();
  const Figures bare = OfBareParticipants(seconds / 3.0);
  const Figures machine = OfMachine("", 2, seconds);
  const Figures checked = OfMachine("checkpoint_ms = 200\n", 3, seconds / 3.0);
  const Table table("12 idle actuators and their controller");
  table.Row("as many bare participants, CPU of all", {bare.cpu()}, "% of a core");
  table.Row("as many bare participants, context switches", {bare.switches}, "/s");
  table.Row("as many bare participants, packets", {bare.traffic.packets}, "/s");
  table.Row("as many bare participants, traffic", {bare.traffic.bytes / 1000}, "kB/s");
  Print(table, "idle", machine);
  // All that Musher does at rest, so no less than what health costs.
  table.Row("idle, CPU of all beyond bare participants", {machine.cpu() - bare.cpu()},
            "% of a core", 0.5);
  Print(table, "with checkpoint_ms = 200", checked);
  // A heartbeat each 50 ms instead of 500 is all that differs.
  table.Row("idle, CPU of the actuators' heartbeats: a ninth of what ten times as many cost more",
            {(checked.cpu() - machine.cpu()) / 9}, "% of a core");
  if (!own_network) std::printf("\nTraffic is that of the whole host: no network of our own.\n");
}

}  // namespace musher::benchmark
