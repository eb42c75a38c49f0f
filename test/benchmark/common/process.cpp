#include "musher/test/benchmark/common/process.hpp"

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace musher::benchmark {
namespace {

// The number behind `key` in a file of lines "Key:   123 kB"; 0 when there is none.
double Field(const std::string& file, const std::string& key) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with(key + ":")) return std::stod(line.substr(key.size() + 1));
  }
  return 0;
}

// Of all threads, the CPU in nanoseconds; unlike utime and stime it does not count in ticks.
void AddThreads(const std::string& process, Cost& cost) {
  std::error_code ended;
  for (const auto& task : std::filesystem::directory_iterator(process + "/task", ended)) {
    std::int64_t on_cpu = 0;
    std::ifstream(task.path() / "schedstat") >> on_cpu;
    cost.cpu += Duration(on_cpu);
    for (const char* kind : {"voluntary_ctxt_switches", "nonvoluntary_ctxt_switches"}) {
      cost.context_switches += static_cast<std::int64_t>(Field(task.path() / "status", kind));
    }
  }
}

}  // namespace

Cost CostOf(pid_t pid) {
  const std::string process = "/proc/" + std::to_string(pid);
  Cost cost;
  cost.resident_mb = Field(process + "/smaps_rollup", "Rss") / 1024;
  cost.proportional_mb = Field(process + "/smaps_rollup", "Pss") / 1024;
  cost.threads = static_cast<int>(Field(process + "/status", "Threads"));
  AddThreads(process, cost);
  return cost;
}

}  // namespace musher::benchmark
