// Three cameras of 640x480: how old a picture is when a program has it, how many are lost, and what
// each process pays.
//
//   benchmark_camera [SECONDS [HZ...]]

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "musher/test/benchmark/common/child.hpp"
#include "musher/test/benchmark/common/process.hpp"
#include "musher/test/benchmark/common/statistics.hpp"

namespace musher::benchmark {
namespace {

constexpr const char* kWidth = "640";
constexpr const char* kHeight = "480";
const std::vector<std::string> kWorldTopics = {"world/camera/front", "world/camera/left",
                                               "world/camera/right"};

using Arguments = std::vector<std::string>;

Arguments operator+(Arguments arguments, const Arguments& more) {
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

class Folder {
 public:
  Folder() : path_(std::filesystem::temp_directory_path() / "musher-camera-XXXXXX") {
    if (mkdtemp(path_.data()) == nullptr) Fail("no folder");
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  std::string File(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

// What one sink saw.
struct Seen {
  std::vector<double> latencies_ms;
  double lost = 0;
  double cpu_s = 0;
};

Seen Read(const std::string& file) {
  std::ifstream in(file);
  Seen seen;
  std::string word;
  in >> word >> seen.lost >> word >> seen.cpu_s;
  seen.cpu_s /= 1e9;
  for (double latency_ns = 0; in >> latency_ns;) seen.latencies_ms.push_back(latency_ns / 1e6);
  return seen;
}

// A process whose share of a core is told.
struct Payer {
  std::string name;
  const Child* child;
  Duration before{};
};

struct Setting {
  std::string what;
  int sinks = 1;
  int bystanders = 0;
};

void Measure(const Setting& setting, int seconds, int hz, int number) {
  setenv("ROS_DOMAIN_ID", std::to_string(Domain(number)).c_str(), 1);
  const Folder folder;
  const Child source(
      Arguments{Program("benchmark_picture_source"), kWidth, kHeight, std::to_string(hz)} +
      kWorldTopics);
  std::vector<Child> sinks;
  std::vector<Child> bystanders;
  std::vector<Payer> payers = {{"the cameras", &source}};
  for (int i = 0; i < setting.bystanders; ++i) {
    bystanders.emplace_back(Arguments{Program("benchmark_picture_source"), "8", "8", "1", "other"});
  }
  if (!bystanders.empty()) payers.push_back({"a bystander", &bystanders.front()});
  for (int i = 0; i < setting.sinks; ++i) {
    sinks.emplace_back(Arguments{Program("benchmark_picture_sink"),
                                 folder.File("sink" + std::to_string(i)), std::to_string(seconds)} +
                           kWorldTopics,
                       Child::Environment{}, Child::Output::kPiped);
  }
  for (const Child& sink : sinks) sink.AwaitOutput();
  for (Payer& payer : payers) payer.before = CostOf(payer.child->pid()).cpu;
  const Time begun = std::chrono::steady_clock::now();
  for (Child& sink : sinks) {
    if (sink.Wait() != 0) Fail("a sink has failed");
  }
  const double elapsed = Seconds(std::chrono::steady_clock::now() - begun);

  const Table table(setting.what + ", " + std::to_string(hz) + " Hz");
  std::vector<double> lost;
  std::vector<double> cpu;
  for (int i = 0; i < setting.sinks; ++i) {
    const Seen seen = Read(folder.File("sink" + std::to_string(i)));
    table.Row("age of a picture", seen.latencies_ms, "ms");
    lost.push_back(100 * seen.lost / (static_cast<double>(seen.latencies_ms.size()) + seen.lost));
    cpu.push_back(100 * seen.cpu_s / seconds);
  }
  table.Row("lost", lost, "%");
  for (const Payer& payer : payers) {
    const double used = Seconds(CostOf(payer.child->pid()).cpu - payer.before);
    table.Row("CPU of " + payer.name, {100 * used / elapsed}, "% of a core");
  }
  table.Row("CPU of a program that watches", cpu, "% of a core");
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  using musher::benchmark::Measure;
  const int seconds = argc > 1 ? std::atoi(argv[1]) : 10;
  std::vector<int> rates;
  for (int i = 2; i < argc; ++i) rates.push_back(std::atoi(argv[i]));
  if (rates.empty()) rates = {15, 30};
  int number = 0;
  for (const int hz : rates) {
    Measure({"Straight to one program"}, seconds, hz, number++);
    Measure({"Straight to two programs, eight others beside", 2, 8}, seconds, hz, number++);
  }
}
