// A robot of three computers with a standby: what is lost, and what it leads then. Each invariant
// of the simulation is checked after every event.

#include <gmock/gmock.h>

#include <algorithm>
#include <functional>
#include <string>

#include "musher/simulation/checker.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"

namespace musher::testing::simulated_standby_test {

using simulation::Layout;
using simulation::SimRobot;
using simulation::SimulatedController;

constexpr Duration kFailover = std::chrono::seconds(3);

// "a" is a unit of the robot, "b" of the dock, "c" of the arm, where the standby is.
class StandbyOfThree : public ::testing::Test {
 protected:
  static MachineConfig MakeConfig() {
    MachineConfig config = MachineOf(3);
    config.transport = TransportProfile::kLan;
    config.failover = kFailover;
    for (const char* name : {"robot", "dock", "arm"}) {
      HostConfig& host = config.hosts.emplace_back();
      host.name = host.address = name;
    }
    for (const ActuatorIndex i : config.actuators.Indices()) {
      ActuatorConfig& actuator = config.actuators[i];
      actuator.command = {"run", actuator.name};
      actuator.host = config.hosts[i.value()].name;
      actuator.critical = true;
      actuator.restart.policy = RestartPolicy::kOnFailure;
      actuator.restart.limit = 10;
      std::fill(actuator.times.begin(), actuator.times.end(), Duration(std::chrono::seconds(5)));
    }
    return config;
  }
  static Layout MakeLayout() {
    Layout layout;
    layout.hosts = {"robot", "dock", "arm"};
    layout.host_of = PerActuator<std::size_t>(3, 0);
    layout.host_of[ActuatorIndex(1)] = kDock;
    layout.host_of[ActuatorIndex(2)] = kArm;
    layout.machine_id = "11111111-0000-4000-8000-000000000000";
    layout.controllers = {kRobot, kArm};
    return layout;
  }

  StandbyOfThree() : robot_(1, MakeConfig(), {}, MakeLayout()), checker_(robot_) {
    robot_.on_record = [this](const action::Record& record) {
      checker_.OnRecord(record);
      records_ += record.message + "\n";
    };
    robot_.on_killed = [this](const SimulatedController& one) { checker_.OnControllerKilled(one); };
  }
  ~StandbyOfThree() override { robot_.on_killed = {}; }

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
  bool AllActive() const {
    return std::ranges::all_of(robot_.config().actuators, [this](const ActuatorConfig& actuator) {
      const auto report = robot_.ReportOf(actuator.name);
      return report && report->state == kActive && !report->busy();
    });
  }
  bool StandbyLeads() const {
    const SimulatedController* second = robot_.controller(1);
    return second != nullptr && second->leads() && robot_.leader() == second;
  }
  void BringUp() {
    robot_.StartController(std::chrono::seconds(1));
    robot_.StartStandby();
    ASSERT_TRUE(RunUntil([this] { return AllActive() && robot_.machine().state == kActive; }));
    RunFor(std::chrono::seconds(2));
    ASSERT_FALSE(robot_.controller(1)->leads());
  }
  void ExpectNoViolation() const {
    EXPECT_FALSE(checker_.violation()) << checker_.violation()->what;
  }
  void TearDown() override { ExpectNoViolation(); }

  static constexpr std::size_t kRobot = 0;
  static constexpr std::size_t kDock = 1;
  static constexpr std::size_t kArm = 2;
  SimRobot robot_;
  simulation::Checker checker_;
  std::string records_;
};

TEST_F(StandbyOfThree, LeadsNothingBesideAController) {
  BringUp();
  RunFor(std::chrono::minutes(1));
  EXPECT_FALSE(StandbyLeads());
}

TEST_F(StandbyOfThree, LeadsAMachineWhoseControllerIsKilledAndSwitchesNothing) {
  BringUp();
  robot_.CrashLeader();
  ASSERT_TRUE(RunUntil([this] { return StandbyLeads(); }, 5 * kFailover));
  ASSERT_TRUE(RunUntil([this] { return robot_.machine().phase == Phase::kRunning; }));
  EXPECT_EQ(robot_.machine().state, kActive);
  EXPECT_TRUE(AllActive());
  for (const char* name : {"a", "b", "c"}) EXPECT_EQ(robot_.processes().CountOf(name), 1U) << name;
  const auto down = robot_.Set(State(kTearDown));
  ASSERT_TRUE(down);
  EXPECT_EQ(down->outcome, SwitchOutcome::kDone) << down->reason;
}

// What ran there is started again once it has booted, and no other host runs it meanwhile.
TEST_F(StandbyOfThree, LeadsWhatIsLeftWhereTheHostOfTheControllerLosesItsPower) {
  BringUp();
  robot_.RebootHost(kRobot);
  ASSERT_TRUE(RunUntil([this] { return StandbyLeads(); }, 5 * kFailover));
  RunFor(std::chrono::seconds(10));
  EXPECT_EQ(robot_.processes().CountOf("a"), 0U);
  robot_.BootHost(kRobot);
  ASSERT_TRUE(RunUntil([this] { return robot_.processes().CountOf("a") == 1; })) << records_;
  EXPECT_TRUE(robot_.processes().IsAlive("a", kRobot));
}

// It was refused until the start of "a" had failed, 2.5 s later.
TEST_F(StandbyOfThree, CarriesOutARequestThatComesWithItsFirstStep) {
  BringUp();
  robot_.RebootHost(kRobot);
  ASSERT_TRUE(RunUntil([this] { return StandbyLeads(); }, 5 * kFailover));
  const auto set = robot_.Set(State(kLowPower));
  ASSERT_TRUE(set);
  EXPECT_EQ(set->outcome, SwitchOutcome::kDoneDegraded) << set->reason;  // without "a"
  EXPECT_EQ(robot_.machine().state, kLowPower);
  robot_.BootHost(kRobot);
  ASSERT_TRUE(RunUntil([this] { return robot_.processes().CountOf("a") == 1; })) << records_;
}

// It reaches "a" alone: it gives up, and the standby leads the others. Once the link is back one of
// them leads all.
TEST_F(StandbyOfThree, LeadsAloneWhereTheControllerIsCutOff) {
  BringUp();
  robot_.hosts().SetCutOff(kRobot, true);
  ASSERT_TRUE(RunUntil([this] { return StandbyLeads() && robot_.leaders() == 1; },
                       std::chrono::seconds(30)));
  RunFor(std::chrono::seconds(20));
  EXPECT_EQ(robot_.leaders(), 1U);
  EXPECT_EQ(robot_.processes().CountOf("a"), 1U);
  robot_.hosts().SetCutOff(kRobot, false);
  RunFor(std::chrono::seconds(30));
  EXPECT_TRUE(StandbyLeads());
  EXPECT_EQ(robot_.leaders(), 1U);
  for (const char* name : {"a", "b", "c"}) EXPECT_EQ(robot_.processes().CountOf(name), 1U) << name;
}

// A person at the first host leads back; then the standby is not started by itself.
TEST_F(StandbyOfThree, IsReplacedByAPersonWhoTakesTheMachineBack) {
  BringUp();
  robot_.CrashLeader();
  ASSERT_TRUE(RunUntil([this] { return StandbyLeads(); }, 5 * kFailover));
  robot_.TakeBack();
  ASSERT_TRUE(RunUntil([this] { return robot_.leader() == robot_.controller(0); }));
  RunFor(std::chrono::seconds(10));
  EXPECT_EQ(robot_.leaders(), 1U);
  EXPECT_TRUE(AllActive());
}

}  // namespace musher::testing::simulated_standby_test
