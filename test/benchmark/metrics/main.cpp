// The cost of one GET /metrics of a machine, without the network.
//
//   benchmark_metrics [ACTUATORS [SCRAPES]]
//
// With 0 scrapes it prints the text instead, in the format of Prometheus, for
// `promtool check metrics`.

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/view/metrics/robot_metrics.hpp"

namespace musher::benchmark {
namespace {

using view::MetricsFormat;
using view::RobotMetrics;

msg::MachineStatus StatusOf(int actuators) {
  msg::MachineStatus status;
  status.machine = "robot";
  status.phase = "running";
  status.state = "Active";
  status.policy.active = true;
  status.policy.battery = 80;
  for (int i = 0; i < actuators; ++i) {
    msg::ActuatorInfo& info = status.actuators.emplace_back();
    info.name = "actuator_" + std::to_string(i);
    info.state = "Active";
    info.presence = "present";
    info.health = "well";
  }
  return status;
}

// A switch that took 40 ms.
void AddSwitch(RobotMetrics& metrics, std::uint64_t number, const std::string& target) {
  msg::HistoryEntry entry;
  entry.epoch = 1;
  entry.kind = "switch";
  entry.switch_number = number;
  entry.id = 2 * number;
  entry.wall_ns = static_cast<std::int64_t>(number) * 1'000'000'000;
  entry.data = R"({"target":")" + target + R"("})";
  metrics.On(entry, "switch_started");
  ++entry.id;
  entry.wall_ns += 40'000'000;
  entry.data = R"({"target":")" + target + R"(","outcome":"done"})";
  metrics.On(entry, "switch_done");
}

void Fill(RobotMetrics& metrics, const msg::MachineStatus& status, Time now) {
  metrics.On(status, now);
  for (std::uint64_t number = 1; number <= 6; number += 2) {
    AddSwitch(metrics, number, "LowPower");
    AddSwitch(metrics, number + 1, "Active");
  }
  for (const msg::ActuatorInfo& info : status.actuators) {
    msg::ActuatorHeartbeat heartbeat;
    heartbeat.name = info.name;
    heartbeat.period_ns = 100'000'000;
    metrics.On(heartbeat, now);
    metrics.OnProcess(info.name, ProcessUsage{1, 1, 1.25, 12 << 20});
  }
}

double UsOf(const auto& call) {
  const auto begin = std::chrono::steady_clock::now();
  call();
  return Microseconds(std::chrono::steady_clock::now() - begin);
}

void Measure(int actuators, int scrapes) {
  const Time now = std::chrono::steady_clock::now();
  const msg::MachineStatus status = StatusOf(actuators);
  RobotMetrics metrics;
  Fill(metrics, status, now);
  if (scrapes == 0) {
    std::fputs(metrics.Text(now, MetricsFormat::kPrometheus).c_str(), stdout);
    return;
  }
  std::vector<double> text_us, status_us, process_us, bytes;
  for (int i = 0; i < scrapes; ++i) {
    std::string text;
    text_us.push_back(UsOf([&] { text = metrics.Text(now, MetricsFormat::kOpenMetrics); }));
    status_us.push_back(UsOf([&] { metrics.On(status, now); }));
    process_us.push_back(UsOf([] { static_cast<void>(UsageOf(1)); }));
    bytes.push_back(static_cast<double>(text.size()));
  }
  const Table table("GET /metrics of " + std::to_string(actuators) + " actuators");
  table.Row("writing the text", text_us, "us");
  table.Row("size of the text", bytes, "bytes");
  table.Row("a new status of the machine", status_us, "us");
  table.Row("examining one process", process_us, "us");
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  const int actuators = argc > 1 ? std::atoi(argv[1]) : 100;
  const int scrapes = argc > 2 ? std::atoi(argv[2]) : 2000;
  musher::benchmark::Measure(actuators, scrapes);
  return 0;
}
