// A client that waits for the answer of a controller that exits: it waited until its own deadline.

#include "musher/controller/client/leader_call.hpp"

#include <gmock/gmock.h>

#include <map>

#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/test/controller/two_controllers.hpp"

namespace musher::testing::leader_call_test {

using ::testing::HasSubstr;

class LeaderCalls : public TwoControllers {
 protected:
  // `host`: the client's.
  void Request(const std::string& host) {
    callback_takes_ = Milliseconds(1500);
    const std::string actuator = config_.actuators.begin()->name;
    const auto watch = [this](std::int32_t, std::function<void()> on_end) {
      on_exit_ = std::move(on_end);
      return std::make_unique<transport::LoopHandle>();
    };
    call_ = LeaderCall<msg::RestartActuator>::Make(
                *desk_, {"", host, watch}, "restart_actuator", {actuator, "me"},
                std::chrono::seconds(60), [this](auto reply) { reply_ = std::move(reply); })
                .value();
    ASSERT_TRUE(RunUntil([this] { return call_->found(); }));
    network_.RunFor(Milliseconds(300));
    ASSERT_FALSE(reply_);
  }

  std::function<void()> on_exit_;
  std::optional<Result<msg::RestartActuator::Response>> reply_;
  std::unique_ptr<LeaderCall<msg::RestartActuator>> call_;
};

TEST_F(LeaderCalls, PassOnTheAnswerOfALivingController) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  ASSERT_NO_FATAL_FAILURE(Request("sim-1/0"));
  ASSERT_TRUE(RunUntil([this] { return reply_.has_value(); }));
  ASSERT_TRUE(*reply_);
  EXPECT_EQ(reply_->value().code, kCodeOk) << reply_->value().reason;
}

TEST_F(LeaderCalls, EndAtOnceWithTheControllerOfTheirHost) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  ASSERT_NO_FATAL_FAILURE(Request("sim-1/0"));
  const std::string pid = std::to_string(first_.process->pid());
  first_.process.reset();
  on_exit_();
  ASSERT_TRUE(RunUntil([this] { return reply_.has_value(); }, Milliseconds(300)));
  ASSERT_FALSE(*reply_);
  EXPECT_THAT(reply_->error().message,
              HasSubstr("the controller (pid " + pid + ", epoch 1) has exited before it answered"));
}

// DDS delivers the last status of an exited controller for some seconds. Such a call waited until
// its own deadline, which is 5 min in an upgrade, for a controller that did not run any more.
TEST_F(LeaderCalls, EndSoonIfTheControllerHasExitedBeforeTheyReachIt) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  const auto exited = [](std::int32_t, const std::function<void()>&) { return nullptr; };
  call_ = LeaderCall<msg::RestartActuator>::Make(
              *desk_, {"", "sim-1/0", exited}, "restart_actuator",
              {config_.actuators.begin()->name, "me"}, std::chrono::seconds(60),
              [this](auto reply) { reply_ = std::move(reply); })
              .value();
  ASSERT_TRUE(RunUntil([this] { return reply_.has_value(); }, std::chrono::seconds(6)));
  ASSERT_FALSE(*reply_);
  EXPECT_EQ(reply_->error().code, kCodeNetError);
  EXPECT_THAT(reply_->error().message, HasSubstr("has exited before it was called"));
}

TEST_F(LeaderCalls, AreSentToTheSuccessorOfAControllerThatHasExitedBeforeTheyReachIt) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  const std::int32_t exited_pid = first_.process->pid();
  const auto watch = [=](std::int32_t pid, const std::function<void()>&) {
    return pid == exited_pid ? nullptr : std::make_unique<transport::LoopHandle>();
  };
  call_ = LeaderCall<msg::RestartActuator>::Make(*desk_, {"", "sim-1/0", watch}, "restart_actuator",
                                                 {config_.actuators.begin()->name, "me"},
                                                 std::chrono::seconds(60),
                                                 [this](auto reply) { reply_ = std::move(reply); })
              .value();
  network_.RunFor(std::chrono::seconds(1));
  ASSERT_FALSE(reply_);
  first_.process.reset();
  Open(second_, "second", &first_.disk);
  second_.process->Begin(false);
  ASSERT_TRUE(RunUntil([this] { return reply_.has_value(); }, std::chrono::seconds(20)));
  EXPECT_TRUE(*reply_) << reply_->error().message;
}

TEST_F(LeaderCalls, AreNotSentToASuccessorThatComesAfterTheirEnd) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  int received = 0;
  const auto beside = network_.MakeNode("beside");  // receives what the controllers receive
  const auto server =
      transport::MakeServer<msg::RestartActuator>(
          *beside, transport::MachineService("", "restart_actuator"),
          [&received](const msg::RestartActuator::Request&, const auto&) { ++received; })
          .value();
  const std::int32_t exited_pid = first_.process->pid();
  const auto watch = [=](std::int32_t pid, const std::function<void()>&) {
    return pid == exited_pid ? nullptr : std::make_unique<transport::LoopHandle>();
  };
  call_ = LeaderCall<msg::RestartActuator>::Make(*desk_, {"", "sim-1/0", watch}, "restart_actuator",
                                                 {config_.actuators.begin()->name, "me"},
                                                 std::chrono::seconds(60),
                                                 [this](auto reply) { reply_ = std::move(reply); })
              .value();
  ASSERT_TRUE(RunUntil([this] { return reply_.has_value(); }, std::chrono::seconds(6)));
  first_.process.reset();
  Open(second_, "second", &first_.disk);
  second_.process->Begin(false);
  ASSERT_TRUE(RunUntil([this] { return call_->found(); }, std::chrono::seconds(20)));
  network_.RunFor(std::chrono::seconds(2));
  EXPECT_EQ(received, 0);
}

TEST_F(LeaderCalls, EndWithALostControllerOfAnotherHostAlsoBesideItsSuccessor) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  ASSERT_NO_FATAL_FAILURE(Request("desk"));
  first_.process.reset();
  Open(second_, "second", &first_.disk);
  network_.RunFor(std::chrono::seconds(1));
  second_.process->Begin(false);
  ASSERT_TRUE(RunUntil([this] { return reply_.has_value(); }, std::chrono::seconds(10)));
  EXPECT_FALSE(*reply_);
}

TEST_F(LeaderCalls, GoOnWithAControllerWhoseLinkIsBackSoon) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  ASSERT_NO_FATAL_FAILURE(Request("desk"));
  network_.Block("first", "desk");
  network_.RunFor(std::chrono::seconds(2));
  network_.Heal("first", "desk");
  ASSERT_TRUE(RunUntil([this] { return reply_.has_value(); }));
  ASSERT_TRUE(*reply_) << reply_->error().message;
  EXPECT_EQ(reply_->value().code, kCodeOk) << reply_->value().reason;
}

// It was kept after its end, as by the page, and sent to the next controller, whenever that came.
TEST_F(LeaderCalls, AreNotSentAfterTheirEnd) {
  int received = 0;
  const auto beside = network_.MakeNode("beside");  // receives what the controller receives
  const auto server =
      transport::MakeServer<msg::RestartActuator>(
          *beside, transport::MachineService("", "restart_actuator"),
          [&received](const msg::RestartActuator::Request&, const auto&) { ++received; })
          .value();
  call_ = LeaderCall<msg::RestartActuator>::Make(
              *desk_, {"", "desk", {}}, "restart_actuator", {config_.actuators.begin()->name, "me"},
              std::chrono::seconds(2), [this](auto reply) { reply_ = std::move(reply); })
              .value();
  ASSERT_TRUE(RunUntil([this] { return reply_.has_value(); }));
  ASSERT_FALSE(*reply_);
  EXPECT_EQ(reply_->error().code, kCodeTimeout);
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  network_.RunFor(std::chrono::seconds(2));
  EXPECT_EQ(received, 0);
}

}  // namespace musher::testing::leader_call_test
