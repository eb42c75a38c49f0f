// Real processes. A child reports that it runs by writing into a named pipe, so no test waits for a
// time.

#include "musher/controller/process/process_supervisor.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <future>
#include <iterator>
#include <memory>
#include <optional>
#include <set>
#include <thread>

#include "musher/base/host.hpp"
#include "musher/test/controller/supervised.hpp"
#include "musher/test/support/temp_folder.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::process_supervisor_test {

using ::testing::AllOf;
using ::testing::HasSubstr;

// Such as a pipe whose reader waits for its end.
TEST_F(Supervisor, GivesAProcessWithoutALogFileNoOutputOfThisOne) {
  ProcessSpec spec = Script("(readlink /proc/$$/fd/1 /proc/$$/fd/2) > $PIPE");
  spec.output = -1;
  MustStart(spec);
  EXPECT_EQ(WaitForLine(), "/dev/null");
  EXPECT_EQ(WaitForLine(), "/dev/null");
}

TEST_F(Supervisor, ReportsTheExitCode) {
  MustStart(Script("exit 3"));
  EXPECT_EQ(WaitForExit(), (ProcessExit{ProcessExit::Kind::kExited, 3, ""}));
  EXPECT_EQ(exit_->Text(), "exit code 3");
  EXPECT_EQ(exit_->code(), 3);
  EXPECT_FALSE(exit_->clean());
}

TEST_F(Supervisor, CallsExitCodeZeroClean) {
  MustStart(Script("exit 0"));
  ASSERT_TRUE(WaitForExit());
  EXPECT_TRUE(exit_->clean());
}

TEST_F(Supervisor, ReportsTheSignalThatKilledAProcess) {
  const pid_t pid = MustStart(Script("echo up > $PIPE; exec sleep 1000"));
  WaitForLine();
  kill(pid, SIGKILL);
  EXPECT_EQ(WaitForExit(), (ProcessExit{ProcessExit::Kind::kKilled, SIGKILL, ""}));
  EXPECT_EQ(exit_->Text(), "killed by SIGKILL");
  EXPECT_EQ(exit_->code(), 0) << "a signal's number is no exit code";
}

TEST_F(Supervisor, ReportsTheLastOutputOfAProcessThatExitsWithAnError) {
  std::ofstream(log_) << "of the one before\n";
  MustStart(Script("echo one; printf '  no\\033[1m such port\\n\\n \\n' >&2; exit 2"));
  ASSERT_TRUE(WaitForExit());
  EXPECT_EQ(exit_->Text(), "exit code 2: no [1m such port");
  exit_.reset();
  MustStart(Script("exit 2"));
  ASSERT_TRUE(WaitForExit());
  EXPECT_EQ(exit_->Text(), "exit code 2") << "the words are another one's";
}

TEST_F(Supervisor, ReportsWhatTheLastLogLineSaysWithoutItsTime) {
  MustStart(Script("echo '2026-11-26 06:48:46.082 helper: error: no such port'; exit 2"));
  ASSERT_TRUE(WaitForExit());
  EXPECT_EQ(exit_->Text(), "exit code 2: helper: error: no such port");
}

TEST_F(Supervisor, CutsLongLastOutputBetweenCharacters) {
  MustStart(Script("for i in $(seq 300); do printf ä; done; exit 1"));
  ASSERT_TRUE(WaitForExit());
  EXPECT_EQ(exit_->last_output.size(), 200 + std::string("…").size());
  EXPECT_TRUE(exit_->last_output.ends_with("ä…"));
}

TEST_F(Supervisor, GivesAProcessItsNiceness) {
  ProcessSpec spec = Script("nice > $PIPE");
  spec.limits.nice = 7;
  MustStart(spec);
  EXPECT_EQ(WaitForLine(), "7");
}

// Its niceness alone has no effect there: each process of the controller is a session of its own.
TEST_F(Supervisor, GivesTheSessionOfAProcessItsNicenessWhereTheKernelWeighsSessions) {
  if (!std::filesystem::exists("/proc/self/autogroup")) GTEST_SKIP() << "no autogroups here";
  ProcessSpec spec = Script("cat /proc/self/autogroup > $PIPE");
  spec.limits.nice = 7;
  MustStart(spec);
  EXPECT_THAT(WaitForLine(), ::testing::EndsWith(" nice 7"));
}

TEST_F(Supervisor, GivesAProcessItsRealtimePriority) {
  sched_param priority{};
  priority.sched_priority = 3;
  if (sched_setscheduler(0, SCHED_FIFO, &priority) != 0) GTEST_SKIP() << "no realtime here";
  priority.sched_priority = 0;
  ASSERT_EQ(sched_setscheduler(0, SCHED_OTHER, &priority), 0);
  ProcessSpec spec = Script("cut -d ' ' -f 40,41 /proc/self/stat > $PIPE");
  spec.limits.realtime_priority = 3;
  MustStart(spec);
  EXPECT_EQ(WaitForLine(), "3 1");  // of SCHED_FIFO
}

TEST_F(Supervisor, StartsNoProcessWithoutThePriorityThatItIsToHave) {
  rlimit none{};
  ASSERT_EQ(setrlimit(RLIMIT_RTPRIO, &none), 0);
  // Without the privileges of root, in a thread of its own: they are of a thread.
  std::string why;
  std::thread([&] {
    if (geteuid() == 0 && syscall(SYS_setresuid, -1, 65534, -1) != 0) return;
    ProcessSpec spec = Script("true");
    spec.limits.realtime_priority = 3;
    const auto child = Spawn(spec);
    if (!child) return;
    if (const auto failure = child.value().Failure()) why = failure->error.message;
    ReapChild(child.value().pid());
  }).join();
  EXPECT_THAT(why, AllOf(HasSubstr("can't run sh: can't set its `realtime_priority`"),
                         HasSubstr("LimitRTPRIO="), HasSubstr("Operation not permitted")));
}

TEST_F(Supervisor, LeavesNoZombie) {
  const pid_t pid = MustStart(Script("exit 0"));
  ASSERT_TRUE(WaitForExit());
  EXPECT_EQ(waitpid(pid, nullptr, WNOHANG), -1);
  EXPECT_EQ(errno, ECHILD);
}

TEST_F(Supervisor, WatchesManyProcessesAtOnce) {
  std::multiset<int> codes;
  for (int code = 0; code < 20; ++code) {
    const auto pid =
        supervisor_->Start(Script("exit " + std::to_string(code)),
                           [&](const ProcessExit& exit) { codes.insert(exit.number); });
    ASSERT_TRUE(pid);
  }
  EXPECT_TRUE(loop_.RunUntil([&] { return codes.size() == 20; }, Deadline()));
  EXPECT_EQ(*codes.begin(), 0);
  EXPECT_EQ(*codes.rbegin(), 19);
}

TEST_F(Supervisor, MayStartTheNextProcessFromTheExitOfTheLast) {
  const auto pid = supervisor_->Start(Script("exit 1"),
                                      [&](const ProcessExit&) { MustStart(Script("exit 2")); });
  ASSERT_TRUE(pid);
  EXPECT_EQ(WaitForExit(), (ProcessExit{ProcessExit::Kind::kExited, 2, ""}));
}

TEST_F(Supervisor, AppendsOutputAndErrorsToTheLogFile) {
  std::ofstream(log_) << "before\n";
  MustStart(Script("echo out; echo err >&2"));
  ASSERT_TRUE(WaitForExit());
  EXPECT_EQ(ReadFile(log_), "before\nout\nerr\n");
}

TEST_F(Supervisor, GivesTheProcessItsFolderAndItsEnvironmentAddedToThatOfTheController) {
  setenv("MUSHER_TEST_OURS", "kept", 1);
  setenv("MUSHER_TEST_BOTH", "ours", 1);
  ProcessSpec spec = Script("pwd; echo $MUSHER_TEST_OURS $MUSHER_TEST_BOTH");
  spec.env["MUSHER_TEST_BOTH"] = "its own";
  spec.cwd = std::filesystem::canonical(folder_.path()).string();
  MustStart(spec);
  ASSERT_TRUE(WaitForExit());
  EXPECT_EQ(ReadFile(log_), spec.cwd + "\nkept its own\n");
}

TEST_F(Supervisor, KeepsWhatSystemdGaveToUsFromTheProcess) {
  for (const char* name : {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"}) setenv(name, "1", 1);
  ProcessSpec spec = Script("echo $NOTIFY_SOCKET $WATCHDOG_USEC $WATCHDOG_PID");
  spec.env["WATCHDOG_USEC"] = "its own";
  MustStart(spec);
  for (const char* name : {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"}) unsetenv(name);
  ASSERT_TRUE(WaitForExit());
  EXPECT_EQ(ReadFile(log_), "its own\n");
}

TEST_F(Supervisor, FindsAProgramThroughThePathOfItsEnvironment) {
  std::ofstream(folder_ / "bark") << "#!/bin/sh\necho woof\n";
  chmod((folder_ / "bark").c_str(), 0700);
  MustStart({"dog", {"bark"}, "", {{"PATH", "/nowhere:" + folder_.path()}}, output_.get()});
  ASSERT_TRUE(WaitForExit());
  EXPECT_EQ(ReadFile(log_), "woof\n");
}

TEST_F(Supervisor, StartsTheProcessWithoutOurDescriptorsAndWithAnEmptyStdin) {
  const UniqueFd leaky(open("/dev/null", O_RDONLY));  // like DDS: not close-on-exec
  ASSERT_TRUE(leaky.valid());
  const UniqueFd stdin_before(dup(0));
  dup2(pipe_.get(), 0);
  MustStart(Script("ls /proc/$$/fd; readlink /proc/$$/fd/0"));
  dup2(stdin_before.get(), 0);
  ASSERT_TRUE(WaitForExit());
  EXPECT_EQ(ReadFile(log_), "0\n1\n2\n/dev/null\n");
}

TEST_F(Supervisor, StartsTheProcessWithDefaultSignalHandling) {
  sigset_t blocked;
  sigemptyset(&blocked);
  sigaddset(&blocked, SIGTERM);
  sigset_t before;
  pthread_sigmask(SIG_BLOCK, &blocked, &before);
  const auto pipe_before = signal(SIGPIPE, SIG_IGN);
  MustStart({"dog", {"grep", "-E", "Sig(Blk|Ign)", "/proc/self/status"}, "", {}, output_.get()});
  EXPECT_TRUE(WaitForExit());
  sigset_t now;
  pthread_sigmask(SIG_SETMASK, &before, &now);
  signal(SIGPIPE, pipe_before);
  EXPECT_EQ(ReadFile(log_), "SigBlk:\t0000000000000000\nSigIgn:\t0000000000000000\n");
  EXPECT_TRUE(sigismember(&now, SIGTERM) && !sigismember(&now, SIGUSR1))
      << "our own mask must stay as it was";
}

TEST_F(Supervisor, GivesTheProcessItsOwnGroupSoThatCtrlCIsNotForIt) {
  const pid_t pid = MustStart(Script("echo up > $PIPE; exec sleep 1000"));
  WaitForLine();
  EXPECT_EQ(getpgid(pid), pid);
  EXPECT_NE(getsid(pid), getsid(0));
}

TEST_F(Supervisor, ReportsAMissingProgramBeforeStartReturns) {
  const auto pid = supervisor_->Start({"dog", {"no-such-program"}, "", {}, output_.get()}, nullptr);
  ASSERT_FALSE(pid);
  EXPECT_EQ(pid.error().message, "can't run no-such-program: No such file or directory");
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1) << "the failed child is still there";
}

TEST_F(Supervisor, ReportsAProgramThatIsNotExecutable) {
  std::ofstream(folder_ / "text") << "not a program\n";
  const auto pid = supervisor_->Start({"dog", {folder_ / "text"}, "", {}, output_.get()}, nullptr);
  ASSERT_FALSE(pid);
  EXPECT_THAT(pid.error().message, AllOf(HasSubstr("text"), HasSubstr("Permission denied")));
}

TEST_F(Supervisor, ReportsAMissingFolderOfAProcess) {
  ProcessSpec spec = Script("exit 0");
  spec.cwd = folder_ / "missing";
  const auto pid = supervisor_->Start(spec, nullptr);
  ASSERT_FALSE(pid);
  EXPECT_EQ(pid.error().message, "can't run sh in " + spec.cwd + ": No such file or directory");
}

// As a disk is that stalls: the child waits for it, and the loop does not.
TEST_F(Supervisor, DoesNotWaitForADiskThatStallsWhileAProgramIsLoaded) {
  supervisor_ = std::make_unique<ProcessSupervisor>(loop_, disk_, Duration::zero());
  bool turned = false;
  const pid_t pid = MustStart(Script("echo up > $PIPE; exec sleep 1000"));
  loop_.Post([&] { turned = true; });
  EXPECT_TRUE(loop_.RunUntil([&] { return turned; }, Deadline()));
  EXPECT_EQ(WaitForLine(), "up");
  EXPECT_TRUE(supervisor_->Signal(pid, SIGKILL));
}

TEST_F(Supervisor, ReportsAsItsEndThatAProgramCouldNotBeRunWhereThatShowsLate) {
  supervisor_ = std::make_unique<ProcessSupervisor>(loop_, disk_, Duration::zero());
  const auto on_exit = [this](const ProcessExit& exit) { exit_ = exit; };
  for (bool late = false; !late;) {  // mostly at the first time
    exit_.reset();
    const auto pid =
        supervisor_->Start({"dog", {"no-such-program"}, "", {}, output_.get()}, on_exit);
    late = pid.ok();
  }
  ASSERT_TRUE(WaitForExit());
  EXPECT_EQ(exit_->kind, ProcessExit::Kind::kNotRun);
  EXPECT_EQ(exit_->Text(), "can't run no-such-program: No such file or directory");
  EXPECT_FALSE(exit_->clean());
}

TEST_F(Supervisor, WaitsForLastWordsOnADiskThatStallsForAMomentOnly) {
  std::promise<void> disk_works;
  disk_.Do("stall", [works = disk_works.get_future().share()] {
    works.wait();
    return Ok();
  });
  MustStart(Script("echo no such port; exit 2"));
  ASSERT_TRUE(WaitForExit());
  EXPECT_EQ(exit_->Text(), "exit code 2") << "its last output is on a disk that does not answer";
  disk_works.set_value();
}

TEST_F(Supervisor, RefusesAnEmptyCommand) {
  const auto pid = supervisor_->Start({"dog", {}, "", {}, output_.get()}, nullptr);
  ASSERT_FALSE(pid);
  EXPECT_EQ(pid.error().code, kCodeParametersInvalid);
}

TEST_F(Supervisor, SignalsTheWholeGroup) {
  const pid_t pid = MustStart(
      Script("trap : TERM;"
             "(trap 'echo helper got it > $PIPE; exit' TERM; echo up > $PIPE; sleep 1000 & wait) &"
             "wait; wait"));
  WaitForLine();
  ASSERT_TRUE(supervisor_->Signal(pid, SIGTERM));
  EXPECT_EQ(WaitForLine(), "helper got it");
}

TEST_F(Supervisor, KillsTheRestOfTheGroupWhenItsLeaderHasExited) {
  const pid_t leader = MustStart(
      Script("sh -c 'trap \"\" TERM HUP; echo $$ > $PIPE; while :; do sleep 1000; done' & wait"));
  const pid_t helper = std::stoi(WaitForLine());
  EXPECT_TRUE(EndsAfter(helper, [&] { kill(leader, SIGTERM); }));
}

TEST_F(Supervisor, DoesNotSignalAProcessThatHasEnded) {
  const pid_t pid = MustStart(Script("exit 0"));
  ASSERT_TRUE(WaitForExit());
  EXPECT_FALSE(supervisor_->Signal(pid, SIGTERM));
}

TEST_F(Supervisor, DoesNotSignalAnUnknownProcess) {
  EXPECT_FALSE(supervisor_->Signal(getppid(), 0));
}

TEST_F(Supervisor, LeavesTheProcessesRunningWhenItGoes) {
  const std::string order = folder_ / "order";
  ASSERT_EQ(mkfifo(order.c_str(), 0600), 0);
  ProcessSpec spec = Script("echo up > $PIPE; read line < $ORDER && echo $line > $PIPE");
  spec.env["ORDER"] = order;
  MustStart(spec);
  WaitForLine();
  supervisor_.reset();
  std::fstream order_pipe(order);  // to read and write: does not wait for the child to open its end
  order_pipe << "go\n" << std::flush;
  EXPECT_EQ(WaitForLine(), "go");
}

TEST_F(Supervisor, WatchesAndSignalsAProcessOfTheControllerBeforeIt) {
  const pid_t pid = MustStart(Script("echo up > $PIPE; exec sleep 1000"));
  WaitForLine();
  supervisor_ = std::make_unique<ProcessSupervisor>(loop_, disk_, kLoading);
  ASSERT_TRUE(supervisor_->Watch(pid, [this](const ProcessExit& exit) { exit_ = exit; }));
  ASSERT_TRUE(supervisor_->Signal(pid, SIGTERM));
  ASSERT_TRUE(WaitForExit());
  EXPECT_EQ(exit_->Text(), "exit code unknown");
  EXPECT_FALSE(exit_->clean());
}

// Several actuators in one process: the second watch was refused, and its end was seen by silence.
TEST_F(Supervisor, ReportsAnExitToAllWatchers) {
  const pid_t pid = MustStart(Script("echo up > $PIPE; exec sleep 1000"));
  WaitForLine();
  std::vector<std::string> reported;
  const auto report = [&](const std::string& name) {
    return [&reported, name](const ProcessExit& exit) {
      reported.push_back(name + " " + exit.Text());
    };
  };
  ASSERT_TRUE(supervisor_->Watch(pid, report("arm")));
  ASSERT_TRUE(supervisor_->Watch(pid, report("leg")));
  ASSERT_TRUE(supervisor_->Signal(pid, SIGKILL));
  ASSERT_TRUE(WaitForExit());
  EXPECT_EQ(exit_->Text(), "killed by SIGKILL");
  EXPECT_THAT(reported, ::testing::ElementsAre("arm killed by SIGKILL", "leg killed by SIGKILL"));
}

TEST_F(Supervisor, ReportsTheExitOfAProcessOfAnEarlierControllerToAllWatchers) {
  const pid_t pid = MustStart(Script("echo up > $PIPE; exec sleep 1000"));
  WaitForLine();
  supervisor_ = std::make_unique<ProcessSupervisor>(loop_, disk_, kLoading);
  int reported = 0;
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(supervisor_->Watch(pid, [&](const ProcessExit&) { ++reported; }));
  }
  ASSERT_TRUE(supervisor_->Signal(pid, SIGKILL));
  EXPECT_TRUE(loop_.RunUntil([&] { return reported == 3; }, Deadline()));
}

TEST_F(Supervisor, DoesNotWatchAProcessThatHasExited) {
  const pid_t pid = MustStart(Script("exit 0"));
  ASSERT_TRUE(WaitForExit());
  const auto watched = supervisor_->Watch(pid, nullptr);
  ASSERT_FALSE(watched);
  EXPECT_THAT(watched.error().message, HasSubstr("No such process"));
}

TEST_F(Supervisor, StartsProcessesWhileOtherThreadsAllocateAndStartThreads) {
  std::atomic<bool> stop = false;
  std::jthread busy([&] {
    while (!stop) std::jthread([] { std::string(4096, 'x').shrink_to_fit(); });
  });
  for (int i = 0; i < 30; ++i) {
    exit_.reset();
    MustStart(Script("exit 7"));
    EXPECT_EQ(WaitForExit(), (ProcessExit{ProcessExit::Kind::kExited, 7, ""}));
  }
  stop = true;
}

}  // namespace musher::process_supervisor_test
