// A robot that is powered off as its app does it, by the real program.

#include <future>

#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/test/integration/cli/machine.hpp"
#include "musher/transport/dds/node_thread.hpp"
#include "musher/transport/service.hpp"

namespace musher::testing::power_test {

class PowerOff : public MachineByCli {
 protected:
  void Start(const std::string& power) {
    std::ofstream(config_, std::ios::app)
        << "[policy]\nmanager = true\n[policy.power_off]\ndelay_s = 0\n"
        << power;
    up_ = std::make_unique<Process>(Command({"up", config_}));
    ASSERT_NE(up_->LineWith("eyes: Active done"), "");
  }
  msg::Trigger::Response CallTrigger(const std::string& service) {
    const auto node = transport::NodeThread::Start().value();
    std::promise<Result<msg::Trigger::Response>> promise;
    std::unique_ptr<transport::Client<msg::Trigger>> client;
    node->RunOnLoop([&] {
      client =
          transport::MakeClient<msg::Trigger>(node->node(), name_space_ + "/" + service).value();
      client->Call({}, std::chrono::seconds(120), [&](auto reply) { promise.set_value(reply); });
    });
    const auto reply = promise.get_future().get();
    node->RunOnLoop([&] { client.reset(); });
    EXPECT_TRUE(reply.ok());
    return reply.ok() ? reply.value() : msg::Trigger::Response{};
  }

  std::unique_ptr<Process> up_;
};

TEST_F(PowerOff, TearsTheMachineDownAndRunsTheCommand) {
  const std::string mark = folder_ / "off";
  ASSERT_NO_FATAL_FAILURE(
      Start("command = [\"sh\", \"-c\", \"echo good night; touch " + mark + "\"]\n"));
  EXPECT_TRUE(CallTrigger("poweroff").success);
  EXPECT_EQ(up_->Wait().exit, 0);
  ASSERT_TRUE(AwaitFile(mark)) << "the command has not run";
  const std::string said = ReadFile(folder_ / "state" + "/logs/power_off.log");
  EXPECT_THAT(said, ::testing::HasSubstr("good night"));
}

TEST_F(PowerOff, WithoutACommandIsATearDown) {
  ASSERT_NO_FATAL_FAILURE(Start(""));
  EXPECT_TRUE(CallTrigger("poweroff").success);
  EXPECT_EQ(up_->Wait().exit, 0);
  EXPECT_THAT(Musher({"history", "--journal", folder_ / "state" + "/journal.sqlite"}).out,
              ::testing::HasSubstr("no command is configured"));
}

}  // namespace musher::testing::power_test
