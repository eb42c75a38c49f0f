#pragma once
// A robot of two computers: the controller and actuator legs on one, actuator eyes on the other,
// the board, whose systemd runs it. The board is a real one but for its kernel: a root of Debian
// with systemd, D-Bus and ssh boots under systemd-nspawn, joined to the robot's host by a pair of
// network interfaces. Needs root, systemd-nspawn, mmdebstrap and Debian's archive.

#include <signal.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "musher/base/files.hpp"
#include "musher/base/program_path.hpp"
#include "musher/test/integration/cli/host.hpp"
#include "musher/test/support/machine_fixture.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/wait.hpp"

namespace musher::testing {

inline constexpr const char* kLink = "eth8";  // at both ends
inline constexpr const char* kRobotAddress = "10.77.3.1";
inline constexpr const char* kBoardAddress = "10.77.3.2";
inline constexpr const char* kUnit = "musher-robot-eyes.service";

// The root, made once for all tests; with MUSHER_BOARD_ROOT=FOLDER there, and kept for the next
// run. Without one `why` says what is missing.
class BoardRoot {
 public:
  explicit BoardRoot(std::string& why) {
    if (geteuid() != 0) {
      why = "another host needs root";
      return;
    }
    for (const char* program : {"systemd-nspawn", "mmdebstrap", "ssh", "ssh-keygen"}) {
      if (!FindInPath(program).empty()) continue;
      why = std::string(program) + " is missing";
      return;
    }
    const char* kept = std::getenv("MUSHER_BOARD_ROOT");
    path_ = kept != nullptr ? kept : folder_ / "root";
    kept_ = kept != nullptr;
    const std::string libraries =
        "ldd " + BinDir() + "/musher-exec " + BinDir() + "/musher | awk '/=> \\// {print $3}'";
    const Ended made = RunToEnd(
        {"sh", "-c",
         "set -e; . /etc/os-release; root=" + path_ + "; [ -e $root/etc/ssh ] || " +
             "mmdebstrap --quiet --variant=apt --include=systemd,systemd-sysv,dbus," +
             "openssh-server,iproute2 \"$VERSION_CODENAME\" $root; for library in $(" + libraries +
             "); do [ -e $root$library ] || cp --parents -L $library $root; done; " +
             "ssh-keygen -q -t ed25519 -N '' -f " + Key() + "; mkdir -p -m 700 $root/root/.ssh; " +
             "cp " + Key() + ".pub $root/root/.ssh/authorized_keys; printf '%s %s\\n' " +
             kBoardAddress + " \"$(cat $root/etc/ssh/ssh_host_ed25519_key.pub)\" > " +
             KnownHosts()});
    if (made.exit != 0) why = "no root of Debian could be made: " + made.err;
  }
  ~BoardRoot() {
    if (!kept_) RunToEnd({"rm", "-rf", "--one-file-system", path_});
  }

  const std::string& path() const { return path_; }
  std::string Key() const { return folder_ / "key"; }
  std::string KnownHosts() const { return folder_ / "known_hosts"; }

 private:
  const TempFolder folder_;
  std::string path_;
  bool kept_ = false;
};

class RobotAndBoard : public MachineFixture {
 protected:
  static void SetUpTestSuite() { root_ = std::make_unique<BoardRoot>(missing_); }
  static void TearDownTestSuite() { root_ = nullptr; }

  void SetUp() override {
    if (!missing_.empty()) GTEST_SKIP() << missing_;
    setenv("XDG_STATE_HOME", folder_.path().c_str(), 1);  // without machines of other tests
    robot_ = std::make_unique<Host>();
    wire_ = std::make_unique<Host>();
    if (!robot_->up() || !wire_->up()) GTEST_SKIP() << "no network or pid namespace here";
    bool made = true;
    robot_->InNetwork([&] {
      made = RunToEnd({"ip", "link", "add", kLink, "type", "veth", "peer", "name", kLink, "netns",
                       std::to_string(wire_->init())})
                 .exit == 0;
    });
    if (!made) GTEST_SKIP() << "no pair of network interfaces (veth) here";
    for (const auto& [host, address] :
         {std::pair(robot_.get(), kRobotAddress), std::pair(wire_.get(), kBoardAddress)}) {
      Ip(*host, {"link", "set", "lo", "up"});
      Ip(*host, {"address", "add", std::string(address) + "/24", "dev", kLink});
      Ip(*host, {"link", "set", kLink, "up"});
    }
    Write();
    Boot();
    ASSERT_TRUE(AwaitBoard()) << ReadFile(folder_ / "console");
  }
  ~RobotAndBoard() override {
    PowerOff();
    KillChildren();
    unsetenv("XDG_STATE_HOME");
  }

  void Ip(const Host& host, std::vector<std::string> words) const {
    words.insert(words.begin(), "ip");
    EXPECT_EQ(host.Do(std::move(words)).exit, 0);
  }
  void Cut() const { Ip(*robot_, {"link", "set", kLink, "down"}); }
  void Heal() const { Ip(*robot_, {"link", "set", kLink, "up"}); }

  // Each start is a boot of its own.
  void Boot() {
    const std::string folder = folder_.path();
    board_.emplace(std::vector<std::string>{
        "sh", "-c",
        "exec systemd-nspawn --quiet --directory=" + root_->path() +
            " --boot --register=no --keep-unit --machine=board" +
            " --network-namespace-path=/proc/" + std::to_string(wire_->init()) + "/ns/net" +
            " --bind-ro=" + folder + " --bind-ro=" + BinDir() + " < /dev/null > " +
            (folder_ / "console") + " 2>&1"});
  }
  // As if its power was cut: its first process is killed, and with it all others.
  void PowerOff() {
    if (!board_) return;
    const std::string pid = std::to_string(board_->pid());
    std::ifstream children("/proc/" + pid + "/task/" + pid + "/children");
    for (pid_t child = 0; children >> child;) kill(child, SIGKILL);
    board_->Wait();
    board_.reset();
  }
  bool AwaitBoard() const {
    return Until([this] { return OnBoard({"true"}).exit == 0; }, std::chrono::seconds(60));
  }

  // From the robot's host, by ssh.
  Ended OnBoard(std::vector<std::string> words) const {
    words.insert(words.begin(), {"ssh", "-xT", "-o", "BatchMode=yes", "-o", "ConnectTimeout=2",
                                 "-o", "UserKnownHostsFile=" + root_->KnownHosts(), "-i",
                                 root_->Key(), "-l", "root", kBoardAddress, "--"});
    return robot_->Do(std::move(words));
  }
  // Whether its kernel keeps limits of memory, as the board says itself.
  bool KeepsMemory() const {
    return OnBoard({"grep -qsw memory /sys/fs/cgroup/cgroup.controllers || "
                    "grep -q 'cgroup rw,.*memory' /proc/mounts"})
               .exit == 0;
  }
  std::string Property(const std::string& name) const {
    std::string value = OnBoard({"systemctl", "show", "--value", "-p", name, kUnit}).out;
    while (value.ends_with('\n')) value.pop_back();
    return value;
  }
  // "" if systemd does not know the unit.
  std::string Units() const {
    return OnBoard({"systemctl", "list-units", "--all", "--no-legend", "'musher-*'"}).out;
  }

  pid_t PidOfEyes() const {
    const nlohmann::json status = robot_->Status();
    const nlohmann::json pid =
        status.is_null() ? nlohmann::json() : status["actuators"]["eyes"]["pid"];
    return pid.is_number() ? pid.get<pid_t>() : 0;
  }
  Ended Up() const { return robot_->Run({"up", config_, "--detach"}); }
  void StartUp() const {
    const Ended up = Up();
    ASSERT_EQ(up.exit, 0) << up.err;
    ASSERT_TRUE(Until([this] { return AllHaveArrivedIn("Active")(robot_->Status()); },
                      std::chrono::seconds(60)))
        << robot_->Status();
  }
  // All are Active, and eyes runs in this process of the board.
  bool AwaitActive() const {
    return Until([this] { return AllHaveArrivedIn("Active")(robot_->Status()); },
                 std::chrono::seconds(60));
  }
  std::string History() const { return robot_->Run({"history"}).out; }
  void Replace(const std::string& words, const std::string& by) const {
    std::string toml = ReadFile(config_);
    toml.replace(toml.find(words), words.size(), by);
    std::ofstream(config_) << toml;
  }

  static inline std::unique_ptr<BoardRoot> root_;
  static inline std::string missing_;
  const std::string config_ = folder_ / "robot.toml";
  std::unique_ptr<Host> robot_;
  std::unique_ptr<Host> wire_;  // holds the board's network, also while the board is off
  std::optional<Process> board_;

 private:
  void Write() const {
    const std::string states = R"(["SetUp", "TearDown", "SelfCheck", "Active", "LowPower"])";
    const auto actuator = [&](const std::string& name, const std::string& program) {
      std::ofstream(folder_ / (name + ".toml")) << "[state.LowPower]\nrun = [\"true\"]\n";
      return "[actuator." + name + "]\nstates = " + states +
             "\ntimes = [10000, 5000, 5000, 5000, 5000]\ncommand = [\"" + program + "\", \"" +
             (folder_ / name) + ".toml\"]\n";
    };
    std::ofstream(config_) << "[controller]\nname = \"robot\"\nactuators = [\"legs\", \"eyes\"]\n"
                           << "states = " << states << "\ndefault_time = 2000\nnamespace = \""
                           << name_space_ << "\"\nstate_dir = \"state\"\n"
                           << "[transport]\nprofile = \"lan\"\ninterfaces = [\"" << kLink
                           << "\"]\n[host.board]\naddress = \"" << kBoardAddress
                           << "\"\nuser = \"root\"\nkey = \"" << root_->Key()
                           << "\"\nknown_hosts = \"" << root_->KnownHosts() << "\"\n"
                           << actuator("legs", "musher-exec") << "critical = true\n"
                           << actuator("eyes", BinDir() + "/musher-exec") << "host = \"board\"\n";
  }
};

}  // namespace musher::testing
