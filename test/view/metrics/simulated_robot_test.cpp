// What the real decision code records is counted as it is meant, in virtual time.

#include <gmock/gmock.h>

#include "musher/controller/journal/record_data.hpp"
#include "musher/controller/shell/wire.hpp"
#include "musher/lifecycle/event_name.hpp"
#include "musher/simulation/robot.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"
#include "musher/test/view/metrics/openmetrics_grammar.hpp"
#include "musher/view/metrics/robot_metrics.hpp"

namespace musher::view::simulated_robot_test {

using musher::testing::ParsedLabels;
using musher::testing::ParsedMetrics;
using musher::testing::ParseOpenMetrics;
using simulation::SimRobot;
using ::testing::IsEmpty;

MachineConfig Robot() {
  MachineConfig config = musher::testing::MachineOf(3);
  for (ActuatorConfig& actuator : config.actuators) {
    actuator.command = {"run", actuator.name};
    actuator.restart.policy = RestartPolicy::kOnFailure;
  }
  return config;
}

// Its metrics get each record as the controller's history has it.
class SimulatedRobot : public ::testing::Test {
 protected:
  SimulatedRobot() {
    robot_.on_record = [this](const action::Record& record) { OnRecord(record); };
    msg::MachineStatus status;  // the actuators are known from the beginning
    for (const ActuatorConfig& actuator : robot_.config().actuators) {
      status.actuators.emplace_back().name = actuator.name;
    }
    metrics_.On(status, robot_.network().now());
  }

  void OnRecord(const action::Record& record) {
    JournalEntry entry;
    entry.epoch = robot_.has_controller() ? robot_.machine().epoch : Epoch(1);
    entry.wall_ns = transport::ToNanoseconds(robot_.network().now());
    entry.id = record.id;
    entry.kind = record.kind;
    entry.switch_number = record.switch_number;
    if (record.actuator) entry.actuator = robot_.config().actuators[*record.actuator].name;
    entry.data = DataOf(record);
    metrics_.On(ToMessage(entry), NameOf(record.event));
  }

  void ComesUp() {
    robot_.StartController();
    ASSERT_TRUE(robot_.RunUntil([&] { return robot_.machine().phase == Phase::kRunning; }));
    robot_.RunFor(std::chrono::seconds(2));
  }
  double Value(const std::string& sample, const ParsedLabels& labels) {
    if (robot_.has_controller()) {
      metrics_.On(ToMessage(robot_.config(), robot_.machine()), robot_.network().now());
    }
    const std::string text = metrics_.Text(robot_.network().now(), MetricsFormat::kOpenMetrics);
    const ParsedMetrics parsed = ParseOpenMetrics(text);
    EXPECT_THAT(parsed.errors, IsEmpty());
    return parsed.Value(sample, labels).value_or(-1);
  }
  double Switches(const std::string& target, const std::string& outcome) {
    return Value("musher_switches_total", {{"target", target}, {"outcome", outcome}});
  }
  double Faults(const std::string& actuator, const std::string& verdict) {
    return Value("musher_actuator_faults_total", {{"actuator", actuator}, {"verdict", verdict}});
  }

  SimRobot robot_{1, Robot()};
  RobotMetrics metrics_;
};

TEST_F(SimulatedRobot, ItsSwitchesAndRefusalsAreCounted) {
  ComesUp();
  const double active = Switches("Active", "done");
  ASSERT_TRUE(robot_.Set("LowPower")->done());
  ASSERT_TRUE(robot_.Set("Active")->done());
  EXPECT_EQ(Switches("LowPower", "done"), 1);
  EXPECT_EQ(Switches("Active", "done"), active + 1);
  EXPECT_GT(Value("musher_switch_duration_seconds_count", {{"target", "LowPower"}}), 0);
  robot_.EngageEmergencyStop(7);
  robot_.RunFor(std::chrono::seconds(1));
  EXPECT_EQ(Value("musher_emergency_stop", {}), 1);
  ASSERT_EQ(robot_.Set("Active")->outcome, SwitchOutcome::kRefused);
  EXPECT_EQ(Switches("unknown", "refused"), 1);
}

TEST_F(SimulatedRobot, ACrashIsOneFaultAndOneRestart) {
  ComesUp();
  robot_.CrashActuator("b");
  robot_.RunFor(std::chrono::seconds(20));
  EXPECT_EQ(Faults("b", "crashed"), 1);
  EXPECT_EQ(Faults("b", "hung"), 0);
  EXPECT_EQ(Faults("a", "crashed"), 0);
  EXPECT_EQ(Value("musher_actuator_restarts_total", {{"actuator", "b"}}), 1);
  EXPECT_EQ(Value("musher_actuator_present", {{"actuator", "b"}}), 1);
}

TEST_F(SimulatedRobot, AHungProcessIsOneFaultAlthoughItIsKilled) {
  ComesUp();
  robot_.FreezeActuator("c");
  robot_.RunFor(std::chrono::minutes(2));
  EXPECT_EQ(Faults("c", "hung"), 1);
  EXPECT_EQ(Faults("c", "crashed"), 0);
  EXPECT_EQ(Value("musher_actuator_restarts_total", {{"actuator", "c"}}), 1);
}

TEST_F(SimulatedRobot, ARequestedRestartIsNoFault) {
  ComesUp();
  robot_.Restart("a");
  robot_.RunFor(std::chrono::seconds(20));
  EXPECT_EQ(Value("musher_actuator_restarts_total", {{"actuator", "a"}}), 1);
  EXPECT_EQ(Faults("a", "crashed"), 0);
}

TEST_F(SimulatedRobot, ARestartedControllerContinuesTheCounters) {
  ComesUp();
  ASSERT_TRUE(robot_.Set("LowPower")->done());
  robot_.CrashController();
  robot_.RunFor(std::chrono::seconds(1));
  ComesUp();
  EXPECT_EQ(Switches("LowPower", "done"), 1);
  ASSERT_TRUE(robot_.Set("OTA")->done());
  ASSERT_TRUE(robot_.Set("LowPower")->done());
  EXPECT_EQ(Switches("LowPower", "done"), 2);
}

}  // namespace musher::view::simulated_robot_test
