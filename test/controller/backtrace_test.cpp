// Real processes, looked at by the real tools where they are installed and may trace, and by small
// scripts in their place for what those can't be brought to do.

#include "musher/controller/process/backtrace.hpp"

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>

#include "musher/base/scheduling.hpp"
#include "musher/controller/process/process_supervisor.hpp"
#include "musher/test/support/temp_folder.hpp"
#include "musher/transport/linux_event_loop.hpp"

extern "C" [[gnu::noinline]] void HangsInHere(int ready) {
  if (write(ready, "r", 1) != 1) _exit(1);
  while (true) pause();
}

namespace musher::backtrace_test {

using ::testing::HasSubstr;

// A child that hangs in a function of that name.
class HungProcess {
 public:
  HungProcess() {
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) std::abort();
    pid_ = fork();
    if (pid_ == 0) HangsInHere(ends[1]);
    char ready = 0;
    if (read(ends[0], &ready, 1) != 1) std::abort();
    for (const int end : ends) close(end);
  }
  HungProcess(const HungProcess&) = delete;
  HungProcess& operator=(const HungProcess&) = delete;
  ~HungProcess() { Kill(); }

  void Kill() {
    if (pid_ == 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
    pid_ = 0;
  }
  pid_t pid() const { return pid_; }

 private:
  pid_t pid_ = 0;
};

// The tools are those in a folder of the test's own, which is all of PATH.
class Backtrace : public ::testing::Test {
 protected:
  Backtrace() { setenv("PATH", folder_.path().c_str(), 1); }
  ~Backtrace() override {
    setenv("PATH", path_before_.c_str(), 1);
    taker_ = nullptr;
    hung_.Kill();
    while (waitpid(-1, nullptr, 0) > 0) {  // tools that were killed
    }
  }

  bool HasTool(const std::string& name) {
    const std::string program = "/usr/bin/" + name;
    if (access(program.c_str(), X_OK) != 0) return false;
    std::filesystem::create_symlink(program, folder_ / name);
    return true;
  }
  void WriteTool(const std::string& name, const std::string& script) {
    std::ofstream(folder_ / name) << "#!/bin/sh\n" << script << "\n";
    chmod((folder_ / name).c_str(), 0700);
  }
  // A tool that stops the process and hangs; when it is killed, the process stays stopped.
  void WriteToolThatHangs() {
    WriteTool("eu-stack",
              "echo $$ > " + (folder_ / "tool") + "; kill -STOP $2; exec /bin/sleep 1000");
  }
  pid_t ToolPid() {
    pid_t pid = 0;
    std::ifstream(folder_ / "tool") >> pid;
    return pid;
  }

  bool Eventually(const std::function<bool()>& condition) {
    const auto tick = loop_.Every(Milliseconds(2), [] {});
    return loop_.RunUntil(condition, loop_.Now() + std::chrono::seconds(120));
  }
  void Begin(pid_t pid, Duration timeout = std::chrono::seconds(120)) {
    taker_->Take(pid, timeout, [this](const Result<std::string>& result) {
      ++calls_;
      result_ = result;
    });
  }
  Result<std::string> Take(pid_t pid, Duration timeout = std::chrono::seconds(120)) {
    result_.reset();
    Begin(pid, timeout);
    EXPECT_FALSE(result_) << "called inside Take()";
    EXPECT_TRUE(Eventually([this] { return result_.has_value(); }));
    return result_.value_or(Error{kCodeFailed, "nothing was reported"});
  }
  Error TakeFails(pid_t pid, Duration timeout = std::chrono::seconds(120)) {
    const auto result = Take(pid, timeout);
    EXPECT_FALSE(result) << result.value();
    return result ? Error{} : result.error();
  }

  const std::string path_before_ = std::getenv("PATH");
  TempFolder folder_;
  transport::LinuxEventLoop loop_;
  transport::DiskWriter disk_{loop_};
  ProcessSupervisor processes_{loop_, disk_, std::chrono::seconds(20)};
  std::unique_ptr<BacktraceTaker> taker_ = std::make_unique<BacktraceTaker>(loop_, processes_);
  std::optional<Result<std::string>> result_;
  int calls_ = 0;
  HungProcess hung_;
};

class BacktraceBy : public Backtrace, public ::testing::WithParamInterface<const char*> {
 protected:
  // The stack of the hung process; empty where this host does not let us look.
  std::string Stack() {
    if (!HasTool(GetParam())) {
      why_not_ = std::string(GetParam()) + " is not installed";
      return {};
    }
    const auto result = Take(hung_.pid());
    if (result) return result.value();
    why_not_ = result.error().message;
    EXPECT_EQ(result.error().code, kCodePermissionDenied) << why_not_;
    return {};
  }

  std::string why_not_;
};

TEST_P(BacktraceBy, ShowsWhereAProcessHangsAndContinuesIt) {
  const std::string stack = Stack();
  if (stack.empty()) GTEST_SKIP() << why_not_;
  EXPECT_THAT(stack, HasSubstr("HangsInHere"));
  EXPECT_TRUE(Eventually([&] { return RunStateOf(hung_.pid()) == ProcessRunState::kRunning; }));
}

TEST_P(BacktraceBy, ShowsWhereAStoppedProcessIsAndLeavesItStopped) {
  kill(hung_.pid(), SIGSTOP);
  ASSERT_TRUE(Eventually([&] { return RunStateOf(hung_.pid()) == ProcessRunState::kStopped; }));
  const std::string stack = Stack();
  if (stack.empty()) GTEST_SKIP() << why_not_;
  EXPECT_THAT(stack, HasSubstr("HangsInHere"));
  EXPECT_TRUE(Eventually([&] { return RunStateOf(hung_.pid()) == ProcessRunState::kStopped; }));
}

INSTANTIATE_TEST_SUITE_P(Tools, BacktraceBy, ::testing::Values("eu-stack", "gdb"),
                         [](const auto& tool) {
                           return tool.param == std::string("gdb") ? "Gdb" : "EuStack";
                         });

TEST_F(Backtrace, PrefersEuStack) {
  WriteTool("gdb", "echo '#0 by gdb'");
  EXPECT_EQ(Take(hung_.pid()).value(), "#0 by gdb\n");
  WriteTool("eu-stack", "echo \"#0 by eu-stack $*\"");
  EXPECT_EQ(Take(hung_.pid()).value(), "#0 by eu-stack -p " + std::to_string(hung_.pid()) + "\n");
}

TEST_F(Backtrace, ReportsAMissingTool) {
  const Error error = TakeFails(hung_.pid());
  EXPECT_EQ(error.code, kCodeUnSupport);
  EXPECT_EQ(error.message,
            "no tool for backtraces, can't run eu-stack: No such file or directory, can't run gdb: "
            "No such file or directory");
}

TEST_F(Backtrace, ReportsThatTheProcessDoesNotExist) {
  WriteTool("eu-stack", "echo '#0'");
  const pid_t pid = hung_.pid();
  hung_.Kill();
  EXPECT_EQ(TakeFails(pid).message, "there is no process " + std::to_string(pid));
}

TEST_F(Backtrace, IsNotTakenOfThisProcess) {
  WriteTool("eu-stack", "echo '#0'");
  EXPECT_EQ(TakeFails(getpid()).code, kCodeParametersInvalid);
}

TEST_F(Backtrace, ReportsAMissingPermission) {
  WriteTool("eu-stack", "echo 'eu-stack: ptrace: Operation not permitted' >&2; exit 2");
  const Error error = TakeFails(hung_.pid());
  EXPECT_EQ(error.code, kCodePermissionDenied);
  EXPECT_THAT(error.message, HasSubstr("CAP_SYS_PTRACE"));
}

TEST_F(Backtrace, ReportsTheOutputOfTheToolWithoutAStack) {
  WriteTool("eu-stack", "echo PID; echo 'no such luck' >&2; exit 1");
  EXPECT_EQ(TakeFails(hung_.pid()).message, "eu-stack shows no stack of process " +
                                                std::to_string(hung_.pid()) +
                                                ": exit code 1, no such luck");
}

TEST_F(Backtrace, IsCutWhereItIsTooLong) {
  WriteTool("eu-stack", "echo '#0'; /usr/bin/head -c 1000000 /dev/zero");
  const auto result = Take(hung_.pid());
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_LT(result.value().size(), 64 * 1024 + 100);
  EXPECT_TRUE(result.value().ends_with("(cut after 65536 bytes)\n"));
}

TEST_F(Backtrace, KillsASlowToolAndContinuesTheProcess) {
  WriteToolThatHangs();
  const Error error = TakeFails(hung_.pid(), Milliseconds(1000));
  EXPECT_EQ(error.code, kCodeTimeout);
  EXPECT_EQ(error.message, "eu-stack did not exit within 1000 ms");
  EXPECT_TRUE(Eventually([this] { return RunStateOf(ToolPid()) == ProcessRunState::kExited; }));
  EXPECT_TRUE(Eventually([&] { return RunStateOf(hung_.pid()) == ProcessRunState::kRunning; }));
  EXPECT_EQ(calls_, 1);
}

TEST_F(Backtrace, IsDiscardedWithItsTaker) {
  WriteToolThatHangs();
  Begin(hung_.pid());
  ASSERT_TRUE(Eventually([&] { return RunStateOf(hung_.pid()) == ProcessRunState::kStopped; }));
  Begin(hung_.pid());  // refused, but not reported any more
  taker_ = nullptr;
  EXPECT_TRUE(Eventually([&] { return RunStateOf(hung_.pid()) == ProcessRunState::kRunning; }));
  EXPECT_EQ(RunStateOf(ToolPid()), ProcessRunState::kExited);
  EXPECT_EQ(calls_, 0);
}

TEST_F(Backtrace, IsTakenOnceAtATimeOfAProcess) {
  WriteToolThatHangs();
  Begin(hung_.pid());
  EXPECT_EQ(TakeFails(hung_.pid()).code, kCodeTargetBusy);
  // Its shell has read the script, which is replaced now.
  ASSERT_TRUE(Eventually([&] { return RunStateOf(hung_.pid()) == ProcessRunState::kStopped; }));
  HungProcess other;
  WriteTool("eu-stack", "echo '#0 other'");
  EXPECT_TRUE(Take(other.pid()));
}

TEST_F(Backtrace, MayDestroyItsTakerOnceItIsComplete) {
  WriteTool("eu-stack", "echo '#0'");
  taker_->Take(hung_.pid(), std::chrono::seconds(120), [this](const Result<std::string>&) {
    taker_ = nullptr;
    ++calls_;
  });
  EXPECT_TRUE(Eventually([this] { return calls_ == 1; }));
}

}  // namespace musher::backtrace_test
