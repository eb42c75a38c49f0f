#include "musher/base/program.hpp"

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <string_view>

#include "musher/test/support/temp_folder.hpp"

namespace musher::program_test {

using ::testing::HasSubstr;
using ::testing::Not;

ProgramSpec Shell(const std::string& line) {
  ProgramSpec spec;
  spec.argv = {"sh", "-c", line};
  return spec;
}

TEST(Program, RunsToItsEndWithItsInputAndBothOutputs) {
  const auto run = RunProgram(Shell("read word; echo got $word; echo odd >&2; exit 3"), "hello\n");
  ASSERT_TRUE(run) << run.error().message;
  EXPECT_EQ(run.value().output, "got hello\n");
  EXPECT_EQ(run.value().errors, "odd\n");
  EXPECT_EQ(run.value().status, (ExitStatus{false, 3}));
  EXPECT_EQ(run.value().status.Text(), "exit code 3");
  EXPECT_FALSE(run.value().timed_out);
}

TEST(Program, IsKilledWhenItsTimeIsOver) {
  const auto run = RunProgram(Shell("exec tail -f /dev/null"), "", Milliseconds(50));
  ASSERT_TRUE(run);
  EXPECT_TRUE(run.value().timed_out);
  EXPECT_EQ(run.value().status.Text(), "killed by SIGKILL");
}

TEST(Program, ReportsWhyItCannotBeExecuted) {
  ProgramSpec spec;
  spec.argv = {"no-such-program"};
  const auto missing = RunProgram(spec, "");
  ASSERT_TRUE(missing && missing.value().failure);
  EXPECT_TRUE(missing.value().failure->missing);
  EXPECT_EQ(missing.value().failure->error.message,
            "can't run no-such-program: No such file or directory");

  spec.argv = {"/etc/passwd"};
  const auto refused = RunProgram(spec, "");
  ASSERT_TRUE(refused && refused.value().failure);
  EXPECT_FALSE(refused.value().failure->missing);
  EXPECT_THAT(refused.value().failure->error.message, HasSubstr("Permission denied"));

  spec = Shell("true");
  spec.cwd = "/no/such/folder";
  const auto nowhere = RunProgram(spec, "");
  ASSERT_TRUE(nowhere && nowhere.value().failure);
  EXPECT_THAT(nowhere.value().failure->error.message, HasSubstr("can't run sh in /no/such/folder"));

  spec.argv.clear();
  EXPECT_EQ(RunProgram(spec, "").error().message, "no command");
}

TEST(Program, GetsTheEnvironmentOfThisProcessWithItsOwnChanges) {
  setenv("MUSHER_TEST_KEPT", "kept", 1);
  setenv("MUSHER_TEST_CHANGED", "before", 1);
  setenv("MUSHER_TEST_DROPPED", "dropped", 1);
  ProgramSpec spec = Shell("env");
  spec.env["MUSHER_TEST_CHANGED"] = "after";
  spec.without = {"MUSHER_TEST_DROPPED"};
  const std::string output = RunProgram(spec, "").value().output;
  EXPECT_THAT(output, HasSubstr("MUSHER_TEST_KEPT=kept\n"));
  EXPECT_THAT(output, HasSubstr("MUSHER_TEST_CHANGED=after\n"));
  EXPECT_THAT(output, Not(HasSubstr("before")));
  EXPECT_THAT(output, Not(HasSubstr("dropped")));
}

TEST(Program, IsSearchedInItsOwnPath) {
  const TempFolder folder;
  std::ofstream(folder / "greet") << "#!/bin/sh\necho hello\n";
  ASSERT_EQ(chmod((folder / "greet").c_str(), 0700), 0);
  ProgramSpec spec;
  spec.argv = {"greet"};
  EXPECT_TRUE(RunProgram(spec, "").value().failure);
  spec.env["PATH"] = "/no/such/folder:" + folder.path() + ":/usr/bin:/bin";
  EXPECT_EQ(RunProgram(spec, "").value().output, "hello\n");
}

// DDS opens sockets without close-on-exec; a program that kept them would keep the port.
TEST(Program, InheritsNoOtherDescriptor) {
  const int left_open = dup(0);
  const std::string output = RunProgram(Shell("ls /proc/self/fd"), "").value().output;
  close(left_open);
  EXPECT_EQ(output, "0\n1\n2\n3\n") << "3 is that of the folder which ls lists";
}

TEST(Program, StartsWithDefaultSignalHandling) {
  const auto before = std::signal(SIGTERM, SIG_IGN);
  const auto run = RunProgram(Shell("kill -TERM $$"), "");
  static_cast<void>(std::signal(SIGTERM, before));
  EXPECT_EQ(run.value().status.Text(), "killed by SIGTERM");
}

TEST(Program, RunsItsHooksInTheChild) {
  ProgramSpec spec = Shell("echo $MUSHER_TEST_MARK");
  spec.env["MUSHER_TEST_MARK"] = "?";
  spec.after_fork = [](char* const* environment) {
    for (; *environment != nullptr; ++environment) {
      char* value = *environment + std::string_view("MUSHER_TEST_MARK=").size();
      if (std::string_view(*environment).starts_with("MUSHER_TEST_MARK=")) *value = '!';
    }
  };
  EXPECT_EQ(RunProgram(spec, "").value().output, "!\n");
  spec.before_exec = [] { return false; };
  EXPECT_EQ(RunProgram(spec, "").value().status, (ExitStatus{false, 127}));
}

}  // namespace musher::program_test
