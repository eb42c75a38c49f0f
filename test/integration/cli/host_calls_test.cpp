// Commands of the controller's host reach it without the network.

#include <signal.h>

#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing::host_calls_test {

using ::testing::HasSubstr;

class CallsOfThisHost : public MachineByCli {
 protected:
  void Start(const std::string& until) {
    up_ = std::make_unique<Process>(Command({"up", config_}));
    ASSERT_NE(up_->LineWith(until), "");
  }
  // A command whose DDS cannot start: its settings name an interface that does not exist.
  static Ended WithoutNetwork(std::vector<std::string> words) {
    std::vector<std::string> command = {
        "env",
        "CYCLONEDDS_URI=<CycloneDDS><Domain><General><Interfaces><NetworkInterface "
        "name=\"none0\"/></Interfaces></General></Domain></CycloneDDS>"};
    for (std::string& word : Command(std::move(words))) command.push_back(std::move(word));
    return Process(command).Wait();
  }

  std::unique_ptr<Process> up_;
};

TEST_F(CallsOfThisHost, NeedNoNetwork) {
  ASSERT_NO_FATAL_FAILURE(Start("eyes: Active done"));
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {"status"}, {"plan", "LowPower"}, {"capabilities"}, {"history"}, {"restart", "voice"}}) {
    const Ended ended = WithoutNetwork(words);
    EXPECT_EQ(ended.exit, 0) << words[0] << ": " << ended.err;
  }
  EXPECT_NE(WithoutNetwork({"set", "LowPower"}).exit, 0) << "or the settings have no effect";
}

// It went by discovery, which takes seconds where the network is flooded or the host is busy.
TEST_F(CallsOfThisHost, TakeTheMachineDownWithoutTheNetwork) {
  ASSERT_NO_FATAL_FAILURE(Start("eyes: Active done"));
  const Ended down = WithoutNetwork({"down"});
  EXPECT_EQ(down.exit, 0) << down.err;
  EXPECT_THAT(down.out, HasSubstr("done: the machine is in TearDown"));
  EXPECT_THAT(down.err, HasSubstr("whether more actuators run in this namespace is not known: "));
  EXPECT_EQ(up_->Wait().exit, 0);
  EXPECT_TRUE(AwaitNoChildren());
}

TEST_F(CallsOfThisHost, GoToTheNextControllerOnceItLeads) {
  ASSERT_NO_FATAL_FAILURE(Start("eyes: Active done"));
  kill(Status()["pid"].get<pid_t>(), SIGKILL);
  up_->Wait();
  EXPECT_NE(WithoutNetwork({"plan", "LowPower"}).exit, 0);
  ASSERT_NO_FATAL_FAILURE(Start("is adopted in Active"));
  EXPECT_EQ(WithoutNetwork({"plan", "LowPower"}).exit, 0);
}

}  // namespace musher::testing::host_calls_test
