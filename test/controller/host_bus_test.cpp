// The connection to the systemd of another host, up to D-Bus: with a shell in the place of ssh. The
// units themselves are tested in host_units_test.cpp and test/integration/hosts.

#include "musher/controller/process/host_bus.hpp"

#include <gmock/gmock.h>

#include <signal.h>

#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "musher/base/exit_status.hpp"
#include "musher/base/files.hpp"
#include "musher/base/program.hpp"
#include "musher/controller/process/host_uptime.hpp"
#include "musher/controller/process/ssh.hpp"
#include "musher/test/support/temp_folder.hpp"
#include "musher/test/support/wait.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::host_bus_test {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr Duration kSoon = std::chrono::seconds(120);
constexpr const char* kHost = "01234567-89ab-cdef-0123-456789abcdef/4026531836";

class HostConnection : public ::testing::Test {
 protected:
  struct Down {
    bool was_up = false;
    bool for_good = false;
  };

  HostBus Make(const std::string& shell, Duration connect_within = Milliseconds(8'000)) {
    HostBus::Hooks hooks;
    hooks.on_up = [this] { ++ups_; };
    hooks.on_down = [this](bool was_up, bool for_good) { downs_.push_back({was_up, for_good}); };
    hooks.on_signal = [](const BusMessage&) {};
    return HostBus(loop_, {{"sh", "-c", shell}, "root@10.0.0.2", {}, connect_within},
                   std::move(hooks));
  }
  void AwaitDown(std::size_t count = 1) {
    EXPECT_TRUE(loop_.RunUntil([&] { return downs_.size() >= count; }, testing::In(kSoon)));
  }

  transport::LinuxEventLoop loop_;
  int ups_ = 0;
  std::vector<Down> downs_;
};

TEST_F(HostConnection, ThatIsRefusedSaysWhyAndWhatToDo) {
  HostBus bus = Make("echo 'root@10.0.0.2: Permission denied (publickey).' >&2; exit 255");
  bus.Open();
  EXPECT_THAT(downs_, IsEmpty());  // nothing is called inside Open()
  AwaitDown();
  EXPECT_THAT(bus.trouble(), AllOf(HasSubstr("Permission denied (publickey). put the public key"),
                                   HasSubstr("`ssh root@10.0.0.2 true`")));
  EXPECT_TRUE(downs_.front().for_good);
  EXPECT_FALSE(downs_.front().was_up);
  EXPECT_FALSE(bus.is_up());
}

TEST_F(HostConnection, ToAHostThatIsOffIsTriedAgain) {
  HostBus bus = Make("echo 'connect to host 10.0.0.2 port 22: No route to host' >&2; exit 255");
  bus.Open();
  AwaitDown(3);
  EXPECT_FALSE(downs_.back().for_good);
  EXPECT_THAT(bus.trouble(), HasSubstr("No route to host; check that it runs"));
}

TEST_F(HostConnection, ToAHostThatHangsIsGivenUpWithItsNameAndTriedAgain) {
  for (const std::string answer : {"", "echo 'Welcome.'; ", "printf 'musher-host '; "}) {
    SCOPED_TRACE(answer);
    downs_.clear();
    HostBus bus = Make(answer + "exec sleep 1000", Milliseconds(1000));
    bus.Open();
    AwaitDown(answer.empty() ? 2 : 1);
    EXPECT_FALSE(downs_.back().was_up);
    EXPECT_FALSE(downs_.back().for_good);
    EXPECT_THAT(bus.trouble(),
                AllOf(HasSubstr("no answer within 1 s"), HasSubstr("`ssh root@10.0.0.2 true`")));
  }
}

TEST_F(HostConnection, WithoutSshNamesThePackage) {
  HostBus::Hooks hooks;
  hooks.on_down = [this](bool was_up, bool for_good) { downs_.push_back({was_up, for_good}); };
  HostBus bus(loop_, {{"/opt/none/ssh"}, "board"}, std::move(hooks));
  bus.Open();
  AwaitDown();
  EXPECT_THAT(bus.trouble(), HasSubstr("install openssh-client"));
}

// What a login prints before is skipped; what follows the line is D-Bus, which this host ends.
TEST_F(HostConnection, HasTheIdThatTheHostPrints) {
  HostBus bus =
      Make("echo 'Welcome.'; echo 'musher-host " + std::string(kHost) + " 12.34'; exit 0");
  bus.Open();
  AwaitDown();
  EXPECT_EQ(bus.host_id(), kHost);
  EXPECT_EQ(ups_, 0);
}

// What a host prints that has no memory for `cat`, or no /proc.
TEST_F(HostConnection, ToAHostThatDoesNotSayWhichItIsIsNotUsed) {
  for (const std::string greeting :
       {"musher-host /4026531836 12.34", "musher-host 5f3c/4026531836 12.34",
        "musher-host 01234567-89ab-cdef-0123-456789abcdef/ 12.34",
        "musher-host 01234567-89ab-cdef-0123-456789abcdef/4026531836",
        "musher-host 01234567-89ab-cdef-0123-456789abcdef/4026531836 "}) {
    downs_.clear();
    HostBus bus = Make("echo '" + greeting + "'; exec sleep 1000");
    bus.Open();
    AwaitDown();
    EXPECT_THAT(bus.trouble(), HasSubstr("it does not say which host it is; run `ssh root@"));
    EXPECT_THAT(bus.host_id(), IsEmpty());
  }
}

TEST_F(HostConnection, ThatIsClosedEndsItsProgramAndCallsNothing) {
  const TempFolder folder;
  HostBus bus = Make("echo $$ > " + (folder / "pid.new") + "; mv " + (folder / "pid.new") + " " +
                     (folder / "pid") + "; echo Welcome; exec sleep 1000");
  bus.Open();
  ASSERT_TRUE(
      loop_.RunUntil([&] { return !ReadFile(folder / "pid").empty(); }, testing::In(kSoon)));
  const pid_t pid = std::stoi(ReadFile(folder / "pid"));
  bus.Close();
  // On a busy computer it may take longer to end than Close() waits.
  const auto end = ReapChild(pid);
  EXPECT_TRUE(!end || *end == (ExitStatus{true, SIGKILL}));
  EXPECT_THAT(downs_, IsEmpty());
}

// As with hidepid, for a user who is not root.
TEST(HostUptime, IsReadWhereTheFirstProcessIsHidden) {
  std::string script = kReadRunning;
  const std::string first = "/proc/1/stat";
  script.replace(script.find(first), first.size(), "/proc/no-process/stat");
  const auto before = std::chrono::duration_cast<std::chrono::seconds>(SinceBoot()).count();
  ProgramSpec spec;
  spec.argv = {"sh", "-c", script + "echo \"$running\""};
  const auto end = RunProgram(spec, "", kSoon);
  ASSERT_TRUE(end) << end.error().message;
  EXPECT_EQ(end.value().errors, "");
  EXPECT_NEAR(std::stod("0" + end.value().output), static_cast<double>(before), 60);
}

TEST(SshArguments, AskNothingAndTakeTheAddressForNoOption) {
  const auto argv = SshArguments({"board", "10.0.0.2", "root", "/keys/id", "/keys/known hosts"});
  EXPECT_THAT(argv, AllOf(Contains("BatchMode=yes"), Contains("/keys/id"),
                          Contains("UserKnownHostsFile=\"/keys/known hosts\"")));
  EXPECT_THAT(std::vector<std::string>(argv.end() - 4, argv.end()),
              ElementsAre("-l", "root", "--", "10.0.0.2"));
  EXPECT_THAT(SshArguments({"board", "board", "", "", ""}), Not(Contains("-i")));
}

TEST(SshTrouble, HasWhatToDoForEachWayInWhichAHostIsNotReached) {
  struct Case {
    const char* said;  // by ssh, or by the shell there
    const char* cure;
    bool for_good;
  };
  for (const Case& one :
       {Case{"ssh: Could not resolve hostname vison: Name or service not known",
             "; correct its address", false},
        {"root@10.0.0.2: Permission denied (publickey,password).",
         " put the public key into ~/.ssh/authorized_keys of that user", true},
        {"Host key verification failed.", " its key is not known here, or has changed", true},
        {"sh: 1: exec: systemd-stdio-bridge: not found",
         "; install systemd there; its processes need it", true},
        {"Failed to start bus client: No such file or directory", "; its D-Bus does not run",
         false},
        {"ssh: connect to host 10.0.0.2 port 22: Connection timed out",
         "; check that it runs, and that `ssh root@10.0.0.2 true` works", false},
        {"ssh: connect to host 10.0.0.2 port 22: Connection refused",
         "; check that it runs, and that `ssh root@10.0.0.2 true` works", false}}) {
    const SshTrouble trouble = SshTroubleOf(one.said, "root@10.0.0.2");
    EXPECT_THAT(trouble.text, HasSubstr(std::string(one.said) + one.cure));
    EXPECT_EQ(trouble.for_good, one.for_good) << one.said;
  }
}

}  // namespace musher::host_bus_test
