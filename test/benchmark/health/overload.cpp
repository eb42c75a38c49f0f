#include <unistd.h>

#include <atomic>
#include <cmath>
#include <cstdio>
#include <mutex>
#include <thread>

#include "musher/test/benchmark/common/board.hpp"
#include "musher/test/benchmark/common/child.hpp"
#include "musher/test/benchmark/common/fleet.hpp"
#include "musher/test/benchmark/common/observed_controller.hpp"
#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/test/benchmark/health/parts.hpp"

namespace musher::benchmark {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kOverloadActuators = 12;
constexpr int kWatched = 4;  // the first ones: cycles with checkpoints
constexpr int kOverloadHz = 50;
constexpr const char* kLoader = "a11";
constexpr auto kSwitchPeriod = std::chrono::seconds(2);
constexpr auto kLoadPeriod = std::chrono::minutes(3);

std::string KeysOf(const Fleet& fleet, const std::string& name) {
  const bool watched = std::stoi(name.substr(1)) < kWatched;
  std::string keys = CommandKey(fleet.Module(name, watched ? kOverloadHz : 0));
  if (watched) keys += "checkpoint_ms = 200\n";
  if (name == kLoader) {
    keys += "checkpoint_ms = 200\ncheckpoint_ms_in = { SetUp = 30000, SelfCheck = 30000 }\n";
  }
  return keys;
}

// What went wrong by the controller's records. Nothing is broken, so each loss is a false one.
class Losses {
 public:
  Losses() : last_(kOverloadActuators) {}

  struct Counts {
    int crashed = 0, hung = 0, partitioned = 0, starved = 0, lost = 0, restarted = 0;
    int all() const { return crashed + hung + partitioned + lost + restarted; }
  };
  Counts counts() const {
    const std::lock_guard lock(mutex_);
    return counts_;
  }

  void OnRecord(const action::Record& record, const Machine& machine) {
    const std::lock_guard lock(mutex_);
    for (const ActuatorIndex i : last_.Indices()) {
      const KnownActuator& now = machine.actuators[i];
      KnownActuator& before = last_[i];
      const int bad = counts_.all();
      if (now.health != before.health) {
        counts_.crashed += now.health == Health::kCrashed;
        counts_.hung += now.health == Health::kHung;
        counts_.partitioned += now.health == Health::kPartitioned;
        counts_.starved += now.health == Health::kStarved;
      }
      counts_.lost += now.presence == Presence::kLost && before.presence != Presence::kLost;
      counts_.restarted +=
          before.process.pid != 0 && now.process.pid != 0 && now.process.pid != before.process.pid;
      if (counts_.all() > bad) std::fprintf(stderr, "  %s\n", record.message.c_str());
      if (now.process.pid == 0) continue;  // until it is started again the one before counts
      before = now;
    }
  }

 private:
  mutable std::mutex mutex_;
  Counts counts_;
  PerActuator<KnownActuator> last_;  // as of the last record
};

struct Switches {
  std::vector<double> times;       // milliseconds
  std::vector<double> load_times;  // of those in which one loads
  int not_done = 0;
};

void Progress(Clock::duration passed, const Losses::Counts& counts, const Switches& switches) {
  std::fprintf(
      stderr,
      "%4.1f min: %d false losses, %d starved; %zu switches, %d not done, slowest %.0f ms\n",
      ToSeconds(passed) / 60, counts.all(), counts.starved, switches.times.size(),
      switches.not_done, Quantile(switches.times, 1));
}

void Switch(ObservedController& controller, const State& target, std::vector<double>& times,
            int& not_done) {
  const auto begin = Clock::now();
  const SwitchResult result = controller.Switch(target);
  times.push_back(ToSeconds(Clock::now() - begin) * 1000);
  if (result.done()) return;
  ++not_done;
  std::fprintf(stderr, "  %s was %s: %s\n", target.name().c_str(),
               std::string(OutcomeName(result.outcome)).c_str(), result.reason.c_str());
}

void Run(ObservedController& controller, const Losses& losses, Board& loader, int load_ms,
         Clock::time_point begin, Clock::time_point end, Switches& switches) {
  auto next_load = begin + std::min<Clock::duration>(kLoadPeriod, (end - begin) / 2);
  auto next_word = begin + std::chrono::minutes(1);
  for (int i = 0; Clock::now() < end; ++i) {
    const auto next = Clock::now() + std::min<Clock::duration>(kSwitchPeriod, (end - begin) / 10);
    if (Clock::now() >= next_load) {
      loader.load_ms = load_ms;
      Switch(controller, State(kSelfCheck), switches.load_times, switches.not_done);
      next_load += kLoadPeriod;
    } else {
      const State target(i % 2 == 0 ? kDeActive : kActive);
      Switch(controller, target, switches.times, switches.not_done);
    }
    if (Clock::now() >= next_word) {
      Progress(Clock::now() - begin, losses.counts(), switches);
      next_word += std::chrono::minutes(1);
    }
    std::this_thread::sleep_until(next);
  }
}

// What is distinguished from load must still be found under load.
double RealHang(ObservedController& controller, Board& board) {
  AwaitCheckpoint(board);
  std::fprintf(stderr, "a0 hangs now, on purpose:\n");
  auto known = controller.Next(IsOnRecord(0, Health::kHung));
  board.silent = true;
  const Time at = MomentOf(known, "a hang under load");
  return ToSeconds(at - FromBoard(board.checkpoint_at)) / 0.2;
}

void Print(const Losses::Counts& counts, const Switches& switches, double up_s, double hang) {
  const auto whole = [](int count) { return std::vector<double>{static_cast<double>(count)}; };
  const Table table("12 actuators on a machine that is overloaded");
  table.Row("all set up and Active after", {up_s}, "s");
  table.Row("false verdicts: crashed", whole(counts.crashed), "");
  table.Row("false verdicts: hung", whole(counts.hung), "");
  table.Row("false verdicts: partitioned", whole(counts.partitioned), "");
  table.Row("actuators lost", whole(counts.lost), "");
  table.Row("actuators restarted", whole(counts.restarted), "");
  table.Row("starved (reported, no action)", whole(counts.starved), "");
  table.Row("switches that were not done", whole(switches.not_done), "");
  table.Row("a switch of all", switches.times, "ms");
  table.Row("a self-check in which one loads", switches.load_times, "ms");
  table.Row("a real hang → hung, by checkpoint_ms", {hang}, "×");
}

}  // namespace

void Overload(double minutes, double factor, int load_ms) {
  // Each in a session of its own: schedulers that share by session must not spare us.
  std::vector<Child> burners;
  const long count = std::lround(factor * static_cast<double>(sysconf(_SC_NPROCESSORS_ONLN)));
  for (long i = 0; i < count; ++i) {
    burners.emplace_back(std::vector<std::string>{Program("benchmark_health"), "burn"});
  }
  const Fleet fleet(KeysOf, kOverloadActuators);
  Board& loader = OpenBoard(fleet.BoardFile(kLoader));
  loader.load_ms = load_ms;
  const auto begin = Clock::now();
  const auto end = begin + std::chrono::duration_cast<Clock::duration>(
                               std::chrono::duration<double>(minutes * 60));
  Losses losses;
  ObservedController controller(fleet.config_file());
  controller.Watch([&](const action::Record& record, const Machine& machine) {
    losses.OnRecord(record, machine);
  });
  controller.AwaitAllThere();
  const double up_s = ToSeconds(Clock::now() - begin);
  Switches switches;
  Run(controller, losses, loader, load_ms, begin, end, switches);
  const Losses::Counts counts = losses.counts();
  const double hang = RealHang(controller, OpenBoard(fleet.BoardFile("a0")));
  Print(counts, switches, up_s, hang);
}

void Burn() {
  DieWithParent();
  setsid();
  for (std::atomic<unsigned> count = 0;;) count.fetch_add(1, std::memory_order_relaxed);
}

}  // namespace musher::benchmark
