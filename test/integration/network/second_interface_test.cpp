// A robot with two outer interfaces: while one of them is up, each command of a person at another
// host reaches the robot, and no process of the robot is disturbed. Neither docker's bridge nor a
// tunnel is used beside them.

#include "musher/test/integration/network/robot_and_desk.hpp"

namespace musher::testing::second_interface_test {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

using SecondInterface = RobotAndDesk;

TEST_F(SecondInterface, CarriesTheCommandsOfAnotherHostWhileTheFirstIsLostAndTheOtherWayRound) {
  ASSERT_NO_FATAL_FAILURE(StartOnBoth());
  for (const TestNet& lost : {kEthernet, kWifi}) {
    SCOPED_TRACE(std::string(lost.robot) + " is down");
    Down(lost);
    ExpectTheRobotObeysTheDesk();
    Up(lost);
  }
  Down(kEthernet);
  ExpectNothingWasLost();
  const Ended down = desk_->Run({"down"});
  EXPECT_EQ(down.exit, 0) << down.err;
  EXPECT_TRUE(robot_->Status().is_null());
}

TEST_F(SecondInterface, IsUsedAndDockersBridgeAndATunnelAreNot) {
  ASSERT_NO_FATAL_FAILURE(StartOnBoth());
  const std::string doctor = robot_->Run({"doctor", config_}).out;
  EXPECT_THAT(doctor, AllOf(HasSubstr("eth7 with 10.77.1.1 (this host has no ethernet"),
                            HasSubstr("wlan7 with 10.77.2.1 (this host has no ethernet"),
                            HasSubstr("docker0 (it is virtual (bridge)"),
                            HasSubstr("tun7 (it is virtual (tun)")));
  EXPECT_THAT(doctor, HasSubstr("4 processes of this machine use them"));
  const std::string sockets = robot_->Do({"cat", "/proc/net/udp"}).out;
  EXPECT_THAT(sockets, AllOf(HasSubstr("01014D0A:"), HasSubstr("01024D0A:")));
  EXPECT_THAT(sockets, Not(HasSubstr("010011AC:"))) << "docker0";
  EXPECT_THAT(sockets, Not(HasSubstr("0600080A:"))) << "tun7";
  ExpectTheRobotObeysTheDesk();
}

// A script at the desk, which limits each command.
TEST_F(SecondInterface, CarriesAStopWithATimeoutAndAWaitWhileTheFirstIsLostAndTheOtherWayRound) {
  ASSERT_NO_FATAL_FAILURE(StartOnBoth());
  for (const TestNet& lost : {kEthernet, kWifi}) {
    SCOPED_TRACE(std::string(lost.robot) + " is down");
    Down(lost);
    const Ended wait = desk_->Run({"--timeout", "60", "wait", "Active"});
    EXPECT_EQ(wait.exit, 0) << wait.err;
    const Ended estop = desk_->Run({"--timeout", "60", "estop", "--json"});
    EXPECT_EQ(estop.exit, 0) << estop.err;
    EXPECT_EQ(robot_->Run({"estop", "--release"}).exit, 0);
    EXPECT_EQ(robot_->Run({"set", "Active"}).exit, 0);
    Up(lost);
  }
  ExpectNothingWasLost();
}

// Its controller cannot confirm the stop, and the actuators have.
TEST_F(SecondInterface, LeavesTimeToReportAStopThatNotAllHaveConfirmed) {
  ASSERT_NO_FATAL_FAILURE(StartOnBoth());
  Down(kEthernet);
  const std::string controller = std::to_string(pids_["controller"]);
  ASSERT_EQ(robot_->Do({"kill", "-STOP", controller}).exit, 0);
  const Ended estop = desk_->Run({"--timeout", "20", "estop", "--json"});
  ASSERT_EQ(robot_->Do({"kill", "-CONT", controller}).exit, 0);
  EXPECT_EQ(estop.exit, 1) << estop.err;
  EXPECT_THAT(estop.err, HasSubstr("no controller answers"));
  // By all networks, by each alone, and by the one that reaches it.
  EXPECT_THAT(estop.err, ContainsRegex("\\(pid [0-9]+, [0-9]+, [0-9]+, [0-9]+\\)"));
  const nlohmann::json actuators = Json(estop.out)["actuators"];
  EXPECT_EQ(actuators.size(), 3U) << estop.out;
  for (const auto& [name, actuator] : actuators.items()) EXPECT_EQ(actuator["stopped"], true);
}

// It can never be confirmed: no network is tried in vain.
TEST_F(SecondInterface, EndsAStopAtOnceThatOneActuatorDoesNotSupport) {
  Connect(kEthernet);
  Connect(kWifi);
  Drop("namespace = \"" + name_space_ + "\"\n");  // where the program has its node
  unsetenv("MUSHER_NAMESPACE");
  Replace("\"eyes\"]", "\"eyes\", \"talker\"]");
  std::ofstream(config_, std::ios::app)
      << "[actuator.talker]\nprotocol = \"ros2_lifecycle\"\nstates = "
         "[\"SetUp\", \"TearDown\", \"Active\", \"LowPower\"]\ntimes = [60000, 20000, "
         "20000, 20000]\ncommand = [\""
      << BinDir() << "/managed_node\", \"talker\"]\n";
  ASSERT_TRUE(made_);
  const Ended up = robot_->Run({"up", config_, "--detach"});
  ASSERT_EQ(up.exit, 0) << up.err;
  AwaitDesk(true);
  const Ended estop = desk_->Run({"estop", "--json"});
  EXPECT_EQ(estop.exit, 1) << estop.err;
  EXPECT_THAT(estop.err,
              AllOf(HasSubstr("stop not confirmed: talker"), ContainsRegex("\\(pid [0-9]+\\)")))
      << "one attempt";
  EXPECT_EQ(Json(estop.out)["actuators"].size(), 4U) << estop.out;
}

// It went on without having joined, and crashed.
TEST_F(SecondInterface, ACommandOfTheRobotThatCannotJoinByAnyNetworkSaysWhy) {
  Connect(kEthernet);
  Connect(kWifi);
  ASSERT_NO_FATAL_FAILURE(Start());
  for (const std::string command : {"status", "estop"}) {
    const Ended ran = robot_->Run({"--keys", "/nowhere", command});
    EXPECT_THAT(ran.exit, ::testing::AnyOf(1, 2, 3)) << command;
    EXPECT_THAT(ran.err, HasSubstr("/nowhere")) << command;
  }
}

// DDS rejects the name of the other one.
TEST_F(SecondInterface, IsUsedWhereTheOtherCannotBeJoined) {
  ASSERT_NO_FATAL_FAILURE(StartOnBoth());
  for (const TestNet& other : {kEthernet, kWifi}) {
    const std::string name = "far&" + std::string(other.robot);
    SCOPED_TRACE(name);
    Ip(*desk_, {"link", "set", other.Desk(), "down"});
    Ip(*desk_, {"link", "set", other.Desk(), "name", name});
    Ip(*desk_, {"link", "set", name, "up"});
    ASSERT_TRUE(made_);
    ExpectTheRobotObeysTheDesk();
    Ip(*desk_, {"link", "set", name, "down"});
    Ip(*desk_, {"link", "set", name, "name", other.Desk()});
    Ip(*desk_, {"link", "set", other.Desk(), "up"});
  }
  ExpectNothingWasLost();
}

// The process that goes on with it had joined before: it published to no host, for its whole
// minute.
using StopFromTheDesk = RobotAndDesk;

TEST_F(StopFromTheDesk, ReachesTheRobotOnceTheNetworkOfTheDeskComes) {
  Connect(kWifi);
  for (const TestNet& net : {kEthernet, kWifi}) Ip(*desk_, {"link", "set", net.Desk(), "down"});
  ASSERT_NO_FATAL_FAILURE(Start());
  const Ended estop = desk_->Run({"estop", "smoke", "--timeout", "1"});
  EXPECT_EQ(estop.exit, 3) << estop.out;
  EXPECT_EQ(robot_->Status()["emergency_stop"]["engaged"], false);
  Ip(*desk_, {"link", "set", kWifi.Desk(), "up"});
  ASSERT_TRUE(made_);
  EXPECT_TRUE(Until([this] { return robot_->Status()["emergency_stop"]["engaged"] == true; },
                    kReachedWithin));
}

}  // namespace musher::testing::second_interface_test
