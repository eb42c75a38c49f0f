// The end of an upgrade that has failed: the command takes the machine back out of OTA.

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "musher/base/break_watch.hpp"
#include "musher/base/code.hpp"
#include "musher/base/host.hpp"
#include "musher/cli/commands/ota/ota_root.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/messages/musher_msgs/policy_request.hpp"
#include "musher/ota/bundle.hpp"
#include "musher/ota/install.hpp"
#include "musher/ota/posix_disk.hpp"
#include "musher/ota/signature.hpp"
#include "musher/test/cli/fake_controller.hpp"
#include "musher/test/support/domain.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::cli::ota_leave_test {

// A machine that was started from a root. Its controller lets it into OTA, and refuses the policy's
// way out, as of a request that may be late.
class AMachineInOta : public ::testing::Test {
 protected:
  AMachineInOta() {
    status_.phase = "running";
    status_.state = "Active";
    status_.epoch = 1;
    status_.switch_number = 1;
    status_.config_file = root_.ConfigFile(ota::Slot::kA);
    controller_.SetConfigFile(status_.config_file);
    controller_.Serve<msg::GetStatus>("get_status", [this](const auto&, const auto& reply) {
      msg::GetStatus::Response answer;
      answer.status = status_;
      reply(answer);
    });
    controller_.Serve<msg::RequestPolicy>("request_policy",
                                          [this](const auto& request, const auto& reply) {
                                            msg::RequestPolicy::Response answer;
                                            if (request.enable) {
                                              SwitchTo("OTA");
                                            } else {
                                              answer.code = kCodeStateInvalid;
                                              answer.reason = "it may be late";
                                            }
                                            answer.state = status_.state;
                                            reply(answer);
                                          });
    controller_.Serve<msg::SetState>("set_state", [this](const auto& request, const auto& reply) {
      ++switches_;
      msg::SetState::Response answer;
      on_switch_(request, answer);
      answer.state = status_.state;
      reply(answer);
    });
  }
  ~AMachineInOta() override { unsetenv("ROS_DOMAIN_ID"); }

  // The machine, after its way into OTA.
  std::unique_ptr<RootMachine> Entered() {
    GlobalOptions global;
    global.name_space = name_space_;
    auto found = RootMachine::Find(root_, global);
    const auto* failure = std::get_if<Failure>(&found);
    EXPECT_EQ(failure, nullptr) << failure->error.message;
    if (failure != nullptr) return nullptr;
    auto machine = std::get<std::unique_ptr<RootMachine>>(std::move(found));
    const Result<> entered = machine->EnterOta();
    EXPECT_TRUE(entered) << entered.error().message;
    return machine;
  }
  // Of the controller, on its thread.
  void SwitchTo(const std::string& state) {
    status_.state = state;
    ++status_.switch_number;
  }

  std::function<void(const msg::SetState::Request&, msg::SetState::Response&)> on_switch_;
  std::atomic<int> switches_{0};  // that were requested
  msg::MachineStatus status_;     // the controller's thread only

 private:
  static ota::Root MakeRoot(ota::Disk& disk, const TempFolder& folder) {
    std::filesystem::create_directory(folder / "built");
    std::ofstream(folder / "built/robot.toml") << "# 1.0.0\n";
    const ota::KeyPair keys = ota::MakeKeyPair().value();
    ota::Manifest manifest;
    manifest.robot = "dog";
    manifest.version = ota::ParseVersion("1.0.0").value();
    EXPECT_TRUE(
        ota::MakeBundle(disk, folder / "built", manifest, keys.private_pem, folder / "1.0.0", {}));
    EXPECT_TRUE(ota::InitRoot(disk, folder / "robot", folder / "1.0.0", keys.public_pem, {}, {}));
    return ota::Root::Open(disk, folder / "robot").value();
  }

  // In the domain of the tests, before anything joins one.
  static std::string NameSpace() {
    setenv("ROS_DOMAIN_ID", std::to_string(transport::TestDomain()).c_str(), 1);
    return "ota_leave_test_" + std::to_string(getpid());
  }

  const std::string name_space_ = NameSpace();
  const TempFolder folder_;
  ota::PosixDisk disk_;
  const ota::Root root_ = MakeRoot(disk_, folder_);
  const std::unique_ptr<ota::Disk::Lock> run_lock_ = disk_.Take(root_.RunLock(), false).value();
  FakeController controller_{
      name_space_, "dog", "d0900000-0000-4000-8000-000000000002", "Active", {HostId(), getpid()}};
};

// A controller that was suspended with its computer refused the way back, and the robot stayed in
// OTA.
TEST_F(AMachineInOta, IsSwitchedBackOnceItsControllerNoLongerRefusesWhatMayBeLate) {
  on_switch_ = [this, until = std::optional<Time>()](const auto& request, auto& answer) mutable {
    const Time now = std::chrono::steady_clock::now();
    if (!until) until = now + BreakWatch::kArriveWithin;
    if (now >= *until) return SwitchTo(request.target);
    answer.code = kCodeStateInvalid;
    answer.reason = "it may be late";
  };
  const auto machine = Entered();
  ASSERT_TRUE(machine);
  const Result<> left = machine->LeaveOta();
  EXPECT_TRUE(left) << left.error().message;
  EXPECT_EQ(switches_, 2);
}

// What has begun to move, and failed, is not moved once more.
TEST_F(AMachineInOta, IsNotSwitchedBackTwiceWhereTheFirstSwitchHasBegun) {
  on_switch_ = [this](const auto&, auto& answer) {
    SwitchTo("OTA");
    answer.code = kCodeFailed;
    answer.reason = "legs failed";
  };
  const auto machine = Entered();
  ASSERT_TRUE(machine);
  EXPECT_FALSE(machine->LeaveOta());
  EXPECT_EQ(switches_, 1);
}

}  // namespace musher::cli::ota_leave_test
