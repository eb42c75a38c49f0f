#include "musher/simulation/robot.hpp"

#include <gmock/gmock.h>
#include <signal.h>

#include "musher/messages/rosgraph_msgs/clock.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"
#include "musher/transport/clock.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::testing::robot_test {

using simulation::SimRobot;
using transport::sim::LinkFaults;

MachineConfig Robot(int actuators) {
  MachineConfig config = MachineOf(actuators);
  for (ActuatorConfig& actuator : config.actuators) actuator.command = {"run", actuator.name};
  return config;
}

// The second controller is on a host of its own.
simulation::Layout TwoHosts(std::size_t actuators) {
  simulation::Layout layout;
  layout.hosts = {"robot", "dock"};
  layout.host_of = PerActuator<std::size_t>(actuators, 0);
  layout.controllers = {0, 1};
  return layout;
}

bool IsUp(const SimRobot& robot) {
  return robot.machine().phase == Phase::kRunning;
}

TEST(SimRobot, ComesUpAndSwitches) {
  SimRobot robot(1, Robot(7));
  robot.StartController();
  ASSERT_TRUE(robot.RunUntil([&] { return IsUp(robot); }));
  EXPECT_EQ(robot.machine().state, "Active");
  EXPECT_TRUE(robot.Set("LowPower")->done());
  EXPECT_TRUE(robot.Set("OTA")->done());
  EXPECT_TRUE(robot.Set("Active")->done());
  EXPECT_EQ(robot.ReportOf("c")->state, "Active");
}

TEST(SimRobot, IsTornDownAndItsProcessesEnd) {
  SimRobot robot(1, Robot(3));
  robot.StartController();
  ASSERT_TRUE(robot.RunUntil([&] { return IsUp(robot); }));
  EXPECT_TRUE(robot.Set("TearDown")->done());
  EXPECT_EQ(robot.machine().phase, Phase::kStopped);
  for (const char* name : {"a", "b", "c"}) EXPECT_FALSE(robot.IsAlive(name));
}

TEST(SimRobot, IsTheSameTwiceFromTheSameSeed) {
  const auto run = [](std::uint64_t seed) {
    SimRobot robot(seed, Robot(5));
    LinkFaults faults;
    faults.loss = 0.1;
    faults.delay_max = Milliseconds(20);
    robot.network().SetFaults(faults);
    robot.StartController();
    robot.RunUntil([&] { return IsUp(robot); });
    robot.Set("LowPower");
    return robot.journal();
  };
  EXPECT_EQ(run(7), run(7));
}

// The time that was known last was that of the switch down, 30 s ago.
TEST(SimRobot, ThatLiesStillIsUpForTheWholeTimeOfTheClockTopicAfterASwitchUp) {
  MachineConfig config = Robot(2);
  config.clock = ClockSource::kTopic;
  LowPowerPolicy& low_power = config.policy.emplace().low_power.emplace();
  low_power.motion_ids = {0};
  low_power.enabled = true;
  SimRobot robot(1, config);
  const auto world = robot.network().MakeNode("world");
  const auto clock =
      transport::MakePublisher<msg::Clock>(*world, transport::kClockTopic, transport::kClockQos)
          .value();
  const auto timer = world->loop().Every(
      Milliseconds(100), [&] { ASSERT_TRUE(clock->Publish({msg::ToStamp(robot.age())}).ok()); });
  robot.StartController();
  ASSERT_TRUE(robot.RunUntil([&] { return IsUp(robot); }));
  robot.SetMotion(0);
  ASSERT_TRUE(robot.RunUntil([&] { return robot.machine().state == "LowPower"; }));
  robot.RunFor(std::chrono::seconds(25));
  EXPECT_TRUE(robot.Set("Active")->done());
  robot.RunFor(std::chrono::seconds(29));
  EXPECT_EQ(robot.machine().state, "Active");
  robot.RunFor(std::chrono::seconds(2));
  EXPECT_EQ(robot.machine().state, "LowPower");
}

TEST(SimRobot, ASuccessorOfAControllerKilledInASwitchBringsAllActuatorsToOneState) {
  SimRobot robot(3, Robot(5));
  robot.StartController();
  ASSERT_TRUE(robot.RunUntil([&] { return IsUp(robot); }));
  EXPECT_FALSE(robot.Set("LowPower", std::nullopt, Milliseconds(1)).has_value());
  robot.CrashController();
  robot.RunFor(std::chrono::seconds(1));
  for (const char* name : {"a", "b", "c", "d", "e"}) EXPECT_TRUE(robot.IsAlive(name));
  robot.StartController();
  ASSERT_TRUE(robot.RunUntil([&] { return IsUp(robot); }));
  robot.RunFor(std::chrono::seconds(1));
  for (const char* name : {"a", "b", "c", "d", "e"}) {
    EXPECT_EQ(robot.ReportOf(name)->state, robot.machine().state) << name;
  }
}

TEST(SimRobot, AControllerThatListensFirstAttachesTheActuatorsThatItReceivedMeanwhile) {
  SimRobot robot(1, MachineOf(3));
  for (const char* name : {"a", "b", "c"}) robot.StartActuator(name);
  robot.RunFor(std::chrono::seconds(1));
  robot.StartController(std::chrono::seconds(1));
  ASSERT_TRUE(robot.RunUntil([&] { return IsUp(robot); }, std::chrono::seconds(2)));
  for (const KnownActuator& known : robot.machine().actuators) {
    EXPECT_EQ(known.presence, Presence::kPresent);
  }
}

TEST(SimRobot, AControllerThatHasStoppedItsMachineFencesNoOther) {
  SimRobot robot(1, Robot(2), {}, TwoHosts(2));
  robot.StartController();
  ASSERT_TRUE(robot.RunUntil([&] { return IsUp(robot); }));
  robot.Set("TearDown");
  ASSERT_EQ(robot.machine().phase, Phase::kStopped);
  robot.StartRival(false);
  ASSERT_TRUE(robot.RunUntil([&] { return IsUp(robot); }, std::chrono::seconds(5)));
  robot.RunFor(std::chrono::seconds(5));
  EXPECT_TRUE(IsUp(robot));
}

TEST(SimRobot, AProcessThatNeverPublishesEndsWithTheMachine) {
  SimRobot robot(1, Robot(2));
  robot.StartController();
  ASSERT_TRUE(robot.RunUntil([&] { return IsUp(robot); }));
  robot.CrashController();
  robot.FreezeActuator("b");
  robot.StartController();
  ASSERT_TRUE(robot.RunUntil([&] { return robot.machine().start_up.set_up; }));
  robot.Set("TearDown");
  robot.RunFor(std::chrono::seconds(1));
  EXPECT_FALSE(robot.IsAlive("b"));
}

TEST(SimRobot, AStopThatIsEngagedForANewControllerIsEngagedForItsActuators) {
  SimRobot robot(1, Robot(2));
  robot.StartController();
  ASSERT_TRUE(robot.RunUntil([&] { return IsUp(robot); }));
  robot.EngageEmergencyStop(7);  // by a panel whose sample stays latched
  robot.RunFor(std::chrono::seconds(1));
  robot.ReleaseEmergencyStop();
  robot.RunFor(std::chrono::seconds(1));
  EXPECT_EQ(robot.ReportOf("a")->emergency_stop, StopId(0));
  robot.CrashController();
  robot.StartController(std::chrono::seconds(1));
  robot.RunFor(std::chrono::seconds(5));
  EXPECT_EQ(robot.machine().emergency.stop.has_value(), robot.ReportOf("a")->emergency_stop == 7);
}

TEST(SimRobot, TwoReportsOfOneInstantHaveDifferentStamps) {
  SimRobot robot(1, MachineOf(1));
  LinkFaults faults;
  faults.delay_max = faults.delay_min;  // simultaneous queries arrive simultaneously
  robot.network().SetFaults(faults);
  robot.StartActuator("a");
  const auto node = robot.network().MakeNode("caller");
  const auto client =
      transport::MakeClient<msg::ActuatorCommand>(*node, transport::CommandService("", "a"))
          .value();
  std::vector<std::int64_t> stamps;
  for (int i = 0; i < 2; ++i) {
    msg::ActuatorCommand::Request query;
    query.kind = msg::ActuatorCommand::kKindQuery;
    client->Call(query, std::chrono::seconds(1), [&](Result<msg::ActuatorCommand::Response> reply) {
      ASSERT_TRUE(reply.ok());
      stamps.push_back(reply.value().status.stamp_ns);
    });
  }
  ASSERT_TRUE(robot.RunUntil([&] { return stamps.size() == 2; }));
  EXPECT_LT(stamps[0], stamps[1]);
}

TEST(SimRobot, AStaleStatusOfAnExitedProcessDoesNotAffectItsSuccessor) {
  SimRobot robot(5, MachineOf(1));
  robot.StartActuator("a");
  robot.StartController();
  ASSERT_TRUE(robot.RunUntil([&] { return IsUp(robot); }));
  robot.network().Block("a", "controller");
  robot.Set("Protected", std::nullopt, Milliseconds(20));  // its status is delayed on the link
  robot.CrashActuator("a");
  robot.StartActuator("a");
  robot.network().Free("a", "controller");
  robot.RunFor(std::chrono::seconds(30));  // also past the lease of the dead process
  EXPECT_EQ(robot.machine().actuators[0].presence, Presence::kPresent);
  EXPECT_EQ(robot.ReportOf("a")->state, robot.machine().state);
}

// A regression: TearDown was reported as done while the found process still ran in Active.
TEST(SimRobot, ATearDownRightAfterAStartListsAFoundActuatorWithoutAReport) {
  SimRobot robot(1, MachineOf(1));
  robot.StartActuator("a");
  robot.StartController();
  ASSERT_TRUE(robot.RunUntil([&] { return IsUp(robot); }));
  robot.CrashController();
  robot.FreezeActuator("a");
  robot.StartController();
  const auto result = robot.Set("TearDown");
  ASSERT_TRUE(result);
  EXPECT_EQ(result->outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_THAT(result->degraded, ::testing::ElementsAre("a"));
}

// A regression: TearDown was reported as done while the actuator ran on the other host.
TEST(SimRobot, ATearDownAfterARebootListsAnActuatorOfAnotherHostThatIsOutOfReach) {
  simulation::Layout layout = TwoHosts(1);
  layout.host_of = {1};
  SimRobot robot(1, MachineOf(1), {}, layout);
  robot.StartActuator("a");
  robot.StartController();
  ASSERT_TRUE(robot.RunUntil([&] { return IsUp(robot); }));
  robot.hosts().SetHostBlocked(0, 1, true);
  robot.hosts().SetHostBlocked(1, 0, true);
  robot.RebootHost(0);
  robot.StartController();
  robot.RunFor(std::chrono::seconds(10));
  const auto result = robot.Set("TearDown");
  ASSERT_TRUE(result);
  EXPECT_EQ(result->outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_THAT(result->degraded, ::testing::ElementsAre("a"));
  EXPECT_THAT(result->reason, ::testing::HasSubstr("another host, dock-1/0"));
}

// A regression: a restart by hand started a second process.
TEST(SimRobot, ARestartByHandOfAnActuatorOnAnotherHostIsRefusedWithTheHost) {
  SimRobot robot(1, Robot(1), {}, TwoHosts(1));
  robot.processes().Launch("a", 1);
  robot.RunFor(std::chrono::seconds(1));
  robot.StartController(std::chrono::seconds(1));
  ASSERT_TRUE(robot.RunUntil([&] { return IsUp(robot); }));
  Result<> answer;
  robot.leader()->shell().Restart("a", "alice", [&](const Result<>& result) { answer = result; });
  robot.RunFor(std::chrono::seconds(5));
  EXPECT_EQ(robot.processes().CountOf("a"), 1U);
  ASSERT_FALSE(answer);
  EXPECT_THAT(answer.error().message, ::testing::HasSubstr("runs on another host, dock-1/0"));
}

// Two processes run as one actuator. The exit of the one that only waits ended the monitoring of
// the other one, which was present for ever, frozen or not.
TEST(SimRobot, AnActuatorIsMonitoredAfterTheExitOfASecondProcess) {
  simulation::Layout layout = TwoHosts(1);
  layout.host_of = {1};
  SimRobot robot(1, MachineOf(1), {}, layout);
  robot.StartActuator("a");
  robot.StartController();
  ASSERT_TRUE(robot.RunUntil([&] { return IsUp(robot); }));
  robot.processes().Launch("a", 0);
  robot.RunFor(std::chrono::seconds(2));
  ASSERT_TRUE(robot.machine().actuators[0].other);
  robot.processes().End("a", 0, {ProcessExit::Kind::kKilled, SIGKILL});
  robot.RunFor(std::chrono::seconds(1));
  ASSERT_EQ(robot.machine().actuators[0].presence, Presence::kPresent);
  robot.FreezeActuator("a");
  robot.RunFor(std::chrono::seconds(5));
  EXPECT_EQ(robot.machine().actuators[0].presence, Presence::kLost);
}

TEST(SimRobot, ARebootedHostHasANewIdSmallerIncarnationsAndTheSamePids) {
  SimRobot robot(1, MachineOf(1), {}, TwoHosts(1));
  robot.hosts().SetUptime(0, std::chrono::hours(1));
  robot.StartActuator("a");
  robot.RunFor(std::chrono::seconds(1));
  const ActuatorReport before = *robot.ReportOf("a");
  robot.RebootHost(0);
  EXPECT_FALSE(robot.IsAlive("a"));
  robot.StartActuator("a");
  EXPECT_NE(robot.ReportOf("a")->host, before.host);
  EXPECT_LT(robot.ReportOf("a")->incarnation, before.incarnation);
  EXPECT_EQ(robot.ReportOf("a")->pid, before.pid);
}

TEST(SimRobot, AControllerReachesNoProcessOfAnotherHost) {
  SimRobot robot(1, Robot(1), {}, TwoHosts(1));
  robot.StartController();
  ASSERT_TRUE(robot.RunUntil([&] { return IsUp(robot); }));
  robot.processes().Launch("a", 1);
  const std::int32_t pid = robot.processes().PidOf("a", 1);
  EXPECT_FALSE(robot.processes().Signal(0, pid, SIGKILL));
  robot.StartRival(true);
  robot.RunFor(std::chrono::seconds(5));
  EXPECT_EQ(robot.processes().PidOf("a", 1), pid);  // the same process
}

TEST(SimRobot, ActuatorsThatShareAProcessAreFrozenAndEndTogether) {
  simulation::Layout layout;
  layout.process_of = {0, 0};
  SimRobot robot(1, MachineOf(2), {}, layout);
  robot.StartActuator("a");
  robot.StartController();
  ASSERT_TRUE(robot.RunUntil([&] { return IsUp(robot); }));
  EXPECT_EQ(robot.ReportOf("a")->pid, robot.ReportOf("b")->pid);
  robot.FreezeActuator("b");
  EXPECT_TRUE(robot.processes().IsFrozen("a"));
  robot.CrashActuator("b");
  EXPECT_FALSE(robot.IsAlive("a"));
}

// A regression: its heartbeats end with its TearDown, and the process was killed as one that hangs.
TEST(SimRobot, AProcessRunsOnForTheSecondOfItsActuatorsWhenTheFirstIsTornDown) {
  MachineConfig config = MachineOf(2);
  config.actuators[0].command = {"run", "a"};
  config.actuators[0].restart.policy = RestartPolicy::kOnFailure;
  simulation::Layout layout;
  layout.process_of = {0, 0};
  SimRobot robot(1, config, {}, layout);
  robot.StartController();
  ASSERT_TRUE(robot.RunUntil([&] { return IsUp(robot); }));
  ASSERT_TRUE(robot.Set(State(kTearDown), "a"));
  robot.RunFor(std::chrono::seconds(20));
  ASSERT_TRUE(robot.IsAlive("b"));
  EXPECT_EQ(robot.ReportOf("b")->state, "Active");
}

// A regression: the first controller was started while the second one of its host was listening,
// with the lock on their folder.
TEST(SimRobot, ASecondControllerThatListensKeepsTheFirstOfItsHostFromStarting) {
  MachineConfig config = Robot(1);
  config.transport = TransportProfile::kLan;
  simulation::Layout layout = TwoHosts(1);
  layout.controllers = {0, 0};
  SimRobot one(1, config, {}, layout);
  EXPECT_TRUE(one.MayStartFirst());
  one.StartRival(false);
  ASSERT_FALSE(one.has_controller()) << "it listens";
  EXPECT_FALSE(one.MayStartFirst());
  SimRobot two(1, config, {}, TwoHosts(1));
  two.StartRival(false);
  EXPECT_TRUE(two.MayStartFirst()) << "each has a folder of its own";
}

TEST(SimRobot, ATakeoverOnTheSameHostEndsTheControllerBeforeIt) {
  SimRobot robot(1, Robot(1));
  robot.StartController();
  ASSERT_TRUE(robot.RunUntil([&] { return IsUp(robot); }));
  robot.StartRival(false);
  EXPECT_EQ(robot.controller(1), nullptr);  // its folder is locked
  robot.StartRival(true);
  robot.RunFor(std::chrono::seconds(1));
  EXPECT_EQ(robot.controller(0), nullptr);
  EXPECT_TRUE(IsUp(robot));
  EXPECT_EQ(robot.processes().CountOf("a"), 1U);
}

}  // namespace musher::testing::robot_test
