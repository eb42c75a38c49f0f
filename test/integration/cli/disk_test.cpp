// The controller's disk lets it down while the robot runs.

#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "musher/base/unique_fd.hpp"
#include "musher/test/fault_injection/host/isolation.hpp"
#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing::disk_test {

using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::Not;

class Disk : public MachineByCli {
 protected:
  void Start() {
    up_ = std::make_unique<Process>(Command({"up", config_, "--json"}));
    ASSERT_NE(up_->LineWith("eyes: Active done"), "");
  }
  // `musher up` with a state folder that hangs while the file `stall` is there, for half a minute
  // at most: for the controller, and for what actuators print.
  void StartOnADiskThatMayHang() {
    const std::string library = BinDir() + "/cli_stalling_disk.so";
    std::vector<std::string> words = {"env", "LD_PRELOAD=" + library,
                                      "MUSHER_STALL_BELOW=" + (folder_ / "state"),
                                      "MUSHER_STALL_WHILE=" + stall_};
    const auto up = Command({"up", config_, "--json"});
    words.insert(words.end(), up.begin(), up.end());
    up_ = std::make_unique<Process>(words);
  }
  void Hang() const { std::ofstream(stall_) << "now"; }
  void Answer() const { std::filesystem::remove(stall_); }

  // Of legs, which is restarted on failure.
  void ExpectACrashedActuatorIsRestarted() const {
    const pid_t before = Status()["actuators"]["legs"]["pid"];
    kill(before, SIGKILL);
    ASSERT_NE(up_->LineWith("legs: Active done"), "");
    const auto after = Status()["actuators"]["legs"];
    EXPECT_NE(after["pid"], before);
    EXPECT_EQ(after["state"], "Active");
  }

  std::unique_ptr<Process> up_;

 private:
  const std::string stall_ = folder_ / "stall";
};

TEST_F(Disk, WithAFileSizeLimitIsReportedAndDoesNotEndTheController) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const pid_t controller = Status()["pid"];
  rlimit limit{};
  prlimit(controller, RLIMIT_FSIZE, nullptr, &limit);
  limit.rlim_cur = 1;
  ASSERT_EQ(prlimit(controller, RLIMIT_FSIZE, &limit, nullptr), 0);
  EXPECT_EQ(Musher({"set", "LowPower"}).exit, 0);
  EXPECT_NE(up_->LineWith("the journal is not on disk: "), "");
  EXPECT_EQ(Musher({"set", "Active"}).exit, 0);
  EXPECT_EQ(Status()["pid"], controller);
}

// An actuator whose command had printed a line hung with the disk of its log: it could be neither
// switched nor stopped.
TEST_F(Disk, ThatHangsHoldsNoActuatorThatPrints) {
  for (const char* actuator : {"legs", "voice", "eyes"}) {
    Does(actuator,
         "[state.LowPower]\nshell = \"echo rests\"\n[emergency_stop]\nshell = \"echo stops\"\n");
  }
  StartOnADiskThatMayHang();
  ASSERT_NE(up_->LineWith("eyes: Active done"), "");
  Hang();
  const Ended set = Musher({"set", "LowPower"});
  EXPECT_EQ(set.exit, 0) << set.out << set.err;
  const Ended stop = Musher({"estop"});
  EXPECT_THAT(stop.err, Not(HasSubstr("not confirmed"))) << stop.out;
  Answer();
}

TEST_F(Disk, ThatHangsIsNamedByTheStartThatWaitsForIt) {
  Hang();
  StartOnADiskThatMayHang();
  EXPECT_TRUE(up_->AwaitError("has not begun yet; perhaps the disk of"));
  Answer();
  EXPECT_NE(up_->LineWith("the machine is Active"), "");
}

TEST_F(Disk, ThatIsFullIsInTheStatusAndTheHistoryAndForTheNextController) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const pid_t controller = Status()["pid"];
  rlimit limit{};
  prlimit(controller, RLIMIT_FSIZE, nullptr, &limit);
  limit.rlim_cur = 4096;  // as on a full disk, a block that is there can be written
  ASSERT_EQ(prlimit(controller, RLIMIT_FSIZE, &limit, nullptr), 0);
  ASSERT_EQ(Musher({"set", "LowPower"}).exit, 0);
  ASSERT_EQ(Musher({"set", "Active"}).exit, 0);
  const auto status = AwaitStatus([](const auto& s) { return !s["not_on_disk"].empty(); });
  EXPECT_THAT(status["not_on_disk"][0].get<std::string>(), HasSubstr("journal ("));

  const Ended history = Musher({"history"});
  EXPECT_THAT(history.err, HasSubstr("the journal is not on disk since 2"));
  EXPECT_THAT(history.out, HasSubstr("LowPower → Active"));
  const Ended why = Musher({"history", "--why"});
  EXPECT_THAT(why.err, HasSubstr("the journal is not on disk since 2"));
  const std::string last = "(switch " + std::to_string(status["switch"].get<int>()) + ")";
  EXPECT_THAT(why.out, HasSubstr(last));

  kill(controller, SIGKILL);
  EXPECT_EQ(up_->Wait().exit, 1);
  const Ended file = Musher({"history", "--journal", folder_ / "state/journal.sqlite"});
  EXPECT_THAT(file.err, HasSubstr("the journal lacks the newest entries"));
  ASSERT_EQ(UpDetached().exit, 0);
  EXPECT_THAT(Musher({"history"}).out, HasSubstr("entries are missing before this one"));
}

TEST_F(Disk, ThatIsFullIsSaidByAnEmergencyStop) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const pid_t controller = Status()["pid"];
  rlimit limit{};
  prlimit(controller, RLIMIT_FSIZE, nullptr, &limit);
  limit.rlim_cur = 1;
  ASSERT_EQ(prlimit(controller, RLIMIT_FSIZE, &limit, nullptr), 0);
  const Ended estop = Musher({"estop"});
  EXPECT_EQ(estop.exit, 0) << "every actuator is stopped";
  EXPECT_THAT(estop.err, HasSubstr("not on disk: emergency stop ("));
  End(PublisherOf(estop));  // a reboot within a minute is stopped again
}

// It succeeded with no word on stderr, and the next controller started the actuator.
TEST_F(Disk, ThatIsFullIsSaidWhereAnActuatorIsSetAlone) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const pid_t controller = Status()["pid"];
  const Ended before = Musher({"set", "LowPower", "eyes"});
  EXPECT_EQ(before.exit, 0);
  EXPECT_EQ(before.err, "");
  rlimit limit{};
  prlimit(controller, RLIMIT_FSIZE, nullptr, &limit);
  limit.rlim_cur = 1;
  ASSERT_EQ(prlimit(controller, RLIMIT_FSIZE, &limit, nullptr), 0);
  const Ended held = Musher({"set", "LowPower", "voice"});
  EXPECT_EQ(held.exit, 0);
  EXPECT_THAT(held.err, HasSubstr("not on disk: list of actuators ("));
  EXPECT_THAT(held.err, HasSubstr("may start voice or raise it"));
  const Ended torn_down = Musher({"set", "TearDown", "eyes"});
  EXPECT_EQ(torn_down.exit, 0);
  EXPECT_THAT(torn_down.err, HasSubstr("not on disk: list of actuators ("));
}

// As another user could have left them before the folder became ours: they were followed.
TEST_F(Disk, FollowsNoLinkToALogInTheStateFolder) {
  const std::string state = folder_ / "state";
  const std::string target = folder_ / "target";
  const std::string elsewhere = folder_ / "elsewhere";
  std::filesystem::create_directory(state);
  std::filesystem::permissions(state, std::filesystem::perms(0700));
  std::filesystem::create_directory(elsewhere);
  std::ofstream(target) << "precious\n";
  std::ofstream(elsewhere + "/legs.log") << "of another\n";
  std::filesystem::create_symlink(target, state + "/controller.log");
  std::filesystem::create_directory_symlink(elsewhere, state + "/logs");
  const Ended up = UpDetached();
  EXPECT_EQ(up.exit, 0);
  EXPECT_THAT(up.err, HasSubstr("can't write " + state + "/logs/legs.log: Too many levels of " +
                                "symbolic links"));
  EXPECT_EQ(Musher({"set", "LowPower"}).exit, 0);
  EXPECT_EQ(Musher({"down"}).exit, 0);
  EXPECT_EQ(ReadFile(target), "precious\n");
  EXPECT_EQ(ReadFile(elsewhere + "/legs.log"), "of another\n");
  EXPECT_EQ(EntriesOf(elsewhere).size(), 1U);
}

TEST_F(Disk, FollowsALinkThatTheConfigNamesAsTheControllersLog) {
  Replace("state_dir", "log = \"robot.log\"\nstate_dir");
  std::filesystem::create_symlink(folder_ / "elsewhere.log", folder_ / "robot.log");
  EXPECT_EQ(UpDetached().exit, 0);
  EXPECT_EQ(Musher({"down"}).exit, 0);
  EXPECT_THAT(ReadFile(folder_ / "elsewhere.log"), HasSubstr("controller started"));
}

TEST_F(Disk, ThatCannotBeWrittenAtTheStartKeepsTheMachineFromActive) {
  Replace("state_dir = \"state\"", "state_dir = \"/proc/robot\"");
  const Ended up = UpDetached();
  EXPECT_EQ(up.exit, 1);
  EXPECT_THAT(up.err, HasSubstr("the state folder cannot be written"));
  EXPECT_EQ(Status()["state"], "SelfCheck");
  EXPECT_EQ(Musher({"set", "Active"}).exit, 0) << "a person may";
}

TEST_F(Disk, WithoutItsStateFolderStillLetsAnActuatorBeStartedAgain) {
  ASSERT_NO_FATAL_FAILURE(Start());
  // What runs may make a file in a folder that is being removed: then once more.
  std::error_code failed;
  for (int i = 0; i < 100 && std::filesystem::exists(folder_ / "state"); ++i) {
    std::filesystem::remove_all(folder_ / "state", failed);
  }
  ExpectACrashedActuatorIsRestarted();
  // The controller looks once a second.
  EXPECT_TRUE(AwaitFile(folder_ / "state/logs/legs.log"));
}

TEST_F(Disk, WithoutWritableLogsIsReportedAndActuatorsAreStillRestarted) {
  ASSERT_NO_FATAL_FAILURE(Start());
  std::filesystem::remove_all(folder_ / "state/logs");
  std::ofstream(folder_ / "state/logs") << "in the way";
  const pid_t before = Status()["actuators"]["legs"]["pid"];
  kill(before, SIGKILL);
  EXPECT_THAT(up_->LineWith("actuator output is lost"), HasSubstr("Not a directory"));
  AwaitStatus([before](const auto& s) {
    const auto& legs = s["actuators"]["legs"];
    return legs["pid"] != before && legs["state"] == "Active";
  });
}

// It went on for ever into files that no name led to, with an empty `not_on_disk`.
TEST_F(Disk, WhoseStateFolderIsReplacedHasTheJournalAndAllSmallFilesAgain) {
  ASSERT_NO_FATAL_FAILURE(Start());
  {
    Process before(Command({"history", "-f"}));  // on a busy host the journal is begun later
    ASSERT_NE(before.LineWith("eyes: Active done"), "");
  }
  const std::string state = folder_ / "state";
  std::filesystem::rename(state, state + ".before");  // as another volume is mounted there
  EXPECT_NE(up_->LineWith("had been removed, or another volume was mounted there; saved again"),
            "");
  for (const char* file : {"machine", "epoch", "config", "processes"}) {
    EXPECT_TRUE(std::filesystem::exists(state + "/" + file)) << file;
  }
  // It is looked for once a second, as they are.
  Process history(Command({"history", "-f"}));
  EXPECT_NE(history.LineWith("the journal's file was removed while it was written"), "");
  ASSERT_EQ(Musher({"set", "LowPower"}).exit, 0);
  EXPECT_NE(history.LineWith("Active → LowPower"), "");
}

// The state folder is a small disk of its own, in a mount namespace of this test.
class SmallDisk : public Disk {
 protected:
  void SetUp() override {
    before_ = UniqueFd(open("/proc/thread-self/ns/mnt", O_RDONLY | O_CLOEXEC));
    root_ = UniqueFd(open("/", O_PATH | O_CLOEXEC));
    place_ = UniqueFd(open(".", O_PATH | O_CLOEXEC));
    if (geteuid() != 0 || unshare(CLONE_NEWNS) != 0) {
      GTEST_SKIP() << "no mount namespace here: " << std::strerror(errno);
    }
    entered_ = true;
    ASSERT_EQ(mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr), 0);
    std::filesystem::create_directory(state_);
    fault_injection::MountMemory(state_, kKilobytes);
    std::filesystem::permissions(state_, std::filesystem::perms(0755));
  }
  ~SmallDisk() override {
    KillChildren();
    if (!entered_) return;
    umount2(state_.c_str(), MNT_DETACH);
    // It leads to the root of the namespace, also where this process has another one (chroot).
    const bool back = setns(before_.get(), CLONE_NEWNS) == 0 && fchdir(root_.get()) == 0 &&
                      chroot(".") == 0 && fchdir(place_.get()) == 0;
    EXPECT_TRUE(back) << std::strerror(errno);
  }

  void Fill() const {
    const UniqueFd file(open((state_ + "/filler").c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600));
    ASSERT_TRUE(file.valid());
    const std::string block(4096, 'x');
    while (write(file.get(), block.data(), block.size()) > 0) {
    }
    ASSERT_EQ(errno, ENOSPC);
    struct statfs disk {};
    ASSERT_EQ(statfs(state_.c_str(), &disk), 0);
    ASSERT_EQ(disk.f_bavail, 0U);
  }
  // The power fails: nothing of the machine runs any more, and none of it could say so.
  void CutPower() {
    KillChildren();
    up_.reset();
    std::filesystem::remove(state_ + "/processes");  // of a boot that is over
    ASSERT_TRUE(Status().is_null());
  }
  // The machine has a state between SelfCheck and Protected.
  void GiveDeActive() const {
    ReplaceAll("\"SelfCheck\", ", "\"SelfCheck\", \"DeActive\", ");
    ReplaceAll("times = [10000, ", "times = [10000, 5000, ");
  }
  static bool AllAre(const nlohmann::json& status, const std::string& state) {
    if (status["state"] != state) return false;
    for (const auto& [name, actuator] : status["actuators"].items()) {
      if (actuator["state"] != state) return false;
    }
    return true;
  }

  static constexpr int kKilobytes = 4096;
  const std::string state_ = folder_ / "state";

 private:
  void ReplaceAll(const std::string& words, const std::string& by) const {
    std::string toml = ReadFile(config_);
    for (std::size_t at = 0; (at = toml.find(words, at)) != std::string::npos; at += by.size()) {
      toml.replace(at, words.size(), by);
    }
    std::ofstream(config_) << toml;
  }

  UniqueFd before_;
  UniqueFd root_;
  UniqueFd place_;
  bool entered_ = false;
};

// The stop was not on disk, and the robot stood up to Active.
TEST_F(SmallDisk, ThatIsFullKeepsAnEmergencyStopOverALossOfPower) {
  ASSERT_NO_FATAL_FAILURE(Start());
  ASSERT_NO_FATAL_FAILURE(Fill());
  const Ended estop = Musher({"estop", "it", "smokes"});
  EXPECT_EQ(estop.exit, 0) << estop.err;
  EXPECT_THAT(estop.err, Not(HasSubstr("not on disk")));
  EXPECT_EQ(Status()["emergency_stop"]["engaged"], true);
  ASSERT_NO_FATAL_FAILURE(CutPower());
  const Ended up = UpDetached();
  EXPECT_EQ(up.exit, 1);
  EXPECT_THAT(up.err, HasSubstr("an emergency stop is engaged"));
  const auto status = Status();
  EXPECT_EQ(status["state"], "SetUp");
  for (const auto& [name, actuator] : status["actuators"].items()) {
    EXPECT_THAT(actuator["state"], AnyOf("SetUp", "Uninitialized")) << name;
  }
  EXPECT_EQ(status["emergency_stop"]["engaged"], true);
  EXPECT_EQ(status["emergency_stop"]["reason"], "it smokes");
  EXPECT_EQ(Musher({"set", "Active"}).exit, 1);
  EXPECT_EQ(Musher({"estop", "--release"}).exit, 0);
}

// What a person had torn down alone, or held, came on by itself.
TEST_F(SmallDisk, ThatIsFullKeepsWhatHasEndedAndWhatIsHeldOverARestartOfTheController) {
  ASSERT_NO_FATAL_FAILURE(Start());
  ASSERT_NO_FATAL_FAILURE(Fill());
  for (const auto& [state, actuator] : {std::pair("TearDown", "eyes"), {"LowPower", "voice"}}) {
    const Ended set = Musher({"set", state, actuator});
    EXPECT_EQ(set.exit, 0) << set.err;
    EXPECT_THAT(set.err, Not(HasSubstr("not on disk")));
  }
  const auto before = Status();
  const pid_t voice = before["actuators"]["voice"]["pid"];
  kill(before["pid"].get<pid_t>(), SIGKILL);
  kill(voice, SIGKILL);
  up_->Wait();
  Process again(Command({"up", config_, "--restarted"}));
  const auto after = AwaitStatus([&](const auto& now) {
    const auto& held = now["actuators"]["voice"];
    const bool is_new = held["pid"].is_number() && held["pid"] != voice;
    return is_new && (held["state"] == "LowPower" || held["state"] == "Active");
  });
  EXPECT_EQ(after["actuators"]["voice"]["state"], "LowPower");
  EXPECT_EQ(after["actuators"]["legs"]["state"], "Active");
  EXPECT_TRUE(after["actuators"]["eyes"]["pid"].is_null()) << "it stays down";
}

// What its actuators have received before is lost with them: it may not know of a stop.
TEST_F(SmallDisk, ThatIsReadOnlyAfterALossOfPowerKeepsTheMachineInDeActive) {
  GiveDeActive();
  ASSERT_NO_FATAL_FAILURE(Start());
  ASSERT_EQ(Status()["state"], "Active");
  ASSERT_NO_FATAL_FAILURE(CutPower());
  fault_injection::MakeReadOnly(state_, true);
  const Ended up = UpDetached();
  EXPECT_EQ(up.exit, 0) << up.err;
  EXPECT_THAT(up.out, HasSubstr("the state folder cannot be written")) << up.err;
  const auto status = AwaitStatus([](const auto& now) { return AllAre(now, "DeActive"); });
  EXPECT_EQ(status["state"], "DeActive");
  EXPECT_EQ(Musher({"set", "Active"}).exit, 0) << "a person may";
}

// The stop was on the disk, and the robot went to DeActive without it: `musher set Active` stood it
// up.
TEST_F(SmallDisk, ThatIsReadOnlyAfterALossOfPowerKeepsAnEmergencyStop) {
  GiveDeActive();
  ASSERT_NO_FATAL_FAILURE(Start());
  const std::string id = Status()["machine_id"];
  ASSERT_EQ(Musher({"estop", "it", "smokes"}).exit, 0);
  AwaitStatus([](const auto& now) { return now["not_on_disk"].empty(); });
  ASSERT_NO_FATAL_FAILURE(CutPower());
  fault_injection::MakeReadOnly(state_, true);
  const Ended up = UpDetached();
  EXPECT_EQ(up.exit, 1);
  EXPECT_THAT(up.err, HasSubstr("an emergency stop is engaged"));
  const auto status = Status();
  EXPECT_EQ(status["state"], "SetUp");
  EXPECT_EQ(status["emergency_stop"]["reason"], "it smokes");
  EXPECT_EQ(status["machine_id"], id);
  EXPECT_EQ(Musher({"set", "Active"}).exit, 1);
  EXPECT_EQ(Musher({"estop", "--release"}).exit, 0);
}

}  // namespace musher::testing::disk_test
