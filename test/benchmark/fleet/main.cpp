// A fleet of actuators in processes of their own: how long from the start of all of them until all
// are Active; and warm, how long SelfCheck and Active take together, beside a plain C client that
// has the same two rounds with as many plain C servers.
//
//   benchmark_fleet [rounds [actuators...]]

#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "musher/controller/machine_controller.hpp"
#include "musher/test/benchmark/common/child.hpp"
#include "musher/test/benchmark/common/fleet.hpp"
#include "musher/test/benchmark/common/plain_service.hpp"
#include "musher/test/benchmark/common/statistics.hpp"

namespace musher::benchmark {
namespace {

using Clock = std::chrono::steady_clock;

double Milliseconds(Clock::time_point since) {
  return Microseconds(Clock::now() - since) / 1000;
}

// As many servers, each a process, and a client that calls them all at once.
class PlainFleet {
 public:
  PlainFleet(int domain, const std::vector<std::string>& names)
      : participant_(domain), waitset_(participant_) {
    for (const std::string& name : names) {
      servers_.push_back(std::make_unique<Child>(std::vector<std::string>{
          Program("benchmark_plain_server"), name, std::to_string(domain), ""}));
      ends_.push_back(std::make_unique<PlainEnd>(participant_, name, PlainEnd::Role::kClient));
      waitset_.Attach(*ends_.back(), ends_.size() - 1);
    }
    for (const auto& end : ends_) end->CallUntil([&] { return end->Take() == 0; });
  }

  void Round() {
    ++sequence_;
    for (const auto& end : ends_) end->Call(sequence_);
    for (std::size_t left = ends_.size(); left > 0;) {
      for (const std::size_t i : waitset_.Wait()) {
        for (auto answer = ends_[i]->Take(); answer >= 0; answer = ends_[i]->Take()) {
          if (answer == sequence_) --left;
        }
      }
    }
  }

 private:
  std::int64_t sequence_ = 0;
  std::vector<std::unique_ptr<Child>> servers_;
  PlainParticipant participant_;
  std::vector<std::unique_ptr<PlainEnd>> ends_;
  PlainWaitset waitset_;
};

void Measure(int count, int number, int rounds, const Table& table) {
  const std::string many = std::to_string(count) + " actuators: ";
  setenv("ROS_DOMAIN_ID", std::to_string(Domain(2 * number)).c_str(), 1);
  const Fleet fleet(count, true);
  const auto started = Clock::now();
  MachineController controller;
  if (!controller.Init(fleet.config_file())) Fail("no controller");
  if (!controller.AwaitSetUp()) Fail("not all are set up");
  const double set_up = Milliseconds(started);
  const auto first = Clock::now();
  MustBeDone(controller.Switch("SelfCheck"));
  MustBeDone(controller.Switch("Active"));
  const double first_active = Milliseconds(first);
  table.Row(many + "started at once → all Active", {Milliseconds(started)}, "ms");
  table.Row(many + "… of which until all are set up", {set_up}, "ms");
  table.Row(many + "SetUp → SelfCheck → Active, the first time", {first_active}, "ms");

  PlainFleet plain(Domain(2 * number + 1), fleet.names());
  std::vector<double> plain_times;
  std::vector<double> times;
  for (int i = -5; i < rounds; ++i) {
    const auto plain_begin = Clock::now();
    plain.Round();
    plain.Round();
    const double plain_time = Milliseconds(plain_begin);
    MustBeDone(controller.Switch("DeActive"));
    const auto begin = Clock::now();
    MustBeDone(controller.Switch("SelfCheck"));
    MustBeDone(controller.Switch("Active"));
    const double time = Milliseconds(begin);
    if (i < 0) continue;  // warming up
    plain_times.push_back(plain_time);
    times.push_back(time);
  }
  table.Row(many + "plain C client, two rounds", plain_times, "ms");
  table.Row(many + "SelfCheck → Active, warm", times, "ms");
  table.Row(many + "ratio", Ratios(times, plain_times), "×", count == 32 ? 1.25 : 0);
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 200;
  std::vector<int> counts;
  for (int i = 2; i < argc; ++i) counts.push_back(std::atoi(argv[i]));
  if (counts.empty()) counts = {8, 32, 100};
  const musher::benchmark::Table table("A fleet of processes");
  int number = 0;
  for (const int count : counts) musher::benchmark::Measure(count, number++, rounds, table);
}
