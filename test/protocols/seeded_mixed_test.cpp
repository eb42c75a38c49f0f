// Schedules of faults drawn from seeds against a machine of three CyberDog modules and three ROS 2
// nodes beside one actuator of Musher; then no faults, and all of them are in one state.
// MUSHER_SEED=n runs one seed and prints its scenario; MUSHER_SEEDS=n runs that many.

#include <gmock/gmock.h>

#include <cstdlib>
#include <iostream>
#include <set>

#include "musher/simulation/robot.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"
#include "musher/test/protocols/cyberdog_module.hpp"
#include "musher/test/protocols/ros_managed_node.hpp"
#include "musher/test/support/nightly.hpp"

namespace musher::testing::seeded_mixed_test {

using simulation::SimRobot;

using transport::sim::LinkFaults;
using transport::sim::Random;
using Outcome = RosManagedNode::Outcome;

class MixedScenario {
 public:
  explicit MixedScenario(std::uint64_t seed) : random_(seed), robot_(seed, Config()) {
    for (const ActuatorConfig& actuator : robot_.config().actuators) {
      const std::string name = actuator.name;
      if (actuator.protocol == Protocol::kCyberdog) {
        robot_.UseProgram(name, [this, name](transport::Node& node) {
          auto module = std::make_shared<CyberdogModule>(node, "", name, name);
          modules_[name] = module.get();
          return module;
        });
      } else if (actuator.protocol == Protocol::kRos2Lifecycle) {
        robot_.UseProgram(name, [this, name](transport::Node& node) {
          auto ros = std::make_shared<RosManagedNode>(node, name);
          nodes_[name] = ros.get();
          return ros;
        });
      }
    }
  }

  void Run() {
    robot_.on_start = [this](const simulation::SimulatedController&, const std::string& name) {
      EXPECT_FALSE(robot_.IsAlive(name)) << name << " is started while its process runs";
    };
    LinkFaults faults;
    faults.loss = 0.05;
    faults.duplication = 0.05;
    faults.reordering = 0.05;
    faults.delay_max = Milliseconds(5);
    robot_.network().SetFaults(faults);
    robot_.StartController();
    ASSERT_TRUE(robot_.RunUntil([this] { return robot_.machine().phase != Phase::kStarting; }));
    for (int i = 0; i < 10 && !::testing::Test::HasFailure(); ++i) TakeATurn();
    EndFaults();
    CheckResult();
    robot_.Set(State(kTearDown));
    for (const ActuatorConfig& actuator : robot_.config().actuators) {
      if (by_hand_.contains(actuator.name)) continue;
      EXPECT_FALSE(robot_.IsAlive(actuator.name)) << actuator.name << " outlives the machine";
    }
  }

  void Print() const {
    for (const std::string& line : robot_.journal()) std::cout << line << "\n";
  }

 private:
  static MachineConfig Config() {
    MachineConfig config = MachineOf(7);
    for (const ActuatorIndex i : config.actuators.Indices()) {
      ActuatorConfig& actuator = config.actuators[i];
      actuator.command = {"run"};
      if (i == 0) continue;
      actuator.protocol = i < 4 ? Protocol::kCyberdog : Protocol::kRos2Lifecycle;
      if (i < 4) actuator.heartbeat_name = actuator.name;
    }
    config.actuators[6].ros2_states = {{"LowPower", Ros2State::kUnconfigured},
                                       {"Protected", Ros2State::kActive}};
    return config;
  }

  void SampleFaults() {
    for (const auto& [name, module] : modules_) {
      if (!robot_.IsAlive(name)) continue;
      for (const State state : {kActive, kLowPower, kProtected, kDeActive, kOta}) {
        CyberdogModule::Callback& callback = module->script[state];
        callback.takes = Sample(0.1) ? Milliseconds(300) : Milliseconds(5);
        callback.code = Sample(0.1) ? 5001 : 0;
      }
    }
    for (const auto& [name, ros] : nodes_) {
      if (!robot_.IsAlive(name)) continue;
      for (const char* transition : {"configure", "activate", "deactivate", "cleanup"}) {
        RosManagedNode::Callback& callback = ros->script[transition];
        callback.takes = Sample(0.1) ? Milliseconds(700) : Milliseconds(5);
        callback.outcome = Sample(0.1)   ? Outcome::kError
                           : Sample(0.1) ? Outcome::kFailure
                                         : Outcome::kSuccess;
      }
      ros->lost_change_replies = Sample(0.2) ? 1 : 0;
      ros->lost_get_replies = Sample(0.2) ? 2 : 0;
      ros->publishes_events = !Sample(0.2);
    }
  }
  bool Sample(double probability) { return faulty_ && random_.Bernoulli(probability); }

  void TakeATurn() {
    SampleFaults();
    static const std::vector<State> kTargets = {"Active", "Protected", "LowPower", "DeActive",
                                                "OTA"};
    const State target = kTargets[random_.Next() % kTargets.size()];
    const std::string& victim = robot_.config().actuators[ActuatorIndex(random_.Next() % 7)].name;
    if (random_.Bernoulli(0.1)) robot_.network().Partition("controller", victim);
    if (random_.Bernoulli(0.15)) robot_.CrashActuator(victim);
    if (random_.Bernoulli(0.1)) {
      robot_.CrashController();
      robot_.RunFor(Milliseconds(50));
      robot_.StartController();
      robot_.RunUntil([this] { return robot_.machine().phase != Phase::kStarting; });
    }
    ASSERT_TRUE(robot_.Set(target)) << "every switch has an end";
    if (random_.Bernoulli(0.5)) HealAll();
  }

  void HealAll() {
    for (const ActuatorConfig& actuator : robot_.config().actuators) {
      robot_.network().Heal("controller", actuator.name);
    }
  }

  // What cannot be repaired remotely is restarted: a node that is finalized or could not be
  // configured.
  void EndFaults() {
    faulty_ = false;
    HealAll();
    robot_.network().SetFaults(LinkFaults{});
    robot_.RunFor(std::chrono::seconds(15));  // past every lease
    SampleFaults();
    for (const auto& [name, ros] : nodes_) {
      if (!robot_.IsAlive(name)) continue;
      const bool not_set_up =
          robot_.machine().actuators[*robot_.config().IndexOf(name)].presence != Presence::kPresent;
      if (ros->state() == Ros2State::kFinalized || not_set_up) robot_.CrashActuator(name);
    }
    for (const ActuatorConfig& actuator : robot_.config().actuators) {
      if (robot_.IsAlive(actuator.name)) continue;
      robot_.StartActuator(actuator.name);
      by_hand_.insert(actuator.name);
    }
    robot_.RunFor(std::chrono::seconds(20));
    SampleFaults();
  }

  void CheckResult() {
    robot_.Set(State(kSelfCheck));
    robot_.RunFor(std::chrono::seconds(2));
    for (const BuiltInState target : {kDeActive, kActive, kLowPower, kDeActive}) {
      ASSERT_TRUE(robot_.Set(target));
      robot_.RunFor(std::chrono::seconds(2));
    }
    EXPECT_EQ(robot_.machine().state, kDeActive);
    EXPECT_THAT(Degraded(robot_.config(), robot_.machine()), ::testing::IsEmpty());
    for (const KnownActuator& known : robot_.machine().actuators) {
      EXPECT_EQ(known.state(), kDeActive);
    }
    for (const auto& [name, module] : modules_) EXPECT_EQ(module->log().back(), kDeActive) << name;
    for (const auto& [name, ros] : nodes_) EXPECT_EQ(ros->state(), Ros2State::kInactive) << name;
  }

  Random random_;
  bool faulty_ = true;
  std::set<std::string> by_hand_;  // started by the test
  std::map<std::string, CyberdogModule*> modules_;
  std::map<std::string, RosManagedNode*> nodes_;
  SimRobot robot_;
};

std::uint64_t Environment(const char* name, std::uint64_t otherwise) {
  const char* value = std::getenv(name);
  return value == nullptr ? otherwise : std::strtoull(value, nullptr, 10);
}

TEST(SeededFaultsAmongProtocols, LeaveTheMachineInOneStateAfterTheFaultsEnd) {
  const std::uint64_t only = Environment("MUSHER_SEED", 0);
  const std::uint64_t last = only != 0 ? only : Environment("MUSHER_SEEDS", Nightly() ? 500 : 150);
  for (std::uint64_t seed = only != 0 ? only : 1; seed <= last; ++seed) {
    MixedScenario scenario(seed);
    scenario.Run();
    if (only != 0 || HasFailure()) scenario.Print();
    ASSERT_FALSE(HasFailure()) << "again with: MUSHER_SEED=" << seed << " protocol_test";
  }
}

}  // namespace musher::testing::seeded_mixed_test
