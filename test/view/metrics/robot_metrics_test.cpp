#include "musher/view/metrics/robot_metrics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/test/view/metrics/openmetrics_grammar.hpp"

namespace musher::view::robot_metrics_test {

using musher::testing::ParsedLabels;
using musher::testing::ParsedMetrics;
using musher::testing::ParseOpenMetrics;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr Time kNow{std::chrono::seconds(1000)};

msg::ActuatorInfo Actuator(const std::string& name) {
  msg::ActuatorInfo info;
  info.name = name;
  info.state = "Active";
  info.presence = "present";
  info.health = "well";
  return info;
}

msg::MachineStatus Status(const std::vector<std::string>& actuators = {"legs", "eyes"}) {
  msg::MachineStatus status;
  status.machine = "dog";
  status.phase = "running";
  status.state = "Active";
  status.epoch = 1;
  for (const std::string& name : actuators) status.actuators.push_back(Actuator(name));
  return status;
}

class RobotMetricsTest : public ::testing::Test {
 protected:
  RobotMetricsTest() { metrics_.On(Status(), kNow); }

  ParsedMetrics Parsed(Time now = kNow) const {
    const std::string text = metrics_.Text(now, MetricsFormat::kOpenMetrics);
    ParsedMetrics parsed = ParseOpenMetrics(text);
    EXPECT_THAT(parsed.errors, IsEmpty()) << text;
    return parsed;
  }
  std::optional<double> Value(const std::string& sample, const ParsedLabels& labels = {}) const {
    return Parsed().Value(sample, labels);
  }
  std::optional<double> Switches(const std::string& target, const std::string& outcome) const {
    return Value("musher_switches_total", {{"target", target}, {"outcome", outcome}});
  }
  std::optional<double> Faults(const std::string& actuator, const std::string& verdict) const {
    return Value("musher_actuator_faults_total", {{"actuator", actuator}, {"verdict", verdict}});
  }

  // The next entry of the history, a millisecond later than the last one.
  msg::HistoryEntry Next(const std::string& kind, const std::string& actuator = "") {
    msg::HistoryEntry entry;
    entry.id = ++id_;
    entry.epoch = epoch_;
    entry.wall_ns = wall_ns_ += 1'000'000;
    entry.kind = kind;
    entry.actuator = actuator;
    return entry;
  }
  void Begin(std::uint64_t number, const std::string& target) {
    msg::HistoryEntry entry = Next("switch");
    entry.switch_number = number;
    entry.data = R"({"target":")" + target + R"(","state":"Active"})";
    metrics_.On(entry, "switch_started");
  }
  msg::HistoryEntry Ended(std::uint64_t number, const std::string& target,
                          const std::string& outcome, const std::string& actuator = "") {
    msg::HistoryEntry entry = Next("switch", actuator);
    entry.switch_number = number;
    entry.data =
        R"({"target":")" + target + R"(","state":"Active","outcome":")" + outcome + R"("})";
    return entry;
  }
  void Commanded(const std::string& event, const std::string& target, const std::string& took_ms) {
    msg::HistoryEntry entry = Next("actuator", "legs");
    entry.data = R"({"arguments":{"actuator":"legs","target":")" + target + R"(","took_ms":)" +
                 took_ms + "}}";
    metrics_.On(entry, event);
  }
  void Happens(const std::string& event, const std::string& actuator = "legs") {
    metrics_.On(Next("actuator", actuator), event);
  }

  RobotMetrics metrics_;
  std::uint64_t id_ = 0;
  std::uint64_t epoch_ = 1;
  std::int64_t wall_ns_ = 1'000'000'000;
};

TEST_F(RobotMetricsTest, AllCountersAreZeroFromTheBeginning) {
  EXPECT_EQ(Switches("LowPower", "undone"), 0);
  EXPECT_EQ(Faults("eyes", "hung"), 0);
  EXPECT_EQ(Value("musher_actuator_restarts_total", {{"actuator", "legs"}}), 0);
}

TEST_F(RobotMetricsTest, TheStateOfTheMachineIsOneOfAll) {
  EXPECT_EQ(Value("musher_machine_state", {{"musher_machine_state", "Active"}}), 1);
  EXPECT_EQ(Value("musher_machine_state", {{"musher_machine_state", "Error"}}), 0);
  msg::MachineStatus status = Status();
  status.state = "Patrol";  // of the config
  metrics_.On(status, kNow);
  EXPECT_EQ(Value("musher_machine_state", {{"musher_machine_state", "Patrol"}}), 1);
  metrics_.On(Status(), kNow);
  EXPECT_EQ(Value("musher_machine_state", {{"musher_machine_state", "Patrol"}}), 0);
  EXPECT_EQ(Switches("Patrol", "done"), 0);
}

TEST_F(RobotMetricsTest, WithoutAControllerItsStateIsNotKnownAndCountersStay) {
  metrics_.On(Ended(1, "Active", "done"), "switch_done");
  metrics_.OnControllerLost();
  EXPECT_EQ(Value("musher_controller_up"), 0);
  EXPECT_EQ(Value("musher_machine_state", {{"musher_machine_state", "Active"}}), std::nullopt);
  EXPECT_EQ(Value("musher_actuator_present", {{"actuator", "legs"}}), std::nullopt);
  EXPECT_EQ(Switches("Active", "done"), 1);
  metrics_.On(Status(), kNow);
  EXPECT_EQ(Value("musher_controller_up"), 1);
  EXPECT_EQ(Switches("Active", "done"), 1);
}

TEST_F(RobotMetricsTest, CountsSwitchesByTargetAndOutcomeAndTheirDurations) {
  Begin(4, "LowPower");
  wall_ns_ += 300'000'000;
  metrics_.On(Ended(4, "LowPower", "done-degraded"), "switch_done_degraded");
  EXPECT_EQ(Switches("LowPower", "done-degraded"), 1);
  EXPECT_EQ(Switches("LowPower", "done"), 0);
  const ParsedLabels of_target = {{"target", "LowPower"}};
  EXPECT_EQ(Value("musher_switch_duration_seconds_count", of_target), 1);
  EXPECT_DOUBLE_EQ(*Value("musher_switch_duration_seconds_sum", of_target), 0.301);
}

TEST_F(RobotMetricsTest, ARefusalBeforeTheBeginHasNoTarget) {
  metrics_.On(Next("switch"), "switch_refused");
  EXPECT_EQ(Switches("unknown", "refused"), 1);
}

TEST_F(RobotMetricsTest, TheSentenceOfAnEntryDoesNotMatter) {
  msg::HistoryEntry entry = Next("switch");
  entry.message = "switch 3 is done";
  metrics_.On(entry, "switch_requested");
  EXPECT_EQ(Switches("unknown", "done"), 0);
}

TEST_F(RobotMetricsTest, AnOlderControllersEntriesCountByTheirData) {
  metrics_.On(Ended(1, "OTA", "undone"), "");
  EXPECT_EQ(Switches("OTA", "undone"), 1);
}

TEST_F(RobotMetricsTest, ASwitchOfOneActuatorIsNotOneOfTheMachine) {
  metrics_.On(Ended(1, "LowPower", "done", "eyes"), "switch_done");
  EXPECT_EQ(Switches("LowPower", "done"), 0);
  EXPECT_EQ(Value("musher_actuator_switches_total", {{"actuator", "eyes"}, {"outcome", "done"}}),
            1);
}

TEST_F(RobotMetricsTest, AWallClockThatIsSetBackMeasuresNothing) {
  Begin(4, "Active");
  wall_ns_ -= 500'000'000;
  metrics_.On(Ended(4, "Active", "done"), "switch_done");
  EXPECT_EQ(Switches("Active", "done"), 1);
  EXPECT_EQ(Value("musher_switch_duration_seconds_count", {{"target", "Active"}}), std::nullopt);
}

TEST_F(RobotMetricsTest, MeasuresEachCommandByActuatorAndTarget) {
  const ParsedLabels to_active = {{"actuator", "legs"}, {"target", "Active"}};
  EXPECT_EQ(Value("musher_command_duration_seconds_count", to_active), std::nullopt);
  Commanded("command_done", "Active", "120");
  Commanded("command_done", "Active", "80");
  Commanded("command_done", "LowPower", "7");
  EXPECT_EQ(Value("musher_command_duration_seconds_count", to_active), 2);
  EXPECT_DOUBLE_EQ(*Value("musher_command_duration_seconds_sum", to_active), 0.2);
  EXPECT_EQ(Value("musher_commands_overdue_total", {{"actuator", "legs"}}), 0);
}

// Its fault is recorded as well, without the time.
TEST_F(RobotMetricsTest, AnOverdueCommandCountsOnceAndHasNoDuration) {
  Commanded("command_overdue", "Active", "3000");
  Happens("command_overdue");
  EXPECT_EQ(Value("musher_commands_overdue_total", {{"actuator", "legs"}}), 1);
  EXPECT_EQ(
      Value("musher_command_duration_seconds_count", {{"actuator", "legs"}, {"target", "Active"}}),
      std::nullopt);
}

TEST_F(RobotMetricsTest, DataThatIsNoCommandMeasuresNothing) {
  for (const std::string data :
       {"", "[]", "{}", R"({"arguments":3})", R"({"arguments":{"target":"Active"}})",
        R"({"arguments":{"target":"Active","took_ms":"soon"}})",
        R"({"arguments":{"took_ms":3}})"}) {
    msg::HistoryEntry entry = Next("actuator", "legs");
    entry.data = data;
    metrics_.On(entry, "command_done");
  }
  EXPECT_EQ(
      Value("musher_command_duration_seconds_count", {{"actuator", "legs"}, {"target", "Active"}}),
      std::nullopt);
}

TEST_F(RobotMetricsTest, CountsFaultsAndRestarts) {
  Happens("actuator_crashed");
  Happens("restart_scheduled");
  Happens("actuator_present");
  Happens("restart_requested");
  Happens("actuator_starved", "eyes");
  Happens("actuator_partitioned", "eyes");
  EXPECT_EQ(Faults("legs", "crashed"), 1);
  EXPECT_EQ(Value("musher_actuator_restarts_total", {{"actuator", "legs"}}), 2);
  EXPECT_EQ(Faults("eyes", "starved"), 1);
  EXPECT_EQ(Faults("eyes", "partitioned"), 1);
  EXPECT_EQ(Faults("eyes", "crashed"), 0);
}

TEST_F(RobotMetricsTest, TheEndOfAHungProcessIsNotACrashAsWell) {
  Happens("actuator_hung");
  Happens("actuator_crashed");  // by SIGKILL
  Happens("actuator_present");
  EXPECT_EQ(Faults("legs", "hung"), 1);
  EXPECT_EQ(Faults("legs", "crashed"), 0);
  Happens("actuator_crashed");
  EXPECT_EQ(Faults("legs", "crashed"), 1);
}

TEST_F(RobotMetricsTest, ARestartedControllerContinuesTheCounters) {
  metrics_.On(Ended(1, "Active", "done"), "switch_done");
  epoch_ = 2;
  id_ = 0;  // of a new controller
  metrics_.On(Ended(1, "Active", "done"), "switch_done");
  EXPECT_EQ(Switches("Active", "done"), 2);
}

// The faults of such a machine were not counted until the clock had caught up.
TEST_F(RobotMetricsTest, AMachineThatLostItsDiskAndItsTimeContinuesTheCounters) {
  for (int i = 0; i < 3; ++i) metrics_.On(Ended(1, "Active", "done"), "switch_done");
  id_ = 0;  // in the same epoch
  wall_ns_ = 0;
  metrics_.On(Ended(1, "Active", "done"), "switch_done");
  EXPECT_EQ(Switches("Active", "done"), 4);
}

TEST_F(RobotMetricsTest, NotesOfTheJournalItselfDoNotCount) {
  msg::HistoryEntry entry = Ended(1, "Active", "done");
  entry.id = 0;
  metrics_.On(entry, "switch_done");
  EXPECT_EQ(Switches("Active", "done"), 0);
}

TEST_F(RobotMetricsTest, GivesTheAgeOfTheLastHeartbeat) {
  msg::ActuatorHeartbeat heartbeat;
  heartbeat.name = "legs";
  heartbeat.period_ns = 100'000'000;
  metrics_.On(heartbeat, kNow);
  const ParsedMetrics parsed = Parsed(kNow + Milliseconds(1500));
  const ParsedLabels legs = {{"actuator", "legs"}};
  EXPECT_EQ(parsed.Value("musher_actuator_heartbeat_age_seconds", legs), 1.5);
  EXPECT_EQ(parsed.Value("musher_actuator_heartbeat_period_seconds", legs), 0.1);
  EXPECT_EQ(parsed.Value("musher_actuator_heartbeat_age_seconds", {{"actuator", "eyes"}}),
            std::nullopt);
  msg::MachineStatus status = Status();
  status.actuators[0].presence = "lost";  // what is not there is not late
  metrics_.On(status, kNow);
  EXPECT_EQ(Value("musher_actuator_heartbeat_age_seconds", legs), std::nullopt);
}

TEST_F(RobotMetricsTest, CpuTimeGrowsAcrossARestartOfTheProcess) {
  const ParsedLabels legs = {{"actuator", "legs"}};
  metrics_.OnProcess("legs", ProcessUsage{7, 100, 50.0, 4096});
  EXPECT_EQ(Value("musher_actuator_cpu_seconds_total", legs), 0);
  metrics_.OnProcess("legs", ProcessUsage{7, 100, 52.5, 8192});
  EXPECT_EQ(Value("musher_actuator_cpu_seconds_total", legs), 2.5);
  EXPECT_EQ(Value("musher_actuator_resident_memory_bytes", legs), 8192);
  metrics_.OnProcess("legs", ProcessUsage{7, 900, 1.0, 8192});  // the pid is used again
  EXPECT_EQ(Value("musher_actuator_cpu_seconds_total", legs), 3.5);
  metrics_.OnProcess("legs", std::nullopt);
  EXPECT_EQ(Value("musher_actuator_resident_memory_bytes", legs), std::nullopt);
}

TEST_F(RobotMetricsTest, TheBatteryIsARatioAndMissingWhereItIsNotKnown) {
  EXPECT_EQ(Value("musher_battery_ratio"), std::nullopt);
  msg::MachineStatus status = Status();
  status.policy.active = true;
  status.policy.battery = 42;
  metrics_.On(status, kNow);
  EXPECT_EQ(Value("musher_battery_ratio"), 0.42);
  status.policy.battery = -1;
  metrics_.On(status, kNow);
  EXPECT_EQ(Value("musher_battery_ratio"), std::nullopt);
}

TEST_F(RobotMetricsTest, NamesThatNoStatusHasGetNoSeries) {
  Happens("actuator_crashed", "unlisted");
  msg::ActuatorHeartbeat heartbeat;
  for (int i = 0; i < 1000; ++i) {
    heartbeat.name = "b" + std::to_string(i);
    metrics_.On(heartbeat, kNow);
  }
  EXPECT_EQ(Value("musher_dropped_names_total", {{"kind", "actuator"}}), 1001);
  EXPECT_EQ(Faults("unlisted", "crashed"), std::nullopt);
}

TEST_F(RobotMetricsTest, TheNumberOfActuatorsAndStatesIsBounded) {
  std::vector<std::string> names;
  for (int i = 0; i < 2000; ++i) names.push_back("a" + std::to_string(i));
  names.push_back(std::string(65, 'x'));
  names.push_back("a0");
  metrics_.On(Status(names), kNow);
  for (int i = 0; i < 100; ++i) {
    msg::MachineStatus status = Status();
    status.state = "S" + std::to_string(i);
    metrics_.On(status, kNow);
  }
  metrics_.On(Status(names), kNow);
  const ParsedMetrics parsed = Parsed();
  EXPECT_EQ(parsed.Find("musher_actuator_present")->samples.size(), RobotMetrics::kMostActuators);
  EXPECT_EQ(parsed.Find("musher_machine_state")->samples.size(), 10 + RobotMetrics::kMostStates);
  EXPECT_EQ(parsed.Value("musher_dropped_names_total", {{"kind", "state"}}),
            100 - RobotMetrics::kMostStates);
}

TEST_F(RobotMetricsTest, AnActuatorKeepsItsCountersWhenTheConfigHasAnotherOrder) {
  Happens("actuator_crashed", "eyes");
  metrics_.On(Status({"eyes", "voice", "legs"}), kNow);
  EXPECT_EQ(Faults("eyes", "crashed"), 1);
  EXPECT_EQ(Faults("voice", "crashed"), 0);
  EXPECT_EQ(Parsed().Find("musher_actuator_present")->samples.at(0).labels.at(0).second, "eyes");
}

TEST(RobotMetricsText, IsTheSameForTheSameRobot) {
  const auto text = [] {
    RobotMetrics metrics;
    metrics.On(Status(), kNow);
    return metrics.Text(kNow, MetricsFormat::kPrometheus);
  };
  EXPECT_EQ(text(), text());
  EXPECT_THAT(text(), HasSubstr("musher_machine_info{machine=\"dog\""));
}

TEST(RobotMetricsText, KeepsToTheGrammarBeforeAnythingIsKnown) {
  const ParsedMetrics parsed =
      ParseOpenMetrics(RobotMetrics().Text(kNow, MetricsFormat::kOpenMetrics));
  EXPECT_THAT(parsed.errors, IsEmpty());
  EXPECT_EQ(parsed.Value("musher_controller_up"), 0);
}

}  // namespace musher::view::robot_metrics_test
