// What a person reads when an actuator does not come up, or ends by itself.

#include <sys/stat.h>

#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing::reasons_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class Reasons : public MachineByCli {
 protected:
  // voice runs these words instead of musher-exec with its file.
  void VoiceRuns(const std::string& words) const {
    Replace("command = [\"musher-exec\", \"" + (folder_ / "voice") + ".toml\"]",
            "command = [" + words + "]");
  }
};

TEST_F(Reasons, CheckReadsTheFilesOfMusherExecToo) {
  Does("legs", "[state.Activ]\nrun = [\"true\"]\n");
  const Ended check = Musher({"check", config_});
  EXPECT_EQ(check.exit, 2);
  EXPECT_THAT(check.out, AllOf(HasSubstr("in 'actuator.legs': 'command'"),
                               HasSubstr("legs.toml:1:8: error: "), Not(HasSubstr("ok:"))));
  Does("legs", "[state.Active]\nrun = [\"true\"]\n");
  EXPECT_EQ(Musher({"check", config_}).exit, 0);
}

TEST_F(Reasons, AProgramThatIsNoModuleIsToBeWrapped) {
  Replace("times = [10000, 5000, 5000, 5000, 5000, 5000]\ncommand = [\"musher-exec\", \"" +
              (folder_ / "voice"),
          "times = [4000, 5000, 5000, 5000, 5000, 5000]\ncommand = [\"musher-exec\", \"" +
              (folder_ / "voice"));
  VoiceRuns("\"tail\", \"-f\", \"/dev/null\"");
  const Ended up = Musher({"up", config_, "--detach"});
  const std::string note = Status()["actuators"]["voice"]["message"];
  EXPECT_THAT(
      note,
      AllOf(
          HasSubstr("its program runs (process "),
          HasSubstr("but did not announce itself as actuator voice within 4000 ms"),
          HasSubstr("it is idle and does not hold the name of the actuator, so it is not a Musher "
                    "module, or one of another name: wrap it with musher-exec"),
          HasSubstr("command = [\"musher-exec\", \"--\", \"tail\", \"-f\", \"/dev/null\"]")));
}

TEST_F(Reasons, StatusReportsAProgramThatExitedByItself) {
  Replace("\ncommand = [\"musher-exec\", \"" + (folder_ / "voice"),
          "\nrestart = \"no\"\ncommand = [\"musher-exec\", \"" + (folder_ / "voice"));
  // Release() opens and closes it, and cat ends.
  ASSERT_EQ(mkfifo((folder_ / "released").c_str(), 0600), 0);
  VoiceRuns("\"musher-exec\", \"--\", \"cat\", \"" + (folder_ / "released") + "\"");
  ASSERT_EQ(UpDetached().exit, 0);
  Release();
  const auto status = AwaitStatus([](const auto& s) {
    const std::string message = s["actuators"]["voice"]["message"];
    return message.find("exit code") != std::string::npos;
  });
  EXPECT_THAT(status["actuators"]["voice"]["message"].get<std::string>(),
              AllOf(HasSubstr("the program exited by itself: exit code 0"),
                    Not(HasSubstr("connection lost"))));
}

TEST_F(Reasons, PythonUnderMusherExecPrintsAtOnce) {
  Does("voice", "[state.SetUp]\nrun = [\"sh\", \"-c\", \"echo unbuffered=$PYTHONUNBUFFERED\"]\n");
  ASSERT_EQ(UpDetached().exit, 0);
  const std::string log = ReadFile(folder_ / "state/logs/voice.log");
  EXPECT_THAT(log, HasSubstr("unbuffered=1"));
}

TEST_F(Reasons, UpCountsTheRestartsOfAProgramThatEndsAtOnceAndNamesItsReasonOnce) {
  Replace("command = [\"musher-exec\", \"" + (folder_ / "voice") + ".toml\"]",
          "command = [\"sh\", \"-c\", \"echo no board found >&2; exit 1\"]\n"
          "restart_delay_ms = 10\nrestart_limit = 3");
  const Ended up = Musher({"up", config_, "--detach"});
  EXPECT_EQ(up.exit, 0) << up.err;
  const auto times = [&up](const std::string& words) {
    int found = 0;
    for (std::size_t at = 0; (at = up.out.find(words, at)) != std::string::npos; ++at) ++found;
    return found;
  };
  EXPECT_EQ(times("voice: repeated 2 times\n"), 1) << up.out;
  EXPECT_EQ(times("voice started (pid "), 1) << up.out;
  EXPECT_EQ(times("no board found"), 2) << "how it ended, and that it is degraded\n" << up.out;
  EXPECT_EQ(
      times("voice is degraded: given up after 3 restarts, until `musher restart voice`; as above"),
      1)
      << up.out;
  const std::string log = ReadFile(folder_ / "state/controller.log");
  EXPECT_THAT(log, HasSubstr("voice: restarting in 40 ms (3 of 3)"));
}

// setsid makes it a session, and so a process group, of its own. tail would end by itself when the
// pipe that a command of musher-exec writes to has no reader any more.
TEST_F(Reasons, AChildThatBecameADaemonEndsWithItsModule) {
  const std::string fifo = folder_ / "fifo";
  ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
  Does("voice", "[state.SetUp]\nshell = \"setsid -f sh -c 'echo $$ > " + fifo +
                    "; exec tail -f /dev/null > /dev/null 2>&1'; cat " + fifo + " > " +
                    (folder_ / "daemon") + "\"\n");
  ASSERT_EQ(UpDetached().exit, 0);
  pid_t daemon = 0;
  std::ifstream(folder_ / "daemon") >> daemon;
  ASSERT_GT(daemon, 0);
  ASSERT_EQ(kill(daemon, 0), 0);
  ASSERT_EQ(Musher({"restart", "voice"}).exit, 0);
  EXPECT_TRUE(AwaitEnd(daemon));
  EXPECT_EQ(Musher({"down"}).exit, 0);
  EXPECT_TRUE(AwaitNoChildren());
}

}  // namespace musher::testing::reasons_test
