// A robot with two outer interfaces, each of which may go, come late, or come back with another
// address: while one of them is up, each command of a person at another host reaches the robot, and
// no process of the robot is disturbed. These take minutes.

#include "musher/test/integration/network/robot_and_desk.hpp"

namespace musher::testing::changing_interface_test {

using ::testing::AllOf;
using ::testing::HasSubstr;

using ChangingInterface = RobotAndDesk;

TEST_F(ChangingInterface, IsLostAtOnceWithTheFirstAndBothComeBack) {
  ASSERT_NO_FATAL_FAILURE(StartOnBoth());
  for (const TestNet& net : {kEthernet, kWifi}) Down(net);
  const Time end = In(kOutage);
  do {
    ExpectTheRobotObeys(*robot_);
  } while (std::chrono::steady_clock::now() < end);
  AwaitDesk(false);
  Up(kWifi);
  AwaitDesk(true);
  ExpectTheRobotObeysTheDesk();
  Up(kEthernet);
  Down(kWifi);
  AwaitDesk(true);
  ExpectTheRobotObeysTheDesk();
  ExpectNothingWasLost();
}

// What needs a new process to be used is reported with its command.
TEST_F(ChangingInterface, ComesLateAndIsUsedAfterATakeoverThatDisturbsNoActuator) {
  Connect(kWifi);
  ASSERT_NO_FATAL_FAILURE(Start());
  AwaitDesk(true);
  Connect(kEthernet);
  EXPECT_TRUE(Until([this] {
    const std::string history = robot_->Run({"history"}).out;
    return history.find("eth7 with 10.77.1.1 has come") != std::string::npos;
  }));
  ExpectTheRobotObeysTheDesk();
  const std::string doctor = robot_->Run({"doctor", config_}).out;
  EXPECT_THAT(doctor, AllOf(HasSubstr("the controller"), HasSubstr("not eth7 with 10.77.1.1"),
                            HasSubstr("musher restart legs")));
  const auto before = pids_;
  ASSERT_EQ(robot_->Run({"up", config_, "--takeover", "--detach"}).exit, 0);
  pids_ = Pids();
  for (const auto& [name, pid] : before) {
    EXPECT_EQ(pids_[name] == pid, name != "controller") << name;
  }
  ExpectTheRobotObeysTheDesk();
  Down(kWifi);
  AwaitDesk(true);
  for (const char* state : {"LowPower", "Active"}) {
    const Ended set = desk_->Run({"set", state});
    EXPECT_EQ(set.exit, 0) << set.err;
  }
  // The actuators have started before the ethernet came: they stop, and cannot say so there.
  const Ended estop = desk_->Run({"estop"});
  EXPECT_EQ(estop.exit, 1) << estop.err;
  EXPECT_THAT(estop.err, HasSubstr("stop not confirmed: legs"));
  EXPECT_TRUE(robot_->Status().value("emergency_stop", nlohmann::json()).is_object());
  ASSERT_EQ(desk_->Run({"estop", "--release"}).exit, 0);
  ExpectTheRobotObeys(*robot_);
  ExpectNothingWasLost();
}

TEST_F(ChangingInterface, CarriesTheCommandsWhileTheFirstComesBackWithAnotherAddress) {
  ASSERT_NO_FATAL_FAILURE(StartOnBoth());
  LoseAddress(kEthernet);
  ExpectTheRobotObeysTheDesk();
  Connect(kEthernet, 9);
  ExpectTheRobotObeysTheDesk();
  const Ended restart = robot_->Run({"restart", "voice"});
  EXPECT_EQ(restart.exit, 0) << restart.err;
  ASSERT_TRUE(Until([this] { return AllHaveArrivedIn("Active")(robot_->Status()); }));
  pids_["voice"] = Pids()["voice"];
  ExpectTheRobotObeysTheDesk();
  ExpectTheRobotObeys(*robot_);
  ExpectNothingWasLost();
}

}  // namespace musher::testing::changing_interface_test
