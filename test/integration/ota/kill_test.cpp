// Whichever process is killed in the middle of an upgrade, the robot has a version that runs.

#include <sys/wait.h>

#include <memory>
#include <utility>

#include "musher/base/host.hpp"
#include "musher/controller/storage/state_store.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/ota/install.hpp"
#include "musher/ota/posix_disk.hpp"
#include "musher/test/integration/ota/root.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/wait.hpp"
#include "musher/transport/dds/node_thread.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::testing::kill_test {

using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::Not;

// Of a process that an actuator of some controller has left behind.
constexpr const char* kMark = "MUSHER_STARTED_AS=0000000001/0//left";

class Killed : public RobotWithUpgrades {
 protected:
  // An installer waits with the files until this is given back: for ten seconds, at most.
  std::unique_ptr<ota::Disk::Lock> HoldState() {
    auto lock = disk_.Take(root_ + "/ota_state.lock", /*wait=*/true);
    EXPECT_TRUE(lock) << lock.error().message;
    return std::move(lock).value();
  }
  // What an installer that is killed before it starts the machine again leaves.
  void MarkForTrialBoot(const std::string& version) {
    auto files = BeginInstallation(version, ota::Slot::kA);
    ASSERT_TRUE(files && files->Check({}) && files->Prepare() && files->Copy({}) &&
                files->CheckWritten({}) && files->MarkTrialBoot());
  }
  std::optional<ota::Installation> BeginInstallation(const std::string& version,
                                                     std::optional<ota::Slot> running) {
    if (!opened_) {
      auto root = ota::Root::Open(disk_, root_);
      EXPECT_TRUE(root) << root.error().message;
      opened_.emplace(std::move(root).value());
    }
    auto begun = ota::Installation::Begin(*opened_, Bundle(version), {}, running);
    return begun ? std::optional(std::move(begun).value()) : std::nullopt;
  }
  static void KillController() {
    const auto controller = Status()["pid"].get<pid_t>();
    const auto process = OpenPidfd(controller);
    ASSERT_TRUE(process) << process.error().message;
    ASSERT_EQ(kill(controller, SIGKILL), 0);
    ASSERT_TRUE(AwaitReadable(process.value().get(), In(std::chrono::seconds(120))));
  }
  static std::vector<pid_t> Pids() {
    std::vector<pid_t> pids;
    const auto status = Status();
    for (const auto& actuator : status["actuators"]) pids.push_back(actuator["pid"]);
    return pids;
  }
  // What a program of the new version does: it makes this file, and does not come back.
  std::string Waits() const { return "touch " + (folder_ / "runs") + "; exec sleep 60"; }

 private:
  ota::PosixDisk disk_;
  std::optional<ota::Root> opened_;
};

// A controller of another host that leads the machine, as far as other controllers see it.
class FarController {
 public:
  explicit FarController(const std::string& name_space) {
    thread_->RunOnLoop([&] {
      heartbeats_ = transport::MakePublisher<msg::ControllerHeartbeat>(
                        thread_->node(), transport::ControllerHeartbeatTopic(name_space),
                        transport::kLatchedQos)
                        .value();
      msg::ControllerHeartbeat heartbeat;
      heartbeat.machine = "dog";
      heartbeat.epoch = 9;
      heartbeat.host = "another boot/1";
      heartbeat.pid = 7;
      heartbeat.participant = thread_->node().participant().value();
      heartbeat.period_ns = Duration(std::chrono::seconds(60)).count();
      EXPECT_TRUE(heartbeats_->Publish(heartbeat));
    });
  }
  ~FarController() {
    thread_->RunOnLoop([this] { heartbeats_ = nullptr; });
  }
  FarController(const FarController&) = delete;
  FarController& operator=(const FarController&) = delete;

 private:
  const std::shared_ptr<transport::NodeThread> thread_ = transport::NodeThread::Start({}).value();
  std::unique_ptr<transport::Publisher<msg::ControllerHeartbeat>> heartbeats_;
};

TEST_F(Killed, InstallerLeavesTheMachineInOtaUntilItIsInstalledAgain) {
  Make("1.1.0", {});
  ASSERT_EQ(UpDetached().exit, 0);
  auto state = HoldState();
  Process installer(Command({"ota", "install", Bundle("1.1.0")}));
  ASSERT_NE(installer.LineWith("enter OTA"), "");
  installer.Signal(SIGKILL);
  EXPECT_EQ(installer.Wait().exit, -1);
  state.reset();
  EXPECT_EQ(Where(), "OTA from a");
  const Ended again = Install("1.1.0");
  EXPECT_EQ(again.exit, 0) << again.err;
  EXPECT_EQ(Where(), "Active from b");
}

// The next start did not say so, and the robot seemed to have the version that it has not.
TEST_F(Killed, InstallerAndControllerInTheMiddleAreReportedByTheNextStartOnce) {
  Make("1.1.0", {.large_bytes = 64 << 20});
  ASSERT_EQ(UpDetached().exit, 0);
  Process installer(Command({"ota", "install", Bundle("1.1.0")}));
  ASSERT_NE(installer.LineWith("copy"), "");
  installer.Signal(SIGKILL);
  EXPECT_EQ(installer.Wait().exit, -1);
  KillController();
  const Ended up = UpDetached();
  ASSERT_EQ(up.exit, 0) << up.err;
  EXPECT_EQ(Where(), "OTA from a") << "it adopts the actuators as they are";
  EXPECT_THAT(History(), HasSubstr("the upgrade to version 1.1.0 did not finish"));
  ASSERT_EQ(Musher({"down"}).exit, 0);
  const Ended again = Musher({"up", root_, "--detach"});
  EXPECT_EQ(again.exit, 0);
  EXPECT_THAT(again.out, Not(HasSubstr("did not finish")));
}

TEST_F(Killed, InstallerIsInterruptedByCtrlCAndTheMachineIsBackWhereItWas) {
  Make("1.1.0", {});
  ASSERT_EQ(UpDetached().exit, 0);
  auto state = HoldState();
  Process installer(Command({"ota", "install", Bundle("1.1.0")}));
  ASSERT_NE(installer.LineWith("enter OTA"), "");
  installer.Signal(SIGINT);
  state.reset();  // it continues, and detects with the first bytes that it is to end
  const Ended ended = installer.Wait();
  EXPECT_EQ(ended.exit, 130) << ended.err;
  EXPECT_EQ(Where(), "Active from a");
}

// The robot lay, and stood up.
TEST_F(Killed, InstallerLeavesTheMachineWhereItWasSwitchedMeanwhile) {
  Make("1.1.0", {});
  ASSERT_EQ(UpDetached().exit, 0);
  auto state = HoldState();
  Process installer(Command({"ota", "install", Bundle("1.1.0")}));
  ASSERT_NE(installer.LineWith("enter OTA"), "");
  ASSERT_EQ(Musher({"set", "LowPower"}).exit, 0);
  installer.Signal(SIGINT);
  state.reset();
  const Ended ended = installer.Wait();
  EXPECT_EQ(ended.exit, 130) << ended.err;
  EXPECT_EQ(Where(), "LowPower from a");
  EXPECT_THAT(History(), Not(HasSubstr("LowPower → Active")));
}

// It was taken down while it was in use.
TEST_F(Killed, InstallerDoesNotStartAMachineAgainThatHasLeftOtaMeanwhile) {
  Make("1.1.0", {});
  ASSERT_EQ(UpDetached().exit, 0);
  auto state = HoldState();
  Process installer(Command({"ota", "install", Bundle("1.1.0")}));
  ASSERT_NE(installer.LineWith("enter OTA"), "");
  ASSERT_EQ(Musher({"set", "LowPower"}).exit, 0);
  state.reset();
  const Ended ended = installer.Wait();
  EXPECT_EQ(ended.exit, 1);
  EXPECT_THAT(ended.err, HasSubstr("the machine was switched to LowPower meanwhile"));
  EXPECT_EQ(Where(), "LowPower from a");
  EXPECT_EQ(Versions()["slots"]["b"]["role"], "tried at the next start");
}

TEST_F(Killed, MachineInOtaCanBeTakenOutOfItByHand) {
  ASSERT_EQ(UpDetached().exit, 0);
  ASSERT_EQ(Musher({"set", "OTA"}).exit, 0);
  AwaitStatus(AllHaveArrivedIn("OTA"));
  EXPECT_EQ(Musher({"set", "Active"}).exit, 0);
  EXPECT_EQ(Where(), "Active from a");
}

TEST_F(Killed, ControllerInTheTrialBootIsFollowedByAControllerOfThePreviousVersion) {
  Make("1.1.0", {.set_up = Waits()});
  ASSERT_EQ(UpDetached().exit, 0);
  Process installer(Command({"ota", "install", Bundle("1.1.0")}));
  ASSERT_TRUE(AwaitFile(folder_ / "runs"));
  const int controller = Status()["pid"];
  ASSERT_EQ(kill(controller, SIGKILL), 0);
  const Ended ended = installer.Wait();
  EXPECT_EQ(ended.exit, 1);
  EXPECT_THAT(ended.err, HasSubstr("the controller exited during the trial boot"));
  const Ended up = UpDetached();
  EXPECT_EQ(up.exit, 0) << up.err;
  EXPECT_EQ(Where(), "Active from a");
  EXPECT_THAT(History(), HasSubstr("its trial boot did not finish"));
  // Nothing of the version that was left is left.
  for (const auto& actuator : Status()["actuators"]) EXPECT_EQ(actuator["state"], "Active");
}

// The installer said that the next start rolls back, which the next start did not do.
TEST_F(Killed, ControllerInTheTearDownBeforeTheTrialBootLeavesItToTheNextStart) {
  Make("2.0.0", {.tear_down = Waits()});
  Make("2.1.0", {});
  ASSERT_EQ(UpDetached().exit, 0);
  ASSERT_EQ(Install("2.0.0").exit, 0);
  Process installer(Command({"ota", "install", Bundle("2.1.0")}));
  ASSERT_TRUE(AwaitFile(folder_ / "runs"));
  KillController();
  const Ended ended = installer.Wait();
  EXPECT_EQ(ended.exit, 1);
  EXPECT_THAT(ended.err, HasSubstr("the controller exited before the trial boot, which waits for"));
  EXPECT_EQ(Versions()["slots"]["a"]["role"], "tried at the next start");
}

// It waited for 5 min for the answer of a controller that did not run any more.
TEST_F(Killed, ControllerBeforeTheMachineIsInOtaEndsTheInstallationSoon) {
  Make("1.1.0", {.large_bytes = 64 << 20});
  ASSERT_EQ(UpDetached().exit, 0);
  const int controller = Status()["pid"];
  Process installer(Command({"ota", "install", Bundle("1.1.0")}));
  ASSERT_NE(installer.LineWith("check"), "");
  ASSERT_EQ(kill(controller, SIGKILL), 0);
  const auto ended = installer.Wait();
  EXPECT_EQ(ended.exit, 1);
  EXPECT_THAT(ended.err,
              AnyOf(HasSubstr("exited before it"), HasSubstr("lost before it answered")));
}

TEST_F(Killed, MachineIsTakenDownInTheTrialBootAndStartsFromTheVersionBefore) {
  Make("1.1.0", {.set_up = Waits()});
  ASSERT_EQ(Install("1.1.0").exit, 0);
  Process up(Command({"up", root_}));
  ASSERT_TRUE(AwaitFile(folder_ / "runs"));
  up.Signal(SIGINT);
  EXPECT_EQ(up.Wait().exit, 1);  // it was stopped before it was up
  EXPECT_THAT(std::string(Versions()["last"]["reason"]), HasSubstr("taken down before it was up"));
  ASSERT_EQ(UpDetached().exit, 0);
  EXPECT_EQ(Where(), "Active from a");
}

TEST_F(Killed, TwoInstallersDoNotMeet) {
  Make("1.1.0", {.set_up = Waits()});
  ASSERT_EQ(UpDetached().exit, 0);
  Process first(Command({"ota", "install", Bundle("1.1.0")}));
  ASSERT_TRUE(AwaitFile(folder_ / "runs"));
  const Ended second = Install("1.1.0");
  EXPECT_EQ(second.exit, 1);
  EXPECT_THAT(second.err, HasSubstr("another installation is running"));
  first.Signal(SIGKILL);
  first.Wait();
  const Ended third = Install("1.1.0");
  EXPECT_EQ(third.exit, 1);
  EXPECT_THAT(third.err, HasSubstr("a trial boot is running"));
}

// The second start took the first one for a trial boot that had not finished, recorded a good
// version as failed, and ended the processes of the first.
TEST_F(Killed, AMachineThatIsBeingStartedIsNotStartedTwice) {
  Make("1.1.0", {});
  ASSERT_EQ(Install("1.1.0").exit, 0);
  // A process that is left of the other slot and ignores SIGTERM: a start waits for its end.
  Process left({"env", kMark, "MUSHER_CONFIG=" + root_ + "/slots/a/robot.toml", "sh", "-c",
                "trap '' TERM; echo runs; exec sleep 60"});
  ASSERT_NE(left.LineWith("runs"), "");
  Process first(Command({"up", root_}));
  ASSERT_TRUE(Until([] { return Versions()["slots"]["b"]["role"] == "on trial"; }));
  const Ended second = UpDetached();
  EXPECT_EQ(second.exit, 2);
  EXPECT_THAT(second.err, HasSubstr("already leads the machine of " + root_));
  EXPECT_NE(first.LineWith("version 1.1.0 in slot b is kept"), "");
  EXPECT_EQ(Where(), "Active from b");
  EXPECT_EQ(Versions()["last"]["kept"], true);
}

// It ended the actuators of an Active robot, without TearDown, for the trial boot that was due.
TEST_F(Killed, ControllerOfARobotThatStandsIsFollowedByOneThatLeavesThePendingTrialBootForLater) {
  Make("1.1.0", {});
  ASSERT_EQ(UpDetached().exit, 0);
  MarkForTrialBoot("1.1.0");  // and its installer is killed
  const auto before = Pids();
  KillController();
  ASSERT_EQ(Musher({"up", root_, "--detach", "--restarted"}).exit, 0);
  EXPECT_EQ(Where(), "Active from a");
  EXPECT_EQ(Pids(), before);
  EXPECT_THAT(History(), HasSubstr("the trial boot of slot b, version 1.1.0, waits"));
  const std::string versions = Musher({"ota", "status"}).out;
  EXPECT_THAT(versions, HasSubstr("its trial boot waits for `musher down`"));
  ASSERT_EQ(Musher({"down"}).exit, 0);
  ASSERT_EQ(UpDetached().exit, 0);
  EXPECT_EQ(Where(), "Active from b");
  EXPECT_EQ(Versions()["last"]["kept"], true);
}

TEST_F(Killed, NoActuatorEndsInATakeoverWhileATrialBootIsPending) {
  Make("1.1.0", {});
  ASSERT_EQ(UpDetached().exit, 0);
  MarkForTrialBoot("1.1.0");
  const auto before = Pids();
  ASSERT_EQ(Musher({"up", root_, "--detach", "--takeover"}).exit, 0);
  EXPECT_EQ(Where(), "Active from a");
  EXPECT_EQ(Pids(), before);
}

// The actuators that are up stand: they have to lie down before their processes end.
TEST_F(Killed, ControllerInTheTrialBootIsFollowedByOneThatTearsTheNewVersionDownFirst) {
  const std::string torn_down = folder_ / "torn_down";
  Make("1.1.0", {.set_up = "mkdir " + (folder_ / "first") + " && exit; " + Waits(),
                 .tear_down = "touch " + torn_down});
  ASSERT_EQ(UpDetached().exit, 0);
  Process installer(Command({"ota", "install", Bundle("1.1.0")}));
  ASSERT_TRUE(AwaitFile(folder_ / "runs")) << "legs are Active, voice is set up";
  installer.Signal(SIGKILL);
  KillController();
  ASSERT_EQ(Musher({"up", root_, "--detach", "--restarted"}).exit, 0);
  EXPECT_EQ(Where(), "Active from a");
  EXPECT_TRUE(std::filesystem::exists(torn_down));
  EXPECT_EQ(Versions()["last"]["kept"], false);
  EXPECT_THAT(History(), HasSubstr("its trial boot did not finish"));
}

// The slot was emptied under the machine that had begun to run from it.
TEST_F(Killed, MachineThatIsStartedDuringAnInstallationWaitsForItsEnd) {
  Make("1.1.0", {});
  Make("1.2.0", {});
  ASSERT_EQ(Install("1.1.0").exit, 0);
  auto installation = BeginInstallation("1.2.0", std::nullopt);
  ASSERT_TRUE(installation);
  ASSERT_TRUE(installation->Check({}));
  Process up(Command({"up", root_}));
  ASSERT_TRUE(up.AwaitError("the start waits for it"));
  ASSERT_TRUE(installation->Prepare() && installation->Copy({}) && installation->CheckWritten({}) &&
              installation->MarkTrialBoot());
  installation.reset();
  EXPECT_NE(up.LineWith("version 1.2.0 in slot b is kept"), "");
}

TEST_F(Killed, AnInstallerThatHasFoundNoMachineIsRefusedOnceThereIsOne) {
  Make("1.1.0", {});
  ASSERT_EQ(UpDetached().exit, 0);
  EXPECT_FALSE(BeginInstallation("1.1.0", std::nullopt));
}

TEST_F(Killed, AMachineThatRunsIsNotStartedTwice) {
  ASSERT_EQ(UpDetached().exit, 0);
  const Ended second = UpDetached();
  EXPECT_EQ(second.exit, 2);
  EXPECT_THAT(second.err, HasSubstr("already leads the machine of " + root_));
  const Ended takeover = Musher({"up", root_, "--detach", "--takeover"});
  EXPECT_EQ(takeover.exit, 0) << takeover.err;
  EXPECT_EQ(Where(), "Active from a");
}

// They were ended before the start had looked for a controller of another host, which may lead
// them. And the version that was to be tried counted as one whose trial had not finished.
TEST_F(Killed, NoProcessOfTheOtherSlotEndsWhereAControllerOfAnotherHostLeads) {
  Make("1.1.0", {.policy = "[transport]\nprofile = \"lan\"\n"});
  ASSERT_EQ(Install("1.1.0").exit, 0);
  Process left({"env", kMark, "MUSHER_CONFIG=" + root_ + "/slots/a/robot.toml", "sh", "-c",
                "trap 'echo ended; exit' TERM; echo runs; while :; do sleep 0.1; done"});
  ASSERT_NE(left.LineWith("runs"), "");
  {
    const FarController leads(name_space_);
    const Ended refused = UpDetached();
    EXPECT_EQ(refused.exit, 2);
    EXPECT_THAT(refused.err, HasSubstr("process 7 of another host"));
  }
  EXPECT_EQ(Versions()["slots"]["b"]["role"], "tried at the next start");
  left.Signal(SIGKILL);
  EXPECT_THAT(left.Wait().out, Not(HasSubstr("ended")));
  const Ended up = UpDetached();
  EXPECT_EQ(up.exit, 0) << up.err;
  EXPECT_EQ(Where(), "Active from b");
}

// Another start took the lock while the program was loaded, and changed the choice of the slot.
TEST_F(Killed, AControllerHoldsItsRootWhileItExecutesItsProgramAgain) {
  const std::string program = folder_ / "musher";
  std::filesystem::copy_file(BinDir() + "/musher", program);
  Make("1.1.0", {});
  const Ended up =
      RunToEnd({"env", "PATH=" + BinDir() + ":/usr/bin:/bin", program, "up", root_, "--detach"});
  ASSERT_EQ(up.exit, 0) << up.err;
  const int controller = Status()["pid"];
  const std::string loads = folder_ / "loads";
  const std::string loaded = folder_ / "loaded";
  // As the kernel names the program of a process once its file is removed.
  const std::string stand_in = program + " (deleted)";
  std::ofstream(stand_in) << "#!/bin/sh\ntouch " << loads << "\nuntil [ -e " << loaded
                          << " ]; do sleep 0.05; done\nexec " << BinDir() << "/musher \"$@\"\n";
  std::filesystem::permissions(stand_in, std::filesystem::perms(0755));
  std::filesystem::remove(program);
  Process installer(Command({"ota", "install", Bundle("1.1.0")}));
  ASSERT_TRUE(AwaitFile(loads));
  EXPECT_EQ(ota::HolderOf(root_ + "/run.lock"), controller);
  const Ended second = UpDetached();
  EXPECT_EQ(second.exit, 2);
  EXPECT_THAT(second.err, HasSubstr("already leads the machine of " + root_));
  std::ofstream(loaded) << "";
  const Ended installed = installer.Wait();
  EXPECT_EQ(installed.exit, 0) << installed.err;
  EXPECT_EQ(Where(), "Active from b");
  EXPECT_EQ(ota::HolderOf(root_ + "/run.lock"), controller);
}

// The good version was recorded as failed: its start had not begun.
TEST_F(Killed, AVersionIsTriedAtTheNextStartWhereAnotherControllerHasTakenTheMachine) {
  Make("1.1.0", {});
  ASSERT_EQ(Install("1.1.0").exit, 0);
  {
    const auto taken = StateStore::Open(root_ + "/state",
                                        {"dog", name_space_, transport::TestDomain(), root_, ""});
    ASSERT_TRUE(taken) << taken.error().message;
    EXPECT_EQ(UpDetached().exit, 2);
  }
  EXPECT_EQ(Versions()["slots"]["b"]["role"], "tried at the next start");
  const Ended up = UpDetached();
  EXPECT_EQ(up.exit, 0) << up.err;
  EXPECT_EQ(Where(), "Active from b");
}

TEST_F(Killed, ATakeoverInTheTrialBootContinuesIt) {
  const std::string go = folder_ / "go";
  Make("1.1.0", {.set_up = "touch " + (folder_ / "runs") + "; until [ -e " + go +
                           " ]; do sleep 0.05; done"});
  ASSERT_EQ(Install("1.1.0").exit, 0);
  Process first(Command({"up", root_}));
  ASSERT_TRUE(AwaitFile(folder_ / "runs"));
  Process second(Command({"up", root_, "--takeover"}));
  ASSERT_TRUE(first.AwaitError("the actuators keep running"));
  std::ofstream(go) << "";
  EXPECT_NE(second.LineWith("version 1.1.0 in slot b is kept"), "");
  EXPECT_EQ(Where(), "Active from b");
  EXPECT_EQ(Versions()["last"]["kept"], true);
}

// It ended the trial boot of the controller that lives, which then rolled the good version back.
TEST_F(Killed, ATakeoverThatIsRefusedInTheTrialBootLeavesItToTheControllerThatLeads) {
  const std::string go = folder_ / "go";
  Make("1.1.0", {.set_up = "touch " + (folder_ / "runs") + "; until [ -e " + go +
                           " ]; do sleep 0.05; done"});
  ASSERT_EQ(Install("1.1.0").exit, 0);
  Process first(Command({"up", root_}));
  ASSERT_TRUE(AwaitFile(folder_ / "runs"));
  const Ended refused = Musher({"--namespace", "elsewhere", "up", root_, "--takeover", "--detach"});
  EXPECT_EQ(refused.exit, 2);
  EXPECT_THAT(refused.err, HasSubstr("--namespace differs from the config"));
  std::ofstream(go) << "";
  EXPECT_NE(first.LineWith("version 1.1.0 in slot b is kept"), "");
  EXPECT_EQ(Where(), "Active from b");
}

// Each start was of the version that cannot begin.
TEST_F(Killed, AVersionThatIsRefusedWhereNoControllerLeadsHasHadItsTrialBoot) {
  Make("1.1.0", {.policy = "# another config\n"});
  ASSERT_EQ(Install("1.1.0").exit, 0);
  const std::string built = folder_ / "built-1.0.0";
  const Ended other = RunToEnd({"env", "PATH=" + built + "/bin:" + BinDir() + ":/usr/bin:/bin",
                                BinDir() + "/musher", "up", built + "/robot.toml", "--detach"});
  ASSERT_EQ(other.exit, 0) << other.err;
  KillController();
  const Ended refused = UpDetached();
  EXPECT_EQ(refused.exit, 2);
  EXPECT_THAT(refused.err, HasSubstr("with a different config than"));
  EXPECT_EQ(Musher({"down", "--without-controller"}).exit, 0);
  const Ended up = UpDetached();
  EXPECT_EQ(up.exit, 0) << up.err;
  EXPECT_EQ(Where(), "Active from a");
}

// The version before was started all the same.
TEST_F(Killed, AStartThatAPersonEndsBeforeItsVersionIsRefusedStartsNothingAgain) {
  Make("1.1.0", {.policy = "[transport]\nprofile = \"lan\"\n"});  // it listens for a second
  ASSERT_EQ(Install("1.1.0").exit, 0);
  std::ofstream(folder_ / "refuses") << "";
  Process up({"sh", "-c",
              "ASAN_OPTIONS=\"$ASAN_OPTIONS:verify_asan_link_order=0\" LD_PRELOAD=\"$0\" "
              "MUSHER_REFUSES_WITH=\"$1\" && export ASAN_OPTIONS LD_PRELOAD MUSHER_REFUSES_WITH && "
              "exec \"$2\" up \"$3\"",
              BinDir() + "/ota_refused_topic.so", folder_ / "refuses", BinDir() + "/musher",
              root_});
  const std::string name =
      NameLock::NameOf(transport::TestDomain(), name_space_, "musher/controller");
  ASSERT_TRUE(Until([&] { return NameLock::IsHeld(name); }));
  up.Signal(SIGTERM);
  const auto ended = [&up] {
    siginfo_t info{};
    return waitid(P_PID, static_cast<id_t>(up.pid()), &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
           info.si_pid == up.pid();
  };
  ASSERT_TRUE(Until(ended)) << Where();
  EXPECT_FALSE(std::filesystem::exists(folder_ / "refuses"));
  EXPECT_FALSE(NameLock::IsHeld(name)) << up.Wait().err;
  EXPECT_EQ(Versions()["last"]["kept"], false) << "it was refused, and had its trial boot";
  const Ended next = UpDetached();
  EXPECT_EQ(next.exit, 0) << next.err;
  EXPECT_EQ(Where(), "Active from a");
}

// It went on without the lock, from a slot that the installer may yet have written into.
TEST_F(Killed, AStartBesideAnInstallerThatIsStoppedIsRefused) {
  Make("1.1.0", {.large_bytes = 64 << 20});
  Process installer(Command({"ota", "install", Bundle("1.1.0")}));
  ASSERT_NE(installer.LineWith("copy"), "");
  installer.Signal(SIGSTOP);
  for (const auto& words : {std::vector<std::string>{"up", root_, "--detach"},
                            std::vector<std::string>{"up", root_, "--detach", "--takeover"}}) {
    const Ended refused = Musher(words);
    EXPECT_EQ(refused.exit, 2);
    EXPECT_THAT(refused.err,
                HasSubstr("it is stopped: `kill -CONT " + std::to_string(installer.pid())));
  }
  installer.Signal(SIGKILL);
  installer.Wait();
  const Ended up = UpDetached();
  EXPECT_EQ(up.exit, 0) << up.err;
  EXPECT_EQ(Where(), "Active from a");
}

}  // namespace musher::testing::kill_test
