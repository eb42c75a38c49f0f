// What an idle process costs: a bare Cyclone participant, an actuator, a controller of many.
//
//   benchmark_footprint [seconds of idling [actuators of the controller]]

#include <cstdlib>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "musher/test/benchmark/common/child.hpp"
#include "musher/test/benchmark/common/fleet.hpp"
#include "musher/test/benchmark/common/process.hpp"
#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/transport/dds/settings.hpp"

namespace musher::benchmark {
namespace {

struct Costs {
  std::string what;
  std::vector<double> resident_mb = {};
  std::vector<double> proportional_mb = {};
  std::vector<double> threads = {};
  std::vector<double> cpu_percent = {};
};

// A machine of hand-started actuators, Active and at rest.
class Machine {
 public:
  explicit Machine(int actuators, int domain) : fleet_(actuators, false) {
    const Child::Environment env = {{"MUSHER_CONFIG", fleet_.config_file()},
                                    {"ROS_DOMAIN_ID", std::to_string(domain)}};
    for (const std::string& name : fleet_.names()) {
      actuators_.push_back(std::make_unique<Child>(
          std::vector<std::string>{Program("benchmark_actuator"), name}, env));
    }
    controller_ = std::make_unique<Child>(
        std::vector<std::string>{Program("benchmark_controller"), fleet_.config_file()}, env,
        Child::Output::kPiped);
    controller_->AwaitOutput();
  }

  pid_t controller() const { return controller_->pid(); }
  pid_t actuator(std::size_t i) const { return actuators_[i]->pid(); }

 private:
  Fleet fleet_;
  std::vector<std::unique_ptr<Child>> actuators_;
  std::unique_ptr<Child> controller_;
};

void Watch(pid_t pid, Duration before, double seconds, Costs& costs) {
  const Cost cost = CostOf(pid);
  costs.resident_mb.push_back(cost.resident_mb);
  costs.proportional_mb.push_back(cost.proportional_mb);
  costs.threads.push_back(cost.threads);
  costs.cpu_percent.push_back(ToSeconds(cost.cpu - before) / seconds * 100);
}

void Print(const Table& table, const Costs& costs, const Costs& bare, double limit,
           double more_threads) {
  table.Row(costs.what + ", RSS", costs.resident_mb, "MB", Median(bare.resident_mb) * limit);
  table.Row(costs.what + ", PSS", costs.proportional_mb, "MB");
  table.Row(costs.what + ", threads", costs.threads, "",
            more_threads > 0 ? Median(bare.threads) + more_threads : 0);
  table.Row(costs.what + ", idle CPU", costs.cpu_percent, "%");
}

void Main(int seconds, int actuators) {
  constexpr int kBare = 5;
  const std::string uri = transport::dds::SettingsXml(TransportProfile::kLocal, std::nullopt);
  std::vector<std::unique_ptr<Child>> bare_ones;
  for (int i = 0; i < kBare; ++i) {
    const std::string domain = std::to_string(Domain(i));
    bare_ones.push_back(std::make_unique<Child>(
        std::vector<std::string>{Program("benchmark_bare_participant"), domain},
        Child::Environment{{"CYCLONEDDS_URI", uri}}));
  }
  const Machine alone(1, Domain(kBare));
  const Machine many(actuators, Domain(kBare + 1));
  std::this_thread::sleep_for(std::chrono::seconds(2));  // until all are at rest

  std::vector<std::pair<pid_t, Costs*>> watched;
  watched.reserve(kBare + actuators + 2);
  Costs bare{"bare participant"};
  Costs single{"actuator, alone with its controller"};
  Costs one_of_many{"actuator among " + std::to_string(actuators)};
  Costs controller{"controller of " + std::to_string(actuators)};
  for (const auto& child : bare_ones) watched.emplace_back(child->pid(), &bare);
  watched.emplace_back(alone.actuator(0), &single);
  for (int i = 0; i < actuators; ++i) watched.emplace_back(many.actuator(i), &one_of_many);
  watched.emplace_back(many.controller(), &controller);

  std::vector<Duration> before;
  before.reserve(watched.size());
  for (const auto& [pid, costs] : watched) before.push_back(CostOf(pid).cpu);
  std::this_thread::sleep_for(std::chrono::seconds(seconds));
  for (std::size_t i = 0; i < watched.size(); ++i) {
    Watch(watched[i].first, before[i], seconds, *watched[i].second);
  }
  const Table table("What an idle process costs");
  Print(table, bare, bare, 0, 0);
  Print(table, single, bare, 1.4, 2);
  Print(table, one_of_many, bare, 0, 2);
  Print(table, controller, bare, 2, 0);
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  const int seconds = argc > 1 ? std::atoi(argv[1]) : 10;
  const int actuators = argc > 2 ? std::atoi(argv[2]) : 32;
  musher::benchmark::Main(seconds, actuators);
}
