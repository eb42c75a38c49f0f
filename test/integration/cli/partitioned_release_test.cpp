// A machine of two hosts whose network fails during an emergency stop: two network and pid
// namespaces of this computer, with a link between them.

#include <fstream>
#include <memory>
#include <regex>

#include "musher/test/fault_injection/host/isolation.hpp"
#include "musher/test/fault_injection/host/link.hpp"
#include "musher/test/integration/cli/host.hpp"
#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing::partitioned_release_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// eyes runs on the board, started by hand; the others on the robot.
class PartitionedActuator : public MachineByCli {
 protected:
  void SetUp() override {
    if (geteuid() != 0 || access("/dev/net/tun", R_OK | W_OK) != 0) {
      GTEST_SKIP() << "two hosts need root and /dev/net/tun";
    }
    setenv("XDG_STATE_HOME", folder_.path().c_str(), 1);
    robot_ = std::make_unique<Host>();
    board_ = std::make_unique<Host>();
    ASSERT_TRUE(robot_->up() && board_->up());
    board_->InNetwork([] { fault_injection::BringUp("lo"); });
    robot_->InNetwork([this] {
      fault_injection::BringUp("lo");
      link_ = std::make_unique<fault_injection::Link>(board_->init());
    });
    setenv("CYCLONEDDS_URI",
           "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name=\"link\"/></Interfaces>"
           "</General></Domain></CycloneDDS>",
           1);
    const std::string toml = std::regex_replace(
        ReadFile(config_), std::regex("\ncommand = \\[\"musher-exec\", \"[^\"]*eyes.toml\"\\]"),
        "");
    std::ofstream(config_) << toml;
    ASSERT_EQ(robot_->Run({"up", config_, "--detach"}).exit, 0);
    eyes_ = std::make_unique<Process>(
        board_->Here({"env", "MUSHER_ACTUATOR=eyes", "MUSHER_CONFIG=" + config_,
                      BinDir() + "/musher-exec", folder_ / "eyes.toml"}));
    ASSERT_TRUE(Until([this] { return Eyes()["state"] == "Active"; }, std::chrono::minutes(2)));
  }
  void TearDown() override {
    unsetenv("CYCLONEDDS_URI");
    unsetenv("XDG_STATE_HOME");
  }
  nlohmann::json Eyes() const {
    const nlohmann::json status = robot_->Status();
    return status.is_null() ? nlohmann::json::object() : status["actuators"]["eyes"];
  }

  std::unique_ptr<Host> robot_;
  std::unique_ptr<Host> board_;
  std::unique_ptr<fault_injection::Link> link_;
  std::unique_ptr<Process> eyes_;
};

// `musher estop --release` ended with exit code 0: eyes, out of reach since before the stop,
// counted as released.
TEST_F(PartitionedActuator, HasNotConfirmedTheReleaseAndIsNamed) {
  link_->Set({.loss_percent = 100}, {.loss_percent = 100}, 1);
  ASSERT_TRUE(Until([this] { return Eyes()["presence"] == "lost"; }, std::chrono::minutes(2)));
  const Ended stop = robot_->Run({"estop", "--timeout", "3"});
  EXPECT_EQ(stop.exit, 1) << stop.out;
  const Ended release = robot_->Run({"estop", "--release"});
  EXPECT_EQ(release.exit, 1) << release.out;
  EXPECT_THAT(release.err,
              HasSubstr("the release of the emergency stop is not confirmed by eyes: they may "
                        "still be stopped; release it again once they can be reached"));
  EXPECT_THAT(release.out, Not(HasSubstr("emergency stop released")));
  EXPECT_EQ(robot_->Status()["emergency_stop"]["engaged"], false);
  link_->Heal();
  ASSERT_TRUE(Until([this] { return Eyes()["presence"] == "present"; }, std::chrono::minutes(2)));
  ASSERT_EQ(robot_->Run({"estop", "--timeout", "60"}).exit, 0);
  const Ended again = robot_->Run({"estop", "--release"});
  EXPECT_EQ(again.exit, 0) << again.err;
}

}  // namespace musher::testing::partitioned_release_test
