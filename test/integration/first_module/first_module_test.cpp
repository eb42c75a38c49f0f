// The guide's first module, as a reader has it: its folder, its config, its processes. The
// commands of the guide are tested here.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "musher/controller/machine_controller.hpp"
#include "musher/test/support/domain.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/process.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::first_module_test {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class FirstModule : public ::testing::Test {
 protected:
  FirstModule() {
    setenv("ROS_DOMAIN_ID", std::to_string(transport::TestDomain()).c_str(), 1);
    setenv("XDG_STATE_HOME", (folder_ / "state").c_str(), 1);
    const std::string path = std::getenv("PATH");
    setenv("PATH", (BinDir() + ":" + path).c_str(), 1);
    fs::copy(SourceDir() + "/examples/first_module", robot_);
    fs::create_directory(robot_ + "/build");
    fs::create_symlink(BinDir() + "/gripper", robot_ + "/build/gripper");
  }
  ~FirstModule() override { controller_.Switch("TearDown"); }

  void Start() {
    ASSERT_TRUE(controller_.Init(robot_ + "/robot.toml"));
    const Result<> set_up = controller_.AwaitSetUp();
    ASSERT_TRUE(set_up) << set_up.error().message;
  }

  std::string Read(const std::string& file) const {
    std::ifstream stream(file);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  std::string Lamp() const { return Read(robot_ + "/lamp"); }
  std::string GripperLog() const {
    return Read(folder_ / ("state/musher/hand.domain" + std::to_string(transport::TestDomain()) +
                           "/logs/gripper.log"));
  }

  const TempFolder folder_;
  const std::string robot_ = folder_ / "robot";
  MachineController controller_;
};

std::string DescribeResult(const SwitchResult& result) {
  return std::string(OutcomeName(result.outcome)) + " " + result.reason;
}

TEST_F(FirstModule, GoesToActiveToLowPowerAndToTearDown) {
  ASSERT_NO_FATAL_FAILURE(Start());
  for (const BuiltInState state : {kSelfCheck, kActive}) {
    const SwitchResult result = controller_.Switch(state);
    ASSERT_TRUE(result.done()) << state << ": " << DescribeResult(result);
  }
  EXPECT_EQ(Lamp(), "on\n");
  EXPECT_THAT(GripperLog(), HasSubstr("power on"));

  const SwitchResult low_power = controller_.Switch("LowPower");
  ASSERT_TRUE(low_power.done()) << DescribeResult(low_power);
  EXPECT_EQ(Lamp(), "off\n");
  EXPECT_THAT(GripperLog(), HasSubstr("power off"));

  const SwitchResult tear_down = controller_.Switch("TearDown");
  ASSERT_TRUE(tear_down.done()) << DescribeResult(tear_down);
  EXPECT_FALSE(fs::exists(robot_ + "/lamp"));
}

TEST_F(FirstModule, ReportsAFailedSelfCheckWithItsCode) {
  ASSERT_NO_FATAL_FAILURE(Start());
  std::ofstream(robot_ + "/temperature") << "91\n";
  const SwitchResult result = controller_.Switch("SelfCheck");
  EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_EQ(result.code, 6109);
  EXPECT_THAT(result.reason, HasSubstr("gripper"));
  EXPECT_THAT(result.reason, HasSubstr("the motor has 91 °C"));
}

// examples/own_client, as a process of its own.
TEST_F(FirstModule, IsSetByAClientOfOnesOwn) {
  ASSERT_NO_FATAL_FAILURE(Start());
  ASSERT_TRUE(controller_.Switch("SelfCheck").done());
  const testing::Ended client = testing::RunToEnd({BinDir() + "/machine_client", "Active"});
  EXPECT_EQ(client.exit, 0) << client.err;
  EXPECT_EQ(client.out, "done, the machine is in Active\n");
  EXPECT_EQ(controller_.GetMachineState(), "Active");
}

TEST_F(FirstModule, DoesNotBecomeActiveAfterAFailedSelfCheck) {
  ASSERT_NO_FATAL_FAILURE(Start());
  std::ofstream(robot_ + "/temperature") << "91\n";
  controller_.Switch("SelfCheck");
  const SwitchResult result = controller_.Switch("Active");
  EXPECT_EQ(result.outcome, SwitchOutcome::kRefused) << DescribeResult(result);
  EXPECT_EQ(controller_.GetMachineState(), "SelfCheck");
}

}  // namespace musher::first_module_test
