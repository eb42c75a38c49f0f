// `musher deploy` to two hosts that are folders here, with a script in the place of ssh. With a
// real one it is tested in test/integration/hosts.

#include <gmock/gmock.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <tuple>
#include <utility>

#include "musher/base/exit_status.hpp"
#include "musher/base/files.hpp"
#include "musher/base/program.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/ota/posix_disk.hpp"
#include "musher/ota/root.hpp"
#include "musher/test/cli/program.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/temp_folder.hpp"
#include "musher/test/support/wait.hpp"

namespace musher::cli::deploy_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

namespace fs = std::filesystem;

class Deployed : public ::testing::Test {
 protected:
  Deployed() {
    if (!SupportsHosts()) return;
    setenv("PATH", (folder_.path() + ":" + BinDir() + ":" + path_).c_str(), 1);
    Ssh("");
    Write("from/bin/eyes", "#!/bin/sh\necho 1\n");
    Write("from/bin/ears", "#!/bin/sh\necho 1\n");
    Write("from/eyes.toml", "run = 1\n");
    Write("from/not_named", "x");
    std::string text =
        "[controller]\nname = \"dog\"\nactuators = [\"eyes\", \"ears\"]\nstates = [\"SetUp\", "
        "\"TearDown\", \"Active\"]\ndefault_time = 1000\n[transport]\nprofile = \"lan\"\n";
    for (const auto& [host, address, actuator] :
         {std::tuple("vision", "10.0.0.2", "eyes"), std::tuple("payload", "10.0.0.3", "ears")}) {
      fs::create_directory(folder_ / host);
      text += std::string("[host.") + host + "]\naddress = \"" + address + "\"\n[actuator." +
              actuator + "]\nhost = \"" + host +
              "\"\nstates = [\"SetUp\", \"TearDown\", \"Active\"]\ntimes = [1000, 1000, "
              "1000]\ncommand = [\"" +
              Slot(host) + "/bin/" + actuator + "\", \"eyes.toml\"]\ncwd = \"" + Slot(host) +
              "\"\nenv = { MUSHER_CONFIG = \"" + Slot(host) + "/robot.toml\" }\n";
    }
    Write("robot.toml", text);
    EXPECT_EQ(RunProgram({"ota", "keygen", folder_ / "dog"}).exit, 0);
  }
  ~Deployed() override {
    setenv("PATH", path_.c_str(), 1);
    // InterruptAt() may have left a signal that is blocked.
    sigset_t pending;
    int taken = 0;
    for (const int signal : {SIGINT, SIGTERM}) {
      if (sigpending(&pending) != 0 || sigismember(&pending, signal) != 1) continue;
      sigset_t one;
      sigemptyset(&one);
      sigaddset(&one, signal);
      sigwait(&one, &taken);
    }
  }
  void SetUp() override {
    if (!SupportsHosts()) GTEST_SKIP() << "built without hosts";
  }

  std::string Root(const std::string& host) const { return (folder_ / host) + "/robot"; }
  std::string Slot(const std::string& host) const { return Root(host) + "/current"; }
  void Write(const std::string& path, const std::string& text) const {
    const fs::path file = folder_ / path;
    fs::create_directories(file.parent_path());
    std::ofstream(file) << text;
    fs::permissions(file, fs::perms::owner_all);
  }
  // What runs in the place of ssh before the command; $address is that of the host.
  void Ssh(const std::string& text) const {
    Write("ssh", "#!/bin/sh\nwhile [ \"$1\" != -- ]; do shift; done\naddress=$2; shift 2\n" + text +
                     "\nexec sh -c \"$*\"\n");
  }
  // A program of this name, on the host of this address alone.
  void OnHost(const std::string& address, const std::string& name, const std::string& text) const {
    Write("there/" + name, "#!/bin/sh\n" + text + "\n");
    Ssh("[ $address != " + address + " ] || PATH=" + (folder_ / "there") + ":$PATH");
  }
  // Notes from here on which hosts files are sent to.
  void CountSends() const {
    Ssh("case \"$*\" in *tar*) echo $address >> " + (folder_ / "sends") + ";; esac");
  }
  std::string Sends() const { return ReadFile(folder_ / "sends"); }
  Ran Deploy(const std::string& version) const {
    return RunProgram({"deploy", folder_ / "robot.toml", "--version", version, "--key",
                       folder_ / "dog.key", "--from", folder_ / "from"});
  }
  // Of both hosts.
  void ExpectText(const std::string& text) const {
    EXPECT_EQ(ReadFile(Slot("vision") + "/bin/eyes"), text);
    EXPECT_EQ(ReadFile(Slot("payload") + "/bin/ears"), text);
  }
  void Edit(const std::string& what, const std::string& with) const {
    std::string text = ReadFile(folder_ / "robot.toml");
    const std::size_t at = text.find(what);
    ASSERT_NE(at, std::string::npos) << what;
    text.replace(at, what.size(), with);
    Write("robot.toml", text);
  }
  void MakeKeys(const std::string& folder) const {
    Write("robot.toml",
          ReadFile(folder_ / "robot.toml") + "[security]\nkeys = \"" + folder + "\"\n");
    const Ran keys = RunProgram({"keys", "init", folder_ / "robot.toml"});
    ASSERT_EQ(keys.exit, 0) << keys.err;
  }
  static Ran Step(const std::string& step, const std::string& root, const std::string& version) {
    return RunProgram({"deploy", "--step", step, "--root", root, "--version", version});
  }
  // As a person who presses Ctrl-C while this host takes a step.
  void InterruptAt(const std::string& step) const {
    OnHost("10.0.0.3", "musher",
           "case \"$*\" in *'--step " + step + "'*) kill -INT " + std::to_string(getpid()) +
               ";; esac\nexec " + BinDir() + "/musher \"$@\"");
  }
  void Change(const std::string& text) const {
    Write("from/bin/eyes", text);
    Write("from/bin/ears", text);
  }

  const std::string path_ = getenv("PATH");
  const TempFolder folder_;
};

TEST_F(Deployed, FilesAreAVersionInASlotOfEachHost) {
  const Ran first = Deploy("1.0.0");
  ASSERT_EQ(first.exit, 0) << first.err;
  EXPECT_THAT(first.out,
              AllOf(HasSubstr("vision: version 1.0.0 in " + Root("vision") + ", 3 files"),
                    HasSubstr("musher restart eyes ears")));
  ExpectText("#!/bin/sh\necho 1\n");
  EXPECT_EQ(ReadFile(Slot("vision") + "/eyes.toml"), "run = 1\n");
  EXPECT_EQ(ReadFile(Slot("vision") + "/robot.toml"), ReadFile(folder_ / "robot.toml"));
  EXPECT_FALSE(fs::exists(Slot("vision") + "/bin/ears"));  // of the other host
  EXPECT_FALSE(fs::exists(Slot("vision") + "/not_named"));
  EXPECT_FALSE(fs::exists(Root("vision") + ".incoming"));
  EXPECT_EQ(RunProgram({"ota", "status", "--root", Root("vision")}).exit, 0);

  const std::string before = fs::read_symlink(Slot("vision"));
  Change("#!/bin/sh\necho 2\n");
  const Ran second = Deploy("1.1.0");
  ASSERT_EQ(second.exit, 0) << second.err;
  ExpectText("#!/bin/sh\necho 2\n");
  EXPECT_NE(fs::read_symlink(Slot("vision")), before);
  // What was started from the version before may still read it.
  EXPECT_EQ(ReadFile(Root("vision") + "/" + before + "/bin/eyes"), "#!/bin/sh\necho 1\n");
}

TEST_F(Deployed, FilesOfOneHostGoBeforeThoseOfAll) {
  Write("from/payload/bin/ears", "of the payload");
  ASSERT_EQ(Deploy("1.0.0").exit, 0);
  EXPECT_EQ(ReadFile(Slot("payload") + "/bin/ears"), "of the payload");
}

TEST_F(Deployed, VersionIsOnNoHostIfOneOfThemDoesNotFit) {
  struct Misfit {
    const char* program;  // of the payload
    const char* text;
    const char* reason;
  };
  const Misfit misfits[] = {
      {"musher", "echo musher 0.0.1", "it has musher 0.0.1, this program is"},
      {"df", "echo; echo disk 100 99 1 99% /", "it needs 5 MiB for "},
      {"od", "echo ' b7 00'", "bin/ears is built for another processor than this host's"},
  };
  fs::copy_file("/bin/true", folder_ / "from/bin/ears", fs::copy_options::overwrite_existing);
  for (const Misfit& misfit : misfits) {
    OnHost("10.0.0.3", misfit.program, misfit.text);
    const Ran ran = Deploy("1.0.0");
    EXPECT_EQ(ran.exit, 1);
    EXPECT_THAT(ran.err, AllOf(HasSubstr("host payload (10.0.0.3): "), HasSubstr(misfit.reason),
                               HasSubstr("version 1.0.0 is on no host")));
    for (const char* host : {"vision", "payload"}) {
      for (const char* made : {"", ".incoming", ".new"}) {
        EXPECT_FALSE(fs::exists(Root(host) + made)) << misfit.reason << made;
      }
    }
    fs::remove((folder_ / "there/") + misfit.program);
  }
}

TEST_F(Deployed, VersionThatIsNotNewerIsRefusedBeforeAnyHostIsSwitched) {
  ASSERT_EQ(Deploy("1.0.0").exit, 0);
  Change("#!/bin/sh\necho 2\n");
  const Ran ran = Deploy("1.0.0");
  EXPECT_EQ(ran.exit, 1);
  EXPECT_THAT(ran.err, AllOf(HasSubstr("host vision (10.0.0.2): it is the same version"),
                             HasSubstr("host payload (10.0.0.3): it is the same version")));
  ExpectText("#!/bin/sh\necho 1\n");
}

TEST_F(Deployed, HostsAreSwitchedBackIfOneOfThemIsNotSwitched) {
  ASSERT_EQ(Deploy("1.0.0").exit, 0);
  Change("#!/bin/sh\necho 2\n");
  OnHost("10.0.0.3", "musher",
         "case \"$*\" in *'--step switch'*) echo 'musher: the disk is read-only'; exit 1;; "
         "esac\nexec " +
             BinDir() + "/musher \"$@\"");
  const Ran ran = Deploy("1.1.0");
  EXPECT_EQ(ran.exit, 1);
  EXPECT_THAT(ran.err, AllOf(HasSubstr("host payload (10.0.0.3): the disk is read-only"),
                             HasSubstr("version 1.1.0 is on no host")));
  ExpectText("#!/bin/sh\necho 1\n");
  // Also without a version before it.
  for (const char* host : {"vision", "payload"}) fs::remove_all(Root(host));
  EXPECT_EQ(Deploy("1.1.0").exit, 1);
  EXPECT_FALSE(fs::exists(Root("vision")));
  Ssh("");
  ASSERT_EQ(Deploy("1.1.0").exit, 0);
  ExpectText("#!/bin/sh\necho 2\n");
}

// All of it is repeated; what a host has is neither sent nor written again.
TEST_F(Deployed, DeploymentThatDiedBetweenTwoSwitchesIsRepeated) {
  ASSERT_EQ(Deploy("1.0.0").exit, 0);
  Change("#!/bin/sh\necho 2\n");
  const std::string before = fs::read_symlink(Slot("payload"));
  ASSERT_EQ(Deploy("1.1.0").exit, 0);
  ASSERT_EQ(Step("undo", Root("payload"), "1.1.0").exit, 0);
  ASSERT_EQ(fs::read_symlink(Slot("payload")), before);
  CountSends();
  const Ran again = Deploy("1.1.0");
  ASSERT_EQ(again.exit, 0) << again.err;
  EXPECT_THAT(again.out, AllOf(HasSubstr("vision: has had version 1.1.0 in "),
                               HasSubstr("payload: version 1.1.0 in ")));
  EXPECT_EQ(Sends(), "10.0.0.3\n");
  ExpectText("#!/bin/sh\necho 2\n");
  const Ran last = Deploy("1.1.0");
  EXPECT_EQ(last.exit, 0) << last.err;
  EXPECT_EQ(Sends(), "10.0.0.3\n");
}

TEST_F(Deployed, HostThatHasStagedTheVersionIsOnlySwitched) {
  ASSERT_EQ(Deploy("1.0.0").exit, 0);
  Change("#!/bin/sh\necho 2\n");
  // Neither the switch nor the way back reaches it, and the other one is switched back.
  OnHost("10.0.0.3", "musher",
         "case \"$*\" in *'--step switch'*|*'--step undo'*) kill -9 $PPID; exit;; esac\nexec " +
             BinDir() + "/musher \"$@\"");
  EXPECT_EQ(Deploy("1.1.0").exit, 1);
  ExpectText("#!/bin/sh\necho 1\n");
  CountSends();
  const Ran again = Deploy("1.1.0");
  ASSERT_EQ(again.exit, 0) << again.err;
  EXPECT_EQ(Sends(), "10.0.0.2\n");
  ExpectText("#!/bin/sh\necho 2\n");
}

TEST_F(Deployed, BoardThatWasReplacedGetsTheVersionOfTheOthers) {
  ASSERT_EQ(Deploy("1.0.0").exit, 0);
  fs::remove_all(Root("payload"));
  CountSends();
  const Ran ran = Deploy("1.0.0");
  ASSERT_EQ(ran.exit, 0) << ran.err;
  EXPECT_EQ(Sends(), "10.0.0.3\n");
  ExpectText("#!/bin/sh\necho 1\n");
}

TEST_F(Deployed, HostThatHadTheVersionKeepsItWhereAnotherIsNotSwitched) {
  ASSERT_EQ(Deploy("1.0.0").exit, 0);
  fs::remove_all(Root("payload"));
  OnHost("10.0.0.3", "musher",
         "case \"$*\" in *'--step switch'*) echo 'musher: the disk is read-only'; exit 1;; "
         "esac\nexec " +
             BinDir() + "/musher \"$@\"");
  const Ran ran = Deploy("1.0.0");
  EXPECT_EQ(ran.exit, 1);
  EXPECT_THAT(ran.err, AllOf(HasSubstr("host payload (10.0.0.3): the disk is read-only"),
                             HasSubstr("version 1.0.0 is on no other host than before: vision")));
  EXPECT_EQ(ReadFile(Slot("vision") + "/bin/eyes"), "#!/bin/sh\necho 1\n");
  EXPECT_FALSE(fs::exists(Root("payload")));
}

// The state is written first, and the link last.
TEST_F(Deployed, SwitchThatWasCutBeforeItsLinkIsRepeated) {
  ASSERT_EQ(Deploy("1.0.0").exit, 0);
  const std::string before = fs::read_symlink(Slot("vision"));
  Change("#!/bin/sh\necho 2\n");
  ASSERT_EQ(Deploy("1.1.0").exit, 0);
  fs::remove(Slot("vision"));
  fs::create_directory_symlink(before, Slot("vision"));
  const Ran again = Deploy("1.1.0");
  EXPECT_EQ(again.exit, 0) << again.err;
  EXPECT_THAT(again.out, HasSubstr("vision: version 1.1.0 in "));
  ExpectText("#!/bin/sh\necho 2\n");
}

// A file there was altered since: the version is not taken for whole.
TEST_F(Deployed, VersionThatIsDamagedThereIsNotTakenForTheSame) {
  ASSERT_EQ(Deploy("1.0.0").exit, 0);
  const std::string file = Slot("vision") + "/eyes.toml";
  fs::permissions(file, fs::perms::owner_write, fs::perm_options::add);
  std::ofstream(file) << "run = 2\n";
  const Ran ran = Deploy("1.0.0");
  EXPECT_EQ(ran.exit, 1);
  EXPECT_THAT(ran.err, AllOf(HasSubstr("host vision (10.0.0.2): "), HasSubstr("eyes.toml")));
}

TEST_F(Deployed, HostThatIsLostWhileItIsSwitchedIsNamedWithWhatToDo) {
  ASSERT_EQ(Deploy("1.0.0").exit, 0);
  Change("#!/bin/sh\necho 2\n");
  // It is switched, and is not reached any more.
  OnHost("10.0.0.3", "musher",
         BinDir() + "/musher \"$@\" || exit\ncase \"$*\" in *'--step switch'*) touch " +
             (folder_ / "lost") + "; kill -9 $PPID;; esac");
  Ssh("[ $address != 10.0.0.3 ] || { PATH=" + (folder_ / "there") + ":$PATH; [ ! -e " +
      (folder_ / "lost") + " ] || { echo 'connect: No route to host' >&2; exit 255; }; }");
  const Ran ran = Deploy("1.1.0");
  EXPECT_EQ(ran.exit, 1);
  EXPECT_THAT(
      ran.err,
      AllOf(HasSubstr("host payload (10.0.0.3): connect: No route to host"),
            HasSubstr("it may run version 1.1.0 now"), HasSubstr("version 1.1.0 may be on a host"),
            HasSubstr("musher deploy --step undo --root " + Root("payload") + " --version 1.1.0")));
  EXPECT_EQ(ReadFile(Slot("vision") + "/bin/eyes"), "#!/bin/sh\necho 1\n");
  EXPECT_EQ(
      RunProgram({"deploy", "--step", "undo", "--root", Root("payload"), "--version", "1.1.0"})
          .exit,
      0);
  ExpectText("#!/bin/sh\necho 1\n");
}

TEST_F(Deployed, LateSwitchFindsItsVersionWithdrawn) {
  ASSERT_EQ(Deploy("1.0.0").exit, 0);
  Change("#!/bin/sh\necho 2\n");
  OnHost("10.0.0.3", "musher",
         "case \"$*\" in *'--step switch'*) kill -9 $PPID; exit;; esac\nexec " + BinDir() +
             "/musher \"$@\"");
  const Ran ran = Deploy("1.1.0");
  EXPECT_EQ(ran.exit, 1);
  EXPECT_THAT(ran.err, HasSubstr("version 1.1.0 is on no host"));
  const Ran late = Step("switch", Root("payload"), "1.1.0");
  EXPECT_EQ(late.exit, 1);
  EXPECT_THAT(late.err, HasSubstr("version 1.1.0 is not staged any more"));
  ExpectText("#!/bin/sh\necho 1\n");
  // Also of a first version.
  for (const char* host : {"vision", "payload"}) fs::remove_all(Root(host));
  EXPECT_EQ(Deploy("1.1.0").exit, 1);
  EXPECT_EQ(Step("switch", Root("payload"), "1.1.0").exit, 1);
  EXPECT_FALSE(fs::exists(Root("payload")));
}

// The next start of the root would have tried it.
TEST_F(Deployed, UndoLeavesNoTrialBootOfASwitchThatWasCutInTheMiddle) {
  ASSERT_EQ(Deploy("1.0.0").exit, 0);
  Change("#!/bin/sh\necho 2\n");
  OnHost("10.0.0.3", "musher",
         "case \"$*\" in *'--step switch'*|*'--step undo'*) kill -9 $PPID; exit;; esac\nexec " +
             BinDir() + "/musher \"$@\"");
  EXPECT_EQ(Deploy("1.1.0").exit, 1);
  ota::PosixDisk disk;
  const auto root = ota::Root::Open(disk, Root("payload"));
  ASSERT_TRUE(root) << root.error().message;
  // As the switch leaves it between its two writes.
  ASSERT_TRUE(root.value().Change([](const ota::SlotState& staged) -> Result<ota::SlotState> {
    EXPECT_EQ(staged.installing, "1.1.0");
    ota::SlotState next = staged;
    next.on_trial_boot = true;
    next.installing.clear();
    return next;
  }));
  EXPECT_EQ(Step("undo", Root("payload"), "1.0.0-other").exit, 0);
  EXPECT_TRUE(root.value().State().value().on_trial_boot) << "of another version";
  EXPECT_EQ(Step("undo", Root("payload"), "1.1.0").exit, 0);
  EXPECT_FALSE(root.value().State().value().on_trial_boot);
  ExpectText("#!/bin/sh\necho 1\n");
}

TEST_F(Deployed, RootStaysWhereTheVersionBeforeCannotBeRead) {
  ASSERT_EQ(Deploy("1.0.0").exit, 0);
  const fs::path before = fs::path(Root("vision")) / fs::read_symlink(Slot("vision"));
  Change("#!/bin/sh\necho 2\n");
  ASSERT_EQ(Deploy("1.1.0").exit, 0);
  fs::remove(before / "manifest.toml");
  EXPECT_EQ(Step("undo", Root("vision"), "1.1.0").exit, 1);
  ExpectText("#!/bin/sh\necho 2\n");
}

TEST_F(Deployed, SlotThatTheLinkLeadsToIsNotWrittenOver) {
  ASSERT_EQ(Deploy("1.0.0").exit, 0);
  const std::string before = fs::read_symlink(Slot("vision"));
  Change("#!/bin/sh\necho 2\n");
  ASSERT_EQ(Deploy("1.1.0").exit, 0);
  fs::remove(Slot("vision"));
  fs::create_directory_symlink(before, Slot("vision"));
  const Ran ran = Deploy("1.2.0");
  EXPECT_EQ(ran.exit, 1);
  EXPECT_THAT(ran.err, HasSubstr("leads to " + before +
                                 " still: it was not replaced; run there: "
                                 "ln -sfn slots/"));
  EXPECT_EQ(ReadFile(Slot("vision") + "/bin/eyes"), "#!/bin/sh\necho 1\n");
}

TEST_F(Deployed, HostWithoutItsLinkIsSwitchedBackToo) {
  ASSERT_EQ(Deploy("1.0.0").exit, 0);
  const std::string before = fs::read_symlink(Slot("payload"));
  Change("#!/bin/sh\necho 2\n");
  // Its state is that of the new version.
  OnHost("10.0.0.3", "musher",
         BinDir() + "/musher \"$@\" || exit\ncase \"$*\" in *'--step switch'*) ln -sfn " + before +
             " " + Slot("payload") + "; echo 'musher: it was not replaced'; exit 1;; esac");
  const Ran ran = Deploy("1.1.0");
  EXPECT_EQ(ran.exit, 1);
  EXPECT_THAT(ran.err, HasSubstr("version 1.1.0 is on no host"));
  ExpectText("#!/bin/sh\necho 1\n");
  Ssh("");
  const Ran next = Deploy("1.2.0");
  EXPECT_EQ(next.exit, 0) << next.err;
  ExpectText("#!/bin/sh\necho 2\n");
}

TEST_F(Deployed, SlotFromWhichAProcessRunsIsNotWrittenOver) {
  fs::copy_file("/bin/sleep", folder_ / "from/bin/eyes", fs::copy_options::overwrite_existing);
  ASSERT_EQ(Deploy("1.0.0").exit, 0);
  const auto eyes = ForkProgram({{Slot("vision") + "/bin/eyes", "1000"}, "", {}});
  ASSERT_TRUE(eyes);
  ASSERT_FALSE(eyes.value().Failure(std::chrono::seconds(120)));
  EXPECT_EQ(Deploy("1.1.0").exit, 0);
  const Ran ran = Deploy("1.2.0");
  EXPECT_EQ(ran.exit, 1);
  EXPECT_THAT(ran.err, AllOf(HasSubstr("process " + std::to_string(eyes.value().pid()) +
                                       " (eyes) runs from " + Root("vision") + "/slots/"),
                             HasSubstr("version 1.2.0 is on no host")));
  kill(eyes.value().pid(), SIGKILL);
  ReapChild(eyes.value().pid());
  EXPECT_EQ(Deploy("1.2.0").exit, 0);
}

TEST_F(Deployed, InterruptedBeforeTheSwitchLeavesNothingHere) {
  fs::create_directory(folder_ / "tmp");
  setenv("TMPDIR", (folder_ / "tmp").c_str(), 1);
  ASSERT_EQ(Deploy("1.0.0").exit, 0);
  Change("#!/bin/sh\necho 2\n");
  InterruptAt("stage");
  const Ran ran = Deploy("1.1.0");
  EXPECT_EQ(ran.exit, 130);
  EXPECT_THAT(ran.err, AllOf(HasSubstr("interrupted"), HasSubstr("version 1.1.0 is on no host")));
  ExpectText("#!/bin/sh\necho 1\n");
  EXPECT_TRUE(fs::is_empty(folder_ / "tmp"));
  unsetenv("TMPDIR");
}

// It went on until the files were sent, for a quarter of an hour at most.
TEST_F(Deployed, InterruptedWhileItSendsEndsWithItsSsh) {
  fs::create_directory(folder_ / "tmp");
  setenv("TMPDIR", (folder_ / "tmp").c_str(), 1);
  Ssh("case \"$*\" in *tar*) head -c 100 > " + (folder_ / "half") + "; echo $$ > " +
      (folder_ / "pid") + "; kill -TERM " + std::to_string(getpid()) + "; exec sleep 1000;; esac");
  const Ran ran = Deploy("1.0.0");
  unsetenv("TMPDIR");
  EXPECT_EQ(ran.exit, 130);
  EXPECT_THAT(ran.err, AllOf(HasSubstr("interrupted"), HasSubstr("version 1.0.0 is on no host")));
  const pid_t ssh = std::stoi(ReadFile(folder_ / "pid"));
  // Empty also where it was killed and not reaped yet.
  const std::string command = "/proc/" + std::to_string(ssh) + "/cmdline";
  EXPECT_TRUE(testing::Until([&] { return ReadFile(command).empty(); }));
  EXPECT_TRUE(fs::is_empty(folder_ / "tmp"));
  EXPECT_FALSE(fs::exists(Root("vision")));
}

// A part of the files has arrived: it is no version, and does not stand in the way of the next.
TEST_F(Deployed, HalfOfTheFilesIsNoVersion) {
  ASSERT_EQ(Deploy("1.0.0").exit, 0);
  Change("#!/bin/sh\necho 2\n");
  Ssh("case \"$*\" in *tar*) head -c 3000 | sh -c \"$*\"; exit 1;; esac");
  EXPECT_EQ(Deploy("1.1.0").exit, 1);
  EXPECT_EQ(Step("stage", Root("vision"), "1.1.0").exit, 1);
  EXPECT_EQ(Step("switch", Root("vision"), "1.1.0").exit, 1);
  ExpectText("#!/bin/sh\necho 1\n");
  Ssh("");
  ASSERT_EQ(Deploy("1.1.0").exit, 0);
  ExpectText("#!/bin/sh\necho 2\n");
}

TEST_F(Deployed, SwitchThatWasBegunIsNotInterrupted) {
  ASSERT_EQ(Deploy("1.0.0").exit, 0);
  Change("#!/bin/sh\necho 2\n");
  InterruptAt("switch");
  const Ran ran = Deploy("1.1.0");
  EXPECT_EQ(ran.exit, 0) << ran.err;
  ExpectText("#!/bin/sh\necho 2\n");
}

// No machine runs here.
TEST_F(Deployed, VersionStaysWhereNothingCouldBeRestarted) {
  const Ran ran = RunProgram({"deploy", folder_ / "robot.toml", "--version", "1.0.0", "--key",
                              folder_ / "dog.key", "--from", folder_ / "from", "--restart"});
  EXPECT_NE(ran.exit, 0);
  EXPECT_THAT(ran.err, HasSubstr("all hosts have the version, and not restarted with it: eyes"));
  ExpectText("#!/bin/sh\necho 1\n");
}

TEST_F(Deployed, ModuleMayBeAScriptOfPythonWithItsOwnModules) {
  Write("from/eyes.py", "import sight\n");
  Write("from/lib/sight.py", "print('eyes')\n");
  Edit("\"" + Slot("vision") + "/bin/eyes\"", "\"python3\", \"" + Slot("vision") + "/eyes.py\"");
  Edit("/robot.toml\" }", "/robot.toml\", PYTHONPATH = \"" + Slot("vision") + "/lib\" }");
  const Ran ran = Deploy("1.0.0");
  ASSERT_EQ(ran.exit, 0) << ran.err;
  const auto run =
      musher::RunProgram({{"env", "PYTHONPATH=" + Slot("vision") + "/lib",
                           "PYTHONDONTWRITEBYTECODE=1", "python3", Slot("vision") + "/eyes.py"},
                          "",
                          {}},
                         "");
  ASSERT_TRUE(run);
  EXPECT_EQ(run.value().output, "eyes\n") << run.value().errors;
}

TEST_F(Deployed, ListInTheEnvironmentMayNameAFolderOfTheSlot) {
  Write("from/lib/libeyes.so", "x");
  Edit("env = { ", "env = { LD_LIBRARY_PATH = \"" + Slot("vision") + "/lib:/usr/lib\", ");
  const Ran ran = Deploy("1.0.0");
  ASSERT_EQ(ran.exit, 0) << ran.err;
  EXPECT_TRUE(fs::exists(Slot("vision") + "/lib/libeyes.so"));
}

TEST_F(Deployed, LinkToAFolderInANamedFolderIsSaidNotToBeCopied) {
  Write("from/lib/1.2/libeyes.so", "x");
  fs::create_directory_symlink("1.2", folder_ / "from/lib/now");
  fs::create_symlink("1.2/libeyes.so", folder_ / "from/lib/libeyes.so");
  Edit("env = { ", "env = { LD_LIBRARY_PATH = \"" + Slot("vision") + "/lib\", ");
  const Ran ran = Deploy("1.0.0");
  ASSERT_EQ(ran.exit, 0) << ran.err;
  EXPECT_THAT(ran.err, AllOf(HasSubstr("from/lib/now is not copied: it is a link to a folder"),
                             ::testing::Not(HasSubstr("libeyes.so is not copied"))));
  EXPECT_EQ(ReadFile(Slot("vision") + "/lib/libeyes.so"), "x");
}

TEST_F(Deployed, FilesThatAreMissingHereAreNamed) {
  fs::remove(folder_ / "from/bin/eyes");
  const Ran ran = Deploy("1.0.0");
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.err, HasSubstr("actuator.eyes: bin/eyes is neither in "));
}

TEST_F(Deployed, KeysAreThoseOfTheActuatorsOfAHost) {
  MakeKeys("keys");
  const Ran ran = Deploy("1.0.0");
  ASSERT_EQ(ran.exit, 0) << ran.err;
  const fs::path key = Slot("vision") + "/keys/eyes.key";
  EXPECT_EQ(ReadFile(key), ReadFile(folder_ / "keys/eyes.key"));
  EXPECT_EQ(fs::status(key).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_TRUE(fs::exists(Slot("vision") + "/keys/identity_ca.cert"));
  for (const char* of_others : {"ears.key", "controller.key", "operator.key", "ca"}) {
    EXPECT_FALSE(fs::exists(Slot("vision") + "/keys/" + of_others)) << of_others;
  }
}

TEST_F(Deployed, FolderThatIsNamedGivesNoKeysAway) {
  MakeKeys("from/keys");
  fs::copy_file(folder_ / "dog.key", folder_ / "from/data.pem");
  Write("from/id_ed25519", "-----BEGIN OPENSSH PRIVATE KEY-----\n");
  Write("from/account.json", R"({"private_key": "-----BEGIN PRIVATE KEY-----\nMII"})");
  Edit("\"eyes.toml\"", "\".\"");
  const Ran ran = Deploy("1.0.0");
  ASSERT_EQ(ran.exit, 0) << ran.err;
  EXPECT_THAT(ran.err, HasSubstr("id_ed25519 is not copied: it is a private key"));
  EXPECT_TRUE(fs::exists(Slot("vision") + "/not_named"));
  EXPECT_TRUE(fs::exists(Slot("vision") + "/from/keys/eyes.key"));
  for (const auto& entry : fs::recursive_directory_iterator(Root("vision"))) {
    if (!entry.is_regular_file() || entry.path().filename() == "eyes.key") continue;
    EXPECT_EQ(ReadFile(entry.path()).find("PRIVATE KEY"), std::string::npos) << entry.path();
  }
}

TEST_F(Deployed, PrivateKeyThatIsNamedIsRefused) {
  MakeKeys("from/keys");
  fs::copy_file(folder_ / "dog.key", folder_ / "from/data.pem");
  for (const auto& [word, reason] :
       {std::pair("\"data.pem\"", "data.pem is a private key"),
        std::pair("\"keys/controller.key\"", "controller.key is none of its own keys")}) {
    const std::string before = ReadFile(folder_ / "robot.toml");
    Edit("\"eyes.toml\"", word);
    const Ran ran = Deploy("1.0.0");
    EXPECT_EQ(ran.exit, 2);
    EXPECT_THAT(ran.err, HasSubstr(reason));
    Write("robot.toml", before);
  }
}

TEST_F(Deployed, KeysAreBesideTheConfigThatNamesThem) {
  MakeKeys("keys");
  Edit(Slot("vision") + "/robot.toml", Slot("vision") + "/etc/robot.toml");
  const Ran ran = Deploy("1.0.0");
  ASSERT_EQ(ran.exit, 0) << ran.err;
  EXPECT_TRUE(fs::exists(Slot("vision") + "/etc/keys/eyes.key"));
  EXPECT_TRUE(fs::exists(Slot("payload") + "/keys/ears.key"));
}

TEST_F(Deployed, RulesAreBesideTheConfigThatNamesThem) {
  Write("robot.toml", ReadFile(folder_ / "robot.toml") + "[safety]\nrules = \"etc/rules.txt\"\n");
  Write("etc/rules.txt", "never ears Active while eyes is exited\n");
  Edit(Slot("vision") + "/robot.toml", Slot("vision") + "/in/robot.toml");
  const Ran ran = Deploy("1.0.0");
  ASSERT_EQ(ran.exit, 0) << ran.err;
  EXPECT_THAT(ran.err, Not(HasSubstr("rules")));
  for (const std::string& slot : {Slot("vision") + "/in", Slot("payload")}) {
    EXPECT_EQ(ReadFile(slot + "/etc/rules.txt"), ReadFile(folder_ / "etc/rules.txt"));
    EXPECT_THAT(RunProgram({"check", slot + "/robot.toml"}).out, Not(HasSubstr("rules.txt")));
  }
}

TEST_F(Deployed, RulesThatAreNotCopiedAreNamed) {
  const std::string robot = ReadFile(folder_ / "robot.toml");
  for (const auto& [rules, reason] :
       {std::pair("missing.txt", "it is missing here"), std::pair("../ssh", "it is not below ")}) {
    Write("dog/robot.toml", robot + "[safety]\nrules = \"" + rules + "\"\n");
    const Ran ran = RunProgram({"deploy", folder_ / "dog/robot.toml", "--version", "1.0.0", "--key",
                                folder_ / "dog.key", "--from", folder_ / "from"});
    EXPECT_EQ(ran.exit, 0) << ran.err;
    EXPECT_THAT(ran.err, HasSubstr(reason));
    fs::remove_all(Root("vision"));
    fs::remove_all(Root("payload"));
  }
}

// The bytes of a key are no rules; `deploy` reads them before any other program does.
TEST_F(Deployed, PrivateKeyThatIsNamedAsRulesIsRefused) {
  Write("robot.toml", ReadFile(folder_ / "robot.toml") + "[safety]\nrules = \"dog.key\"\n");
  const Ran ran = Deploy("1.0.0");
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.err, HasSubstr("dog.key is a private key"));
}

TEST_F(Deployed, KeyOfAnotherUserThanTheLoginIsRefused) {
  MakeKeys("keys");
  Edit("[actuator.eyes]\n", "[actuator.eyes]\nuser = \"robot\"\n");
  const Ran ran = Deploy("1.0.0");
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.err, HasSubstr("limits.user robot could not read its key"));
}

TEST_F(Deployed, FilesAreNotSignedWithAKeyThatOthersMayRead) {
  fs::permissions(folder_ / "dog.key", fs::perms::others_read, fs::perm_options::add);
  const Ran ran = Deploy("1.0.0");
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.err, HasSubstr("chmod 600 "));
}

TEST_F(Deployed, FolderThatIsNoRootIsNotTouched) {
  Write("vision/robot/notes", "mine");
  const Ran ran = Deploy("1.0.0");
  EXPECT_EQ(ran.exit, 1);
  EXPECT_THAT(ran.err, HasSubstr("is not an upgrade root and not empty: move it away"));
  EXPECT_EQ(ReadFile(Root("vision") + "/notes"), "mine");
  EXPECT_FALSE(fs::exists(Root("payload")));
}

TEST(Deploy, NeedsAnActuatorThatIsStartedFromARoot) {
  if (!SupportsHosts()) GTEST_SKIP() << "built without hosts";
  const TempFolder folder;
  ASSERT_EQ(RunProgram({"ota", "keygen", folder / "dog"}).exit, 0);
  const Ran ran = RunProgram({"deploy", SourceDir() + "/test/golden/configs/good/hosts_limits.toml",
                              "--version", "1.0.0", "--key", folder / "dog.key"});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.err, HasSubstr("such as /opt/robot/current/bin/eyes"));
}

}  // namespace musher::cli::deploy_test
