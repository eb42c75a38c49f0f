// The units of another host, on a fake systemd (fake_systemd.cpp) behind a script in the place of
// ssh. With a real systemd they are tested in test/integration/hosts.

#include "musher/controller/process/host_units.hpp"

#include <gmock/gmock.h>

#include <fcntl.h>
#include <signal.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "musher/base/exit_status.hpp"
#include "musher/base/files.hpp"
#include "musher/base/program.hpp"
#include "musher/controller/process/bus_systemd.hpp"
#include "musher/controller/process/host_uptime.hpp"
#include "musher/controller/shell/actuator_processes.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/process.hpp"
#include "musher/test/support/temp_folder.hpp"
#include "musher/test/support/wait.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::host_units_test {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

constexpr Duration kSoon = std::chrono::seconds(120);
constexpr const char* kOurs = "MUSHER_MACHINE_ID=ours";
constexpr const char* kFirstBoot = "01234567-89ab-cdef-0123-456789abcdef/4026531836";
constexpr const char* kSecondBoot = "76543210-89ab-cdef-0123-456789abcdef/4026531836";

class UnitOfAnotherHost : public ::testing::Test {
 protected:
  UnitOfAnotherHost() {
    const std::string ssh = folder_ / "ssh";
    std::ofstream(ssh) << "#!/bin/sh\nfor word; do :; done\necho \"$word\" >> "
                       << (folder_ / "commands") << "\n[ ! -e " << (folder_ / "off")
                       << " ] || {\n  echo >> " << (folder_ / "tries")
                       << "\n  echo 'connect to host 10.0.0.2 port 22: No route to host' >&2\n"
                       << "  exit 255\n}\ncat " << (folder_ / "greeting") << "\nexec " << BinDir()
                       << "/controller_fake_systemd " << folder_.path() << "\n";
    std::filesystem::permissions(ssh, std::filesystem::perms::owner_all);
    setenv("PATH", (folder_.path() + ":" + path_).c_str(), 1);
    config_.name = "robot";
    HostConfig& host = config_.hosts.emplace_back();
    host.name = "vision";
    host.address = "10.0.0.2";
    ActuatorConfig eyes;
    eyes.name = "eyes";
    eyes.host = "vision";
    eyes.command = {"/opt/eyes", "$HOME"};
    config_.actuators.push_back(eyes);
    Greet(kFirstBoot, 1000);
    Make();
  }
  ~UnitOfAnotherHost() override {
    units_->Close();
    setenv("PATH", path_.c_str(), 1);
  }

  void Make(Duration start_within = kSoon, Duration reach_within = std::chrono::hours(1)) {
    units_ = std::make_unique<HostUnits>(
        loop_, config_,
        [this] {
          return MachineIdentity{"robot", id_};
        },
        BySsh(loop_),
        HostUnits::Options{.start_within = start_within,
                           .reach_within = reach_within,
                           .since_boot = [this] { return SinceBoot() + suspended_; }});
  }
  void Write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / (name + ".new")) << text;
    std::filesystem::rename(folder_ / (name + ".new"), folder_ / name);
  }
  void Greet(const std::string& host_id, int uptime_s, pid_t bridge = 77) const {
    Write("greeting", "musher-host " + host_id + " " + std::to_string(uptime_s) + ".5 " +
                          std::to_string(bridge) + "\n");
  }
  void SetUnit(const std::string& active, pid_t pid, const std::string& variable = kOurs) const {
    Write("unit", active + " " + std::to_string(pid) + " " + variable + "\n");
  }
  void Open() {
    HostProcesses::Hooks hooks;
    hooks.on_started = [this](const std::string&, pid_t pid, const std::string& host, bool) {
      started_.push_back(pid);
      hosts_.push_back(host);
    };
    hooks.on_not_started = [this](const std::string&, const std::string& why, bool waits) {
      (waits ? waits_ : not_started_).push_back(why);
    };
    hooks.on_ended = [this](const std::string&, pid_t pid, const ProcessExit& exit) {
      ended_.push_back(pid);
      exit_ = exit.Text();
      clean_ = exit.clean();
    };
    hooks.still_starts = [this](const std::string&) { return still_starts_; };
    hooks.is_present = [this](const std::string&) { return is_present_; };
    hooks.on_reach = [this](bool reached, const std::string& message) {
      (reached ? reached_ : troubles_).push_back(message);
    };
    hooks.still_ends = [this](const std::string&, pid_t) { return still_ends_; };
    hooks.has_exited = [this](const std::string&, pid_t pid) { return pid == exited_; };
    hooks.output = [this](const std::string&) { return output_; };
    units_->Open(std::move(hooks));
  }
  void Await(const std::function<bool()>& holds) {
    ASSERT_TRUE(loop_.RunUntil(holds, testing::In(kSoon)));
  }
  // A process of this machine runs there.
  void OpenWithProcess(pid_t pid) {
    SetUnit("active", pid);
    Open();
    Await([&] { return !started_.empty(); });
    ASSERT_THAT(started_, ElementsAre(pid));
  }
  HostProcesses::Found Find() {
    std::vector<HostProcesses::Found> found;
    units_->Find([&](const std::vector<HostProcesses::Found>& there) { found = there; });
    EXPECT_TRUE(loop_.RunUntil([&] { return !found.empty(); }, testing::In(kSoon)));
    return found.empty() ? HostProcesses::Found() : found.front();
  }
  void LoseConnection() {
    const std::size_t before = troubles_.size();
    Write("down", "");
    Await([&] { return troubles_.size() > before; });
  }
  void Start() {
    ProcessSpec spec;
    spec.name = "eyes";
    spec.argv = config_.actuators[0].command;
    spec.cwd = config_.actuators[0].cwd;
    spec.limits = config_.actuators[0].limits;
    units_->Start(spec);
  }
  void AwaitCall(const std::string& call) {
    AwaitThere([this, &call] { return Calls().find(call) != std::string::npos; });
  }
  // What the fake systemd has done is no event of the loop.
  void AwaitThere(const std::function<bool()>& holds) {
    transport::LoopHandlePtr look;
    const std::function<void()> again = [&] {
      look = loop_.At(loop_.Now() + Milliseconds(5), again);
    };
    again();
    Await(holds);
  }
  // Its process, which was reported as started, exits.
  void Exit(int code) {
    Write("unit", std::string("inactive 41 ") + kOurs + " success " + std::to_string(code) + "\n");
    Write("changed", "");
  }
  std::string Calls() const { return ReadFile(folder_ / "calls"); }

  const std::string path_ = getenv("PATH");
  const TempFolder folder_;
  MachineConfig config_;
  std::string id_ = "ours";
  Duration suspended_{};  // the computer of the controller
  bool still_ends_ = true;
  bool still_starts_ = true;
  bool is_present_ = false;
  std::vector<std::string> not_started_;
  std::vector<std::string> waits_;
  std::string exit_;
  bool clean_ = false;
  std::vector<pid_t> started_;
  std::vector<std::string> hosts_;  // where
  pid_t exited_ = 0;                // by the kernel
  std::shared_ptr<const UniqueFd> output_;
  std::vector<pid_t> ended_;
  std::vector<std::string> reached_;
  std::vector<std::string> troubles_;
  transport::LinuxEventLoop loop_;
  std::unique_ptr<HostUnits> units_;
};

TEST_F(UnitOfAnotherHost, RunsOnWhenItsStateCannotBeRead) {
  ASSERT_NO_FATAL_FAILURE(OpenWithProcess(41));
  Write("refuse-GetAll", "org.freedesktop.DBus.Error.NoMemory");
  EXPECT_THAT(Find().unreached, HasSubstr("cannot be read: refused by the test"));
  EXPECT_THAT(ended_, IsEmpty());
  std::filesystem::remove(folder_ / "refuse-GetAll");
  EXPECT_EQ(Find().pid, 41);
  EXPECT_THAT(ended_, IsEmpty());
}

TEST_F(UnitOfAnotherHost, ThatAnotherMachineStartsLaterIsNotTaken) {
  SetUnit("inactive", 0, kOurs);
  Open();
  EXPECT_EQ(Find().pid, 0);
  SetUnit("active", 52, "MUSHER_MACHINE_ID=theirs");
  const std::string reads = ReadFile(folder_ / "reads");
  Write("changed", "");
  Await([&] { return !started_.empty() || ReadFile(folder_ / "reads") != reads; });
  EXPECT_EQ(Find().pid, 0);
  EXPECT_THAT(started_, IsEmpty());
}

TEST_F(UnitOfAnotherHost, OfAMachineWithAnIdIsNotTakenByOneWithout) {
  id_.clear();
  SetUnit("active", 52);
  Open();
  EXPECT_EQ(Find().pid, 0);
  EXPECT_THAT(started_, IsEmpty());
}

TEST_F(UnitOfAnotherHost, WhoseSignalIsRefusedIsReportedOnce) {
  ASSERT_NO_FATAL_FAILURE(OpenWithProcess(41));
  Write("refuse-Kill", "org.freedesktop.DBus.Error.AccessDenied");
  units_->Signal("eyes", 41, SIGTERM);
  units_->Signal("eyes", 41, SIGKILL);
  Find();
  EXPECT_EQ(Calls(), "Kill refused\nKill refused\n");
  ASSERT_THAT(troubles_, SizeIs(1));
  EXPECT_THAT(troubles_.front(), AllOf(HasSubstr("the signal to musher-robot-eyes.service"),
                                       HasSubstr("refused by the test"), HasSubstr("polkit")));
}

TEST_F(UnitOfAnotherHost, GetsTheSignalThatWaitedForItsHost) {
  ASSERT_NO_FATAL_FAILURE(OpenWithProcess(41));
  ASSERT_NO_FATAL_FAILURE(LoseConnection());
  units_->Signal("eyes", 41, SIGKILL);
  Await([this] { return !reached_.empty(); });
  Find();
  Find();  // its calls follow the signal
  EXPECT_EQ(Calls(), "Kill 9\n");
}

// The kernel may deliver a signal minutes after its connection was lost.
TEST_F(UnitOfAnotherHost, GetsNoSignalThatWasForTheProcessBeforeIt) {
  ASSERT_NO_FATAL_FAILURE(OpenWithProcess(41));
  Write("late-Kill", "");
  units_->Signal("eyes", 41, SIGKILL);
  AwaitCall("Kill is late\n");
  SetUnit("active", 52);
  std::filesystem::remove(folder_ / "late-Kill");
  AwaitCall("Kill of another start\n");
  Write("changed", "");
  Await([this] { return started_.back() == 52; });
  EXPECT_THAT(Calls(), Not(HasSubstr("Kill 9")));
  EXPECT_THAT(troubles_, IsEmpty());  // it needs no signal
}

TEST_F(UnitOfAnotherHost, GetsNoSignalWhoseReasonHasPassed) {
  ASSERT_NO_FATAL_FAILURE(OpenWithProcess(41));
  ASSERT_NO_FATAL_FAILURE(LoseConnection());
  units_->Signal("eyes", 41, SIGKILL);
  still_ends_ = false;  // it has recovered
  Await([this] { return !reached_.empty(); });
  Find();
  Find();  // its calls follow the signal
  EXPECT_THAT(Calls(), IsEmpty());
}

// The silence may be over before it is decided, and the SIGKILL before it had another reason.
TEST_F(UnitOfAnotherHost, GetsNoOldSignalForASilenceThatIsNotDecided) {
  Machine machine;
  machine.actuators.resize(1);
  EXPECT_FALSE(IsStillEnded(machine, 0, 41));
  Termination& silent = machine.actuators[0].process.termination.emplace();
  silent.pid = 41;
  silent.for_silence = true;
  EXPECT_FALSE(IsStillEnded(machine, 0, 41));
  silent.killed = true;
  EXPECT_TRUE(IsStillEnded(machine, 0, 41));
  EXPECT_FALSE(IsStillEnded(machine, 0, 42));
}

TEST_F(UnitOfAnotherHost, HasEndedWithARebootOfTheHost) {
  ASSERT_NO_FATAL_FAILURE(OpenWithProcess(41));
  Greet(kSecondBoot, 1);
  SetUnit("inactive", 0);
  ASSERT_NO_FATAL_FAILURE(LoseConnection());
  Await([this] { return !reached_.empty(); });
  EXPECT_THAT(ended_, ElementsAre(41));
}

// The loss is noticed an hour late, and the host was booted in that hour.
TEST_F(UnitOfAnotherHost, HasEndedWithARebootWhileThisComputerWasSuspended) {
  ASSERT_NO_FATAL_FAILURE(OpenWithProcess(41));
  Greet(kSecondBoot, 1000);
  SetUnit("inactive", 0);
  suspended_ = std::chrono::hours(1);
  ASSERT_NO_FATAL_FAILURE(LoseConnection());
  Await([this] { return !reached_.empty(); });
  EXPECT_THAT(ended_, ElementsAre(41));
}

// It has run for longer than the connection was lost: it has not been booted meanwhile.
TEST_F(UnitOfAnotherHost, RunsOnWhenAnotherHostHasTakenTheAddress) {
  ASSERT_NO_FATAL_FAILURE(OpenWithProcess(41));
  Greet(kSecondBoot, 1000);
  SetUnit("inactive", 0);
  ASSERT_NO_FATAL_FAILURE(LoseConnection());
  const std::string why = "another host answers at 10.0.0.2";
  HostProcesses::Found found;
  for (int tries = 0; tries < 100 && !found.unreached.starts_with(why); ++tries) found = Find();
  EXPECT_THAT(found.unreached, HasSubstr(why));
  EXPECT_THAT(ended_, IsEmpty());
  EXPECT_THAT(reached_, IsEmpty());
}

// Its systemd sends SIGTERM, on which a program may exit as one that has done its work.
TEST_F(UnitOfAnotherHost, ThatEndsWhileItsHostShutsDownHasEndedWithThat) {
  ASSERT_NO_FATAL_FAILURE(OpenWithProcess(41));
  Write("system", "stopping");
  Exit(0);
  Await([this] { return !ended_.empty(); });
  EXPECT_EQ(exit_, "its host went down");
}

// In a TearDown of the machine that exit code counted as its own end, and was "done".
TEST_F(UnitOfAnotherHost, ThatEndsInATearDownWhileItsHostShutsDownHasEndedWithThat) {
  ASSERT_NO_FATAL_FAILURE(OpenWithProcess(41));
  still_starts_ = false;
  Write("system", "stopping");
  Exit(0);
  Await([this] { return !ended_.empty(); });
  EXPECT_EQ(exit_, "its host went down");
}

TEST_F(UnitOfAnotherHost, ThatEndsByItselfHasItsExitCode) {
  ASSERT_NO_FATAL_FAILURE(OpenWithProcess(41));
  Exit(0);
  Await([this] { return !ended_.empty(); });
  EXPECT_EQ(exit_, "exit code 0");
}

// systemd keeps no unit that has ended with code 0, and none that SIGTERM has ended: a TearDown
// that was cut short is no work that was done.
TEST_F(UnitOfAnotherHost, OfWhichSystemdKnowsNothingHasEndedWithAnUnknownExitCode) {
  ASSERT_NO_FATAL_FAILURE(OpenWithProcess(41));
  SetUnit("inactive", 0);
  ASSERT_NO_FATAL_FAILURE(LoseConnection());
  Await([this] { return !ended_.empty(); });
  EXPECT_THAT(ended_, ElementsAre(41));
  EXPECT_FALSE(clean_);
  EXPECT_EQ(exit_,
            "exit code unknown: systemd knows nothing of musher-robot-eyes.service any more");
}

// Its end was received while its state was read, and the state that was read has none.
TEST_F(UnitOfAnotherHost, ThatIsDroppedWhileItIsExaminedHasItsExitCode) {
  ASSERT_NO_FATAL_FAILURE(OpenWithProcess(41));
  Write("late-GetAll", "");
  std::vector<HostProcesses::Found> found;
  units_->Find([&](const std::vector<HostProcesses::Found>& there) { found = there; });
  AwaitCall("GetAll is late");
  Exit(0);
  AwaitThere([this] { return !std::filesystem::exists(folder_ / "changed"); });
  SetUnit("inactive", 0);
  std::filesystem::remove(folder_ / "late-GetAll");
  Await([this] { return !ended_.empty(); });
  EXPECT_EQ(exit_, "exit code 0");
  EXPECT_TRUE(clean_);
}

TEST_F(UnitOfAnotherHost, ThatHasFailedWhileItsHostWasOutOfReachHasItsExitCode) {
  ASSERT_NO_FATAL_FAILURE(OpenWithProcess(41));
  Write("unit", std::string("failed 41 ") + kOurs + " exit-code 3\n");
  ASSERT_NO_FATAL_FAILURE(LoseConnection());
  Await([this] { return !ended_.empty(); });
  EXPECT_EQ(exit_, "exit code 3");
}

TEST_F(UnitOfAnotherHost, ThatEndsOutOfReachOnAHostThatShutsDownHasEndedWithThat) {
  ASSERT_NO_FATAL_FAILURE(OpenWithProcess(41));
  Write("system", "stopping");
  SetUnit("inactive", 0);
  ASSERT_NO_FATAL_FAILURE(LoseConnection());
  Await([this] { return !ended_.empty(); });
  EXPECT_EQ(exit_, "its host went down");
}

TEST_F(UnitOfAnotherHost, WhoseEndIsOnlyKnownFromTheReplyToASignalHasEnded) {
  ASSERT_NO_FATAL_FAILURE(OpenWithProcess(41));
  SetUnit("inactive", 0);  // without a signal of systemd
  units_->Signal("eyes", 41, SIGTERM);
  Await([this] { return !ended_.empty(); });
  EXPECT_THAT(ended_, ElementsAre(41));
}

TEST_F(UnitOfAnotherHost, WhoseEndTheMachineWantedHasItsExitCodeOnAHostThatShutsDown) {
  ASSERT_NO_FATAL_FAILURE(OpenWithProcess(41));
  Write("system", "stopping");
  units_->Signal("eyes", 41, SIGTERM);
  Exit(0);
  Await([this] { return !ended_.empty(); });
  EXPECT_EQ(exit_, "exit code 0");
}

TEST_F(UnitOfAnotherHost, WhoseHostIsBootedAgainBeforeItAnswersHasEndedWithThat) {
  ASSERT_NO_FATAL_FAILURE(OpenWithProcess(41));
  Write("ignore-Get", "");
  Exit(0);
  AwaitCall("Get ignored");
  EXPECT_THAT(ended_, IsEmpty());
  Greet(kSecondBoot, 1);
  SetUnit("inactive", 0);
  ASSERT_NO_FATAL_FAILURE(LoseConnection());
  Await([this] { return !reached_.empty(); });
  EXPECT_THAT(ended_, ElementsAre(41));
  EXPECT_EQ(exit_, "its host went down");
}

TEST_F(UnitOfAnotherHost, WhoseHostDoesNotSayWhetherItShutsDownIsAskedAgain) {
  ASSERT_NO_FATAL_FAILURE(OpenWithProcess(41));
  Write("refuse-Get", "org.freedesktop.DBus.Error.NoReply");
  Exit(0);
  AwaitCall("Get refused\nGet refused\n");
  EXPECT_THAT(ended_, IsEmpty());
  Write("system", "stopping");
  std::filesystem::remove(folder_ / "refuse-Get");
  Await([this] { return !ended_.empty(); });
  EXPECT_EQ(exit_, "its host went down");
}

// Its starts would all fail, and it would be given up before its host is back.
TEST_F(UnitOfAnotherHost, WaitsForAHostThatShutsDown) {
  Write("refuse-StartTransientUnit", "org.freedesktop.systemd1.TransactionIsDestructive");
  SetUnit("inactive", 0);
  Open();
  Start();
  const std::string refused = "StartTransientUnit refused\n";
  AwaitCall(refused + refused);
  EXPECT_THAT(waits_, ElementsAre("host vision (10.0.0.2) is shutting down; it is started once its "
                                  "host is reached"));
  EXPECT_THAT(not_started_, IsEmpty());
  std::filesystem::remove(folder_ / "refuse-StartTransientUnit");
  AwaitCall("ExecStartEx");
  EXPECT_THAT(not_started_, IsEmpty());
}

// systemd would replace $HOME.
TEST_F(UnitOfAnotherHost, HasTheArgumentsOfTheConfig) {
  SetUnit("inactive", 0);
  Open();
  Start();
  AwaitCall("StartTransientUnit");
  EXPECT_THAT(Calls(), HasSubstr("ExecStartEx /opt/eyes $HOME no-env-expand\n"));
}

// The kernel may deliver it minutes after its connection was lost.
TEST_F(UnitOfAnotherHost, IsStartedWithinSomeSecondsOfItsHostsClockOrNotAtAll) {
  SetUnit("inactive", 0);
  Open();
  Start();
  AwaitCall("StartTransientUnit");
  const std::string calls = Calls();
  const std::string limit = " ] no-env-expand privileged\n";
  const std::size_t end = calls.find(limit);
  ASSERT_NE(end, std::string::npos) << calls;
  const std::size_t begin = calls.rfind(' ', end - 1) + 1;
  const int until_s = std::stoi(calls.substr(begin, end - begin));
  EXPECT_GE(until_s, 1020);  // it has run for 1,000 s
  EXPECT_LE(until_s, 1050);
  const auto starts = [](Duration limit_of_run) {
    const auto run = RunProgram({UntilHostHasRun(limit_of_run), "", {}}, "");
    EXPECT_TRUE(run && run.value().errors.empty()) << run.value().errors;
    return run && run.value().status.ok();
  };
  EXPECT_TRUE(starts(std::chrono::hours(1'000'000)));
  EXPECT_FALSE(starts(-std::chrono::seconds(1)));
}

// A connection lasts for months, and of two clocks one gains some seconds a day on the other.
TEST_F(UnitOfAnotherHost, IsStartedAlsoIfTheClockOfItsHostHasGainedSinceTheConnectionWasMade) {
  SetUnit("inactive", 0);
  Write("uptime", "1500");  // it was greeted with 1,000
  Open();
  Start();
  AwaitCall("StartTransientUnit skipped\n");
  AwaitCall("StartTransientUnit\n");
  EXPECT_THAT(not_started_, IsEmpty());
}

TEST_F(UnitOfAnotherHost, WhoseHostSkipsEachStartIsNotStarted) {
  SetUnit("inactive", 0);
  Write("uptime", "1000000");
  Open();
  Start();
  Await([this] { return !not_started_.empty(); });
  EXPECT_THAT(not_started_,
              ElementsAre(HasSubstr("systemd executes nothing of musher-robot-eyes")));
}

// systemd skips a unit, too, where the process that looks at the time cannot be set up.
TEST_F(UnitOfAnotherHost, WhoseHostSkipsEachStartNamesWhatMayBeMissing) {
  config_.actuators[0].cwd = "/opt/robot";
  config_.actuators[0].limits.user = "robot";
  config_.actuators[0].limits.realtime_priority = 40;
  config_.actuators[0].limits.nice = -5;
  SetUnit("inactive", 0);
  Write("uptime", "1000000");
  Open();
  Start();
  Await([this] { return !not_started_.empty(); });
  EXPECT_THAT(not_started_, ElementsAre(HasSubstr(
                                "eyes.service: its user robot (`user`) may be missing there, or "
                                "its folder /opt/robot (`cwd`) may be missing there, or its "
                                "systemd may refuse `realtime_priority`, or its systemd may "
                                "refuse `nice`; see")));
}

// A host that is slow has not skipped the start often enough to be sure when the start has to end.
TEST_F(UnitOfAnotherHost, WhoseStartIsSkippedUntilItHasToEndNamesWhatMayBeMissing) {
  config_.actuators[0].cwd = "/opt/robot";
  Make(Milliseconds(3000));
  SetUnit("inactive", 0);
  Write("uptime", "1000000");
  Write("late-StartTransientUnit", "");
  Open();
  Start();
  AwaitCall("StartTransientUnit is late\n");
  Write("ignore-GetAll", "");
  std::filesystem::remove(folder_ / "late-StartTransientUnit");
  Await([this] { return !not_started_.empty(); });
  EXPECT_THAT(not_started_, ElementsAre(HasSubstr("its folder /opt/robot (`cwd`) may be missing")));
}

// Its starts were valid for an hour from then on, and those of all other units of the host.
TEST_F(UnitOfAnotherHost, WhoseHostHasSkippedEachStartIsNotCarriedOutLaterForThat) {
  SetUnit("inactive", 0);
  Write("uptime", "1000000");
  Open();
  Start();
  Await([this] { return !not_started_.empty(); });
  const auto skipped = [this] {
    const std::string line = "StartTransientUnit skipped\n";
    const std::string calls = Calls();
    std::size_t count = 0;
    for (std::size_t at = 0; (at = calls.find(line, at)) != std::string::npos; ++at) ++count;
    return count;
  };
  const std::size_t before = skipped();
  Write("uptime", "1500");  // it was greeted with 1,000
  Start();
  AwaitCall("StartTransientUnit\n");
  EXPECT_GT(skipped(), before);
}

// "Unit musher-robot-eyes.service not found." was all that a person read.
TEST_F(UnitOfAnotherHost, WhoseFileSystemdCannotWriteNamesTheFolderThatMayBeFull) {
  SetUnit("inactive", 0);
  Write("refuse-StartTransientUnit", "org.freedesktop.systemd1.NoSuchUnit\n");
  Open();
  Start();
  Await([this] { return !not_started_.empty(); });
  EXPECT_THAT(not_started_, ElementsAre(AllOf(HasSubstr("host vision (10.0.0.2): "),
                                              HasSubstr("its /run may be full"))));
}

TEST_F(UnitOfAnotherHost, WhoseProgramIsNotExecutedSaysWhy) {
  struct Cause {
    const char* status;
    const char* why;
  };
  for (const Cause& cause : {Cause{"200", "its user robot may not enter its folder /srv/eyes"},
                             Cause{"203", "/opt/eyes could not be executed there: it is missing"},
                             Cause{"217", " has no user robot; make it there"},
                             Cause{"226", "mount namespaces, which `sandbox` needs; see"},
                             Cause{"241", "(systemd's exit code 241); see `journalctl"}}) {
    SCOPED_TRACE(cause.status);
    not_started_.clear();
    config_.actuators[0].limits.user = "robot";
    config_.actuators[0].cwd = "/srv/eyes";
    SetUnit("inactive", 0);
    Write("started", std::string("failed 41 ") + kOurs + " exit-code " + cause.status + "\n");
    Write("job", "failed");
    if (Calls().empty()) Open();
    Start();
    Await([this] { return !not_started_.empty(); });
    EXPECT_THAT(not_started_, ElementsAre(HasSubstr(cause.why)));
  }
}

// Of the program that looks at the time, before its own is executed.
TEST_F(UnitOfAnotherHost, WhoseStartNeedsMoreMemoryThanItsLimitNamesThat) {
  config_.actuators[0].limits.memory_max_bytes = 1 << 20;
  SetUnit("inactive", 0);
  Write("started", std::string("failed 0 ") + kOurs + " oom-kill\n");
  Write("job", "failed");
  Open();
  Start();
  Await([this] { return !not_started_.empty(); });
  EXPECT_THAT(not_started_,
              ElementsAre(HasSubstr("has ended out of memory: its limit (memory_max_mb = 1) or the "
                                    "memory of host vision is used up; raise the limit if it needs "
                                    "more; see `journalctl -u ")));
}

// What waits in the one before would be carried out beside it.
TEST_F(UnitOfAnotherHost, WhoseConnectionIsMadeAgainEndsTheOneBeforeThere) {
  ASSERT_NO_FATAL_FAILURE(OpenWithProcess(41));
  EXPECT_THAT(ReadFile(folder_ / "commands"), Not(HasSubstr("kill")));
  ASSERT_NO_FATAL_FAILURE(LoseConnection());
  Await([this] { return !reached_.empty(); });
  EXPECT_THAT(ReadFile(folder_ / "commands"),
              HasSubstr(EndBridge("01234567-89ab-cdef-0123-456789abcdef", 77)));
}

TEST(EndBridge, EndsABridgeOfThisBootAndNothingElse) {
  const TempFolder folder;
  const std::string boot = ReadFile("/proc/sys/kernel/random/boot_id").substr(0, 36);
  const auto ends = [&](const std::string& program, const std::string& boot_id) {
    std::filesystem::copy_file("/bin/sleep", folder / program,
                               std::filesystem::copy_options::skip_existing);
    ProgramSpec spec;
    spec.argv = {folder / program, "1000"};
    const auto child = ForkProgram(spec);
    const pid_t pid = child.value().pid();
    EXPECT_FALSE(child.value().Failure(kSoon));  // it runs
    EXPECT_TRUE(RunProgram({{"sh", "-c", EndBridge(boot_id, pid)}, "", {}}, ""));
    kill(pid, SIGKILL);
    return ReapChild(pid)->number == SIGTERM;
  };
  EXPECT_TRUE(ends("systemd-stdio-bridge", boot));
  EXPECT_FALSE(ends("systemd-stdio-bridge", "76543210-89ab-cdef-0123-456789abcdef"));
  EXPECT_FALSE(ends("sleep", boot));
}

TEST_F(UnitOfAnotherHost, ThatIsAboutToRunIsNotTakenForEnded) {
  SetUnit("activating", 0);
  Open();
  EXPECT_EQ(Find().unreached, "musher-robot-eyes.service is activating");
}

// Its job has not ended: it could run after the controller has given it up.
TEST_F(UnitOfAnotherHost, ThatIsNotStartedInTimeIsStopped) {
  Make(Milliseconds(3000));
  SetUnit("inactive", 0);
  Open();
  Start();
  AwaitCall("StartTransientUnit");
  SetUnit("activating", 0);
  Await([this] { return !not_started_.empty(); });
  EXPECT_THAT(not_started_.front(), HasSubstr("systemctl status musher-robot-eyes.service"));
  AwaitCall("Stop\n");
  EXPECT_THAT(waits_, IsEmpty());
  EXPECT_EQ(Find().unreached, "musher-robot-eyes.service is about to start");
}

TEST_F(UnitOfAnotherHost, WhoseJobHasNotBegunInTimeIsCancelled) {
  Make(Milliseconds(3000));
  SetUnit("inactive", 0);
  Open();
  Start();
  Await([this] { return !not_started_.empty(); });
  AwaitCall("Cancel\n");
  EXPECT_THAT(Calls(), Not(HasSubstr("Stop\n")));
}

TEST_F(UnitOfAnotherHost, WaitsForItsHostAndIsStartedOnceThatIsReached) {
  Make(Milliseconds(2000));
  Write("off", "");
  SetUnit("inactive", 0);
  Open();
  Start();
  Await([this] { return !waits_.empty(); });
  EXPECT_THAT(waits_.front(),
              AllOf(HasSubstr("host vision (10.0.0.2): "), HasSubstr("No route to host"),
                    HasSubstr("it is started once its host is reached")));
  std::filesystem::remove(folder_ / "off");
  AwaitCall("StartTransientUnit");
  EXPECT_THAT(not_started_, IsEmpty());
  EXPECT_THAT(waits_, SizeIs(1));
}

// A fail-over waited ten seconds for the host of the controller that is gone before it did
// anything.
TEST_F(UnitOfAnotherHost, IsReportedToWaitForItsHostBeforeAStartThereWouldBeOverdue) {
  Make(std::chrono::hours(1), Milliseconds(100));
  Write("off", "");
  SetUnit("inactive", 0);
  Open();
  Start();
  Await([this] { return !waits_.empty(); });
  std::filesystem::remove(folder_ / "off");
  AwaitCall("StartTransientUnit");
  EXPECT_THAT(not_started_, IsEmpty());
}

TEST_F(UnitOfAnotherHost, IsNotStartedOnAHostThatIsReachedAfterTheEndOfTheMachine) {
  Make(Milliseconds(2000));
  Write("off", "");
  SetUnit("inactive", 0);
  Open();
  Start();
  Await([this] { return !waits_.empty(); });
  still_starts_ = false;
  std::filesystem::remove(folder_ / "off");
  Await([this] { return !reached_.empty(); });
  Find();
  Find();  // its calls follow a start
  EXPECT_THAT(Calls(), IsEmpty());
}

// ssh was started for each of them.
TEST_F(UnitOfAnotherHost, IsNotReachedSoonerByEachSignalToIt) {
  ASSERT_NO_FATAL_FAILURE(OpenWithProcess(41));
  Write("off", "");
  ASSERT_NO_FATAL_FAILURE(LoseConnection());
  const auto tries = [this] { return ReadFile(folder_ / "tries").size(); };
  Await([&] { return tries() == 3; });  // the next one is two seconds later
  const auto tries_at_once = [&] {
    units_->Signal("eyes", 41, SIGKILL);
    return tries() > 3;
  };
  EXPECT_FALSE(loop_.RunUntil(tries_at_once, testing::In(Milliseconds(500))));
}

TEST_F(UnitOfAnotherHost, HasTheLimitsOfTheConfig) {
  ProcessLimits& limits = config_.actuators[0].limits;
  limits = {64 << 20, 0.5, -5, 40, "robot"};
  SetUnit("inactive", 0);
  Open();
  Start();
  AwaitCall("StartTransientUnit");
  EXPECT_THAT(Calls(),
              AllOf(HasSubstr("MemoryMax 67108864\nMemorySwapMax 0\n"),
                    HasSubstr("CPUQuotaPerSecUSec 500000\n"), HasSubstr("Nice -5\nCPUWeight 305\n"),
                    HasSubstr("CPUSchedulingPolicy 1\nCPUSchedulingPriority 40\n"),
                    HasSubstr("User robot\n")));
}

TEST_F(UnitOfAnotherHost, HasTheSandboxOfTheConfig) {
  ProcessLimits& limits = config_.actuators[0].limits;
  limits.sandbox = Sandbox::kReadOnly;
  SetUnit("inactive", 0);
  Open();
  Start();
  AwaitCall("StartTransientUnit");
  EXPECT_THAT(Calls(), AllOf(HasSubstr("ProtectSystem strict\nNoNewPrivileges\nReadWritePaths\n"),
                             Not(HasSubstr("ProtectHome")), Not(HasSubstr("Device"))));
}

TEST_F(UnitOfAnotherHost, InAStrictSandboxOpensItsDevicesOnly) {
  ProcessLimits& limits = config_.actuators[0].limits;
  limits.sandbox = Sandbox::kStrict;
  limits.devices = {"/dev/video0"};
  SetUnit("inactive", 0);
  Open();
  Start();
  AwaitCall("StartTransientUnit");
  EXPECT_THAT(Calls(), AllOf(HasSubstr("ProtectHome yes\nPrivateTmp\nProtectKernelTunables\n"),
                             HasSubstr("DevicePolicy closed\nDeviceAllow /dev/video0 rw\n")));
}

TEST_F(UnitOfAnotherHost, EndedByItsLimitOfMemoryNamesThat) {
  config_.actuators[0].limits.memory_max_bytes = 64 << 20;
  ASSERT_NO_FATAL_FAILURE(OpenWithProcess(41));
  Write("unit", std::string("failed 41 ") + kOurs + " oom-kill\n");
  Write("changed", "");
  Await([this] { return !ended_.empty(); });
  EXPECT_EQ(exit_,
            "out of memory: its limit (memory_max_mb = 64) or the memory of host vision is used "
            "up; raise the limit if it needs more");
}

TEST_F(UnitOfAnotherHost, EndedWithoutALimitOfMemoryNamesTheMemoryOfItsHost) {
  ASSERT_NO_FATAL_FAILURE(OpenWithProcess(41));
  Write("unit", std::string("failed 41 ") + kOurs + " oom-kill\n");
  Write("changed", "");
  Await([this] { return !ended_.empty(); });
  EXPECT_EQ(exit_,
            "out of memory: the memory of host vision is used up; limit what uses it by "
            "`memory_max_mb`");
}

// --- this host ---

class UnitOfThisHost : public UnitOfAnotherHost {
 protected:
  UnitOfThisHost() {
    units_->Close();
    config_.hosts.clear();
    config_.actuators[0].host.clear();
    config_.actuators[0].limits.memory_max_bytes = 64 << 20;
    MakeHere();
  }
  ~UnitOfThisHost() override { units_->Close(); }

  void MakeHere(Duration start_within = kSoon) {
    HostUnits::Options options;
    options.start_within = start_within;
    options.own = BySocket(loop_, socket_);
    units_ = std::make_unique<HostUnits>(
        loop_, config_,
        [] {
          return MachineIdentity{"robot", "ours"};
        },
        BySsh(loop_), std::move(options));
  }
  void Listen() {
    systemd_.emplace(
        std::vector<std::string>{BinDir() + "/controller_fake_systemd", folder_.path(), socket_});
    ASSERT_TRUE(testing::Until([this] { return std::filesystem::exists(socket_); },
                               std::chrono::minutes(2)));
  }

  const std::string socket_ = folder_ / "bus";
  std::optional<testing::Process> systemd_;
};

TEST_F(UnitOfThisHost, IsStartedWithTheFileOfItsLogAndWithoutSsh) {
  const auto log = std::make_shared<const UniqueFd>(
      open((folder_ / "log").c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0600));
  output_ = log;
  ASSERT_NO_FATAL_FAILURE(Listen());
  SetUnit("inactive", 0);
  Write("job", "done");
  Write("started", std::string("active 41 ") + kOurs + "\n");
  Open();
  Start();
  Await([this] { return !started_.empty(); });
  EXPECT_THAT(started_, ElementsAre(41));
  EXPECT_THAT(hosts_, ElementsAre(""));
  EXPECT_THAT(Calls(), AllOf(HasSubstr("StandardOutputFileDescriptor written"),
                             HasSubstr("StandardErrorFileDescriptor written"),
                             HasSubstr("MemoryMax 67108864")));
  EXPECT_EQ(ReadFile(folder_ / "log"), "printed by the unit\nprinted by the unit\n");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "commands"));  // of ssh
}

// Its command is a name, which /usr/bin/env looks up.
TEST_F(UnitOfThisHost, WhoseFolderItsUserMayNotEnterNamesItsProgram) {
  ASSERT_NO_FATAL_FAILURE(Listen());
  config_.actuators[0].command = {"eyes"};
  config_.actuators[0].limits.user = "robot";
  config_.actuators[0].cwd = "/srv/eyes";
  SetUnit("inactive", 0);
  Write("started", std::string("failed 41 ") + kOurs + " exit-code 200\n");
  Write("job", "failed");
  Open();
  ProcessSpec spec;
  spec.name = "eyes";
  spec.argv = {"/usr/bin/env", "eyes"};
  spec.cwd = config_.actuators[0].cwd;
  spec.limits = config_.actuators[0].limits;
  units_->Start(spec);
  Await([this] { return !not_started_.empty(); });
  EXPECT_THAT(not_started_,
              ElementsAre(HasSubstr("this host: eyes could not be executed there: its user robot "
                                    "may not enter its folder /srv/eyes (`cwd`)")));
}

TEST_F(UnitOfThisHost, HasEndedWithItsProcessWhileSystemdEndsTheRest) {
  ASSERT_NO_FATAL_FAILURE(Listen());
  ASSERT_NO_FATAL_FAILURE(OpenWithProcess(41));
  Write("unit", std::string("deactivating 41 ") + kOurs + " exit-code 3\n");
  Write("changed", "");
  Await([this] { return !ended_.empty(); });
  EXPECT_EQ(exit_, "exit code 3");
  Start();
  Find();
  Find();
  EXPECT_THAT(Calls(), Not(HasSubstr("StartTransientUnit")));  // the rest has not ended
  Write("unit", std::string("inactive 41 ") + kOurs + " exit-code 3\n");
  Write("changed", "");
  AwaitCall("StartTransientUnit");
}

// The dead process was reported as found, its end as another one, and no new one was started.
TEST_F(UnitOfThisHost, WhoseExitSystemdHasNotNoticedIsStartedOnceItHas) {
  ASSERT_NO_FATAL_FAILURE(Listen());
  ASSERT_NO_FATAL_FAILURE(OpenWithProcess(41));
  exited_ = 41;
  Start();
  Find();
  Find();
  EXPECT_THAT(started_, ElementsAre(41));
  EXPECT_THAT(Calls(), Not(HasSubstr("StartTransientUnit")));
  Write("unit", std::string("inactive 41 ") + kOurs + " exit-code 3\n");
  Write("changed", "");
  AwaitCall("StartTransientUnit");
  EXPECT_THAT(ended_, ElementsAre(41));
  EXPECT_THAT(started_, ElementsAre(41));
}

// A process of this host that runs is known without its systemd.
TEST_F(UnitOfThisHost, IsOnlyUnknownToASearchWhileItsStartIsUnderWay) {
  ASSERT_NO_FATAL_FAILURE(Listen());
  Write("unit", std::string("deactivating 41 ") + kOurs + " exit-code 3\n");
  Open();
  EXPECT_THAT(Find().unreached, IsEmpty());
  SetUnit("inactive", 0);
  Start();
  AwaitCall("StartTransientUnit");
  EXPECT_EQ(Find().unreached, "systemd of this host: musher-robot-eyes.service is about to start");
}

TEST_F(UnitOfThisHost, ThatNeedsMoreMemoryThanItsLimitNamesIt) {
  ASSERT_NO_FATAL_FAILURE(Listen());
  ASSERT_NO_FATAL_FAILURE(OpenWithProcess(41));
  Write("unit", std::string("failed 41 ") + kOurs + " oom-kill 137\n");
  Write("changed", "");
  Await([this] { return !ended_.empty(); });
  EXPECT_EQ(exit_,
            "out of memory: its limit (memory_max_mb = 64) or the memory of this host is used up; "
            "raise the limit if it needs more");
}

// On another host it would wait. Here it fails, so that `restart` counts it.
TEST_F(UnitOfThisHost, IsNotStartedWithoutItsDBus) {
  MakeHere(Milliseconds(300));
  Open();
  Start();
  Await([this] { return !not_started_.empty(); });
  EXPECT_THAT(not_started_.front(),
              AllOf(HasSubstr("systemd of this host: no connection to its D-Bus"),
                    HasSubstr("see `systemctl status dbus`")));
  EXPECT_THAT(waits_, IsEmpty());
  ASSERT_NO_FATAL_FAILURE(Listen());
  SetUnit("inactive", 0);
  Await([this] { return !reached_.empty(); });
  EXPECT_THAT(reached_.front(), HasSubstr("this host is reached"));
  Find();
  EXPECT_THAT(Calls(), Not(HasSubstr("StartTransientUnit")));  // it was given up
}

TEST_F(UnitOfThisHost, IsNotStartedByASystemdThatDoesNotAnswer) {
  ASSERT_NO_FATAL_FAILURE(Listen());
  MakeHere(Milliseconds(300));
  SetUnit("inactive", 0);
  Open();
  EXPECT_THAT(Find().unreached, IsEmpty());
  Write("ignore-GetAll", "");
  Start();
  Await([this] { return !not_started_.empty(); });
  EXPECT_THAT(
      not_started_.front(),
      HasSubstr("musher-robot-eyes.service's state cannot be read: systemd does not answer"));
}

// A process of it on another host, beyond a link that was cut, was known by then: both ran.
TEST_F(UnitOfThisHost, IsNotStartedLateBesideAnotherProcessOfIt) {
  ASSERT_NO_FATAL_FAILURE(Listen());
  SetUnit("inactive", 0);
  Open();
  EXPECT_THAT(Find().unreached, IsEmpty());
  Write("ignore-GetAll", "");
  Start();
  is_present_ = true;
  std::filesystem::remove(folder_ / "ignore-GetAll");
  ASSERT_NO_FATAL_FAILURE(LoseConnection());
  Await([this] { return !not_started_.empty(); });
  EXPECT_EQ(not_started_.front(), "another process of it runs");
  EXPECT_THAT(Calls(), Not(HasSubstr("StartTransientUnit")));
}

TEST_F(UnitOfThisHost, RunsOnWhenItsDBusIsLostAndIsFoundAgain) {
  ASSERT_NO_FATAL_FAILURE(Listen());
  ASSERT_NO_FATAL_FAILURE(OpenWithProcess(41));
  ASSERT_NO_FATAL_FAILURE(LoseConnection());
  Await([this] { return !reached_.empty(); });
  EXPECT_EQ(Find().pid, 41);
  EXPECT_THAT(ended_, IsEmpty());
}

}  // namespace musher::host_units_test
