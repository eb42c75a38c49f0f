// One warm switch of one actuator beside what it cannot do without: the round trip of its command
// on plain Cyclone, and the same with the thread hand-offs that a switch needs. In turns, so that
// all three see the same machine.
//
//   benchmark_request_reply [trials [calls a round]]

#include <array>
#include <atomic>
#include <cstdlib>
#include <functional>
#include <future>
#include <string>
#include <vector>

#include "musher/controller/machine_controller.hpp"
#include "musher/test/benchmark/common/child.hpp"
#include "musher/test/benchmark/common/fleet.hpp"
#include "musher/test/benchmark/common/plain_service.hpp"
#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/test/benchmark/common/thread_queue.hpp"

namespace musher::benchmark {
namespace {

using Clock = std::chrono::steady_clock;

// A client and a server that answer each other on their main threads.
class Raw {
 public:
  explicit Raw(const PlainParticipant& participant)
      : end_(participant, "raw", PlainEnd::Role::kClient), waitset_(participant) {
    waitset_.Attach(end_, 0);
    end_.CallUntil([this] { return end_.Take() == 0; });
  }

  void Call() {
    end_.Call(++sequence_);
    for (auto answer = end_.Take(); answer != sequence_; answer = end_.Take()) {
      if (answer < 0) waitset_.Wait();
    }
  }

 private:
  std::int64_t sequence_ = 0;
  PlainEnd end_;
  PlainWaitset waitset_;
};

// The caller hands to its loop thread and waits; the reply comes by listener and loop thread. The
// server hands on likewise (programs/plain_server.cpp).
class HandedOff {
 public:
  explicit HandedOff(const PlainParticipant& participant)
      : end_(participant, "handed", PlainEnd::Role::kClient, [this] {
          loop_.Give([this] {
            for (auto answer = end_.Take(); answer >= 0; answer = end_.Take()) {
              if (answer == 0) found_ = true;
              if (answer > 0) answered_->set_value();
            }
          });
        }) {
    end_.CallUntil([this] { return found_.load(); });
  }

  void Call() {
    std::promise<void> answered;
    answered_ = &answered;
    loop_.Give([this] { end_.Call(++sequence_); });
    answered.get_future().wait();
  }

 private:
  std::int64_t sequence_ = 0;
  std::atomic<bool> found_ = false;
  std::promise<void>* answered_ = nullptr;
  ThreadQueue loop_;
  PlainEnd end_;
};

// A machine of one actuator that goes to and fro between two states.
class Switched {
 public:
  Switched() : fleet_(1, true) {
    if (!controller_.Init(fleet_.config_file())) Fail("no controller");
    if (!controller_.AwaitSetUp()) Fail("the actuator is not set up");
    MustBeDone(controller_.Switch("SelfCheck"));
    MustBeDone(controller_.Switch("Active"));
  }

  void Call() {
    active_ = !active_;
    const SwitchResult result = controller_.Switch(active_ ? kActive : kDeActive);
    MustBeDone(result);
    if (!result.actuators.front().message.empty()) Fail("nothing was sent");
  }

 private:
  Fleet fleet_;
  MachineController controller_;
  bool active_ = true;
};

// One thing that is measured: all its times, and the median of each round.
struct Measured {
  std::string what;
  std::vector<double> times = {};
  std::vector<double> medians = {};

  void Round(const std::function<void()>& call, int calls) {
    std::vector<double> round;
    for (int i = 0; i < calls; ++i) {
      const auto begin = Clock::now();
      call();
      round.push_back(Microseconds(Clock::now() - begin));
    }
    times.insert(times.end(), round.begin(), round.end());
    medians.push_back(Median(round));
  }
};

// With new processes and threads, since much depends on which of them share a core.
void Trial(int number, int calls, std::array<Measured, 3>& measured) {
  constexpr int kRounds = 5;
  const int plain_domain = Domain(2 * number);
  setenv("ROS_DOMAIN_ID", std::to_string(Domain(2 * number + 1)).c_str(), 1);
  const auto server = [&](const std::string& name, const std::string& option) {
    return Child({Program("benchmark_plain_server"), name, std::to_string(plain_domain), option});
  };
  const Child raw_server = server("raw", "");
  const Child handed_server = server("handed", "--hand-offs");
  const PlainParticipant participant(plain_domain);
  Raw raw(participant);
  HandedOff handed_off(participant);
  Switched switched;

  const std::function<void()> calls_of[] = {[&] { raw.Call(); }, [&] { handed_off.Call(); },
                                            [&] { switched.Call(); }};
  for (const auto& call : calls_of) {
    for (int i = 0; i < 200; ++i) call();  // warm
  }
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t i = 0; i < measured.size(); ++i) measured[i].Round(calls_of[i], calls);
  }
}

void Main(int trials, int calls) {
  std::array<Measured, 3> measured = {{{"raw request-reply"},
                                       {"the same with the hand-offs of a switch"},
                                       {"one switch of one actuator"}}};
  for (int i = 0; i < trials; ++i) Trial(i, calls, measured);
  const auto& [raw, handed_off, switched] = measured;
  const Table table("Request-reply and one switch");
  for (const Measured& one : measured) table.Row(one.what, one.times, "µs");
  table.Row("switch / raw", Ratios(switched.medians, raw.medians), "×", 2.0);
  table.Row("switch / with hand-offs", Ratios(switched.medians, handed_off.medians), "×", 1.25);
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  const int trials = argc > 1 ? std::atoi(argv[1]) : 10;
  const int calls = argc > 2 ? std::atoi(argv[2]) : 200;
  musher::benchmark::Main(trials, calls);
}
