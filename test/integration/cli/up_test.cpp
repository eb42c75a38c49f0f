// A machine's start and end as a person sees them in a terminal.

#include <signal.h>

#include <algorithm>

#include "musher/test/integration/cli/machine.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::testing::up_test {

using ::testing::HasSubstr;
using ::testing::Not;

class Up : public MachineByCli {};

TEST_F(Up, StaysInTheForegroundAndTakesTheMachineDownOnCtrlC) {
  Process up(Command({"up", config_}));
  EXPECT_NE(up.LineWith("robot: 3 actuators, 6 states, 2 stages"), "");
  EXPECT_NE(up.LineWith("legs started (pid"), "");
  EXPECT_NE(up.LineWith("the machine is Active"), "");
  EXPECT_NE(up.LineWith("eyes: Active done"), "");  // stage 2 comes while the machine is in use
  up.Signal(SIGINT);
  const Ended ended = up.Wait();
  EXPECT_EQ(ended.exit, 0) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("the machine is stopped after"));
  EXPECT_EQ(ended.err, "musher: taking robot down\n");
  EXPECT_TRUE(AwaitNoChildren());
}

TEST_F(Up, StopsAMachineWhoseConfigDoesNotListTearDown) {
  for (int i = 0; i < 4; ++i) Drop("\"TearDown\", ");  // of the machine and of each actuator
  for (int i = 0; i < 3; ++i) Replace("[10000, 5000,", "[9000,");
  Process up(Command({"up", config_}));
  ASSERT_NE(up.LineWith("eyes: Active done"), "");
  up.Signal(SIGINT);
  const Ended ended = up.Wait();
  EXPECT_EQ(ended.exit, 0) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("gets SIGTERM"));
  EXPECT_TRUE(AwaitNoChildren());
}

TEST_F(Up, ExitsWithOneAndTheReasonIfAnActuatorFailsToTearDown) {
  Does("voice", "[state.TearDown]\nrun = [\"false\"]\n");
  Process up(Command({"up", config_}));
  ASSERT_NE(up.LineWith("eyes: Active done"), "");
  up.Signal(SIGINT);
  const Ended ended = up.Wait();
  EXPECT_EQ(ended.exit, 1);
  EXPECT_THAT(ended.err, HasSubstr("musher: the machine is stopped after"));
  EXPECT_THAT(ended.err, HasSubstr("; voice: failed with"));
}

TEST_F(Up, ShowsOnATerminalWhichActuatorsAreStillStarting) {
  Blocks("legs", "SelfCheck");
  Process up(OnATerminal({"up", config_, "--detach", "--color=never"}));
  const std::string legs = up.LineWith(" s of 60 s");
  EXPECT_THAT(legs, ::testing::StartsWith("legs "));
  EXPECT_THAT(legs, HasSubstr("SetUp → SelfCheck"));
  Release();
  const Ended ended = up.Wait();
  EXPECT_EQ(ended.exit, 0);
  const std::string behind_the_table = ended.out.substr(ended.out.rfind("\x1b[?7h"));
  EXPECT_THAT(behind_the_table, HasSubstr("\x1b[A\x1b[K")) << "the table is not erased";
  EXPECT_THAT(ended.out, HasSubstr("robot is up; the controller"));
}

TEST_F(Up, ReportsOnASecondCtrlCThatItIsAlreadyStopping) {
  Blocks("legs", "TearDown");
  Process up(Command({"up", config_}));
  ASSERT_NE(up.LineWith("the machine is Active"), "");
  up.Signal(SIGTERM);
  ASSERT_NE(up.LineWith("Active → TearDown"), "");
  up.Signal(SIGINT);
  EXPECT_TRUE(up.AwaitError("is already being taken down"));
  Release();
  const Ended ended = up.Wait();
  EXPECT_EQ(ended.exit, 0);
  EXPECT_EQ(ended.err, "musher: taking robot down\nmusher: robot is already being taken down\n");
}

TEST_F(Up, PrintsALineOfJsonForEachEvent) {
  Process up(Command({"up", config_, "--json"}));
  const auto start_up = Json(up.LineWith(R"("kind":"start-up")"));
  EXPECT_EQ(start_up["code"], 0);
  up.Signal(SIGINT);
  const Ended ended = up.Wait();
  std::istringstream lines(ended.out);
  std::string last_kind;
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) last_kind = Json(line)["kind"];
  EXPECT_GT(count, 10);
  EXPECT_EQ(last_kind, "stopped");
}

// The controller had no descriptor left for /dev/null, and kept the stderr whose reader then waited
// for ever.
TEST_F(Up, ReturnsDetachedAlsoWithFewFileDescriptors) {
  for (const int files : {18, 20, 22, 24}) {
    auto up = Command({"up", config_, "--detach"});
    up.insert(up.begin(), {"prlimit", "--nofile=" + std::to_string(files)});
    EXPECT_NE(RunToEnd(up).exit, 0) << files;
    KillChildren();
    std::filesystem::remove_all(folder_ / "state");
  }
}

TEST_F(Up, LeavesTheMachineUpWhenItIsDetached) {
  const Ended up = UpDetached();
  EXPECT_EQ(up.exit, 0) << up.err;
  EXPECT_THAT(up.out, HasSubstr("robot is up; the controller (pid "));
  EXPECT_EQ(Status()["state"], "Active");
  const Ended down = Musher({"down"});
  EXPECT_EQ(down.exit, 0) << down.err;
  EXPECT_THAT(down.out, HasSubstr("done: the machine is in TearDown"));
  EXPECT_EQ(Musher({"status"}).exit, 3);
}

// A crash of the controller in the middle of TearDown

TEST_F(Up, ASupervisorsStartFinishesATearDownThatACrashInterruptedAndStaysDown) {
  Blocks("legs", "TearDown");
  ASSERT_EQ(UpDetached().exit, 0);
  const pid_t controller = Status()["pid"];
  Process down(Command({"down"}));
  AwaitStatus([](const auto& s) { return s["actuators"]["voice"]["presence"] == "lost"; });
  kill(controller, SIGKILL);
  ASSERT_TRUE(AwaitEnd(controller));
  Process again(Command({"up", config_, "--restarted"}));
  EXPECT_NE(again.LineWith("this start by a supervisor finishes that TearDown"), "");
  Release();
  const Ended ended = again.Wait();
  EXPECT_EQ(ended.exit, 0) << ended.err << "as systemd would start it again otherwise";
  EXPECT_THAT(ended.out, Not(HasSubstr("the machine is Active")));
  down.Signal(SIGINT);  // its controller has exited
  down.Wait();
  EXPECT_TRUE(AwaitNoChildren());
  // Nor does the next one, with nothing left that runs.
  EXPECT_EQ(Musher({"up", config_, "--restarted"}).exit, 0);
  EXPECT_EQ(Musher({"status"}).exit, 3);
  // A person's start clears it.
  EXPECT_EQ(UpDetached().exit, 0);
  EXPECT_EQ(Status()["state"], "Active");
}

// --- rules of the user ---

TEST_F(Up, RefusesRulesThatHaveAnErrorWhereAPersonStartsIt) {
  std::ofstream(config_, std::ios::app) << "[safety]\nrules = \"rules.txt\"\n";
  std::ofstream(folder_ / "rules.txt") << "never leg Active\n";
  const Ended refused = Musher({"up", config_, "--detach"});
  EXPECT_EQ(refused.exit, 2);
  EXPECT_THAT(refused.err, HasSubstr("rules.txt:1:7: error: "));
  // They only report: what a supervisor starts again does without them.
  Process up(Command({"up", config_, "--restarted"}));
  EXPECT_TRUE(up.AwaitError("the rules of [safety] are not checked: "));
  EXPECT_NE(up.LineWith("the machine is Active"), "");
  up.Signal(SIGINT);
  EXPECT_EQ(up.Wait().exit, 0);
}

TEST_F(Up, RecordsARuleThatIsViolatedAndChangesNothing) {
  std::ofstream(config_, std::ios::app) << "[safety]\nrules = \"rules.txt\"\n";
  std::ofstream(folder_ / "rules.txt") << "never machine Active while voice is Active\n";
  ASSERT_EQ(UpDetached().exit, 0);
  Ended history;
  EXPECT_TRUE(Until([&] {
    history = Musher({"history", "--event", "rule_violated"});
    return history.out.find("never machine Active while voice is Active") != std::string::npos;
  })) << history.out
      << history.err;
  EXPECT_EQ(Status()["state"], "Active");
  EXPECT_EQ(Status()["violated_rules"].dump(), R"(["never machine Active while voice is Active"])");
  EXPECT_THAT(Musher({"status"}).out, HasSubstr("a rule of yours is violated: never machine"));
}

// The start-up has failed before the controller's owner has the controller.
TEST_F(Up, ReportsAFirstStageOfWhichNothingCouldBeStarted) {
  std::string config = ReadFile(config_);
  for (std::size_t at = 0; (at = config.find("\"musher-exec\"", at)) != std::string::npos;) {
    config.replace(at, 13, "\"nosuchprogram\"");
  }
  for (std::size_t at = 0; (at = config.find("[actuator.", at)) != std::string::npos;) {
    at = config.find('\n', at) + 1;
    config.insert(at, "restart = \"no\"\n");
  }
  std::ofstream(config_) << config;
  const Ended up = Musher({"up", config_, "--detach"});
  EXPECT_EQ(up.exit, 1);
  EXPECT_THAT(up.err, HasSubstr("nosuchprogram"));
  EXPECT_EQ(Status()["phase"], "failed");
}

TEST_F(Up, AfterARestartOfItsServiceTheMachineIsUp) {
  Process first(Command({"up", config_, "--restarted"}));
  ASSERT_NE(first.LineWith("the machine is Active"), "");
  first.Signal(SIGTERM);
  EXPECT_EQ(first.Wait().exit, 0);
  Process second(Command({"up", config_, "--restarted"}));
  EXPECT_NE(second.LineWith("the machine is Active"), "");
}

// It hangs in no state of its own: the whole process stands still, and nothing here may end it.
TEST_F(Up, DownNamesTheActuatorThatItCannotReachAndExitsWithOne) {
  std::string config = ReadFile(config_);
  const std::string command = "command = [\"musher-exec\", \"" + (folder_ / "voice") + ".toml\"]\n";
  config.erase(config.find(command), command.size());
  std::ofstream(config_) << config;
  Process voice({BinDir() + "/musher-exec", folder_ / "voice.toml", "--config", config_,
                 "--actuator", "voice"});
  ASSERT_EQ(UpDetached().exit, 0);
  voice.Signal(SIGSTOP);
  AwaitStatus([](const auto& s) { return s["actuators"]["voice"]["presence"] == "lost"; });
  const Ended down = Musher({"down"});
  EXPECT_EQ(down.exit, 1);
  EXPECT_THAT(down.err, HasSubstr("voice"));
  EXPECT_THAT(down.err, HasSubstr("may still run in Active"));
  voice.Signal(SIGCONT);
}

TEST_F(Up, CanFollowDownAtOnce) {
  for (int i = 0; i < 3; ++i) {
    const Ended up = UpDetached();
    ASSERT_EQ(up.exit, 0) << up.err;
    ASSERT_EQ(Musher({"down"}).exit, 0);
  }
}

TEST_F(Up, CanFollowTheDownOfAFailedStartAtOnce) {
  Does("legs", "[state.SelfCheck]\nrun = [\"false\"]\n");
  for (int i = 0; i < 6; ++i) {
    const Ended up = Musher({"up", config_});
    ASSERT_EQ(up.exit, 1) << up.err;
    EXPECT_THAT(up.err, HasSubstr("stay up for inspection")) << i;
    const Ended down = Musher({"down"});
    ASSERT_LE(down.exit, 1) << down.err;
    EXPECT_THAT(down.err, Not(HasSubstr("has not exited yet")));
  }
}

TEST_F(Up, LeavesAFailedStartForInspection) {
  Does("legs", "module = 3000\n[state.SelfCheck]\nrun = [\"sh\", \"-c\", \"exit 9\"]\n");
  const Ended up = Musher({"up", config_});
  EXPECT_EQ(up.exit, 1);
  EXPECT_THAT(up.err, HasSubstr("critical legs: 3009 (MotionManager: SelfCheckFailed)"));
  EXPECT_THAT(up.err, HasSubstr("stay up for inspection"));
  const auto status = Status();
  EXPECT_EQ(status["phase"], "failed");
  EXPECT_EQ(status["state"], "SelfCheck");
  EXPECT_EQ(status["actuators"]["legs"]["code"], 3009);
  EXPECT_EQ(status["actuators"]["voice"]["presence"], "present");
  EXPECT_NE(Musher({"down"}).exit, 3);
  EXPECT_EQ(Musher({"status"}).exit, 3);
}

TEST_F(Up, ReportsAnInvalidConfigOfAModuleAtOnce) {
  Does("legs", "[state.Activ]\nrun = [\"true\"]\n");
  const Ended up = Musher({"up", config_});
  EXPECT_EQ(up.exit, 1);
  EXPECT_THAT(up.err, HasSubstr("critical legs: "));
  EXPECT_THAT(up.err, HasSubstr("legs.toml:1:8: error: "));
  EXPECT_THAT(up.err, HasSubstr("because exit code 2 means a configuration error; restart it with "
                                "`musher restart legs`"));
  EXPECT_THAT(up.out, Not(HasSubstr(": restarting in")));
  Does("legs", "[state.Active]\nrun = [\"true\"]\n");
  EXPECT_EQ(Musher({"restart", "legs"}).exit, 0);
  EXPECT_EQ(Musher({"set", "SelfCheck"}).exit, 0);
  EXPECT_EQ(Musher({"set", "Active"}).exit, 0);
  EXPECT_EQ(Status()["state"], "Active");
  const Ended down = Musher({"down"});
  EXPECT_EQ(down.exit, 0) << down.out << down.err;
}

TEST_F(Up, ExitsWithOneWhenItIsStoppedBeforeTheMachineIsUp) {
  Does("legs", "[state.SetUp]\nshell = \"sleep 5\"\n");
  Process up(Command({"up", config_}));
  ASSERT_NE(up.LineWith("legs started (pid"), "");
  up.Signal(SIGINT);
  const Ended ended = up.Wait();
  EXPECT_EQ(ended.exit, 1);
  EXPECT_THAT(ended.err, HasSubstr("stopped before it was up"));
}

TEST_F(Up, RefusesAMachineThatHasAControllerAndNamesIt) {
  ASSERT_EQ(UpDetached().exit, 0);
  const auto before = Status();
  const Ended second = Musher({"up", config_});
  EXPECT_EQ(second.exit, 2);
  EXPECT_THAT(second.err, HasSubstr("process " + std::to_string(before["pid"].get<int>())));
  const Ended json = Musher({"up", config_, "--json"});
  EXPECT_EQ(json.exit, 2);
  EXPECT_EQ(Json(json.out)["code"], 111);
  EXPECT_EQ(Status()["epoch"], before["epoch"]);  // it was not disturbed
}

TEST_F(Up, LosesItsControllerWithItsLauncherButKeepsTheActuators) {
  pid_t legs = 0;
  {
    Process up(Command({"up", config_}));
    ASSERT_NE(up.LineWith("eyes: Active done"), "");
    legs = Status()["actuators"]["legs"]["pid"];
    up.Signal(SIGKILL);
    EXPECT_EQ(up.Wait().exit, -1);
  }
  Process again(Command({"up", config_}));
  EXPECT_NE(again.LineWith("the machine is adopted in Active"), "");
  EXPECT_EQ(Status()["actuators"]["legs"]["pid"], legs);
  again.Signal(SIGINT);
  EXPECT_EQ(again.Wait().exit, 0);
}

TEST_F(Up, ReportsThatItsControllerHasCrashed) {
  Process up(Command({"up", config_}));
  ASSERT_NE(up.LineWith("the machine is Active"), "");
  kill(Status()["pid"].get<pid_t>(), SIGKILL);
  const Ended ended = up.Wait();
  EXPECT_EQ(ended.exit, 1);
  EXPECT_THAT(ended.err, HasSubstr("the controller of robot has crashed (killed by SIGKILL)"));
}

TEST_F(Up, CompletesATearDownInWhichItsPredecessorCrashed) {
  for (const char* slow : {"legs", "voice"}) Blocks(slow, "TearDown");
  Process first(Command({"up", config_}));
  ASSERT_NE(first.LineWith("eyes: Active done"), "");
  const pid_t controller = Status()["pid"];
  first.Signal(SIGINT);
  ASSERT_NE(first.LineWith("eyes: TearDown done"), "");
  AwaitStatus([](const auto& status) {  // stage 1 follows stage 2
    return status["actuators"]["legs"]["target"] == "TearDown" &&
           status["actuators"]["voice"]["target"] == "TearDown";
  });
  kill(controller, SIGKILL);
  ASSERT_EQ(first.Wait().exit, 1);
  Process up(Command({"up", config_}));
  EXPECT_NE(up.LineWith("ended during TearDown; this one finishes it"), "");
  Release();
  const Ended second = up.Wait();
  EXPECT_EQ(second.exit, 1);
  EXPECT_THAT(second.out, HasSubstr("the machine is stopped"));
  EXPECT_THAT(second.err, Not(HasSubstr("stay up for inspection")));
  EXPECT_TRUE(AwaitNoChildren());
}

TEST_F(Up, FindsProgramsBesideItself) {
  setenv("PATH", "/usr/bin:/bin", 1);  // without musher-exec
  EXPECT_EQ(UpDetached().exit, 0);
}

TEST_F(Up, WritesALogBesideTheJournal) {
  ASSERT_EQ(UpDetached().exit, 0);
  ASSERT_EQ(Musher({"down"}).exit, 0);
  const std::string log = ReadFile(folder_ / "state/controller.log");
  EXPECT_THAT(log, HasSubstr(" info: legs started (pid "));
  EXPECT_THAT(log, HasSubstr(" info: the machine is stopped after "));
}

}  // namespace musher::testing::up_test
