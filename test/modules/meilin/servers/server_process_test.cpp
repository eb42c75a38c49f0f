// musher-meilin-server as a controller and the robot's other programs use it: the real program over
// DDS.

#include <gmock/gmock.h>

#include <memory>
#include <string>
#include <vector>

#include "musher/messages/r2_interfaces/arm_action.hpp"
#include "musher/messages/std_msgs/multi_array.hpp"
#include "musher/test/modules/module_process.hpp"
#include "musher/transport/action.hpp"

namespace musher::meilin::servers::server_process_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using transport::GoalEnd;

class ServerProcess : public test::ModuleProcess {
 protected:
  ServerProcess() : ModuleProcess("arm", "musher-meilin-server") {}

  // The arm: each command is done after some reports.
  void OpenHardware() {
    Subscribe<msg::Float32MultiArray>("t0x0103_", [this](const msg::Float32MultiArray& message) {
      commands_.push_back(message.data.at(0));
      reports_ = 0;
    });
    report_out_ = Publisher<msg::Float32MultiArray>("r0x0203");
    hardware_ = peer_.node().loop().Every(Milliseconds(10), [this] {
      msg::Float32MultiArray report;
      report.data = {++reports_ > takes_ ? 1.0F : 0.0F, 0, 0, 0, 0, 0, 0, 0, 0};
      EXPECT_TRUE(report_out_->Publish(report));
    });
  }
  void Send(std::uint8_t command) {
    if (!client_) {
      client_ = transport::MakeActionClient<msg::ArmAction>(peer_.node(), "arm_action").value();
    }
    end_.reset();
    transport::GoalEvents<msg::ArmAction> events;
    events.on_end = [this](const auto& outcome) { end_ = outcome; };
    client_->SendGoal({command, true, 60}, Milliseconds(120'000), std::move(events));
  }

  std::vector<float> commands_;
  int reports_ = 1'000'000;
  int takes_ = 20;
  std::unique_ptr<transport::Publisher<msg::Float32MultiArray>> report_out_;
  transport::LoopHandlePtr hardware_;
  std::unique_ptr<transport::ActionClient<msg::ArmAction>> client_;
  std::optional<transport::GoalOutcome<msg::ArmAction>> end_;
};

TEST_F(ServerProcess, CarriesOutAGoalInActiveAndAbortsItOtherwise) {
  OpenHardware();
  Start("server = \"arm\"\nself_check_ms = 15000\n");
  ExpectDone("SelfCheck");
  ExpectDone("Active");
  Send(1);
  ASSERT_TRUE(peer_.Until([this] { return end_.has_value(); })) << peer_.Output();
  EXPECT_EQ(end_->end, GoalEnd::kSucceeded) << end_->reason << peer_.Output();
  EXPECT_EQ(end_->result.message, "Arm command 1 done");
  takes_ = 1'000'000;
  Send(2);
  ASSERT_TRUE(peer_.Until([this] { return commands_.back() == 2; }));
  ExpectDone("Protected");
  ASSERT_TRUE(peer_.Until([this] { return end_.has_value() && commands_.back() == 0; }));
  EXPECT_EQ(end_->end, GoalEnd::kAborted);
  EXPECT_EQ(end_->result.message, "Aborted: it is in Protected");
  ExpectTornDown();
}

TEST_F(ServerProcess, FailsItsSelfCheckWithoutHardware) {
  Start("server = \"arm\"\nself_check_ms = 100\n");
  EXPECT_THAT(Failure("SelfCheck"),
              AllOf(StartsWith("709 "), HasSubstr("no publisher of r0x0203")));
}

TEST_F(ServerProcess, IsNotStartedWithAnInvalidFile) {
  ExpectRefused("server = \"amr\"\n", "arm.toml:1:10: error: server");
}

TEST_F(ServerProcess, IsNotStartedWithoutAFile) {
  peer_.StartWith({});
  EXPECT_EQ(peer_.AwaitExit(), 2);
}

}  // namespace musher::meilin::servers::server_process_test
