// `musher history`, of a controller that leads and from its journal.

#include <signal.h>

#include <algorithm>

#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing::history_test {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

class History : public MachineByCli {
 protected:
  static std::ptrdiff_t Lines(const std::string& text) {
    return std::count(text.begin(), text.end(), '\n');
  }
};

TEST_F(History, CanBeFilteredByActuatorAndTime) {
  ASSERT_EQ(UpDetached().exit, 0);
  const Ended legs = Musher({"history", "--actuator", "legs"});
  EXPECT_EQ(legs.exit, 0) << legs.err;
  EXPECT_THAT(legs.out, HasSubstr("legs started (pid"));
  EXPECT_THAT(legs.out, Not(HasSubstr("voice started")));
  EXPECT_EQ(Musher({"history", "--until", "1d"}).out, "");
}

TEST_F(History, LimitIsOfWhatMatchesAndZeroIsAll) {
  ASSERT_EQ(UpDetached().exit, 0);
  ASSERT_EQ(Musher({"down"}).exit, 0);
  const std::string journal = folder_ / "state/journal.sqlite";
  const Ended two = Musher({"history", "--journal", journal, "--actuator", "legs", "--lines", "2"});
  EXPECT_EQ(Lines(two.out), 2);
  EXPECT_THAT(two.out, HasSubstr("legs"));
  const Ended all = Musher({"history", "--journal", journal, "--lines", "0"});
  EXPECT_GT(Lines(all.out), 10);
}

TEST_F(History, IsReadFromTheDiskWhenNoControllerLeads) {
  ASSERT_EQ(UpDetached().exit, 0);
  ASSERT_EQ(Musher({"down"}).exit, 0);
  std::vector<std::string> words = Command({"history", "--why"});
  words.insert(words.begin(), {"env", "-C", folder_ / ""});
  const Ended history = RunToEnd(words);
  EXPECT_EQ(history.exit, 0) << history.err;
  EXPECT_THAT(history.err, HasSubstr("no controller leads robot now; reading "));
  EXPECT_THAT(history.out, HasSubstr("the machine went to TearDown"));
}

// Each explained the last change of state only, and left the failure out.
TEST_F(History, NamesTheReasonOfAFailedStart) {
  Does("legs", "[state.SelfCheck]\nshell = \"echo no power; exit 7\"\n");
  ASSERT_EQ(UpDetached().exit, 1);
  const Ended why = Musher({"history", "--why"});
  EXPECT_EQ(why.exit, 0) << why.err;
  EXPECT_THAT(why.out, AllOf(HasSubstr("  last failure: "), HasSubstr("no power")));
}

TEST_F(History, NamesTheReasonOfAnUndoneSwitchFirst) {
  const std::string broken = folder_ / "broken";
  Does("legs",
       "[state.Active]\nshell = \"[ ! -e " + broken + " ] || { echo no brake; exit 7; }\"\n");
  ASSERT_EQ(UpDetached().exit, 0);
  ASSERT_EQ(Musher({"set", "LowPower"}).exit, 0);
  std::ofstream(broken) << "yes";
  ASSERT_EQ(Musher({"set", "Active"}).exit, 1);
  const Ended why = Musher({"history", "--why"});
  EXPECT_EQ(why.exit, 0) << why.err;
  EXPECT_THAT(why.out, ContainsRegex("last failure: [^\n]*no brake(.|\n)*"
                                     "the machine went to LowPower"));
  const std::string legs = Musher({"history", "--why", "--actuator", "legs"}).out;
  EXPECT_THAT(legs, ContainsRegex("last failure: [^\n]*no brake")) << legs;
}

TEST_F(History, NamesTheReasonOfASwitchThatLeftAnActuatorBehind) {
  Does("legs", "[state.LowPower]\nshell = \"echo no brake; exit 7\"\n");
  ASSERT_EQ(UpDetached().exit, 0);
  ASSERT_EQ(Musher({"set", "LowPower"}).exit, 1);
  EXPECT_THAT(Musher({"history", "--why"}).out,
              ContainsRegex("the machine went to LowPower [^\n]*no brake"));
}

TEST_F(History, NamesAHangAfterTheRestart) {
  ASSERT_EQ(UpDetached().exit, 0);
  const auto voice = Status()["actuators"]["voice"]["pid"].get<pid_t>();
  kill(voice, SIGSTOP);
  AwaitStatus([voice](const auto& status) {
    const auto& now = status["actuators"]["voice"];
    return now["pid"] != voice && now["state"] == "Active" && now["health"] == "well";
  });
  const Ended why = Musher({"history", "--why"});
  EXPECT_EQ(why.exit, 0) << why.err;
  EXPECT_THAT(why.out, HasSubstr("last failure: voice is degraded: hung: its process is stopped"));
}

TEST_F(History, IsATableForSpreadsheets) {
  ASSERT_EQ(UpDetached().exit, 0);
  const Ended csv = Musher({"history", "--csv", "--lines", "0"});
  EXPECT_THAT(csv.out, StartsWith("time,epoch,switch,kind,actuator,code,message\r\n20"));
  EXPECT_THAT(csv.out, HasSubstr(",legs,0,legs started (pid "));
}

TEST_F(History, FollowsWhatHappens) {
  ASSERT_EQ(UpDetached().exit, 0);
  Process follow(Command({"history", "-f"}));
  ASSERT_NE(follow.LineWith("the machine is Active"), "");
  ASSERT_EQ(Musher({"set", "LowPower"}).exit, 0);
  EXPECT_NE(follow.LineWith("LowPower"), "");
  follow.Signal(SIGINT);
  EXPECT_EQ(follow.Wait().exit, 0);
}

TEST_F(History, FollowsWhereNoEventIsRecentEnoughToBeShown) {
  ASSERT_EQ(UpDetached().exit, 0);
  Process follow(Command({"history", "-f", "--csv", "--since", "0s"}));
  ASSERT_NE(follow.LineWith("time,epoch,"), "");
  ASSERT_EQ(Musher({"set", "LowPower"}).exit, 0);
  const std::string first = follow.LineWith(",");
  EXPECT_THAT(first, HasSubstr("LowPower")) << "nothing from before";
}

}  // namespace musher::testing::history_test
