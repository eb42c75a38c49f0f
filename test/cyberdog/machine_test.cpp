// A module and a program that use the calls of CyberDog's machine library, over DDS.

#include "musher/cyberdog/machine.hpp"

#include <gmock/gmock.h>

#include <map>
#include <memory>
#include <string>

#include "musher/test/actuator/robot_file.hpp"

namespace musher::testing::cyberdog_machine_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;

class CallsOfCyberdogsLibrary : public ::testing::Test {
 protected:
  CallsOfCyberdogsLibrary() {
    for (const std::string& state : kAllStates) {
      legs_.RegisterStateCallback(state, [this, state] { return state == fails_in_ ? 3009 : 0; });
    }
  }

  const RobotFile file_{{"legs"}, kAllStates};
  const std::shared_ptr<transport::NodeThread> node_ = transport::NodeThread::Start().value();
  std::string fails_in_;
  ActuatorRunner<cyberdog::MachineActuator> legs_{"legs"};
  cyberdog::MachineController controller_;
};

TEST_F(CallsOfCyberdogsLibrary, DriveAMachineFromItsStartToTearDown) {
  ASSERT_TRUE(legs_.MachineActuatorInit(file_.path(), node_));
  ASSERT_TRUE(legs_.ActuatorStart());
  ASSERT_TRUE(controller_.MachineControllerInit(file_.path(), node_));
  ASSERT_TRUE(controller_.WaitActuatorsSetUp());
  EXPECT_TRUE(controller_.SetState("SelfCheck"));
  EXPECT_TRUE(controller_.SetState("Active"));
  EXPECT_TRUE(controller_.SetState("legs", "Protected"));
  std::map<std::string, std::string> states;
  controller_.GetStateMap(states);
  EXPECT_THAT(states, ElementsAre(Pair("legs", "Protected")));
  std::string state;
  EXPECT_TRUE(controller_.GetState("legs", state));
  EXPECT_EQ(state, "Protected");
  EXPECT_FALSE(controller_.GetState("tail", state));
  EXPECT_EQ(state, "Protected") << "unchanged";
  fails_in_ = "Active";
  EXPECT_FALSE(controller_.SetState("Active"));
  EXPECT_TRUE(controller_.SetState("TearDown"));
}

TEST_F(CallsOfCyberdogsLibrary, TakeACallbackInEachFormOfMusherAndTheStateAsAText) {
  cyberdog::MachineActuator tail("tail");
  const char* const chars = "Protected";
  const auto code = [] { return 0; };
  const auto result = [] { return Result<>(Ok()); };
  tail.RegisterStateCallback("SetUp", code);
  tail.RegisterStateCallback("SelfCheck", result);
  tail.RegisterStateCallback(kActive, code);
  tail.RegisterStateCallback(State("DeActive"), result);
  tail.RegisterStateCallback(std::string("LowPower"), code);
  tail.RegisterStateCallback(std::string("OTA"), result);
  tail.RegisterStateCallback(chars, code);
  tail.RegisterStateCallback([](const std::string&) { return 0; });
  const RobotFile file({"tail"}, {"SetUp", "SelfCheck", "Active", "DeActive", "Protected",
                                  "LowPower", "OTA", "Error", "TearDown"});
  EXPECT_TRUE(tail.MachineActuatorInit(file.path(), node_));
}

TEST_F(CallsOfCyberdogsLibrary, ReturnFalseAndLogTheReason) {
  ::testing::internal::CaptureStderr();
  EXPECT_FALSE(legs_.MachineActuatorInit("/nowhere/robot.toml", node_));
  EXPECT_FALSE(controller_.MachineControllerInit("/nowhere/robot.toml", node_));
  EXPECT_FALSE(controller_.WaitActuatorsSetUp());
  EXPECT_FALSE(controller_.SetState("Active"));
  fails_in_ = "SetUp";
  ASSERT_TRUE(legs_.MachineActuatorInit(file_.path(), node_));
  EXPECT_FALSE(legs_.ActuatorStart());
  const std::string log = ::testing::internal::GetCapturedStderr();
  EXPECT_THAT(log, HasSubstr("legs: /nowhere/robot.toml: error: the file cannot be read"));
  EXPECT_THAT(log, HasSubstr("legs: error: not started: 3009 (MotionManager: SelfCheckFailed)"));
}

}  // namespace musher::testing::cyberdog_machine_test
