// A robot with two outer interfaces: while one of them is up, each command of a person at another
// host reaches the robot, and no process of the robot is disturbed. Neither docker's bridge nor a
// tunnel is used beside them.

#include "musher/test/integration/network/robot_and_desk.hpp"

namespace musher::testing::second_interface_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

using SecondInterface = RobotAndDesk;

TEST_F(SecondInterface, CarriesTheCommandsOfAnotherHostWhileTheFirstIsLostAndTheOtherWayRound) {
  Connect(kEthernet);
  Connect(kWifi);
  ASSERT_NO_FATAL_FAILURE(Start());
  AwaitDesk(true);
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
  Connect(kEthernet);
  Connect(kWifi);
  ASSERT_NO_FATAL_FAILURE(Start());
  AwaitDesk(true);
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

}  // namespace musher::testing::second_interface_test
