// Actuators whose processes are ended: by hand, by death, because they hang. They come back to
// where the machine is.

#include <signal.h>

#include <chrono>
#include <filesystem>

#include "musher/base/host.hpp"
#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing::restart_test {

using ::testing::HasSubstr;

class Restart : public MachineByCli {
 protected:
  void Start() {
    up_ = std::make_unique<Process>(Command({"up", config_}));
    ASSERT_NE(up_->LineWith("eyes: Active done"), "");
    voice_ = Voice()["pid"];
  }
  static nlohmann::json Voice() { return Status()["actuators"]["voice"]; }
  static int CountOf(const std::string& words, const std::string& text) {
    int count = 0;
    for (auto at = text.find(words); at != std::string::npos; at = text.find(words, at + 1))
      ++count;
    return count;
  }
  // It has a new process, and is as well as all others.
  void ExpectVoiceIsBack() const {
    const auto voice = Voice();
    EXPECT_NE(voice["pid"], voice_);
    EXPECT_EQ(voice["state"], "Active");
    EXPECT_EQ(voice["health"], "well");
    EXPECT_EQ(voice["degraded"], false) << voice;
    EXPECT_EQ(voice["restarting"], false);
  }

  std::unique_ptr<Process> up_;
  pid_t voice_ = 0;
};

TEST_F(Restart, ByHandEndsWhenTheActuatorIsBack) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const Ended restart = Musher({"restart", "voice"});
  EXPECT_EQ(restart.exit, 0) << restart.err;
  ExpectVoiceIsBack();
  EXPECT_EQ(restart.out,
            "voice is back in Active (pid " + std::to_string(Voice()["pid"].get<int>()) + ")\n");
  EXPECT_EQ(Voice()["restarts"], 0);  // those by hand do not count
}

TEST_F(Restart, ByHandIsRecordedWithThePersonWhoRequestsIt) {
  ASSERT_NO_FATAL_FAILURE(Start());
  ASSERT_EQ(Musher({"restart", "voice"}).exit, 0);
  const std::string requested = "restart of voice requested by " + UserAtHost();
  EXPECT_EQ(CountOf(requested, Musher({"history"}).out), 1);
}

TEST_F(Restart, ByHandExitsWithOneAndTheReasonWhenTheActuatorStaysLost) {
  ASSERT_NO_FATAL_FAILURE(Start());
  Does("voice", "[state.SelfCheck]\nshell = \"echo no sound; exit 7\"\n");
  const Ended restart = Musher({"restart", "voice", "--json"});
  EXPECT_EQ(restart.exit, 1);
  EXPECT_THAT(restart.err, HasSubstr("restart voice: "));
  EXPECT_THAT(Json(restart.out)["error"].get<std::string>(), HasSubstr("SelfCheck failed"));
  EXPECT_EQ(Status()["state"], "Active");
}

TEST_F(Restart, ByHandSuggestsTheNameThatWasMeant) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const Ended restart = Musher({"restart", "vioce"});
  EXPECT_EQ(restart.exit, 2);
  EXPECT_THAT(restart.err,
              HasSubstr("there is no actuator 'vioce'; did you mean 'voice'? There are "
                        "legs, voice and eyes"));
  EXPECT_EQ(Voice()["pid"], voice_);
}

// It waited for 60 s, and then reported that the next controller had not answered.
TEST_F(Restart, ByHandExitsWithFiveAtOnceWhenTheControllerDies) {
  // On a busy computer it takes more than 5 s until the controller is killed.
  const std::string voice = "command = [\"musher-exec\", \"" + (folder_ / "voice");
  Replace("times = [10000, 5000, 5000, 5000, 5000, 5000]\n" + voice,
          "times = [60000, 60000, 60000, 60000, 60000, 60000]\n" + voice);
  Blocks("voice", "SelfCheck");
  Release();
  ASSERT_NO_FATAL_FAILURE(Start());
  std::filesystem::remove(folder_ / "released");
  Process restart(Command({"restart", "voice"}));
  const auto status =
      AwaitStatus([this](const auto& s) { return s["actuators"]["voice"]["pid"] != voice_; });
  const auto controller = status["pid"].get<pid_t>();
  const auto killed = std::chrono::steady_clock::now();
  kill(controller, SIGKILL);
  const Ended ended = restart.Wait();
  EXPECT_LT(std::chrono::steady_clock::now() - killed, std::chrono::seconds(40));
  EXPECT_EQ(ended.exit, 5);
  EXPECT_THAT(ended.err, HasSubstr("the controller (pid " + std::to_string(controller) +
                                   ") has exited before it answered"));
  EXPECT_THAT(ended.err, HasSubstr("shows whether voice is back"));
  Release();
}

TEST_F(Restart, FollowsACrashOfAProcess) {
  ASSERT_NO_FATAL_FAILURE(Start());
  kill(voice_, SIGKILL);
  ASSERT_NE(up_->LineWith("voice is degraded: crashed: "), "");
  ASSERT_NE(up_->LineWith("voice: restarting in 100 ms (1 of 5)"), "");
  ASSERT_NE(up_->LineWith("voice: Active done"), "");
  ExpectVoiceIsBack();
  EXPECT_EQ(Voice()["restarts"], 1);
  EXPECT_THAT(Musher({"status"}).out, HasSubstr("  1 restart\n"));
}

TEST_F(Restart, OfAnActuatorWithAConfigurationErrorWorksOnceItIsFixed) {
  ASSERT_NO_FATAL_FAILURE(Start());
  Does("voice", "[state.Activ]\nrun = [\"true\"]\n");
  kill(voice_, SIGKILL);
  ASSERT_NE(up_->LineWith("voice: restarting in 100 ms"), "");
  const std::string line = up_->LineWith("voice is degraded: exit code 2: ");
  EXPECT_THAT(line, HasSubstr("voice.toml:1:8: error: "));
  EXPECT_THAT(line, HasSubstr("not restarted automatically, because exit code 2 means a "
                              "configuration error; restart it with `musher restart voice`"));
  EXPECT_THAT(Musher({"status"}).out, HasSubstr("exit code 2: "));
  const Ended in_vain = Musher({"restart", "voice"});
  EXPECT_EQ(in_vain.exit, 1);
  EXPECT_THAT(in_vain.err, HasSubstr("voice.toml:1:8: error: "));
  Does("voice", "[state.Active]\nrun = [\"true\"]\n");
  EXPECT_EQ(Musher({"restart", "voice"}).exit, 0);
  ExpectVoiceIsBack();
  const std::string history = Musher({"history"}).out;
  EXPECT_EQ(CountOf("voice started (pid", history), 4)
      << "at first, after its death, and twice by hand:\n"
      << history;
}

// `musher up voice` refers to it.
TEST_F(Restart, ByHandStartsAnActuatorThatHasEnded) {
  const std::string voice = "command = [\"musher-exec\", \"" + (folder_ / "voice");
  Replace(voice, "restart = \"no\"\n" + voice);
  ASSERT_NO_FATAL_FAILURE(Start());
  kill(voice_, SIGKILL);
  AwaitStatus([](const auto& status) { return status["actuators"]["voice"]["pid"].is_null(); });
  const Ended up = Musher({"up", "voice"});
  EXPECT_EQ(up.exit, 2);
  EXPECT_THAT(up.err, HasSubstr("`musher restart voice` an actuator of a machine that runs"));
  const Ended restart = Musher({"restart", "voice"});
  EXPECT_EQ(restart.exit, 0) << restart.err;
  ExpectVoiceIsBack();
}

TEST_F(Restart, FollowsAHangOnceItIsKnownWhatTheProcessWasDoing) {
  ASSERT_NO_FATAL_FAILURE(Start());
  kill(voice_, SIGSTOP);
  ASSERT_NE(up_->LineWith("voice is degraded: hung: its process is stopped"), "");
  ASSERT_NE(up_->LineWith("backtrace of voice:"), "");
  ASSERT_NE(up_->LineWith("killed by SIGKILL"), "");
  ASSERT_NE(up_->LineWith("voice: Active done"), "");
  ExpectVoiceIsBack();
  if (std::system("command -v eu-stack >/dev/null || command -v gdb >/dev/null") != 0)
    GTEST_SKIP() << "no debugger";
  EXPECT_THAT(Musher({"history"}).out, HasSubstr("epoll_wait"));
}

}  // namespace musher::testing::restart_test
