// Actuators of the controller's own host as units of its systemd: `units = "always"`. The host is a
// real one but for its kernel: a root of Debian that boots under systemd-nspawn, in which `musher`
// runs. Needs root, systemd-nspawn, mmdebstrap and Debian's archive. With MUSHER_THIS_HOST it is
// this computer, with its kernel: scripts/kernel boots one in an emulator.

#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "musher/test/integration/hosts/robot_and_board.hpp"

namespace musher::testing::own_units_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr const char* kEyes = "musher-robot-eyes.service";

class OwnUnits : public MachineFixture {
 protected:
  static void SetUpTestSuite() {
    if (!kThisHost) root_ = std::make_unique<BoardRoot>(missing_);
  }
  static void TearDownTestSuite() { root_ = nullptr; }

  void SetUp() override {
    if (!missing_.empty()) GTEST_SKIP() << missing_;
    setenv("XDG_STATE_HOME", folder_.path().c_str(), 1);
    setenv("PATH", (BinDir() + ":" + path_).c_str(), 1);
    Write("always");
    if (kThisHost) return;
    const std::string folder = folder_.path();
    host_.emplace(std::vector<std::string>{
        "sh", "-c",
        "exec systemd-nspawn --quiet --directory=" + root_->path() +
            " --boot --register=no --keep-unit --machine=own --private-network --bind=" + folder +
            " --bind-ro=" + BinDir() + " < /dev/null > " + (folder_ / "console") + " 2>&1"});
    ASSERT_TRUE(Until([this] { return IsBooted(); }, std::chrono::seconds(60)))
        << ReadFile(folder_ / "console");
  }
  ~OwnUnits() override {
    if (kThisHost) Run({"down"});
    if (init_ != 0) kill(init_, SIGKILL);  // and with it all that runs there
    if (host_) host_->Wait();
    KillChildren();
    unsetenv("XDG_STATE_HOME");
    setenv("PATH", path_.c_str(), 1);
  }

  bool IsBooted() {
    const std::string pid = std::to_string(host_->pid());
    std::ifstream("/proc/" + pid + "/task/" + pid + "/children") >> init_;
    return init_ != 0 && Do({"systemctl", "is-active", "--quiet", "multi-user.target"}).exit == 0;
  }
  Ended Do(std::vector<std::string> words) const {
    if (kThisHost) return RunToEnd(words);
    words.insert(words.begin(), {"nsenter", "--target", std::to_string(init_), "--mount", "--uts",
                                 "--ipc", "--net", "--pid", "--root", "--wd", "--"});
    return RunToEnd(words);
  }
  Ended Run(std::vector<std::string> words) const { return Do(Command(std::move(words))); }
  nlohmann::json Status() const {
    const Ended status = Run({"status", "--json"});
    return status.exit == 0 ? Json(status.out) : nlohmann::json();
  }
  std::string History() const { return Run({"history"}).out; }
  bool AwaitHistory(const std::string& text) const {
    return Until([&] { return History().find(text) != std::string::npos; }, kSoon);
  }
  std::string Property(const std::string& name) const {
    std::string value = Do({"systemctl", "show", "--value", "-p", name, kEyes}).out;
    while (value.ends_with('\n')) value.pop_back();
    return value;
  }
  bool KeepsMemory() const {
    return Do({"grep", "-qw", "memory", "/sys/fs/cgroup/cgroup.controllers"}).exit == 0;
  }
  // Of cgroups of version 2.
  static std::string GroupFile(const std::string& name) {
    return "/sys/fs/cgroup/system.slice/" + std::string(kEyes) + "/" + name;
  }
  std::string Units() const {
    return Do({"systemctl", "list-units", "--all", "--no-legend", "--plain", "musher-*"}).out;
  }
  pid_t PidOfEyes() const {
    const nlohmann::json status = Status();
    const nlohmann::json pid =
        status.is_null() ? nlohmann::json() : status["actuators"]["eyes"]["pid"];
    return pid.is_number() ? pid.get<pid_t>() : 0;
  }
  void StartUp(const std::string& from = "/") const {
    const Ended up =
        Do({"env", "--chdir=" + from, BinDir() + "/musher", "up", config_, "--detach"});
    ASSERT_EQ(up.exit, 0) << up.err;
    ASSERT_TRUE(AwaitActive()) << Status();
  }
  bool AwaitActive() const {
    return Until([this] { return AllHaveArrivedIn("Active")(Status()); }, kSoon);
  }
  void KillController() const {
    const std::string pid = std::to_string(Status()["pid"].get<int>());
    ASSERT_EQ(Do({"kill", "-KILL", pid}).exit, 0);
    ASSERT_TRUE(Until([this] { return Status().is_null(); }, kSoon));
  }

  Ended SignalDBus(const std::string& signal) const {
    return Do({"sh", "-c", "kill -" + signal + " $(systemctl show --value -p MainPID dbus)"});
  }

  // `more`: lines of actuator eyes.
  void Write(const std::string& units, const std::string& more = "",
             const std::string& command = "") const {
    const std::string states = R"(["SetUp", "TearDown", "SelfCheck", "Active", "LowPower"])";
    const auto actuator = [&](const std::string& name) {
      std::ofstream(folder_ / (name + ".toml")) << "[state.LowPower]\nrun = [\"true\"]\n";
      return "[actuator." + name + "]\nstates = " + states +
             "\ntimes = [10000, 5000, 5000, 5000, 5000]\n";
    };
    const auto exec = [&](const std::string& name) {
      return "command = [\"musher-exec\", \"" + (folder_ / name) + ".toml\"]\n";
    };
    std::ofstream(config_) << "[controller]\nname = \"robot\"\nactuators = [\"legs\", \"eyes\"]\n"
                           << "states = " << states << "\ndefault_time = 2000\nnamespace = \""
                           << name_space_ << "\"\nstate_dir = \"state\"\nunits = \"" << units
                           << "\"\n"
                           << actuator("legs") << exec("legs") << "critical = true\n"
                           << actuator("eyes") << (command.empty() ? exec("eyes") : command)
                           << more;
  }

  static inline const bool kThisHost = getenv("MUSHER_THIS_HOST") != nullptr;
  static constexpr std::chrono::seconds kSoon{120};
  static inline std::unique_ptr<BoardRoot> root_;
  static inline std::string missing_;
  const std::string path_ = getenv("PATH");
  const std::string config_ = folder_ / "robot.toml";
  std::optional<Process> host_;
  pid_t init_ = 0;
};

TEST_F(OwnUnits, RunTheActuatorsUntilTheMachineIsTornDown) {
  ASSERT_NO_FATAL_FAILURE(StartUp());
  EXPECT_EQ(Property("MainPID"), std::to_string(PidOfEyes()));
  EXPECT_THAT(Units(), AllOf(HasSubstr(kEyes), HasSubstr("musher-robot-legs.service")));
  EXPECT_EQ(Status()["actuators"]["eyes"]["unit"], kEyes);
  EXPECT_THAT(Run({"status"}).out, HasSubstr(kEyes));
  const Ended down = Run({"down"});
  EXPECT_EQ(down.exit, 0) << down.err;
  EXPECT_THAT(Units(), IsEmpty());
}

TEST_F(OwnUnits, HaveTheEnvironmentTheFolderAndTheLogOfAChild) {
  Write("always", "restart = \"no\"\n",
        "command = [\"sh\", \"-c\", \"echo $OF_THE_SHELL in $PWD; echo no such port >&2; exit "
        "3\"]\n");
  const Ended up = Do({"env", "--chdir=" + folder_.path(), "OF_THE_SHELL=seen",
                       BinDir() + "/musher", "up", config_, "--detach"});
  EXPECT_EQ(up.exit, 0) << up.err;
  EXPECT_TRUE(AwaitHistory("ended: exit code 3: no such port")) << History();
  const std::string log = Run({"logs", "eyes"}).out;
  EXPECT_THAT(log, AllOf(HasSubstr("seen in " + folder_.path()), HasSubstr("no such port")));
  EXPECT_EQ(Run({"down"}).exit, 0);
  EXPECT_THAT(Units(), IsEmpty());  // also none that has failed
}

TEST_F(OwnUnits, ThatAreKilledAreSoReportedAndAreStartedAgainAsUnits) {
  ASSERT_NO_FATAL_FAILURE(StartUp());
  const pid_t before = PidOfEyes();
  ASSERT_EQ(Do({"kill", "-KILL", std::to_string(before)}).exit, 0);
  ASSERT_TRUE(Until([&] { return PidOfEyes() != before && PidOfEyes() != 0; }, kSoon));
  ASSERT_TRUE(AwaitActive());
  EXPECT_EQ(Property("MainPID"), std::to_string(PidOfEyes()));
  EXPECT_THAT(History(),
              HasSubstr("eyes's process " + std::to_string(before) + " ended: killed by SIGKILL"));
  EXPECT_EQ(Run({"restart", "eyes"}).exit, 0);
  EXPECT_EQ(Run({"down"}).exit, 0);
  EXPECT_THAT(Units(), IsEmpty());
}

TEST_F(OwnUnits, RunOnWhenTheControllerIsKilledAndTheNextOneEndsThem) {
  ASSERT_NO_FATAL_FAILURE(StartUp());
  const pid_t before = PidOfEyes();
  ASSERT_NO_FATAL_FAILURE(KillController());
  EXPECT_EQ(Property("MainPID"), std::to_string(before));
  ASSERT_NO_FATAL_FAILURE(StartUp());
  EXPECT_EQ(PidOfEyes(), before);
  ASSERT_EQ(Do({"kill", "-KILL", std::to_string(before)}).exit, 0);
  EXPECT_TRUE(
      AwaitHistory("eyes's process " + std::to_string(before) + " ended: killed by SIGKILL"))
      << History();
  ASSERT_TRUE(AwaitActive());
  EXPECT_EQ(Run({"down"}).exit, 0);
  EXPECT_THAT(Units(), IsEmpty());
}

TEST_F(OwnUnits, AreTakenUpByAControllerWithoutUnitsAndChildrenByOneWithThem) {
  Write("never");
  ASSERT_NO_FATAL_FAILURE(StartUp());
  const pid_t child = PidOfEyes();
  EXPECT_THAT(Units(), IsEmpty());
  ASSERT_NO_FATAL_FAILURE(KillController());
  Write("always");
  ASSERT_NO_FATAL_FAILURE(StartUp());
  EXPECT_EQ(PidOfEyes(), child);
  ASSERT_EQ(Run({"restart", "eyes"}).exit, 0);
  ASSERT_TRUE(AwaitActive());
  const pid_t unit = PidOfEyes();
  EXPECT_EQ(Property("MainPID"), std::to_string(unit));
  ASSERT_NO_FATAL_FAILURE(KillController());
  Write("never");
  ASSERT_NO_FATAL_FAILURE(StartUp());
  EXPECT_EQ(PidOfEyes(), unit);
  EXPECT_EQ(Run({"down"}).exit, 0);
  EXPECT_EQ(Do({"kill", "-0", std::to_string(unit)}).exit, 1);
}

// The exit is known from the kernel, and no child is started in the place of the unit.
TEST_F(OwnUnits, ThatExitWhileDBusIsSilentAreStartedOnceItAnswers) {
  ASSERT_NO_FATAL_FAILURE(StartUp());
  const pid_t before = PidOfEyes();
  ASSERT_EQ(SignalDBus("STOP").exit, 0);
  ASSERT_EQ(Do({"kill", "-KILL", std::to_string(before)}).exit, 0);
  EXPECT_TRUE(
      AwaitHistory("eyes's process " + std::to_string(before) + " ended: exit code unknown"))
      << History();
  EXPECT_TRUE(AwaitHistory("could not be started: this host")) << History();
  EXPECT_THAT(Do({"sh", "-c", "grep -lsz 'eyes[.]toml' /proc/[0-9]*/cmdline"}).out, IsEmpty());
  ASSERT_EQ(SignalDBus("CONT").exit, 0);
  ASSERT_TRUE(AwaitActive()) << History();
  EXPECT_EQ(Property("MainPID"), std::to_string(PidOfEyes()));
  EXPECT_EQ(Run({"down"}).exit, 0);
}

// It is started again for the first that connects to its socket.
TEST_F(OwnUnits, RunOnWhenDBusIsKilledAndAreStartedAgainByTheNextOne) {
  ASSERT_NO_FATAL_FAILURE(StartUp());
  const pid_t before = PidOfEyes();
  ASSERT_EQ(SignalDBus("KILL").exit, 0);
  EXPECT_TRUE(AwaitHistory("this host is reached")) << History();
  EXPECT_EQ(PidOfEyes(), before);
  EXPECT_EQ(Status()["actuators"]["eyes"]["state"], "Active");
  ASSERT_EQ(Do({"kill", "-KILL", std::to_string(before)}).exit, 0);
  EXPECT_TRUE(
      AwaitHistory("eyes's process " + std::to_string(before) + " ended: killed by SIGKILL"))
      << History();
  ASSERT_TRUE(Until([&] { return PidOfEyes() != before && PidOfEyes() != 0; }, kSoon));
  ASSERT_TRUE(AwaitActive());
  EXPECT_EQ(Run({"down"}).exit, 0);
  EXPECT_THAT(Units(), IsEmpty());
}

// As an upgrade of its package does.
TEST_F(OwnUnits, RunOnWhenSystemdIsExecutedAgain) {
  ASSERT_NO_FATAL_FAILURE(StartUp());
  const pid_t before = PidOfEyes();
  ASSERT_EQ(Do({"systemctl", "daemon-reexec"}).exit, 0);
  EXPECT_EQ(Property("MainPID"), std::to_string(before));
  EXPECT_EQ(PidOfEyes(), before);
  ASSERT_EQ(Run({"restart", "eyes"}).exit, 0);
  ASSERT_TRUE(AwaitActive());
  EXPECT_NE(PidOfEyes(), before);
  EXPECT_EQ(Property("MainPID"), std::to_string(PidOfEyes()));
  EXPECT_EQ(Run({"down"}).exit, 0);
  EXPECT_THAT(Units(), IsEmpty());
}

TEST_F(OwnUnits, HaveTheLimitsOfTheConfig) {
  Write("always",
        "memory_max_mb = 512\ncpus = 0.5\nnice = 7\nuser = \"daemon\"\nsandbox = \"read-only\"\n");
  // That user reads the config.
  std::filesystem::permissions(folder_.path(), std::filesystem::perms{0755});
  // Its kernel may keep none of them. Into that folder its user may not go.
  ASSERT_NO_FATAL_FAILURE(StartUp("/root"));
  EXPECT_EQ(Property("MemoryMax"), std::to_string(512 << 20));
  EXPECT_EQ(Property("CPUQuotaPerSecUSec"), "500ms");
  EXPECT_EQ(Property("Nice"), "7");
  EXPECT_EQ(Property("User"), "daemon");
  EXPECT_EQ(Property("ProtectSystem"), "strict");
  EXPECT_THAT(Property("Environment"), AllOf(HasSubstr("PATH="), Not(HasSubstr("XDG_"))));
  if (KeepsMemory()) {
    EXPECT_EQ(Do({"cat", GroupFile("memory.max"), GroupFile("cpu.max")}).out,
              std::to_string(512 << 20) + "\n50000 100000\n");
  }
  const pid_t before = PidOfEyes();
  ASSERT_NO_FATAL_FAILURE(KillController());
  ASSERT_NO_FATAL_FAILURE(StartUp());
  EXPECT_EQ(PidOfEyes(), before);
  EXPECT_EQ(Run({"down"}).exit, 0);
  EXPECT_THAT(Units(), IsEmpty());
}

TEST_F(OwnUnits, ThatNeedMoreMemoryThanTheirLimitAreEndedAndStartedAgain) {
  if (!KeepsMemory()) GTEST_SKIP() << "no memory controller in cgroups of version 2 here";
  Write("always", "memory_max_mb = 64\n");
  ASSERT_NO_FATAL_FAILURE(StartUp());
  const std::string pid = std::to_string(PidOfEyes());
  Do({"sh", "-c", "echo $$ > " + GroupFile("cgroup.procs") + "; exec tail /dev/zero"});
  EXPECT_TRUE(AwaitHistory("eyes's process " + pid +
                           " ended: out of memory: its limit (memory_max_mb = 64) or the memory of "
                           "this host is used up; raise the limit if it needs more"))
      << History();
  ASSERT_TRUE(AwaitActive());
  EXPECT_EQ(Status()["actuators"]["eyes"]["restarts"], 1);
}

TEST_F(OwnUnits, WhoseLimitOfMemoryIsBelowWhatTheyNeedAreGivenUpWithWhatToDo) {
  if (!KeepsMemory()) GTEST_SKIP() << "no memory controller in cgroups of version 2 here";
  Write("always", "memory_max_mb = 1\nrestart_limit = 2\nrestart_delay_ms = 10\n");
  const Ended up = Do(Command({"up", config_, "--detach"}));
  EXPECT_EQ(up.exit, 0) << up.out << up.err;  // eyes are not critical
  const auto message = [this] { return Status()["actuators"]["eyes"]["message"].dump(); };
  EXPECT_TRUE(Until(
      [&] {
        return message().find("given up after 2 restarts, until `musher restart eyes`") !=
               std::string::npos;
      },
      kSoon))
      << History();
  EXPECT_THAT(message(), HasSubstr("out of memory: its limit (memory_max_mb = 1) or the memory of "
                                   "this host is used up; raise the limit if it needs more"));
  EXPECT_EQ(Status()["actuators"]["legs"]["state"], "Active");
}

// As `daemon`, a user who may not enter the folder of root.
TEST_F(OwnUnits, ThatSystemdCannotSetUpSayWhatIsMissing) {
  const auto why = [this](const std::string& limits) {
    Write("always", limits + "restart = \"no\"\n");
    Do(Command({"up", config_, "--detach"}));
    const std::string history = History();
    Run({"down"});
    return history;
  };
  EXPECT_THAT(why("user = \"robot-here\"\n"),
              HasSubstr("its user robot-here (`user`) may be missing there"));
  EXPECT_THAT(why("cwd = \"/opt/none\"\n"),
              HasSubstr("its folder /opt/none (`cwd`) may be missing there"));
  EXPECT_THAT(why("user = \"daemon\"\ncwd = \"/root\"\n"),
              HasSubstr("musher-exec could not be executed there: its user daemon may not enter "
                        "its folder /root (`cwd`)"));
}

TEST_F(OwnUnits, InASandboxWriteNoFileAndOpenTheirDevicesOnly) {
  if (Do({"test", "-c", "/dev/mem"}).exit != 0) GTEST_SKIP() << "no /dev/mem here: a container";
  if (folder_.path().starts_with("/tmp")) GTEST_SKIP() << "\"strict\" hides /tmp, set TMPDIR";
  const auto does = [this](const std::string& limits) {
    Write("always", limits);
    std::ofstream(folder_ / "eyes.toml")
        << "[state.SetUp]\nrun = [\"sh\", \"-c\", \"touch /etc/eyes && echo wrote; "
           "head -c 1 /dev/mem > /dev/null && echo opened; test -e /root/.bashrc && echo saw; "
           "echo looked\"]\n[state.LowPower]\nrun = [\"true\"]\n";
    StartUp();
    const std::string log = Run({"logs", "eyes"}).out;
    EXPECT_THAT(log, HasSubstr("looked"));
    EXPECT_EQ(Run({"down"}).exit, 0);
    std::filesystem::remove_all(folder_ / "state");
    return log;
  };
  EXPECT_THAT(does(""), AllOf(HasSubstr("wrote"), HasSubstr("opened"), HasSubstr("saw")));
  EXPECT_THAT(does("sandbox = \"read-only\"\ndevices = [\"/dev/mem\"]\n"),
              AllOf(Not(HasSubstr("wrote")), HasSubstr("opened"), HasSubstr("saw")));
  EXPECT_THAT(does("sandbox = \"strict\"\n"),
              AllOf(Not(HasSubstr("wrote")), Not(HasSubstr("opened")), Not(HasSubstr("saw"))));
}

TEST_F(OwnUnits, OfAnotherMachineOfThisNameAreLeftAlone) {
  ASSERT_EQ(Do({"systemd-run", "--quiet", "--unit=musher-robot-eyes", "sleep", "1000"}).exit, 0);
  const std::string theirs = Property("MainPID");
  Run({"up", config_, "--detach"});
  EXPECT_TRUE(AwaitHistory("this host runs musher-robot-eyes.service already, for another machine"))
      << History();
  Run({"down"});
  EXPECT_EQ(Property("MainPID"), theirs);
}

}  // namespace musher::testing::own_units_test
