// Completion of a machine that runs: its own names, from any shell of its host.

#include <sstream>

#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing::completion_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

class CompletionOfAMachine : public MachineByCli {
 protected:
  static std::vector<std::string> Offered(std::vector<std::string> words) {
    words.insert(words.begin(), "complete");
    const Ended ended = Musher(std::move(words));
    EXPECT_EQ(ended.exit, 0);
    EXPECT_EQ(ended.err, "");
    std::istringstream lines(ended.out);
    std::vector<std::string> offered;
    for (std::string line; std::getline(lines, line);) {
      offered.push_back(line.substr(0, line.find('\t')));
    }
    return offered;
  }
};

TEST_F(CompletionOfAMachine, OffersItsStatesActuatorsAndCapabilities) {
  ASSERT_EQ(UpDetached().exit, 0);
  EXPECT_THAT(Offered({"set", ""}),
              ElementsAre("TearDown", "SelfCheck", "Active", "LowPower", "OTA"));
  EXPECT_THAT(Offered({"plan", "Active", ""}), ElementsAre("legs", "voice", "eyes"));
  EXPECT_THAT(Offered({"restart", "v"}), ElementsAre("voice"));
  EXPECT_THAT(Offered({"history", "--actuator", "e"}), ElementsAre("eyes"));
  EXPECT_THAT(Offered({"capabilities", ""}), ElementsAre("guide", "talk", "jump"));
  EXPECT_THAT(Offered({"behavior", ""}), IsEmpty()) << "none of them is an application";
  EXPECT_THAT(Offered({"--namespace", "elsewhere", "restart", ""}), IsEmpty());
}

TEST_F(CompletionOfAMachine, OffersItsNamesThoughItsConfigIsRemoved) {
  ASSERT_EQ(UpDetached().exit, 0);
  std::filesystem::remove(config_);
  EXPECT_THAT(Offered({"set", "Active", ""}), ElementsAre("legs", "voice", "eyes"));
  EXPECT_THAT(Offered({"capabilities", "t"}), ElementsAre("talk"));
  EXPECT_THAT(Offered({"set", "Low"}), ElementsAre("LowPower")) << "built in";
}

}  // namespace musher::testing::completion_test
