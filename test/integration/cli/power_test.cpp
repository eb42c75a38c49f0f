// A robot that is powered off as its app does it, by the real program.

#include <signal.h>

#include <filesystem>
#include <fstream>
#include <future>

#include "musher/base/host.hpp"
#include "musher/controller/process/host_uptime.hpp"
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
  const Ended end = up_->Wait();
  EXPECT_EQ(end.exit, 0) << end.out << end.err;
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

// What the state folder has, as a controller that was killed has left it.
TEST_F(PowerOff, OfAnEarlierBootIsForgottenByAControllerThatItsSupervisorRestarts) {
  const std::string mark = folder_ / "off";
  ASSERT_NO_FATAL_FAILURE(Start("command = [\"touch\", \"" + mark + "\"]\n"));
  const pid_t controller = Status()["pid"];
  const auto restart_after = [&](const std::string& stored, pid_t killed) {
    kill(killed, SIGKILL);
    up_->Wait();
    std::ofstream(folder_ / "state/policy") << stored;
    up_ = std::make_unique<Process>(Command({"up", config_, "--restarted"}));
  };
  restart_after("power off an-earlier-boot 1000\n", controller);
  ASSERT_TRUE(Until([] {
    return Musher({"history"})
               .out.find(
                   "a power-off that was decided before this computer was "
                   "booted is forgotten") != std::string::npos;
  }));
  const auto status = AwaitStatus(AllHaveArrived);
  EXPECT_EQ(status["state"], "Active");
  EXPECT_FALSE(std::filesystem::exists(mark));
  // A crash in the meantime does not end a power-off that was decided just now.
  const std::string host = HostId();
  restart_after("power off " + host.substr(0, host.find('/')) + " " +
                    std::to_string(ToMilliseconds(SinceBoot())) + "\n",
                status["pid"]);
  EXPECT_EQ(up_->Wait().exit, 0);
  EXPECT_TRUE(AwaitFile(mark)) << "the command has not run";
}

}  // namespace musher::testing::power_test
