// What a tick of a state machine costs beside a plain loop that calls check and run of an object
// through its base and now and then takes another one; how much memory a machine takes; what a
// thousand machines at 1 kHz cost. Ratios are of turns that follow each other in one run.
//
//   benchmark_fsm [TURNS] [SECONDS AT 1 kHz]    (300, 5)

#include <sys/resource.h>

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "musher/behavior/fsm/machine.hpp"
#include "musher/test/behavior/fsm/counting_new.hpp"
#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/test/benchmark/fsm/states.hpp"

namespace musher::benchmark {
namespace {

using fsm::Change;
using fsm::Listener;
using fsm::Machine;

constexpr Duration kStep = Milliseconds(20);
constexpr int kStates = 5;

// Such a loop as written by hand: it checks the present state, with the time since it
// was entered, and runs it or takes another. It has no commands, safety checks, faults, listeners
// or transitions that take time. That it stands in this file is in its favour: the compiler puts it
// into the loop that measures, which it cannot do with a machine.
class PlainLoop {
 public:
  explicit PlainLoop(Duration stay) {
    for (int i = 0; i < kStates; ++i) {
      states_.push_back(MakePlainState(i, (i + 1) % kStates, stay));
    }
    current_ = states_[0].get();
  }
  void RunOnce(Time now) {
    const int next = current_->Check(robot_, now - entered_);
    if (next < 0) return current_->Run(robot_);
    current_->OnExit(robot_);
    current_ = states_[static_cast<std::size_t>(next)].get();
    entered_ = now;
    current_->OnEnter(robot_);
  }
  const Robot& robot() const { return robot_; }

 private:
  Robot robot_;
  std::vector<std::unique_ptr<PlainState>> states_;
  PlainState* current_;
  Time entered_{};
};

class Counter : public Listener {
 public:
  void OnChange(const Machine&, const Change&) override { ++changes_; }

 private:
  std::uint64_t changes_ = 0;
};

class Walker {
 public:
  struct Options {
    std::size_t history = 0;
    bool listened = false;
    int checks = 0;
    Duration stay = kStay;
  };

  explicit Walker(const Options& options) {
    machine_ =
        std::make_unique<Machine>(Machine::Options{.name = "walker", .history = options.history});
    for (int i = 0; i < kStates; ++i) {
      machine_->Add(std::to_string(i), MakeState(robot_, i, (i + 1) % kStates, options.stay));
    }
    if (options.listened) machine_->Listen(&counter_);
    if (options.checks > 0)
      machine_->Add("SAFE", MakeState(robot_, kStates, 0, options.stay), fsm::Role::kSafe);
    for (int i = 0; i < options.checks; ++i) {
      machine_->AddSafetyCheck(std::to_string(i),
                               [this](const fsm::Tick&) { return !robot_.wants_out; });
    }
    if (!machine_->Build("0") || !machine_->Start(Time{})) std::abort();
  }
  void RunOnce(Time now) { machine_->RunOnce(now); }
  const Robot& robot() const { return robot_; }

 private:
  Robot robot_;
  Counter counter_;
  std::unique_ptr<Machine> machine_;
};

constexpr int kTicks = 20'000;

// Nanoseconds of a tick in a turn of kTicks.
template <class Ticked>
double TurnOf(Ticked& ticked, Time& now) {
  const auto began = std::chrono::steady_clock::now();
  for (int i = 0; i < kTicks; ++i) ticked.RunOnce(now += kStep);
  const std::chrono::duration<double, std::nano> took = std::chrono::steady_clock::now() - began;
  if (ticked.robot().moves < kTicks) std::abort();  // and so the loop is not left out
  return took.count() / kTicks;
}

void MeasureTicks(int turns) {
  PlainLoop plain(kStay);
  Walker bare({});
  Walker watched({.history = 64, .listened = true});
  Walker checked({.history = 64, .listened = true, .checks = 2});
  Time plain_now{};
  Time bare_now{};
  Time watched_now{};
  Time checked_now{};
  std::vector<double> plain_ns;
  std::vector<double> bare_ns;
  std::vector<double> watched_ns;
  std::vector<double> checked_ns;
  for (std::vector<double>* values : {&plain_ns, &bare_ns, &watched_ns, &checked_ns}) {
    values->reserve(static_cast<std::size_t>(turns));
  }
  const std::size_t before = testing::AllocationsOfNew().times;
  for (int i = 0; i < turns; ++i) {
    plain_ns.push_back(TurnOf(plain, plain_now));
    bare_ns.push_back(TurnOf(bare, bare_now));
    watched_ns.push_back(TurnOf(watched, watched_now));
    checked_ns.push_back(TurnOf(checked, checked_now));
  }
  const std::size_t allocations = testing::AllocationsOfNew().times - before;
  const Table table("A tick, with a change of state in 100, beside a plain virtual-call loop");
  table.Row("plain loop", plain_ns, "ns");
  table.Row("machine", bare_ns, "ns");
  table.Row("machine with history and a listener", watched_ns, "ns");
  table.Row("the same with two safety checks", checked_ns, "ns");
  table.Row("machine / plain loop", Ratios(bare_ns, plain_ns), "x", 2);
  table.Row("machine with history and a listener / plain loop", Ratios(watched_ns, plain_ns), "x",
            4);
  table.Row("the same with two safety checks / plain loop", Ratios(checked_ns, plain_ns), "x");
  table.Row("allocations in all these ticks", {static_cast<double>(allocations)}, "");
}

// Ticks that each change the state.
void MeasureChanges(int turns) {
  PlainLoop plain(Duration{});
  Walker watched({.history = 64, .listened = true, .stay = Duration{}});
  Time plain_now{};
  Time watched_now{};
  std::vector<double> plain_ns;
  std::vector<double> watched_ns;
  for (int i = 0; i < turns; ++i) {
    plain_ns.push_back(TurnOf(plain, plain_now));
    watched_ns.push_back(TurnOf(watched, watched_now));
  }
  const Table table("A tick that changes the state, beside the same loop");
  table.Row("plain loop", plain_ns, "ns");
  table.Row("machine with history and a listener", watched_ns, "ns");
  table.Row("machine with history and a listener / plain loop", Ratios(watched_ns, plain_ns), "x");
}

void MeasureMemory() {
  const auto bytes_of = [](std::size_t history) {
    const std::size_t before = testing::AllocationsOfNew().bytes;
    const Walker walker({.history = history});
    return static_cast<double>(testing::AllocationsOfNew().bytes - before);
  };
  const Table table("Memory allocated by a machine of five states, states and all");
  table.Row("without history", {bytes_of(0)}, "");
  table.Row("with a history of 64 changes", {bytes_of(64)}, "");
}

double CpuSeconds() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) * 1e-6;
  };
  return seconds(used.ru_utime) + seconds(used.ru_stime);
}

// What 1000 machines need for the ticks of a second at 1 kHz, second by second, as a share of one.
void MeasureMany(int seconds) {
  constexpr int kMachines = 1000;
  constexpr int kTicksASecond = 1000;
  std::vector<std::unique_ptr<Walker>> walkers;
  for (int i = 0; i < kMachines; ++i)
    walkers.push_back(std::make_unique<Walker>(Walker::Options{.history = 64, .listened = true}));
  std::vector<double> shares;
  Time now{};
  for (int second = 0; second < seconds; ++second) {
    const double before = CpuSeconds();
    for (int tick = 0; tick < kTicksASecond; ++tick) {
      now += Milliseconds(1);
      for (const auto& walker : walkers) walker->RunOnce(now);
    }
    shares.push_back((CpuSeconds() - before) * 100);
  }
  const Table table("1000 machines at 1 kHz, each with history and a listener");
  table.Row("CPU, % of a core", shares, "%");
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  const int turns = argc > 1 ? std::atoi(argv[1]) : 300;
  const int seconds = argc > 2 ? std::atoi(argv[2]) : 5;
  musher::benchmark::MeasureTicks(turns);
  musher::benchmark::MeasureChanges(turns);
  musher::benchmark::MeasureMemory();
  musher::benchmark::MeasureMany(seconds);
}
