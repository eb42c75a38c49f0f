// A robot of several hosts whose systemds run its actuators as units
// (simulation/simulated_systemds.hpp).

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <optional>
#include <string>
#include <utility>

#include "musher/simulation/checker.hpp"
#include "musher/simulation/search.hpp"
#include "musher/simulation/timeline.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"
#include "musher/test/simulation/sampled_config.hpp"

namespace musher::testing::units_test {

using simulation::Invariant;
using simulation::Layout;
using simulation::Scenario;
using simulation::ScenarioEnd;
using simulation::ScenarioOptions;
using simulation::SimRobot;
using simulation::Timeline;
using ::testing::HasSubstr;

// A robot of three hosts; "a" is a unit of the second one, "b" of the third.
class Units : public ::testing::Test {
 protected:
  static MachineConfig MakeConfig() {
    MachineConfig config = MachineOf(2);
    config.transport = TransportProfile::kLan;
    for (const char* name : {"dock", "arm"}) {
      HostConfig& host = config.hosts.emplace_back();
      host.name = host.address = name;
    }
    for (ActuatorConfig& actuator : config.actuators) {
      actuator.command = {"run", actuator.name};
      actuator.restart.policy = RestartPolicy::kOnFailure;
      actuator.restart.limit = 10;
      std::fill(actuator.times.begin(), actuator.times.end(), Duration(std::chrono::seconds(5)));
    }
    config.actuators[ActuatorIndex(0)].host = "dock";
    config.actuators[ActuatorIndex(1)].host = "arm";
    return config;
  }
  static Layout MakeLayout() {
    Layout layout;
    layout.hosts = {"robot", "dock", "arm"};
    layout.host_of = PerActuator<std::size_t>(2, 1);
    layout.host_of[ActuatorIndex(1)] = 2;
    layout.machine_id = "11111111-0000-4000-8000-000000000000";
    layout.controllers = {0, 2};
    return layout;
  }

  explicit Units(MachineConfig config = MakeConfig())
      : robot_(1, std::move(config), {}, MakeLayout()), checker_(robot_) {
    robot_.on_record = [this](const action::Record& record) { checker_.OnRecord(record); };
  }
  bool RunUntil(const std::function<bool()>& done, Duration limit = std::chrono::minutes(1)) {
    return robot_.RunUntil(
        [&] {
          checker_.AfterEvent();
          return done();
        },
        limit);
  }
  void RunFor(Duration duration) {
    RunUntil([] { return false; }, duration);
  }
  // Both are in Active, and no earlier process of "a" is that.
  bool IsActive(std::int32_t before = 0) const {
    for (const char* name : {"a", "b"}) {
      const ActuatorReport* report = robot_.processes().ReportOf(name);
      if (report == nullptr || report->state != kActive) return false;
    }
    return robot_.processes().PidOf("a") != before && robot_.machine().state == kActive;
  }
  void BringUp() {
    robot_.StartController(std::chrono::seconds(1));
    ASSERT_TRUE(RunUntil([this] { return IsActive(); })) << Journal();
  }
  std::string Journal() const {
    std::string text;
    for (const std::string& message : robot_.journal()) text += message + "\n";
    return text;
  }
  std::size_t Count(const std::string& words) const {
    std::size_t count = 0;
    for (const std::string& message : robot_.journal()) {
      count += message.find(words) != std::string::npos ? 1 : 0;
    }
    return count;
  }
  void Cut(bool cut) { robot_.hosts().SetCutOff(kDock, cut); }
  void ExpectNoViolation() const {
    EXPECT_FALSE(checker_.violation()) << checker_.violation()->what;
  }

  static constexpr std::size_t kDock = 1;
  SimRobot robot_;
  simulation::Checker checker_;
};

TEST_F(Units, AreStartedDrivenAndEndedWithTheMachine) {
  ASSERT_NO_FATAL_FAILURE(BringUp());
  EXPECT_EQ(robot_.processes().CountOf("a"), 1U);
  EXPECT_TRUE(robot_.processes().IsAlive("a", kDock));
  robot_.Set(State(kTearDown));
  ASSERT_TRUE(RunUntil([this] { return robot_.machine().phase == Phase::kStopped; }));
  RunFor(std::chrono::seconds(1));
  EXPECT_FALSE(robot_.IsAlive("a"));
  EXPECT_FALSE(robot_.IsAlive("b"));
  ExpectNoViolation();
}

TEST_F(Units, WhoseHostLosesItsPowerIsStartedAndDrivenAgain) {
  ASSERT_NO_FATAL_FAILURE(BringUp());
  const std::string boot = robot_.hosts().Id(kDock);
  robot_.RebootHost(kDock);
  RunFor(std::chrono::seconds(20));
  EXPECT_FALSE(robot_.IsAlive("a"));
  robot_.BootHost(kDock);
  ASSERT_TRUE(RunUntil([this] { return IsActive(); }));
  EXPECT_NE(robot_.hosts().Id(kDock), boot);
  EXPECT_EQ(Count("a started on host dock"), 2U);
  EXPECT_EQ(Count("and has been booted again"), 1U);
  ExpectNoViolation();
}

// It exits with code 0 on the SIGTERM of the shutdown, which is no end of its work.
TEST_F(Units, WhoseHostIsShutDownInOrderIsStartedAndDrivenAgain) {
  ASSERT_NO_FATAL_FAILURE(BringUp());
  robot_.systemds()->ShutDown(kDock);
  RunFor(std::chrono::seconds(1));
  EXPECT_FALSE(robot_.IsAlive("a"));
  robot_.RebootHost(kDock);
  RunFor(std::chrono::seconds(20));
  robot_.BootHost(kDock);
  ASSERT_TRUE(RunUntil([this] { return IsActive(); }));
  EXPECT_GE(Count("its host went down"), 1U);
  ExpectNoViolation();
}

// The signal of systemd about its exit is lost with the connection, and no reboot shows it.
TEST_F(Units, WhoseExitIsLostInACutLinkIsStartedAgainOnceThatIsBack) {
  ASSERT_NO_FATAL_FAILURE(BringUp());
  const std::int32_t before = robot_.processes().PidOf("a");
  Cut(true);
  RunFor(Milliseconds(1));
  robot_.CrashActuator("a");
  RunFor(std::chrono::seconds(30));
  EXPECT_FALSE(robot_.IsAlive("a"));
  Cut(false);
  ASSERT_TRUE(RunUntil([&] { return IsActive(before); }));
  EXPECT_EQ(robot_.processes().CountOf("a"), 1U);
  ExpectNoViolation();
}

TEST_F(Units, RunsOnThroughACutLinkAndIsFoundAgain) {
  ASSERT_NO_FATAL_FAILURE(BringUp());
  const std::int32_t before = robot_.processes().PidOf("a");
  Cut(true);
  RunFor(std::chrono::seconds(30));
  Cut(false);
  ASSERT_TRUE(RunUntil([&] { return IsActive(); }));
  EXPECT_EQ(robot_.processes().PidOf("a"), before);
  EXPECT_EQ(Count("a started on host dock"), 1U);
  ExpectNoViolation();
}

TEST_F(Units, AreFoundByTheNextController) {
  ASSERT_NO_FATAL_FAILURE(BringUp());
  const std::int32_t before = robot_.processes().PidOf("a");
  robot_.CrashController();
  RunFor(std::chrono::seconds(1));
  ASSERT_NO_FATAL_FAILURE(BringUp());
  EXPECT_TRUE(RunUntil([this] { return Count("a runs on host dock already") == 1; }));
  EXPECT_EQ(robot_.processes().PidOf("a"), before);
  ExpectNoViolation();
}

// "b" is a unit of the controller's own host.
class OwnUnits : public Units {
 protected:
  static MachineConfig MakeOwn() {
    MachineConfig config = MakeConfig();
    config.own_units = true;
    config.actuators[ActuatorIndex(1)].host.clear();
    return config;
  }
  OwnUnits() : Units(MakeOwn()) {}
};

TEST_F(OwnUnits, AreStartedFoundByTheNextControllerRestartedAndEndedWithTheMachine) {
  ASSERT_NO_FATAL_FAILURE(BringUp());
  const std::int32_t first = robot_.processes().PidOf("b");
  EXPECT_TRUE(robot_.processes().IsAlive("b", robot_.layout().controllers[0]));
  EXPECT_EQ(robot_.systemds()->UnitsOn(robot_.layout().controllers[0]), 1U);
  robot_.CrashController();
  RunFor(std::chrono::seconds(1));
  ASSERT_NO_FATAL_FAILURE(BringUp());
  EXPECT_EQ(robot_.processes().PidOf("b"), first);
  robot_.CrashActuator("b");
  const auto is_restarted = [&] { return IsActive() && robot_.processes().PidOf("b") != first; };
  ASSERT_TRUE(RunUntil(is_restarted)) << Journal();
  EXPECT_EQ(robot_.processes().CountOf("b"), 1U);
  robot_.Set(State(kTearDown));
  ASSERT_TRUE(RunUntil([this] { return robot_.machine().phase == Phase::kStopped; }));
  RunFor(std::chrono::seconds(1));
  EXPECT_FALSE(robot_.IsAlive("b"));
  ExpectNoViolation();
}

// Until it has exited it takes what it finds for a process that its TearDown has missed.
TEST_F(Units, AreNotEndedByTheControllerThatHasStoppedTheMachineBefore) {
  ASSERT_NO_FATAL_FAILURE(BringUp());
  robot_.Set(State(kTearDown));
  ASSERT_TRUE(RunUntil([this] { return robot_.machine().phase == Phase::kStopped; }));
  robot_.StartRival(true);
  ASSERT_TRUE(RunUntil([this] { return IsActive(); })) << Journal();
  EXPECT_EQ(robot_.processes().CountOf("a"), 1U);
  ExpectNoViolation();
}

// The process hangs; a signal is on its way to it when the link is cut. Meanwhile it is ended there
// and the next controller starts another one, which the late signal reaches if it goes by the name.
class LateSignal : public Units {
 protected:
  void Run() {
    ASSERT_NO_FATAL_FAILURE(BringUp());
    const std::int32_t before = robot_.processes().PidOf("a");
    robot_.FreezeActuator("a");
    robot_.leader()->shell().SetState(State(kTearDown), std::nullopt, [](const SwitchResult&) {});
    ASSERT_TRUE(RunUntil([this] { return Count("SIGTERM") != 0; })) << Journal();
    Cut(true);
    RunFor(Milliseconds(100));
    robot_.CrashController();  // with it, what would end its connection on the host
    robot_.CrashActuator("a");
    RunFor(std::chrono::seconds(1));
    Cut(false);
    robot_.StartController(std::chrono::seconds(1));
    ASSERT_TRUE(RunUntil([&] { return robot_.processes().PidOf("a") != before; }));
    RunFor(std::chrono::seconds(30));
  }
};

TEST_F(LateSignal, EndsNoNewerProcess) {
  ASSERT_NO_FATAL_FAILURE(Run());
  EXPECT_TRUE(IsActive());
  ExpectNoViolation();
}

TEST_F(LateSignal, ThatGoesByTheNameOfTheUnitIsFound) {
  robot_.systemds()->signals_by_name = true;
  ASSERT_NO_FATAL_FAILURE(Run());
  ASSERT_TRUE(checker_.violation()) << Journal();
  EXPECT_EQ(checker_.violation()->invariant, Invariant::kOnlyOwnProcessesSignalled);
  EXPECT_THAT(checker_.violation()->what, HasSubstr("reaches the one after it"));
}

}  // namespace musher::testing::units_test
