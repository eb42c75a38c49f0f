// Three cameras of 640x480: how old a picture is when a program has it, how many are lost, and what
// each process pays.
//
//   benchmark_camera [SECONDS [HZ...]]

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "musher/controller/machine_controller.hpp"
#include "musher/test/benchmark/common/child.hpp"
#include "musher/test/benchmark/common/fleet.hpp"
#include "musher/test/benchmark/common/process.hpp"
#include "musher/test/benchmark/common/statistics.hpp"

namespace musher::benchmark {
namespace {

constexpr const char* kWidth = "640";
constexpr const char* kHeight = "480";
const std::vector<std::string> kWorldTopics = {"world/camera/front", "world/camera/left",
                                               "world/camera/right"};
const std::vector<std::string> kManagerTopics = {"image_front", "image_left", "image_right"};

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

// A process whose share of a core is measured.
struct Payer {
  std::string name;
  pid_t pid = 0;
  Duration before = {};
};

struct Setting {
  std::string what;
  int sinks = 1;
  int bystanders = 0;
  bool unicast = false;  // requested by the sinks
  bool manager = false;  // between cameras and sinks
};

// That program, as a child of this process.
pid_t ChildNamed(const std::string& name) {
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    std::ifstream stat(entry.path() / "stat");
    pid_t pid = 0;
    pid_t parent = 0;
    std::string command;
    std::string state;
    stat >> pid >> command >> state >> parent;
    // The kernel keeps 15 characters of the name.
    if (parent == getpid() && command == "(" + name.substr(0, 15) + ")") return pid;
  }
  Fail("there is no " + name);
}

// musher-camera-manager in Active, as a controller has it.
class Manager {
 public:
  Manager() : fleet_([this](const Fleet& fleet, const std::string&) { return Command(fleet); }, 1) {
    if (!controller_.Init(fleet_.config_file()) || !controller_.AwaitSetUp()) {
      Fail("the camera manager is not set up");
    }
    MustBeDone(controller_.Switch("SelfCheck"));
    MustBeDone(controller_.Switch("Active"));
  }
  Manager(const Manager&) = delete;
  Manager& operator=(const Manager&) = delete;
  ~Manager() { static_cast<void>(controller_.Switch("TearDown").done()); }

  pid_t pid() const { return ChildNamed("musher-camera-manager"); }

 private:
  std::string Command(const Fleet&) {
    std::ofstream file(folder_.File("cameras.toml"));
    for (const std::string name : {"front", "left", "right"}) {
      file << "[camera." << name << "]\ntopic = \"image_" << name
           << "\"\nsource = \"world\"\nfrom = \"world/camera/" << name << "\"\n";
    }
    return CommandKey({Program("musher-camera-manager"), folder_.File("cameras.toml")});
  }

  const Folder folder_;
  const Fleet fleet_;
  MachineController controller_;
};

void Measure(const Setting& setting, int seconds, int hz, int number) {
  setenv("ROS_DOMAIN_ID", std::to_string(Domain(number)).c_str(), 1);
  const Folder folder;
  const Child source(
      Arguments{Program("benchmark_picture_source"), kWidth, kHeight, std::to_string(hz)} +
      kWorldTopics);
  std::vector<Child> sinks;
  std::vector<Child> bystanders;
  std::vector<Payer> payers = {{"the cameras", source.pid()}};
  std::optional<Manager> manager;
  if (setting.manager) payers.push_back({"musher-camera-manager", manager.emplace().pid()});
  for (int i = 0; i < setting.bystanders; ++i) {
    bystanders.emplace_back(Arguments{Program("benchmark_picture_source"), "8", "8", "1", "other"});
  }
  if (!bystanders.empty()) payers.push_back({"a bystander", bystanders.front().pid()});
  for (int i = 0; i < setting.sinks; ++i) {
    sinks.emplace_back(
        Arguments{Program("benchmark_picture_sink"), folder.File("sink" + std::to_string(i)),
                  std::to_string(seconds)} +
            (setting.manager ? kManagerTopics : kWorldTopics),
        setting.unicast ? Child::Environment{{"MUSHER_UNICAST", "1"}} : Child::Environment{},
        Child::Output::kPiped);
  }
  for (const Child& sink : sinks) sink.AwaitOutput();
  for (Payer& payer : payers) payer.before = CostOf(payer.pid).cpu;
  const Time begun = std::chrono::steady_clock::now();
  for (Child& sink : sinks) {
    if (sink.Wait() != 0) Fail("a sink has failed");
  }
  const double elapsed = ToSeconds(std::chrono::steady_clock::now() - begun);

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
    const double used = ToSeconds(CostOf(payer.pid).cpu - payer.before);
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
    Measure({"The same, MUSHER_UNICAST set for the two", 2, 8, true}, seconds, hz, number++);
    Measure({"Through musher-camera-manager to one program", 1, 0, false, true}, seconds, hz,
            number++);
  }
}
