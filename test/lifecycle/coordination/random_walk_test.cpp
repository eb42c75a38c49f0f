// Invariants under any order of events: seeds drive a machine through crashes, hangs, silence,
// emergency stops, restarts and switches. A failure names its seed and its events; MUSHER_SEED=n
// runs one seed and prints its scenario, MUSHER_SEEDS=n runs that many.

#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>
#include <random>

#include "musher/test/lifecycle/coordination/harness.hpp"

namespace musher::testing::random_walk_test {

constexpr int kSteps = 40;

// All kinds: two stages, a critical actuator, a bound one, one without a command.
MachineConfig Everything(std::mt19937_64& random) {
  MachineConfig config = MachineOf(4);
  for (const char* name : {"a", "b", "d"}) {
    ActuatorConfig& actuator = ActuatorNamed(config, name);
    actuator.command = {"run", name};
    actuator.restart.policy = RestartPolicy::kOnFailure;
    actuator.restart.limit = 3;
    actuator.restart.reset_after = Milliseconds(5000);
    actuator.restart.delay = Milliseconds(static_cast<int>(random() % 3) * 50);
  }
  ActuatorNamed(config, "a").critical = true;
  ActuatorNamed(config, "a").on_lost = "Protected";
  ActuatorNamed(config, "b").after = {"a"};
  ActuatorNamed(config, "b").binds_to = {"a"};
  ActuatorNamed(config, "b").restart.policy = RestartPolicy::kAlways;
  if (random() % 2 == 0) ActuatorNamed(config, "d").binds_to = {"b", "c"};
  if (random() % 4 == 0) ActuatorNamed(config, "b").binds_to = {"d"};
  ActuatorNamed(config, "d").stage = 2;
  ActuatorNamed(config, "d").on_lost = "LowPower";
  return config;
}

std::uint64_t Environment(const char* name, std::uint64_t otherwise) {
  const char* value = std::getenv(name);
  return value != nullptr ? std::strtoull(value, nullptr, 10) : otherwise;
}

class Walk {
 public:
  explicit Walk(std::uint64_t seed) : random_(seed), t_(Everything(random_)) {
    t_.after_step = [this] { Check(); };
    t_.Begin();
    t_.RunFor(Milliseconds(Below(800)));
  }

  void Run() {
    for (int i = 0; i < kSteps && t_.machine().phase != Phase::kStopped; ++i) {
      DoAnything();
      t_.RunFor(Below(3) == 0 ? Milliseconds(Below(1500)) : Milliseconds(Below(60)));
    }
    Heal();
    t_.Rest(std::chrono::seconds(120));
    const Phase phase = t_.machine().phase;
    if (phase == Phase::kRunning || phase == Phase::kFailed) CheckRest();
    EXPECT_NE(t_.machine().phase, Phase::kStopping);
    for (const char* name : {"a", "b", "d"}) {
      EXPECT_FALSE(t_.stopped() && t_.IsAlive(name)) << name << " outlives the machine";
    }
    CheckAnswers();
  }

  // The events so far, and the last records of the controller.
  std::string Scenario() const {
    std::string scenario = scenario_;
    const std::size_t count = t_.records.size();
    for (std::size_t i = count > 40 ? count - 40 : 0; i < count; ++i)
      scenario += t_.records[i].message + "\n";
    return scenario;
  }

 private:
  int Below(int n) { return static_cast<int>(random_() % static_cast<unsigned>(n)); }
  std::string AnyName() { return std::string(1, static_cast<char>('a' + Below(4))); }
  void Note(const std::string& what) {
    scenario_ += "  at " + std::to_string(ToMilliseconds(t_.now().time_since_epoch()) - 3'600'000) +
                 " ms " + what + "\n";
  }

  void DoAnything() {
    const std::string name = AnyName();
    constexpr BuiltInState states[] = {kActive,   kProtected, kDeActive,
                                       kLowPower, kSelfCheck, kError};
    const State state = states[Below(6)];
    switch (Below(22)) {
      case 0:
      case 1:
      case 2:
        Note("crash " + name);
        return t_.Crash(name);
      case 3:
        Note("hung " + name);
        return t_.Find(name, Health::kHung, Below(2) == 0);
      case 4:
        Note("partitioned " + name);
        return t_.Find(name, Health::kPartitioned, true);
      case 5:
      case 6:
        Note("well " + name);
        return t_.Find(name, Health::kWell);
      case 7:
        Note("stop");
        return t_.StopAll(StopId(static_cast<std::uint64_t>(Below(3))) + 1);
      case 8:
      case 9:
        Note("release");
        calls_.push_back(t_.Release());
        return;
      case 10:
        Note("restart " + name);
        calls_.push_back(t_.Restart(name));
        return;
      case 11:
        Note("controller restarts");
        requests_.clear();
        calls_.clear();
        return t_.RestartController(Below(2) == 0);
      case 12: {
        Behaviour& behaviour = t_.On(name, Below(2) == 0 ? state : "SetUp");
        behaviour = {};
        const int kind = Below(5);
        behaviour.takes = Milliseconds(Below(200));
        behaviour.code = kind == 0 ? kCodeFailed : kCodeOk;
        behaviour.hangs = kind == 1;
        behaviour.ends_when_requested = kind == 2;
        Note("behaviour " + std::to_string(kind) + " of " + name);
        return;
      }
      case 13: {
        const bool to = Below(2) == 0;
        const bool from = Below(2) == 0;
        Note("mute " + name + (to ? " deaf" : "") + (from ? " dumb" : ""));
        return t_.Mute(name, to, from);
      }
      case 14:
        if (t_.IsAlive(name) || name != "c") return;
        Note("start " + name);
        return t_.StartActuator(name);
      case 15:
        Note("exec of " + name);
        t_.On(name, "exec").code = Below(2) == 0 ? kCodeFailed : kCodeOk;
        return;
      case 16:
        Note("set " + name + " " + state);
        requests_.push_back(t_.RequestSwitch(state, name));
        return;
      case 17: {
        Note(name + " says that it is in " + state);
        ActuatorReport report = t_.CoreOf(name).report;
        report.stamp = t_.now();
        report.state = state;
        return t_.Feed(event::StatusSeen{*t_.config().IndexOf(name), report});
      }
      case 18:
        if (Below(4) != 0 || !t_.machine().start_up.set_up) return;
        Note("set TearDown");
        requests_.push_back(t_.RequestSwitch("TearDown"));
        return;
      default:
        Note("set " + state);
        requests_.push_back(t_.RequestSwitch(state));
    }
  }

  // Faults end: nothing hangs, all links work, actuators without a command are started.
  void Heal() {
    Note("heal");
    for (const char* name : {"a", "b", "c", "d"}) {
      for (const State& state : t_.config().states) t_.On(name, state) = {};
      t_.On(name, "exec") = {};
      t_.Mute(name, false, false);
      t_.RepeatStatus(name);
      if (t_.CoreOf(name).report.busy()) t_.Crash(name);
    }
    t_.RunFor(Milliseconds(10));
    if (!t_.IsAlive("c") && t_.machine().phase != Phase::kStopped) t_.StartActuator("c");
    t_.RunFor(std::chrono::seconds(10));
    for (const char* name : {"a", "b", "c", "d"}) t_.Find(name, Health::kWell);
  }

  void Check() {
    const Machine& machine = t_.machine();
    const auto deadline = NextDeadline(t_.config(), machine);
    ASSERT_TRUE(!deadline || *deadline > t_.now()) << "the loop would spin";
    const auto rank = t_.config().RankOf(machine.state);
    if (stopped_ && machine.emergency.stop && rank_ && rank) {
      ASSERT_LE(*rank, *rank_) << "the machine went up to " << machine.state << " while stopped";
    }
    stopped_ = machine.emergency.stop.has_value();
    rank_ = rank;
  }

  void CheckRest() const {
    const Machine& machine = t_.machine();
    EXPECT_FALSE(machine.current);
    for (const ActuatorIndex i : machine.actuators.Indices()) {
      const KnownActuator& known = machine.actuators[i];
      const std::string& name = t_.config().actuators[i].name;
      EXPECT_FALSE(known.command) << name;
      EXPECT_FALSE(known.restart.requested) << name;
      EXPECT_FALSE(known.process.termination) << name;
      const auto own = t_.config().RankOf(known.state());
      const auto machines = t_.config().RankOf(machine.state);
      const bool waits = machine.emergency.stop && (!own || (machines && *own < *machines));
      const bool low = !machines && own.value_or(0) <= *BuiltInRank(kDeActive);  // in a start
      const bool in_place = known.presence == Presence::kPresent
                                ? known.state() == machine.state || low || waits
                                : known.presence == Presence::kAbsent &&  // a later stage
                                      (machine.emergency.stop || machine.phase == Phase::kFailed);
      EXPECT_TRUE(in_place || known.held || known.fault)
          << name << " is " << PresenceName(known.presence) << " in " << known.state()
          << " while the machine is in " << machine.state;
      const ActuatorConfig& actuator = t_.config().actuators[i];
      if (!actuator.critical || known.presence == Presence::kPresent || !machines) continue;
      EXPECT_LE(*machines, *t_.config().RankOf(actuator.on_lost)) << name << " is not there";
    }
  }

  void CheckAnswers() const {
    for (const RequestId request : requests_) {
      EXPECT_EQ(t_.answers.count(request), 1U) << "request " << request << " is not answered";
    }
    for (const RequestId call : calls_) {
      EXPECT_EQ(t_.calls.count(call), 1U) << "call " << call << " is not answered";
    }
  }

  std::mt19937_64 random_;
  Harness t_;
  std::string scenario_;
  std::vector<RequestId> requests_;
  std::vector<RequestId> calls_;
  bool stopped_ = false;
  std::optional<Rank> rank_;
};

void RunSeed(std::uint64_t seed, bool print = false) {
  Walk walk(seed);
  walk.Run();
  if (print) std::cout << walk.Scenario();
  ASSERT_FALSE(::testing::Test::HasFailure())
      << "again with: MUSHER_SEED=" << seed << " lifecycle_test\n"
      << walk.Scenario();
}

TEST(RandomWalk, LeavesEveryActuatorInItsStateAndAnswersEveryRequest) {
  if (const std::uint64_t only = Environment("MUSHER_SEED", 0); only != 0)
    return RunSeed(only, true);
  const std::uint64_t last = Environment("MUSHER_SEEDS", 300);
  for (std::uint64_t seed = 1; seed <= last && !HasFatalFailure(); ++seed) RunSeed(seed);
}

// Above those of the gate. The report of the release was lost on a muted link, which the transport
// rules out.
TEST(RandomWalk, OfASeedThatOnceFailedPasses) {
  RunSeed(2884);
}

}  // namespace musher::testing::random_walk_test
