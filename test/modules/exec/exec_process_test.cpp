// musher-exec as a controller drives it: the real program over DDS.

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "musher/base/unique_fd.hpp"
#include "musher/test/modules/exec/exec_peer.hpp"
#include "musher/test/modules/exec/processes.hpp"
#include "musher/transport/network.hpp"
#include "musher/transport/ros_environment.hpp"

namespace musher::exec::exec_process_test {

using ::testing::HasSubstr;

// A program that prints its pid to a file in the test's folder and runs until it is stopped.
constexpr const char* kProgram = R"(
stop_ms = 20000
module = 3000
[state.SetUp]
start = ["sh", "-c", "echo $$ > $MUSHER_TEST/program; exec sleep infinity"]
)";

TEST(MusherExec, IsSetUpRunsItsStatesAndIsTornDown) {
  ExecPeer peer;
  peer.Start(std::string(kProgram) + "[state.Active]\nshell = \"echo on > $MUSHER_TEST/active\"\n");
  ASSERT_TRUE(peer.AwaitVisible()) << peer.Output();
  EXPECT_EQ(peer.report().pid, peer.pid());
  const pid_t program = ReadPid(peer.folder() / "program");
  ASSERT_GT(program, 0);

  const auto active = peer.Switch("Active");
  ASSERT_TRUE(active);
  EXPECT_EQ(active.value().verdict, msg::ActuatorCommand::kVerdictDone);
  EXPECT_EQ(active.value().status.state, "Active");
  EXPECT_EQ(access((peer.folder() / "active").c_str(), F_OK), 0);

  const auto torn_down = peer.Switch("TearDown");
  ASSERT_TRUE(torn_down);
  EXPECT_EQ(torn_down.value().verdict, msg::ActuatorCommand::kVerdictDone);
  EXPECT_EQ(peer.AwaitExit(), 0) << peer.Output();
  EXPECT_TRUE(HasExited(program));
}

// Its log has a size limit where the controller has one, and the line that names a missing
// [emergency_stop] ended it.
TEST(MusherExec, RunsOnWhereAFileHasReachedItsSizeLimit) {
  ExecPeer peer;
  peer.Start(kProgram);
  ASSERT_TRUE(peer.AwaitVisible()) << peer.Output();
  ASSERT_EQ(kill(peer.pid(), SIGXFSZ), 0);
  const auto active = peer.Switch("Active");
  ASSERT_TRUE(active);
  EXPECT_EQ(active.value().verdict, msg::ActuatorCommand::kVerdictDone);
}

// `ros2 service call` as a command did not meet the machine without settings in the state config.
TEST(MusherExec, GivesItsCommandsTheSettingsThatARos2ProgramNeeds) {
  for (const char* name : {"CYCLONEDDS_URI", "MUSHER_TRANSPORT"}) unsetenv(name);
  setenv("RMW_IMPLEMENTATION", "rmw_of_the_person", 1);
  ExecPeer peer;
  peer.Start("[state.Active]\nshell = \"env > $MUSHER_TEST/env\"\n");
  unsetenv("RMW_IMPLEMENTATION");
  ASSERT_TRUE(peer.AwaitVisible()) << peer.Output();
  ASSERT_TRUE(peer.Switch("Active"));
  std::ifstream file(peer.folder() / "env");
  const std::string environment{std::istreambuf_iterator<char>(file), {}};
  EXPECT_THAT(environment,
              HasSubstr(std::string("CYCLONEDDS_URI=") + transport::kRosOnLoopback + "\n"));
  EXPECT_THAT(environment, HasSubstr("RMW_IMPLEMENTATION=rmw_of_the_person\n"));
}

TEST(MusherExec, GivesItsCommandsTheInterfacesOfTheProfileLan) {
  unsetenv("CYCLONEDDS_URI");
  setenv("MUSHER_TRANSPORT", "lan", 1);
  const std::string settings =
      transport::RosOnInterfaces(transport::OuterInterfaces(TransportProfile::kLan, {}));
  ExecPeer peer;
  peer.Start("[state.Active]\nshell = \"env > $MUSHER_TEST/env\"\n");
  const bool visible = peer.AwaitVisible();
  unsetenv("MUSHER_TRANSPORT");
  ASSERT_TRUE(visible) << peer.Output();
  ASSERT_TRUE(peer.Switch("Active"));
  std::ifstream file(peer.folder() / "env");
  const std::string environment{std::istreambuf_iterator<char>(file), {}};
  EXPECT_THAT(environment, HasSubstr("CYCLONEDDS_URI=" + settings + "\n"));
}

TEST(MusherExec, AnswersWithTheCodeAndTheReasonOfAFailingCommand) {
  ExecPeer peer;
  peer.Start(std::string(kProgram) +
             "[state.SelfCheck]\nshell = \"echo motor 7 is hot; exit 9\"\n");
  ASSERT_TRUE(peer.AwaitVisible()) << peer.Output();
  const auto reply = peer.Switch("SelfCheck");
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply.value().verdict, msg::ActuatorCommand::kVerdictFailed);
  EXPECT_EQ(reply.value().code, 3009);
  EXPECT_EQ(reply.value().message,
            "exit code 9 of `echo motor 7 is hot; exit 9`; last output: motor 7 is hot")
      << "the last line alone is often no reason: `done in 3 s`";
  EXPECT_EQ(reply.value().status.state, "SetUp");
  EXPECT_THAT(peer.Output(), HasSubstr("motor 7 is hot"));
}

TEST(MusherExec, EndsWithTheReasonWhenSetUpFails) {
  ExecPeer peer;
  peer.Start("module = 3000\n[state.SetUp]\nshell = \"echo no port; exit 12\"\n");
  EXPECT_EQ(peer.AwaitExit(), 1);
  EXPECT_THAT(peer.Output(), HasSubstr("3012"));
  EXPECT_THAT(peer.Output(), HasSubstr("no port"));
}

TEST(MusherExec, IsBusyWithASlowCommandAndStopsItOnRequest) {
  ExecPeer peer;
  peer.Start(std::string(kProgram) +
             "[state.Active]\nshell = \"echo $$ > $MUSHER_TEST/slow; exec sleep infinity\"\n");
  ASSERT_TRUE(peer.AwaitVisible()) << peer.Output();
  peer.Send("Active");
  const pid_t slow = ReadPid(peer.folder() / "slow");
  ASSERT_GT(slow, 0);
  EXPECT_FALSE(peer.reply());

  const auto answer = peer.Query();
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer.value().status.target, "Active");
  ASSERT_TRUE(peer.AwaitReply());
  ASSERT_TRUE(*peer.reply());
  EXPECT_EQ(peer.reply()->value().code, 3007);
  EXPECT_TRUE(HasExited(slow));
  EXPECT_EQ(peer.Switch("LowPower").value().status.state, "LowPower");
}

TEST(MusherExec, ExitsAtOnceWithAMessageWhenItsProgramCrashes) {
  ExecPeer peer;
  peer.Start(std::string(kProgram) +
             "[state.Active]\nshell = \"trap '' TERM; echo $$ > $MUSHER_TEST/slow; "
             "while :; do sleep 1; done\"\n");
  ASSERT_TRUE(peer.AwaitVisible()) << peer.Output();
  peer.Send("Active");
  const pid_t slow = ReadPid(peer.folder() / "slow");
  ASSERT_GT(slow, 0);
  const pid_t program = ReadPid(peer.folder() / "program");
  ASSERT_GT(program, 0);
  kill(program, SIGSEGV);
  EXPECT_EQ(peer.AwaitExit(), 1);
  EXPECT_THAT(peer.Output(),
              HasSubstr("motion: warning: the program exited by itself: killed by SIGSEGV"));
  EXPECT_TRUE(HasExited(slow));
}

TEST(MusherExec, LeavesNothingBehindWhenItIsKilled) {
  ExecPeer peer;
  peer.Start(R"([state.SetUp]
start = ["sh", "-c", "sleep infinity & echo $! > $MUSHER_TEST/child; echo $$ > $MUSHER_TEST/program; wait"]
)");
  ASSERT_TRUE(peer.AwaitVisible()) << peer.Output();
  const pid_t program = ReadPid(peer.folder() / "program");
  const pid_t child = ReadPid(peer.folder() / "child");
  ASSERT_GT(program, 0);
  ASSERT_GT(child, 0);
  peer.Signal(SIGKILL);
  EXPECT_EQ(peer.AwaitExit(), -SIGKILL);
  EXPECT_TRUE(HasExited(program));
  EXPECT_TRUE(HasExited(child));
}

TEST(MusherExec, ThatIsKilledInActiveRunsTheCommandOfActiveOnlyWhenItIsSwitchedThereAgain) {
  ExecPeer peer;
  const std::string file = "[state.Active]\nshell = \"echo on >> $MUSHER_TEST/active\"\n";
  const auto runs = [&peer] {
    std::ifstream lines(peer.folder() / "active");
    return std::count(std::istreambuf_iterator<char>(lines), {}, '\n');
  };
  peer.Start(file);
  ASSERT_TRUE(peer.AwaitVisible()) << peer.Output();
  ASSERT_TRUE(peer.Switch("Active"));
  EXPECT_EQ(runs(), 1);
  // So that the status of its successor is known from its own.
  ASSERT_TRUE(peer.AwaitStatus([](const auto& report) { return report.state == "Active"; }));
  peer.Signal(SIGKILL);
  ASSERT_EQ(peer.AwaitExit(), -SIGKILL);
  peer.Start(file);
  ASSERT_TRUE(peer.AwaitVisible()) << peer.Output();
  ASSERT_TRUE(peer.Switch("SelfCheck"));
  EXPECT_EQ(runs(), 1) << "its own start runs nothing of Active";
  ASSERT_TRUE(peer.Switch("Active"));
  EXPECT_EQ(runs(), 2);
}

TEST(MusherExec, StopsItsProgramAndExitsOnSigterm) {
  ExecPeer peer;
  peer.Start(kProgram);
  ASSERT_TRUE(peer.AwaitVisible()) << peer.Output();
  const pid_t program = ReadPid(peer.folder() / "program");
  ASSERT_GT(program, 0);
  peer.Signal(SIGTERM);
  EXPECT_EQ(peer.AwaitExit(), 0);
  EXPECT_TRUE(HasExited(program));
}

TEST(MusherExec, EndsOnSigtermWhileItIsBeingSetUp) {
  ExecPeer peer;
  peer.Start(std::string(kProgram) +
             "shell = \"echo $$ > $MUSHER_TEST/slow; exec sleep infinity\"\n");
  const pid_t slow = ReadPid(peer.folder() / "slow");
  const pid_t program = ReadPid(peer.folder() / "program");
  ASSERT_GT(slow, 0);
  ASSERT_GT(program, 0);
  peer.Signal(SIGTERM);
  EXPECT_EQ(peer.AwaitExit(), 0);
  EXPECT_TRUE(HasExited(slow));
  EXPECT_TRUE(HasExited(program));
}

// A SIGTERM in its TearDown ended it with exit code 0: torn down, with the motors on.
TEST(MusherExec, IsNotTornDownByASignalInItsTearDown) {
  ExecPeer peer;
  peer.Start("[state.TearDown]\nshell = \"echo $$ > $MUSHER_TEST/slow; exec sleep infinity\"\n");
  ASSERT_TRUE(peer.AwaitVisible()) << peer.Output();
  peer.Send("TearDown");
  ASSERT_GT(ReadPid(peer.folder() / "slow"), 0);
  peer.Signal(SIGTERM);
  EXPECT_EQ(peer.AwaitExit(), 1);
}

TEST(MusherExec, EndsWhenTearDownFailsAndItsProgramHasExited) {
  ExecPeer peer;
  peer.Start(std::string(kProgram) +
             "[state.TearDown]\nshell = \"kill -TERM $MUSHER_PROGRAM_PID; echo stuck; exit 5\"\n");
  ASSERT_TRUE(peer.AwaitVisible()) << peer.Output();
  peer.Send("TearDown");
  EXPECT_EQ(peer.AwaitExit(), 1);
  EXPECT_THAT(peer.Output(), HasSubstr("the program exited by itself: killed by SIGTERM"));
}

// It was "stopped", with the motors on.
TEST(MusherExec, DoesNotConfirmAnEmergencyStopOfWhatNothingStops) {
  const std::string none = "motion.toml has no [emergency_stop]: nothing stops ";
  const std::vector<std::pair<std::string, std::string>> files = {
      {"[state.Active]\nshell = \"echo motors on\"\n", none + "what its commands switch on"},
      {kProgram, none + "its program"},
      {"[state.LowPower]\nrun = [\"true\"]\n", ""}};
  for (const auto& [file, trouble] : files) {
    ExecPeer peer;
    peer.Start(file);
    ASSERT_TRUE(peer.AwaitVisible()) << peer.Output();
    peer.EngageStop();
    EXPECT_TRUE(peer.AwaitTrouble(trouble)) << file << peer.trouble();
  }
}

TEST(MusherExec, WithoutAFileDoesNotConfirmAnEmergencyStop) {
  ExecPeer peer;
  peer.StartWith({"--actuator", "motion", "--config", peer.folder() / "machine.toml", "--", "sleep",
                  "infinity"});
  ASSERT_TRUE(peer.AwaitVisible()) << peer.Output();
  peer.EngageStop();
  EXPECT_TRUE(peer.AwaitTrouble(
      "started without a file, it has no [emergency_stop]: nothing stops its program"))
      << peer.trouble();
}

// How often a command was run that adds a line to this file.
std::ptrdiff_t Runs(const ExecPeer& peer, const std::string& file) {
  std::ifstream lines(peer.folder() / file);
  return std::count(std::istreambuf_iterator<char>(lines), {}, '\n');
}

// What the commands have written to this file.
std::string Log(const ExecPeer& peer) {
  std::ifstream file(peer.folder() / "log");
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(MusherExec, ConfirmsAnEmergencyStopOnceItsCommandHasEnded) {
  ExecPeer peer;
  peer.Start(
      "[state.Active]\nshell = \"echo on >> $MUSHER_TEST/on\"\n"
      "[emergency_stop]\ntime_ms = 20000\n"
      "shell = \"until [ -e $MUSHER_TEST/go ]; do sleep 0.02; done; echo off >> "
      "$MUSHER_TEST/off\"\n");
  ASSERT_TRUE(peer.AwaitVisible()) << peer.Output();
  ASSERT_TRUE(peer.Switch("Active"));
  peer.EngageStop();
  EXPECT_TRUE(peer.AwaitTrouble([](const std::string& trouble) {
    return trouble.starts_with("[emergency_stop] has not ended: `until ");
  })) << peer.trouble();
  EXPECT_EQ(Runs(peer, "off"), 0);
  std::ofstream(peer.folder() / "go") << "go";
  EXPECT_TRUE(peer.AwaitTrouble("")) << peer.trouble();
  EXPECT_EQ(Runs(peer, "off"), 1);

  ASSERT_TRUE(peer.ReleaseStop());
  ASSERT_TRUE(peer.Switch("Active"));
  EXPECT_EQ(Runs(peer, "on"), 2) << "once for each command to Active, not by the release";
  EXPECT_EQ(Runs(peer, "off"), 1);
}

// A stop that is released at once switched off what the switch to Active had switched on.
TEST(MusherExec, SwitchesOnOnlyAfterTheCommandOfAReleasedEmergencyStop) {
  ExecPeer peer;
  peer.Start(
      "[state.Active]\nshell = \"echo on >> $MUSHER_TEST/log\"\n"
      "[emergency_stop]\ntime_ms = 20000\n"
      "shell = \"until [ -e $MUSHER_TEST/go ]; do sleep 0.02; done; echo off >> "
      "$MUSHER_TEST/log\"\n");
  ASSERT_TRUE(peer.AwaitVisible()) << peer.Output();
  peer.EngageStop();
  ASSERT_TRUE(peer.AwaitTrouble([](const auto& trouble) { return !trouble.empty(); }));
  ASSERT_TRUE(peer.ReleaseStop());
  peer.Send("Active");
  ASSERT_TRUE(peer.AwaitStatus([](const auto& report) { return report.target == "Active"; }));
  std::ofstream(peer.folder() / "go") << "go";
  ASSERT_TRUE(peer.AwaitReply());
  EXPECT_EQ(peer.reply()->value().verdict, msg::ActuatorCommand::kVerdictDone);
  std::ifstream log(peer.folder() / "log");
  EXPECT_EQ((std::string{std::istreambuf_iterator<char>(log), {}}), "off\non\n");
}

TEST(MusherExec, NamesAnEmergencyStopCommandThatFails) {
  ExecPeer peer;
  peer.Start("[emergency_stop]\nshell = \"echo no brake; exit 9\"\n[state.LowPower]\n");
  ASSERT_TRUE(peer.AwaitVisible()) << peer.Output();
  peer.EngageStop();
  EXPECT_TRUE(
      peer.AwaitTrouble("[emergency_stop]: exit code 9 of `echo no brake; exit 9`; last "
                        "output: no brake"))
      << peer.trouble();
}

TEST(MusherExec, EndsAnEmergencyStopCommandAtItsTime) {
  ExecPeer peer;
  peer.Start(
      "stop_ms = 20\n[state.LowPower]\n[emergency_stop]\ntime_ms = 100\n"
      "shell = \"trap '' TERM; echo $$ > $MUSHER_TEST/stop; while :; do sleep 1; done\"\n");
  ASSERT_TRUE(peer.AwaitVisible()) << peer.Output();
  peer.EngageStop();
  EXPECT_TRUE(peer.AwaitTrouble([](const std::string& trouble) {
    return trouble.ends_with("` has not ended within 100 ms and was ended");
  })) << peer.trouble();
  EXPECT_TRUE(HasExited(ReadPid(peer.folder() / "stop")));
}

TEST(MusherExec, RunsItsEmergencyStopBesideTheCommandOfAStateAndAgainAfterIt) {
  ExecPeer peer;
  peer.Start(std::string("stop_ms = 20000\n[state.Active]\n") +
             "shell = \"trap '' TERM; echo $$ > $MUSHER_TEST/slow; until [ -e $MUSHER_TEST/go ]; "
             "do sleep 0.02; done; echo on > $MUSHER_TEST/on\"\n"
             "[emergency_stop]\nshell = \"echo off >> $MUSHER_TEST/off; rm -f $MUSHER_TEST/on\"\n");
  ASSERT_TRUE(peer.AwaitVisible()) << peer.Output();
  peer.Send("Active");
  ASSERT_GT(ReadPid(peer.folder() / "slow"), 0);
  peer.EngageStop();
  EXPECT_TRUE(peer.AwaitTrouble([](const std::string& trouble) {
    return trouble.starts_with("its callback for Active still runs");
  })) << peer.trouble();
  EXPECT_EQ(Runs(peer, "off"), 1);
  EXPECT_FALSE(peer.reply()) << "the command of Active runs on: it ignores SIGTERM";

  std::ofstream(peer.folder() / "go") << "go";
  ASSERT_TRUE(peer.AwaitReply());
  EXPECT_EQ(peer.reply()->value().verdict, msg::ActuatorCommand::kVerdictFailed);
  EXPECT_TRUE(peer.Until([&] { return Runs(peer, "off") == 2; }));
  EXPECT_TRUE(peer.AwaitTrouble("")) << peer.trouble();
  EXPECT_NE(access((peer.folder() / "on").c_str(), F_OK), 0);
}

// The robot that fell to Protected below a stop drove, and its status said that the stop held it.
TEST(MusherExec, RepeatsItsEmergencyStopAfterACommandThatRanBelowIt) {
  ExecPeer peer;
  peer.Start(
      "[state.Active]\n[state.LowPower]\n"
      "shell = \"echo on ${MUSHER_EMERGENCY_STOP:-free} >> $MUSHER_TEST/log\"\n"
      "[emergency_stop]\nshell = \"echo off >> $MUSHER_TEST/log\"\n");
  ASSERT_TRUE(peer.AwaitVisible()) << peer.Output();
  ASSERT_TRUE(peer.Switch("Active"));
  peer.EngageStop();
  ASSERT_TRUE(peer.AwaitTrouble("")) << peer.trouble();
  ASSERT_TRUE(peer.Switch("LowPower"));
  EXPECT_TRUE(peer.Until([&] { return Log(peer) == "off\non 1\noff\n"; })) << Log(peer);
  EXPECT_TRUE(peer.AwaitTrouble("")) << peer.trouble();

  ASSERT_TRUE(peer.ReleaseStop());
  ASSERT_TRUE(peer.Switch("LowPower"));
  EXPECT_EQ(Log(peer), "off\non 1\noff\non free\n");
}

constexpr const char* kLowPowerRuns =
    "its callback for LowPower still runs and may switch on again";

// Until it has ended it may switch something on again.
// A command of the test waits for its next line: `read -r line < $MUSHER_TEST/…`.
class Pipe {
 public:
  explicit Pipe(const std::string& path) {
    EXPECT_EQ(mkfifo(path.c_str(), 0600), 0);
    end_ = UniqueFd(open(path.c_str(), O_RDWR | O_CLOEXEC));  // no open() waits for the other end
  }
  void WriteLine() const { EXPECT_EQ(write(end_.get(), "\n", 1), 1); }

 private:
  UniqueFd end_;
};

TEST(MusherExec, DoesNotConfirmAnEmergencyStopWhileACommandRunsBelowIt) {
  ExecPeer peer;
  const Pipe go(peer.folder() / "go");
  peer.Start(
      "[state.Active]\n[state.LowPower]\n"
      "shell = \"read -r line < $MUSHER_TEST/go\"\n"
      "[emergency_stop]\nshell = \"echo off >> $MUSHER_TEST/off\"\n");
  ASSERT_TRUE(peer.AwaitVisible()) << peer.Output();
  ASSERT_TRUE(peer.Switch("Active"));
  peer.EngageStop();
  ASSERT_TRUE(peer.AwaitTrouble("")) << peer.trouble();
  peer.Send("LowPower");
  EXPECT_TRUE(peer.AwaitTrouble(kLowPowerRuns)) << peer.trouble();
  EXPECT_EQ(Runs(peer, "off"), 1);
  go.WriteLine();
  ASSERT_TRUE(peer.AwaitReply());
  EXPECT_TRUE(peer.AwaitTrouble("")) << peer.trouble();
  EXPECT_EQ(Runs(peer, "off"), 2);
}

// The command of the stop was under way when the command of LowPower began.
TEST(MusherExec, DoesNotConfirmAnEmergencyStopWhoseCommandEndsBeforeACommandBelowIt) {
  ExecPeer peer;
  const Pipe go(peer.folder() / "go");
  const Pipe end(peer.folder() / "end");
  peer.Start(
      "[state.Active]\n[state.LowPower]\n"
      "shell = \"echo $$ > $MUSHER_TEST/slow; read -r line < $MUSHER_TEST/go\"\n"
      "[emergency_stop]\ntime_ms = 20000\n"
      "shell = \"echo $$ > $MUSHER_TEST/stop; read -r line < $MUSHER_TEST/end\"\n");
  ASSERT_TRUE(peer.AwaitVisible()) << peer.Output();
  ASSERT_TRUE(peer.Switch("Active"));
  peer.EngageStop();
  const pid_t stop = ReadPid(peer.folder() / "stop");
  ASSERT_GT(stop, 0);
  peer.Send("LowPower");
  ASSERT_GT(ReadPid(peer.folder() / "slow"), 0);
  end.WriteLine();
  EXPECT_TRUE(HasExited(stop));
  go.WriteLine();
  ASSERT_TRUE(peer.AwaitReply());
  EXPECT_FALSE(peer.HasConfirmedDuring("LowPower"));
  end.WriteLine();
  EXPECT_TRUE(peer.AwaitTrouble("")) << peer.trouble();
}

// Each run of the command of the stop waits for a line of the pipe `end`. So a run too many leaves
// the stop unconfirmed.
TEST(MusherExec, DoesNotConfirmASecondEmergencyStopWhileACommandRunsBelowTheFirst) {
  ExecPeer peer;
  const Pipe go(peer.folder() / "go");
  const Pipe end(peer.folder() / "end");
  peer.Start(
      "[state.Active]\n[state.LowPower]\n"
      "shell = \"echo $$ > $MUSHER_TEST/slow; read -r line < $MUSHER_TEST/go\"\n"
      "[emergency_stop]\ntime_ms = 60000\n"
      "shell = \"echo off >> $MUSHER_TEST/off; read -r line < $MUSHER_TEST/end\"\n");
  const auto has_not_ended = [](const std::string& trouble) {
    return trouble.starts_with("[emergency_stop] has not ended: `echo off");
  };
  ASSERT_TRUE(peer.AwaitVisible()) << peer.Output();
  ASSERT_TRUE(peer.Switch("Active"));
  peer.EngageStop();
  end.WriteLine();
  ASSERT_TRUE(peer.AwaitTrouble("")) << peer.trouble();
  peer.Send("LowPower");
  ASSERT_GT(ReadPid(peer.folder() / "slow"), 0);
  ASSERT_TRUE(peer.AwaitTrouble([](const std::string& trouble) { return !trouble.empty(); }));
  peer.ForgetConfirmations();  // the command had not begun

  peer.EngageStop(8);
  EXPECT_TRUE(peer.AwaitTrouble(has_not_ended)) << peer.trouble();
  end.WriteLine();
  EXPECT_TRUE(peer.AwaitTrouble(kLowPowerRuns)) << peer.trouble();
  go.WriteLine();
  ASSERT_TRUE(peer.AwaitReply());
  EXPECT_FALSE(peer.HasConfirmedDuring("LowPower"));
  EXPECT_TRUE(peer.AwaitTrouble(has_not_ended)) << peer.trouble();
  end.WriteLine();
  EXPECT_TRUE(peer.AwaitTrouble("")) << peer.trouble();
  EXPECT_EQ(Runs(peer, "off"), 3) << "for each stop, and after the command";
}

// It had begun before the stop.
TEST(MusherExec, DoesNotConfirmAnEmergencyStopWhileACommandThatLeadsDownRuns) {
  ExecPeer peer;
  const Pipe go(peer.folder() / "go");
  peer.Start(
      "[state.Active]\n[state.LowPower]\n"
      "shell = \"echo $$ > $MUSHER_TEST/slow; read -r line < $MUSHER_TEST/go\"\n"
      "[emergency_stop]\nshell = \"echo off >> $MUSHER_TEST/off\"\n");
  ASSERT_TRUE(peer.AwaitVisible()) << peer.Output();
  ASSERT_TRUE(peer.Switch("Active"));
  peer.Send("LowPower");
  ASSERT_GT(ReadPid(peer.folder() / "slow"), 0);
  peer.EngageStop();
  EXPECT_TRUE(peer.AwaitTrouble(kLowPowerRuns)) << peer.trouble();
  EXPECT_EQ(Runs(peer, "off"), 1);
  go.WriteLine();
  ASSERT_TRUE(peer.AwaitReply());
  EXPECT_FALSE(peer.HasConfirmedDuring("LowPower"));
  EXPECT_TRUE(peer.AwaitTrouble("")) << peer.trouble();
  EXPECT_EQ(Runs(peer, "off"), 2) << "at the stop, and after the command";
}

TEST(MusherExec, RepeatsItsEmergencyStopAfterATearDownThatFailsBelowIt) {
  ExecPeer peer;
  peer.Start(
      "[state.Active]\n[state.TearDown]\nshell = \"echo down >> $MUSHER_TEST/log; exit 5\"\n"
      "[emergency_stop]\nshell = \"echo off >> $MUSHER_TEST/log\"\n");
  ASSERT_TRUE(peer.AwaitVisible()) << peer.Output();
  ASSERT_TRUE(peer.Switch("Active"));
  peer.EngageStop();
  ASSERT_TRUE(peer.AwaitTrouble("")) << peer.trouble();
  const auto torn_down = peer.Switch("TearDown");
  ASSERT_TRUE(torn_down);
  EXPECT_EQ(torn_down.value().verdict, msg::ActuatorCommand::kVerdictFailed);
  EXPECT_TRUE(peer.Until([&] { return Log(peer) == "off\ndown\noff\n"; })) << Log(peer);
  EXPECT_TRUE(peer.AwaitTrouble("")) << peer.trouble();
}

TEST(MusherExec, DoesNotRepeatItsEmergencyStopAfterATearDown) {
  ExecPeer peer;
  peer.Start(
      "[state.Active]\n[state.TearDown]\nshell = \"echo down >> $MUSHER_TEST/log\"\n"
      "[emergency_stop]\nshell = \"echo off >> $MUSHER_TEST/log\"\n");
  ASSERT_TRUE(peer.AwaitVisible()) << peer.Output();
  ASSERT_TRUE(peer.Switch("Active"));
  peer.EngageStop();
  ASSERT_TRUE(peer.AwaitTrouble("")) << peer.trouble();
  ASSERT_TRUE(peer.Switch("TearDown"));
  EXPECT_EQ(peer.AwaitExit(), 0) << peer.Output();
  EXPECT_EQ(Log(peer), "off\ndown\n");
}

TEST(MusherExec, EndsItsProgramAtAnEmergencyStopAndIsNotSwitchedOnWithoutIt) {
  ExecPeer peer;
  peer.Start(std::string(kProgram) +
             "[state.Active]\nrun = [\"true\"]\n[emergency_stop]\nend_program = true\n");
  ASSERT_TRUE(peer.AwaitVisible()) << peer.Output();
  const pid_t program = ReadPid(peer.folder() / "program");
  ASSERT_GT(program, 0);
  ASSERT_TRUE(peer.Switch("Active"));
  peer.EngageStop();
  EXPECT_TRUE(peer.AwaitTrouble("")) << peer.trouble();
  EXPECT_TRUE(HasExited(program));
  ASSERT_TRUE(peer.ReleaseStop());

  const std::string reason =
      "an emergency stop has ended its program; `musher restart motion` starts it again";
  for (const char* state : {"SelfCheck", "Active"}) {
    const auto refused = peer.Switch(State(state));
    ASSERT_TRUE(refused);
    EXPECT_EQ(refused.value().verdict, msg::ActuatorCommand::kVerdictFailed) << state;
    EXPECT_EQ(refused.value().message, reason) << state;
  }
  EXPECT_EQ(peer.Switch("LowPower").value().status.state, "LowPower");
  EXPECT_EQ(peer.Switch("TearDown").value().verdict, msg::ActuatorCommand::kVerdictDone);
  EXPECT_EQ(peer.AwaitExit(), 0) << peer.Output();
}

TEST(MusherExec, IsSetUpWithoutItsProgramWhereAnEmergencyStopEndsItInSetUp) {
  ExecPeer peer;
  peer.Start(std::string(kProgram) +
             "shell = \"until [ -e $MUSHER_TEST/go ]; do sleep 0.02; done\"\n"
             "[emergency_stop]\nend_program = true\n");
  const pid_t program = ReadPid(peer.folder() / "program");
  ASSERT_GT(program, 0);
  peer.EngageStop();
  EXPECT_TRUE(HasExited(program)) << "it waited for the end of SetUp";
  ASSERT_TRUE(peer.AwaitVisible()) << "it would be restarted again and again: " << peer.Output();
  EXPECT_TRUE(peer.AwaitTrouble("")) << peer.trouble();
  EXPECT_EQ(peer.Switch("SelfCheck").value().verdict, msg::ActuatorCommand::kVerdictFailed);
}

TEST(MusherExec, WrapsAProgramWithoutAFile) {
  ExecPeer peer;
  peer.StartWith({"--actuator", "motion", "--config", peer.folder() / "machine.toml", "--", "sh",
                  "-c", "echo $$ > $MUSHER_TEST/program; exec sleep infinity"});
  ASSERT_TRUE(peer.AwaitVisible()) << peer.Output();
  EXPECT_EQ(peer.Switch("Active").value().status.state, "Active");
  const pid_t program = ReadPid(peer.folder() / "program");
  ASSERT_GT(program, 0);
  kill(program, SIGKILL);
  EXPECT_EQ(peer.AwaitExit(), 1);
}

// Usage errors.
struct Slip {
  const char* name;
  std::vector<std::string> arguments;
  const char* message;
};

void PrintTo(const Slip& slip, std::ostream* out) {
  *out << slip.name;
}

class MusherExecUsage : public ::testing::TestWithParam<Slip> {};

TEST_P(MusherExecUsage, IsReportedAndExitsWithTwo) {
  ExecPeer peer;
  peer.StartWith(GetParam().arguments);
  EXPECT_EQ(peer.AwaitExit(), 2);
  EXPECT_THAT(peer.Output(), HasSubstr(GetParam().message));
}

INSTANTIATE_TEST_SUITE_P(
    Slips, MusherExecUsage,
    ::testing::Values(
        Slip{"NoActuator", {"--config", "machine.toml", "x.toml"}, "--actuator is required"},
        Slip{"NoConfig", {"--actuator", "motion", "x.toml"}, "--config is required"},
        Slip{"NothingToDo",
             {"--actuator", "motion", "--config", "machine.toml"},
             "expected either FILE or -- PROGRAM"},
        Slip{"UnknownActuator",
             {"--actuator", "moton", "--config", "machine.toml", "x.toml"},
             "machine.toml: there is no actuator 'moton'"},
        Slip{"MissingConfig",
             {"--actuator", "motion", "--config", "none.toml", "x.toml"},
             "none.toml: error: the file cannot be read"},
        Slip{"MissingFile",
             {"--actuator", "motion", "--config", "machine.toml", "none.toml"},
             "none.toml: error: the file cannot be read"},
        Slip{"BothFileAndProgram",
             {"--actuator", "motion", "--config", "machine.toml", "x.toml", "--", "true"},
             "expected either FILE or -- PROGRAM"}),
    [](const auto& slip) { return slip.param.name; });

TEST(MusherExec, PrintsItsHelp) {
  ExecPeer peer;
  peer.StartWith({"--help"});
  EXPECT_EQ(peer.AwaitExit(), 0);
  EXPECT_THAT(peer.Output(), HasSubstr("[state.SetUp]"));
}

}  // namespace musher::exec::exec_process_test
