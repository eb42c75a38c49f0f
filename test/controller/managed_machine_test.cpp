// The machine as a managed node of ROS 2: what it refuses, and the reason in its records.

#include "musher/controller/ros2/managed_machine.hpp"

#include <gmock/gmock.h>

#include "musher/messages/lifecycle_msgs/services.hpp"
#include "musher/test/controller/two_controllers.hpp"
#include "musher/test/support/refusals.hpp"
#include "musher/transport/service.hpp"

namespace musher::testing::managed_machine_test {

using ::testing::HasSubstr;

constexpr std::uint8_t kConfigure = 1;
constexpr std::uint8_t kActivate = 3;

class TheMachineAsANode : public TwoControllers {
 protected:
  // `activate`: the state of that transition; the machine does not have "Gone".
  explicit TheMachineAsANode(const State& activate = "Gone") {
    callback_takes_ = Milliseconds(500);
    config_.ros2.activate = activate;
    simulation::SimulatedController::Hooks hooks;
    hooks.on_record = [this](const action::Record& record) { said_ += record.message + "\n"; };
    first_.process = std::make_unique<simulation::SimulatedController>(
        network_, "first", 0, hosts_, config_, layout_.machine_id, processes_, first_.disk, hooks);
    ros_nodes_ = std::make_unique<transport::RosNodes>(first_.process->node());
    machine_ =
        ManagedMachine::Make(first_.process->node(), first_.process->shell(), *ros_nodes_, "1")
            .value();
    client_ = transport::MakeClient<msg::ChangeState>(*desk_, "musher/change_state").value();
    first_.process->Begin(false);
  }

  // What is recorded while a manager requests the transition in vain. A refusal within ten seconds
  // of another one is not recorded.
  std::string SaidOnRefusal(std::uint8_t transition) {
    said_.clear();
    std::optional<bool> success;
    client_->Call({{transition, ""}}, kEnough,
                  [&](const auto& reply) { success = reply ? reply.value().success : true; });
    EXPECT_TRUE(RunUntil([&] { return success.has_value(); }));
    EXPECT_EQ(success, false);
    return said_;
  }
  void Run() {
    ASSERT_TRUE(RunUntil([this] { return first_.machine().phase == Phase::kRunning; }));
    network_.RunFor(std::chrono::seconds(11));
    machine_->OnRecord();
  }

  std::string said_;
  std::unique_ptr<transport::RosNodes> ros_nodes_;
  std::unique_ptr<ManagedMachine> machine_;
  std::unique_ptr<transport::Client<msg::ChangeState>> client_;
};

TEST_F(TheMachineAsANode, RefusesAManagerWhileItStartsByItself) {
  EXPECT_THAT(SaidOnRefusal(kConfigure), HasRefusal(Refusal::kStartsByItself));
}

TEST_F(TheMachineAsANode, RefusesAManagerWhileASwitchIsUnderWay) {
  ASSERT_NO_FATAL_FAILURE(Run());
  first_.process->shell().SetState("LowPower", std::nullopt, [](const auto&) {});
  EXPECT_THAT(SaidOnRefusal(kConfigure), HasRefusal(Refusal::kMachineSwitching));
}

TEST_F(TheMachineAsANode, RefusesATransitionToAStateThatTheMachineDoesNotHave) {
  ASSERT_NO_FATAL_FAILURE(Run());
  std::optional<SwitchResult> down;
  first_.process->shell().SetState("LowPower", std::nullopt, [&](const auto& r) { down = r; });
  ASSERT_TRUE(RunUntil([&] { return down.has_value(); }));
  machine_->OnRecord();
  EXPECT_THAT(SaidOnRefusal(kActivate), HasRefusal(Refusal::kNoStateOfMachine));
}

class TheMachineAsANodeOfActive : public TheMachineAsANode {
 protected:
  TheMachineAsANodeOfActive() : TheMachineAsANode("Active") {}
};

// A manager's transition that waited in the kernel was carried out when the controller ran again.
TEST_F(TheMachineAsANodeOfActive, IsNotActivatedByATransitionThatWaitedWhileItsProcessWasStopped) {
  ASSERT_NO_FATAL_FAILURE(Run());
  std::optional<SwitchResult> down;
  first_.process->shell().SetState("LowPower", std::nullopt, [&](const auto& r) { down = r; });
  ASSERT_TRUE(RunUntil([&] { return down.has_value(); }));
  machine_->OnRecord();
  said_.clear();
  network_.Pause(first_.process->node());
  std::optional<bool> success;
  client_->Call({{kActivate, ""}}, kEnough,
                [&](const auto& reply) { success = !reply || reply.value().success; });
  network_.RunFor(std::chrono::seconds(9));
  network_.Resume(first_.process->node());
  ASSERT_TRUE(RunUntil([&] { return success.has_value(); }));
  EXPECT_EQ(success, false);
  EXPECT_THAT(said_, HasRefusal(Refusal::kMayBeLate));
  EXPECT_EQ(first_.machine().state, "LowPower");
}

TEST_F(TheMachineAsANode, HasTheProcessesOfAnotherDdsInItsStatus) {
  ASSERT_NO_FATAL_FAILURE(Run());
  ControllerShell& shell = first_.process->shell();
  shell.SetOtherVendors({"process 812 runs Fast DDS"});
  EXPECT_THAT(shell.Status().other_vendors, ::testing::ElementsAre("process 812 runs Fast DDS"));
  shell.SetOtherVendors({});
  EXPECT_THAT(shell.Status().other_vendors, ::testing::IsEmpty());
}

// A robot runs for months, and a new fault must not stay silent after many old ones.
TEST_F(TheMachineAsANode, RecordsTheFaultsOfFurtherPeersAnHourAfterTooMany) {
  ASSERT_NO_FATAL_FAILURE(Run());
  const auto recorded = [this](transport::ParticipantId peer) {
    said_.clear();
    first_.process->node().ReportPeerFault({peer, "rt/chat", "sends nonsense"});
    return said_;
  };
  constexpr transport::ParticipantId kPeer = 7000;
  EXPECT_THAT(recorded(kPeer), HasSubstr("sends nonsense, on rt/chat; recorded once"));
  network_.RunFor(std::chrono::hours(2));
  EXPECT_EQ(recorded(kPeer), "") << "it is known";
  for (transport::ParticipantId other = 1; other <= 100; ++other) recorded(other);
  EXPECT_EQ(recorded(kPeer + 1), "") << "there are too many";
  network_.RunFor(std::chrono::hours(1));
  EXPECT_THAT(recorded(kPeer + 1), HasSubstr("sends nonsense"));
}

}  // namespace musher::testing::managed_machine_test
