// Schedules of faults drawn from seeds, then quiet, then judgement: what was promised holds in
// every one. MUSHER_SEED=n runs one seed and tells its story; MUSHER_SEEDS=n runs that many.

#include <gmock/gmock.h>

#include <cstdlib>
#include <iostream>

#include "musher/simulation/robot.hpp"
#include "musher/test/lifecycle/coordination/theatre.hpp"
#include "musher/test/simulation/replay_check.hpp"

namespace musher::testing {
namespace {

using simulation::SimRobot;
using transport::sim::LinkFaults;
using transport::sim::Random;

class Story {
 public:
  explicit Story(std::uint64_t seed)
      : dice_(seed), robot_(seed, DrawConfig(), [this](const std::string&, const State& state) {
          return DrawAct(state);
        }) {}

  void Run() {
    LinkFaults faults;
    faults.loss = 0.05;
    faults.duplication = 0.05;
    faults.reordering = 0.05;
    faults.delay_max = Milliseconds(5);
    robot_.network().SetFaults(faults);
    StartController();
    for (int i = 0; i < 12 && !::testing::Test::HasFailure(); ++i) TakeATurn();
    EndFaults();
    Judge();
  }

  const SimRobot& robot() const { return robot_; }

  void Tell() const {
    for (const std::string& line : robot_.journal()) std::cout << line << "\n";
  }

 private:
  MachineConfig DrawConfig() {
    MachineConfig config = MachineOf(1 + static_cast<int>(dice_.Next() % 6));
    for (std::size_t i = 0; i < config.actuators.size(); ++i) {
      config.actuators[i].command = {"run"};
      if (i > 0 && dice_.Chance(0.3)) config.actuators[i].after = {config.actuators[i - 1].name};
      if (i > 0 && dice_.Chance(0.2)) config.actuators[i].binds_to = {config.actuators[0].name};
      config.actuators[i].critical = dice_.Chance(0.2);
      if (config.actuators[i].critical) config.actuators[i].on_lost = kProtected;
      config.actuators[i].restart = DrawRestart();
      if (dice_.Chance(0.3)) config.actuators[i].checkpoint = Milliseconds(200);
      if (dice_.Chance(0.2)) {
        config.actuators[i].controller_lost = std::chrono::seconds(1);
        config.actuators[i].on_controller_lost = kProtected;
      }
    }
    return config;
  }

  RestartConfig DrawRestart() {
    RestartConfig restart;
    static constexpr RestartPolicy kPolicies[] = {RestartPolicy::kNo, RestartPolicy::kOnFailure,
                                                  RestartPolicy::kAlways};
    restart.policy = kPolicies[dice_.Next() % 3];
    restart.limit = static_cast<int>(dice_.Next() % 4);
    restart.reset_after = std::chrono::seconds(2);
    return restart;
  }

  simulation::Act DrawAct(const State& state) {
    simulation::Act act;
    act.takes = Milliseconds(1 + static_cast<std::int64_t>(dice_.Next() % 40));
    if (!faulty_ || state == kSetUp) return act;
    if (dice_.Chance(0.05))
      act.takes = Milliseconds(150 + static_cast<std::int64_t>(dice_.Next() % 400));
    if (dice_.Chance(0.05)) act.error = {5001, "drawn"};
    if (dice_.Chance(0.01)) act.takes = std::chrono::hours(24);  // it hangs
    return act;
  }

  void StartController() {
    robot_.StartController();
    ASSERT_TRUE(robot_.RunUntil([this] { return robot_.machine().phase != Phase::kStarting; }))
        << "a start-up has an end";
  }

  void TakeATurn() {
    static const std::vector<State> kTargets = {"Active",   "Protected", "LowPower",
                                                "DeActive", "OTA",       "SelfCheck"};
    const State target = kTargets[dice_.Next() % kTargets.size()];
    if (dice_.Chance(0.15)) {
      robot_.Set(target, std::nullopt, Milliseconds(static_cast<std::int64_t>(dice_.Next() % 60)));
      robot_.CrashController();
      robot_.RunFor(Milliseconds(50));
      return StartController();
    }
    const std::size_t drawn = dice_.Next() % robot_.config().actuators.size();
    const std::string& victim = robot_.config().actuators[drawn].name;
    if (dice_.Chance(0.1)) robot_.network().Partition("controller", victim);
    if (dice_.Chance(0.05) && robot_.IsAlive(victim)) robot_.FreezeActuator(victim);
    if (dice_.Chance(0.03)) robot_.Restart(victim);
    if (dice_.Chance(0.05)) robot_.EngageEmergencyStop(dice_.Next() | 1);
    if (dice_.Chance(0.1)) {
      robot_.CrashActuator(victim);
    } else if (!robot_.IsAlive(victim)) {
      robot_.StartActuator(victim);
    }
    const bool stopped = robot_.machine().emergency_stop.has_value();
    const auto before = StoppedRanks();
    const auto result = robot_.Set(target);
    ASSERT_TRUE(result) << "every switch has an end";
    if (stopped) ExpectNobodyWentUp(before);
    if (dice_.Chance(0.3)) robot_.ReleaseEmergencyStop();
    if (result->done() && target != kSelfCheck) ExpectAllIn(target);
    if (dice_.Chance(0.5)) HealAll();
  }

  // "Done" means that all are there, but for late ones that are still joining.
  void ExpectAllIn(const State& target) {
    for (const ActuatorRecord& record : robot_.machine().actuators) {
      const bool joining = !record.checked || record.due || record.order || record.parked;
      if (!joining) {
        EXPECT_EQ(record.state(), target)
            << "of process " << record.report.pid << ", " << PresenceName(record.presence);
      }
    }
  }

  // The ranks of those that have latched an emergency stop, by their own word. A callback that runs
  // when the stop comes finishes: who is busy is not held to it.
  std::map<std::pair<std::string, std::uint64_t>, Rank> StoppedRanks() const {
    std::map<std::pair<std::string, std::uint64_t>, Rank> ranks;
    for (const ActuatorConfig& actuator : robot_.config().actuators) {
      const auto report = robot_.ReportOf(actuator.name);
      if (!report || report->emergency_stop == 0 || report->busy()) continue;
      const auto rank = robot_.config().RankOf(report->state);
      if (rank) ranks[{actuator.name, report->emergency_stop}] = *rank;
    }
    return ranks;
  }

  void ExpectNobodyWentUp(const std::map<std::pair<std::string, std::uint64_t>, Rank>& before) {
    for (const auto& [stopped, rank] : StoppedRanks()) {
      const auto then = before.find(stopped);
      if (then == before.end()) continue;
      EXPECT_LE(rank, then->second) << stopped.first << " during an emergency stop";
    }
  }

  void HealAll() {
    for (const ActuatorConfig& actuator : robot_.config().actuators) {
      robot_.network().Heal("controller", actuator.name);
      if (robot_.IsAlive(actuator.name)) robot_.ThawActuator(actuator.name);
    }
  }

  void EndFaults() {
    faulty_ = false;
    HealAll();
    robot_.network().SetFaults(LinkFaults{});
    robot_.RunFor(std::chrono::seconds(20));  // restarts take their time, hung ones are killed
    robot_.ReleaseEmergencyStop();
    for (const ActuatorConfig& actuator : robot_.config().actuators) {
      if (!robot_.IsAlive(actuator.name)) {
        robot_.StartActuator(actuator.name);
      } else if (robot_.ReportOf(actuator.name)->busy()) {
        robot_.CrashActuator(actuator.name);  // it hangs, and nobody is to restart it but a person
        robot_.RunFor(std::chrono::seconds(1));
        if (!robot_.IsAlive(actuator.name)) robot_.StartActuator(actuator.name);
      }
    }
    robot_.RunFor(std::chrono::seconds(5));
  }

  void Judge() {
    robot_.Set(State(kSelfCheck));
    robot_.RunFor(std::chrono::seconds(2));
    ASSERT_TRUE(robot_.Set(State(kDeActive)));
    robot_.RunFor(std::chrono::seconds(2));
    EXPECT_EQ(robot_.machine().state, kDeActive);
    for (const ActuatorConfig& actuator : robot_.config().actuators) {
      ASSERT_TRUE(robot_.IsAlive(actuator.name)) << actuator.name;
      EXPECT_EQ(robot_.ReportOf(actuator.name)->state, kDeActive) << actuator.name;
    }
    EXPECT_THAT(Degraded(robot_.config(), robot_.machine()), ::testing::IsEmpty());
  }

  Random dice_;
  bool faulty_ = true;
  SimRobot robot_;
};

std::uint64_t Environment(const char* name, std::uint64_t otherwise) {
  const char* value = std::getenv(name);
  return value == nullptr ? otherwise : std::strtoull(value, nullptr, 10);
}

TEST(SeededFaults, LeaveTheMachineInOneStateOnceTheyHaveCeased) {
  const std::uint64_t only = Environment("MUSHER_SEED", 0);
  const std::uint64_t last = only != 0 ? only : Environment("MUSHER_SEEDS", 5000);
  for (std::uint64_t seed = only != 0 ? only : 1; seed <= last; ++seed) {
    Story story(seed);
    story.Run();
    if (only != 0 || seed % 10 == 0) ExpectReplaysTheSame(story.robot());
    if (only != 0 || HasFailure()) story.Tell();
    ASSERT_FALSE(HasFailure()) << "again with: MUSHER_SEED=" << seed << " simulation_test";
  }
}

}  // namespace
}  // namespace musher::testing
