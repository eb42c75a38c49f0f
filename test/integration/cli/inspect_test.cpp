// `musher logs`, `describe` and `top` of real processes: with the machine up, with a killed or
// stopped actuator, with the controller dead and with the machine down.

#include <grp.h>
#include <signal.h>
#include <unistd.h>

#include <filesystem>

#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing::inspect_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class Inspect : public MachineByCli {
 protected:
  static pid_t PidOf(const std::string& actuator) {
    return Status()["actuators"][actuator]["pid"].get<pid_t>();
  }
};

TEST_F(Inspect, LogsAreFollowedAcrossARestartAndReadWithTheMachineDown) {
  Does("voice", "[state.SelfCheck]\nshell = \"echo tuned\"\n");
  ASSERT_EQ(UpDetached().exit, 0);
  Process follow(Command({"logs", "-f", "--lines", "1", "voice", "controller"}));
  ASSERT_NE(follow.LineWith("controller"), "");
  ASSERT_EQ(Musher({"restart", "voice"}).exit, 0);
  EXPECT_NE(follow.LineWith("tuned"), "") << "printed after the restart";
  follow.Signal(SIGINT);
  EXPECT_EQ(follow.Wait().exit, 0);
  ASSERT_EQ(Musher({"down"}).exit, 0);

  const Ended down = Musher({"logs", "voice", "--config", config_});
  EXPECT_EQ(down.exit, 0) << down.err;
  EXPECT_THAT(down.out, HasSubstr("tuned"));
  EXPECT_THAT(down.err, HasSubstr("reading " + (folder_ / "state/logs/voice.log")));
  const Ended voice = Musher({"logs", "voice", "--config", config_, "--json", "--lines", "1"});
  EXPECT_TRUE(Json(voice.out)["time"].is_string())
      << "a line without a time of its own was stamped when it was written: " << voice.out;
  const Ended json = Musher({"logs", "controller", "--config", config_, "--json", "--lines", "1"});
  EXPECT_EQ(Json(json.out)["actuator"], "controller");
  EXPECT_TRUE(Json(json.out)["time"].is_string());
}

// After the wall clock was set back, `--since` hid each new line until it had caught up.
TEST_F(Inspect, LogsThatAreFollowedShowNewLinesOfAnyTime) {
  Does("voice", "[state.SelfCheck]\nshell = \"echo '2001-03-01 13:00:05.250 voice: tuned'\"\n");
  ASSERT_EQ(UpDetached().exit, 0);
  Process follow(Command({"logs", "-f", "--since", "1h", "voice", "controller"}));
  ASSERT_NE(follow.LineWith("controller"), "");
  ASSERT_EQ(Musher({"restart", "voice"}).exit, 0);
  EXPECT_NE(follow.LineWith("tuned"), "");
}

// Two of user 65534: one in the group of that number, one in none that the host has.
class AnotherUser : public Inspect {
 protected:
  static Ended As(const std::string& group, std::vector<std::string> words) {
    words.insert(words.begin(),
                 {"setpriv", "--reuid=65534", "--regid=" + group, "--clear-groups", "--"});
    return RunToEnd(words);
  }
  void SetUp() override {
    if (geteuid() != 0 || As("65534", {"test", "-x", BinDir() + "/musher"}).exit != 0) {
      GTEST_SKIP() << "needs root, and programs that another user may run";
    }
    std::filesystem::permissions(folder_.path(), std::filesystem::perms(0755));
  }
};

// `logs` said that no controller leads here, `describe` that the logs are on another host.
TEST_F(AnotherUser, SeesThatTheFilesAreOfAnother) {
  ASSERT_EQ(UpDetached().exit, 0);
  const std::string reason = "a controller of another user leads the machine on this host, and";
  const Ended logs = As("65534", Command({"logs"}));
  EXPECT_EQ(logs.exit, 1) << logs.out;
  EXPECT_THAT(logs.err, AllOf(HasSubstr(reason), HasSubstr("log_group in [controller]")));
  EXPECT_THAT(As("65534", Command({"describe", "legs"})).out, HasSubstr(reason));
  const Ended known = As("65534", Command({"logs", "--config", config_}));
  EXPECT_EQ(known.exit, 1) << known.out;
  EXPECT_THAT(known.err, HasSubstr("this user may not read " + (folder_ / "state/logs") + ": "));
}

TEST_F(AnotherUser, ReadsLogsAndJournalAsAMemberOfTheLogGroup) {
  const group* const entry = getgrgid(65534);  // NOLINT(concurrency-mt-unsafe): one thread
  if (entry == nullptr) GTEST_SKIP() << "this host has no group 65534";
  Replace("state_dir", "log_group = \"" + std::string(entry->gr_name) + "\"\nstate_dir");
  ASSERT_EQ(UpDetached().exit, 0);
  const Ended logs = As("65534", Command({"logs", "controller", "--config", config_}));
  EXPECT_EQ(logs.exit, 0) << logs.err;
  EXPECT_THAT(logs.out, HasSubstr("the machine is Active"));
  EXPECT_THAT(logs.err, Not(HasSubstr("no controller of this host leads it")));
  const std::vector<std::string> journal = {"history", "--journal",
                                            folder_ / "state/journal.sqlite"};
  EXPECT_THAT(As("65534", Command(journal)).out, HasSubstr("the machine is Active"));
  EXPECT_THAT(As("65533", Command({"logs", "--config", config_})).err,
              HasSubstr("this user may not read"));
  EXPECT_NE(As("65534", {"touch", folder_ / "state/more"}).exit, 0);
  EXPECT_NE(As("65534", {"cat", folder_ / "state/controller.lock"}).exit, 0);

  ASSERT_EQ(Musher({"down"}).exit, 0);
  const Ended ended = As("65534", Command(journal));
  EXPECT_EQ(ended.exit, 0) << "no process has it open: " << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("the machine is Active"));
}

TEST_F(Inspect, LogsExplainWhyThereAreNone) {
  const std::string command = "command = [\"musher-exec\", \"" + (folder_ / "eyes") + ".toml\"]\n";
  Drop(command);
  const Ended never = Musher({"logs", "--config", config_});
  EXPECT_EQ(never.exit, 1);
  EXPECT_THAT(never.err, HasSubstr("was never started on this host"));
  EXPECT_THAT(Musher({"logs", "eyes", "--config", config_}).err,
              HasSubstr("gives it no `command`"));
  const Ended wrong = Musher({"logs", "vioce", "--config", config_});
  EXPECT_EQ(wrong.exit, 2);
  EXPECT_THAT(wrong.err, HasSubstr("did you mean 'voice'?"));
}

TEST_F(Inspect, DescribeShowsAnActuatorAndItsStoppedProcess) {
  // A stopped process that may be restarted is killed: on a busy computer before it is described.
  Replace("[actuator.voice]\n", "[actuator.voice]\nrestart = \"no\"\n");
  ASSERT_EQ(UpDetached().exit, 0);
  // Its queries have a second, and it listens for less: on a busy computer an answer may come
  // later.
  Ended well;
  Until([&well] {
    well = Musher({"describe", "legs"});
    return well.out.find("can go to     ") != std::string::npos &&
           well.out.find("capability    guide: ") != std::string::npos &&
           well.out.find("health        well (present)") != std::string::npos;
  });
  EXPECT_EQ(well.exit, 0) << well.err;
  EXPECT_THAT(
      well.out,
      AllOf(HasSubstr("state         Active, for "), HasSubstr("health        well (present)"),
            HasSubstr("can go to     "), HasSubstr("LowPower"), HasSubstr("robot.toml:"),
            HasSubstr("capability    guide: allowed now"), HasSubstr("legs started (pid")));
  EXPECT_TRUE(Until([] {
    return Json(Musher({"describe", "legs", "--json"}).out)["heartbeat"].is_object();
  }));

  const pid_t voice = PidOf("voice");
  kill(voice, SIGSTOP);
  const Ended stopped = Musher({"describe", "voice"});
  EXPECT_THAT(stopped.out, AllOf(HasSubstr("STOPPED by a signal"),
                                 HasSubstr("kill -CONT " + std::to_string(voice))));
  kill(voice, SIGCONT);
  const Ended wrong = Musher({"describe", "lgs"});
  EXPECT_EQ(wrong.exit, 2);
  EXPECT_THAT(wrong.err, HasSubstr("did you mean 'legs'?"));
}

TEST_F(Inspect, DescribeOfAMachineThatIsDownShowsWhatTheFilesKnow) {
  ASSERT_EQ(UpDetached().exit, 0);
  ASSERT_EQ(Musher({"down"}).exit, 0);
  const Ended legs = Musher({"describe", "legs", "--config", config_});
  EXPECT_EQ(legs.exit, 3);
  EXPECT_THAT(legs.out, AllOf(HasSubstr("machine       no controller leads robot now\n"),
                              HasSubstr("legs started (pid"), HasSubstr("musher up " + config_)));
}

TEST_F(Inspect, TopShowsWhatTheProcessesUse) {
  ASSERT_EQ(UpDetached().exit, 0);
  const Ended once = Musher({"top", "--once"});
  EXPECT_EQ(once.exit, 0) << once.err;
  EXPECT_THAT(once.out, AllOf(HasSubstr("robot  Active"), HasSubstr("(controller)"),
                              HasSubstr("legs*"), Not(HasSubstr("\x1b"))));
  // It listens for a second: on a busy computer a heartbeat may come later.
  const auto is_silent = [](const auto& process) {
    return process["actuator"] != "controller" && process["heartbeat_age_s"].is_null();
  };
  nlohmann::json json;
  Until([&] {
    json = Json(Musher({"top", "--once", "--json"}).out);
    return std::none_of(json["processes"].begin(), json["processes"].end(), is_silent);
  });
  ASSERT_EQ(json["processes"].size(), 4U);
  for (const auto& process : json["processes"]) {
    EXPECT_GT(process["memory_bytes"], 0) << process;
    EXPECT_GE(process["cpu_percent"], 0) << process;
    if (process["actuator"] != "controller") {
      EXPECT_GE(process["heartbeat_age_s"], 0) << process;
    }
  }
}

}  // namespace musher::testing::inspect_test
