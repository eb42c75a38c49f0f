// Finding the processes that an earlier controller has started: by the stored list and by their
// mark.

#include <gmock/gmock.h>

#include "musher/controller/process/child_processes.hpp"
#include "musher/controller/process/process_probe.hpp"
#include "musher/controller/storage/state_store.hpp"
#include "musher/test/controller/supervised.hpp"

namespace musher::child_processes_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

class ChildProcesses : public Supervisor {
 protected:
  ~ChildProcesses() override {
    for (const MarkedProcess& process : FindMarked()) {
      if (process.mark == mark_) kill(process.pid, SIGKILL);
    }
  }
  // A process of the actuator `dog` that runs until it is killed.
  pid_t StartDog(const std::string& script = "echo ready > $PIPE; exec tail -f /dev/null") {
    ProcessSpec spec = Script(script);
    spec.mark = mark_;
    const pid_t pid = MustStart(spec);
    WaitForLine();
    return pid;
  }
  // A process that the dog has started; 0: there is none.
  pid_t ChildOf(pid_t dog) const {
    for (const MarkedProcess& process : FindMarked()) {
      if (process.mark == mark_ && process.started == dog && process.pid != dog) return process.pid;
    }
    return 0;
  }
  static ChildProcess Now(pid_t pid) { return {"dog", pid, StartTimeOf(pid).value_or(0)}; }
  std::vector<ChildProcess> Find(const std::vector<ChildProcess>& stored, bool runs = false) {
    return FindChildren({{"dog", mark_, runs}}, stored);
  }

  const std::string mark_ = "7/test_" + std::to_string(getpid()) + "/dog";
};

TEST_F(ChildProcesses, AStoredProcessThatRunsIsFoundAgain) {
  ProcessSpec spec = Script("echo ready > $PIPE; exec env -i tail -f /dev/null");
  const pid_t pid = MustStart(spec);
  WaitForLine();
  EXPECT_THAT(Find({Now(pid)}), ElementsAre(Now(pid)));
}

TEST_F(ChildProcesses, AnotherProcessWithTheSamePidIsNotTakenForIt) {
  ChildProcess reused = Now(getpid());
  EXPECT_TRUE(IsRunning(reused));
  reused.start_time -= 1;
  EXPECT_FALSE(IsRunning(reused));
  EXPECT_THAT(Find({reused}), IsEmpty());
}

TEST_F(ChildProcesses, AnExitedProcessDoesNotRunThoughItIsNotReaped) {
  const pid_t pid = fork();
  if (pid == 0) _exit(0);
  siginfo_t info{};
  ASSERT_EQ(waitid(P_PID, static_cast<id_t>(pid), &info, WEXITED | WNOWAIT), 0);
  EXPECT_EQ(StartTimeOf(pid), std::nullopt);
  waitpid(pid, nullptr, 0);
  EXPECT_EQ(StartTimeOf(pid), std::nullopt);
}

TEST_F(ChildProcesses, AProcessThatIsNotStoredIsFoundByItsMark) {
  const pid_t pid = StartDog();
  EXPECT_THAT(Find({}), ElementsAre(Now(pid)));
  EXPECT_THAT(FindChildren({{"cat", "7//cat"}}, {}), IsEmpty());
}

// Its pid is not known before, so that the mark does not name it.
TEST_F(ChildProcesses, AUnitIsFoundByItsMarkAsTheFirstOfItsSession) {
  ProcessSpec spec = Script(
      "tail -f /dev/null & setsid tail -f /dev/null & echo ready > $PIPE; exec tail -f /dev/null");
  spec.env[kChildMark] = UnitMarkOf(mark_);
  const pid_t pid = MustStart(spec);
  WaitForLine();
  EXPECT_THAT(Find({}), ElementsAre(Now(pid)));
  EXPECT_EQ(ChildMarkOf(pid), mark_);
}

// A process that is in the middle of an exec has no environment for some microseconds.
TEST_F(ChildProcesses, AProcessIsFoundByItsMarkWhileItReplacesItsProgram) {
  const std::string program = folder_ / "program";
  std::ofstream(program) << "#!/bin/sh\nexec \"$0\"\n";
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  const pid_t pid = StartDog("echo ready > $PIPE; exec '" + program + "'");
  for (int i = 0; i < 1000; ++i) {
    ASSERT_TRUE(ChildMarkOf(pid) == mark_) << "not in search " << i;
  }
}

TEST_F(ChildProcesses, TheRemainsOfAnExitedProcessAreKilled) {
  const pid_t pid = StartDog("setsid tail -f /dev/null & echo $! > $PIPE; exec tail -f /dev/null");
  const pid_t left = ChildOf(pid);
  ASSERT_NE(left, 0);
  EXPECT_THAT(Find({}), ElementsAre(Now(pid))) << "its own child is not the actuator's process";
  supervisor_.reset();  // it would kill the remains itself
  kill(pid, SIGKILL);
  waitpid(pid, nullptr, 0);
  EXPECT_THAT(Find({}, true), IsEmpty());
  EXPECT_TRUE(StartTimeOf(left)) << "it may hold the actuator's name";
  EXPECT_TRUE(EndsAfter(left, [this] { EXPECT_THAT(Find({}), IsEmpty()); }));
}

TEST_F(ChildProcesses, TheExitOfAnAdoptedProcessIsReportedAndTheRestOfItsSessionIsKilled) {
  const pid_t pid = StartDog("tail -f /dev/null & echo $! > $PIPE; exec tail -f /dev/null");
  const pid_t other = ChildOf(pid);
  ASSERT_NE(other, 0);
  supervisor_ = std::make_unique<ProcessSupervisor>(loop_, disk_, kLoading);  // the next controller
  ASSERT_TRUE(supervisor_->Adopt(pid, Now(pid).start_time,
                                 [this](const ProcessExit& exit) { exit_ = exit; }));
  EXPECT_TRUE(EndsAfter(other, [&] { kill(pid, SIGKILL); }));
  const auto exit = WaitForExit();
  ASSERT_TRUE(exit);
  EXPECT_EQ(exit->kind, ProcessExit::Kind::kUnknown);
}

TEST_F(ChildProcesses, ADaemonThatAnAdoptedProcessLeavesBehindIsKilled) {
  const pid_t pid = StartDog("setsid tail -f /dev/null & echo $! > $PIPE; exec tail -f /dev/null");
  const pid_t daemon = ChildOf(pid);
  ASSERT_NE(daemon, 0);
  supervisor_ = std::make_unique<ProcessSupervisor>(loop_, disk_, kLoading);  // the next controller
  ASSERT_TRUE(supervisor_->Adopt(pid, Now(pid).start_time,
                                 [this](const ProcessExit& exit) { exit_ = exit; }));
  EXPECT_TRUE(EndsAfter(daemon, [&] {
    kill(pid, SIGKILL);
    EXPECT_TRUE(WaitForExit());
  }));
}

TEST_F(ChildProcesses, ALaterProcessWithTheSamePidIsNotAdopted) {
  const pid_t pid = StartDog();
  supervisor_ = std::make_unique<ProcessSupervisor>(loop_, disk_, kLoading);  // the next controller
  EXPECT_FALSE(supervisor_->Adopt(pid, Now(pid).start_time - 1, nullptr));
  EXPECT_FALSE(supervisor_->Signal(pid, SIGTERM)) << "it is not watched";
}

TEST_F(ChildProcesses, InAnotherNetworkNamespaceBelongToAnotherMachine) {
  if (system("unshare -n true 2> /dev/null") != 0) {
    GTEST_SKIP() << "needs the permission to make a network namespace";
  }
  StartDog("exec unshare -n sh -c 'echo ready > $PIPE; exec tail -f /dev/null'");
  const auto marked = FindMarked();
  EXPECT_TRUE(std::none_of(marked.begin(), marked.end(),
                           [&](const MarkedProcess& process) { return process.mark == mark_; }));
}

TEST_F(ChildProcesses, NeverIncludeTheControllerThatAnActuatorsShellHasStarted) {
  const pid_t pid = fork();
  if (pid == 0) {
    // As started by the shell of the actuator "dog", whose process has exited.
    const std::string mark = std::string(kChildMark) + "=0000000002/" + mark_;
    const std::string program = std::filesystem::read_symlink("/proc/self/exe");
    setenv("MUSHER_TEST_MARK", mark_.c_str(), 1);
    putenv(const_cast<char*>(mark.c_str()));
    execl(program.c_str(), program.c_str(), "--gtest_filter=*FindsAndKillsAsAController",
          "--gtest_also_run_disabled_tests", nullptr);
    _exit(127);
  }
  int status = 0;
  waitpid(pid, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << "it has killed itself: " << status;
}

// Runs in a process of the test above only.
TEST(DISABLED_ChildProcessesOfAShell, FindsAndKillsAsAController) {
  const char* mark = std::getenv("MUSHER_TEST_MARK");
  ASSERT_NE(mark, nullptr);
  EXPECT_THAT(FindChildren({{"dog", mark}}, {}), IsEmpty());
  KillMarked(mark, 2);
}

TEST_F(ChildProcesses, TheWorkerOfAShellIsTheProcessThatItWaitsFor) {
  KernelProbe probe(loop_, *supervisor_, [](const std::string& actuator) { return actuator; });
  const pid_t shell = MustStart(Script("sh -c 'echo $$ > $PIPE; exec tail -f /dev/null'; exit 0"));
  const pid_t worker = std::stoi(WaitForLine());
  ASSERT_NE(worker, shell);
  EXPECT_EQ(probe.WorkerOf(shell), worker);
  EXPECT_EQ(probe.WorkerOf(worker), worker);
}

TEST_F(ChildProcesses, AProcessWithSeveralChildrenIsItsOwnWorker) {
  KernelProbe probe(loop_, *supervisor_, [](const std::string& actuator) { return actuator; });
  const pid_t shell =
      MustStart(Script("tail -f /dev/null & tail -f /dev/null & echo ready > $PIPE; wait; exit 0"));
  WaitForLine();
  EXPECT_EQ(probe.WorkerOf(shell), shell);
}

// A shell with an editor was ended by a start from the other slot.
TEST_F(ChildProcesses, AreNotAPersonsShellsThatHaveExportedTheirVariable) {
  ProcessSpec spec = Script("echo ready > $PIPE; exec tail -f /dev/null");
  spec.env["MUSHER_TEST_CONFIG"] = folder_ / "slots/a/robot.toml";
  MustStart(spec);  // without a mark
  WaitForLine();
  spec.mark = mark_;
  const pid_t dog = MustStart(spec);
  WaitForLine();
  const auto found = FindMarkedWith("MUSHER_TEST_CONFIG", folder_ / "slots/a/");
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].pid, dog);
  EXPECT_THAT(FindMarkedWith("MUSHER_TEST_CONFIG", folder_ / "slots/b/"), IsEmpty());
}

TEST_F(ChildProcesses, TheListOfProcessesCannotNameTheInitProcess) {
  EXPECT_THAT(ChildrenFrom("host h\nprocess 1 0 dog\n", "h"), IsEmpty());
}

TEST_F(ChildProcesses, AreStoredForThisBootOfThisHostOnly) {
  const std::vector<ChildProcess> children = {{"dog", 4711, 815}, {"cat", 4712, 816}};
  const std::string text = ToText(children, "this boot/4026531836");
  EXPECT_EQ(ChildrenFrom(text, "this boot/4026531836"), children);
  EXPECT_THAT(ChildrenFrom(text, "the next boot/4026531836"), IsEmpty());
  EXPECT_THAT(ChildrenFrom(text, ""), IsEmpty());
  EXPECT_THAT(ChildrenFrom("host h\nprocess 4711 815 dog\nprocess -1 5 cat\nproc", "h"),
              ElementsAre(children[0]));
}

TEST_F(ChildProcesses, AreKeptInTheFolderOfTheController) {
  const MachineOrigin machine{"robot", "", 0, "/robot.toml"};
  auto store = StateStore::Open(folder_ / "state", machine);
  ASSERT_TRUE(store);
  const std::vector<ChildProcess> children = {{"dog", 4711, 815}};
  ASSERT_TRUE(store.value().SaveChildren(children, "h"));
  EXPECT_EQ(StateStore::LoadChildren(folder_ / "state", "h"), children);
  EXPECT_THAT(StateStore::LoadChildren(folder_ / "nowhere", "h"), IsEmpty());
}

}  // namespace musher::child_processes_test
