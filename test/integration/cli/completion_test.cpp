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
  // Completion looks for a machine for half a second, since a person waits at a prompt; on a busy
  // computer it may be in vain, and the key is pressed again.
  static void ExpectOffered(const std::vector<std::string>& words,
                            const ::testing::Matcher<std::vector<std::string>>& expected) {
    std::vector<std::string> offered;
    Until([&] { return ::testing::Value(offered = Offered(words), expected); });
    EXPECT_THAT(offered, expected) << words.front();
  }
};

TEST_F(CompletionOfAMachine, OffersItsStatesActuatorsAndCapabilities) {
  ASSERT_EQ(UpDetached().exit, 0);
  ExpectOffered({"set", ""}, ElementsAre("TearDown", "SelfCheck", "Active", "LowPower", "OTA"));
  ExpectOffered({"plan", "Active", ""}, ElementsAre("legs", "voice", "eyes"));
  ExpectOffered({"restart", "v"}, ElementsAre("voice"));
  ExpectOffered({"history", "--actuator", "e"}, ElementsAre("eyes"));
  ExpectOffered({"capabilities", ""}, ElementsAre("guide", "talk", "jump"));
  EXPECT_THAT(Offered({"behavior", ""}), IsEmpty()) << "none of them is an application";
  EXPECT_THAT(Offered({"--namespace", "elsewhere", "restart", ""}), IsEmpty());
}

TEST_F(CompletionOfAMachine, OffersItsNamesThoughItsConfigIsRemoved) {
  ASSERT_EQ(UpDetached().exit, 0);
  std::filesystem::remove(config_);
  ExpectOffered({"set", "Active", ""}, ElementsAre("legs", "voice", "eyes"));
  ExpectOffered({"capabilities", "t"}, ElementsAre("talk"));
  ExpectOffered({"set", "Low"}, ElementsAre("LowPower"));  // built in
}

}  // namespace musher::testing::completion_test
