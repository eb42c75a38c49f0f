// A machine of the profile lan on a host whose outer interface is lost, late or renumbered: its
// own processes reach each other all the same, and none is restarted.

#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <map>
#include <memory>
#include <optional>

#include "musher/base/unique_fd.hpp"
#include "musher/test/integration/cli/machine.hpp"
#include "musher/transport/ros_environment.hpp"

namespace musher::testing::outer_interface_test {

using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::Not;

// The network namespace of this thread and of the processes that it starts.
class NetworkNamespace {
 public:
  // That of the caller.
  static NetworkNamespace Current() {
    return NetworkNamespace(UniqueFd(open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC)));
  }
  // A new one, with its loopback up, which is entered; none: this user may not make one.
  static std::optional<NetworkNamespace> Make() {
    if (unshare(CLONE_NEWNET) != 0) return std::nullopt;
    NetworkNamespace made = Current();
    if (RunToEnd({"ip", "link", "set", "lo", "up"}).exit != 0) return std::nullopt;
    return made;
  }
  void Enter() const { ASSERT_EQ(setns(fd_.get(), CLONE_NEWNET), 0) << std::strerror(errno); }

 private:
  explicit NetworkNamespace(UniqueFd fd) : fd_(std::move(fd)) {}

  UniqueFd fd_;
};

constexpr const char* kOuter = "wlan7";           // of the robot
constexpr const char* kFar = "far7";              // of another host
constexpr Duration kOutage = Milliseconds(5000);  // longer than the lease, and than a hang takes

class OuterInterface : public MachineByCli {
 protected:
  void SetUp() override {
    setenv("MUSHER_TRANSPORT", "lan", 1);
    far_ = NetworkNamespace::Make();
    if (far_) robot_ = NetworkNamespace::Make();
    if (!robot_) GTEST_SKIP() << "no network namespace here: " << std::strerror(errno);
    if (RunToEnd({"ip", "link", "add", kOuter, "type", "veth", "peer", "name", kFar}).exit != 0) {
      GTEST_SKIP() << "no pair of network interfaces (veth) here";
    }
    const auto holder = InFar({"sleep", "60"});
    Ip({"link", "set", kFar, "netns", std::to_string(holder->pid())});
    far_->Enter();
    Ip({"address", "add", "10.77.0.2/24", "dev", kFar});
    Ip({"link", "set", kFar, "up"});
    robot_->Enter();
  }
  ~OuterInterface() override {
    KillChildren();
    before_.Enter();
    unsetenv("MUSHER_TRANSPORT");
  }

  static void Ip(const std::vector<std::string>& words) {
    std::vector<std::string> argv = {"ip"};
    argv.insert(argv.end(), words.begin(), words.end());
    const Ended ip = RunToEnd(argv);
    ASSERT_EQ(ip.exit, 0) << ip.err;
  }
  static void Connect(const std::string& address = "10.77.0.1/24") {
    Ip({"address", "add", address, "dev", kOuter});
    Ip({"link", "set", kOuter, "up"});
  }
  // On the other host.
  std::unique_ptr<Process> InFar(const std::vector<std::string>& argv) const {
    far_->Enter();
    auto process = std::make_unique<Process>(argv);
    robot_->Enter();
    return process;
  }
  // Its state as a person on the other host sees it; "" without an answer.
  std::string StateFromFar() const {
    const Ended status = InFar(Command({"status", "--json"}))->Wait();
    return status.exit == 0 ? Json(status.out)["state"].get<std::string>() : "";
  }
  void AwaitFar(bool reachable) const {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(120);
    while (StateFromFar().empty() == reachable) {
      ASSERT_LT(std::chrono::steady_clock::now(), deadline) << "the other host";
    }
  }

  void Start() {
    Ended up = UpDetached();
    ASSERT_EQ(up.exit, 0) << up.err;
    pids_ = Pids();
    ASSERT_EQ(pids_.size(), 4U);
  }
  // Of the controller and of each actuator.
  static std::map<std::string, pid_t> Pids() {
    const nlohmann::json status = Status();
    std::map<std::string, pid_t> pids;
    if (status.is_null()) return pids;
    pids["controller"] = status["pid"];
    for (const auto& [name, actuator] : status["actuators"].items()) pids[name] = actuator["pid"];
    return pids;
  }
  // A person at the robot, for some time: what is asked for is done, and every process runs on.
  void ExpectTheRobotObeys(Duration duration) const {
    const auto end = std::chrono::steady_clock::now() + duration;
    do {
      for (const char* state : {"LowPower", "Active"}) {
        const Ended set = Musher({"set", state});
        ASSERT_EQ(set.exit, 0) << set.err;
      }
      const Ended estop = Musher({"estop", "--json"});
      ASSERT_EQ(estop.exit, 0) << estop.err;
      const nlohmann::json actuators = Json(estop.out)["actuators"];
      ASSERT_EQ(actuators.size(), 3U);
      for (const auto& [name, actuator] : actuators.items()) {
        ASSERT_EQ(actuator["stopped"], true) << name;
      }
      ASSERT_EQ(Musher({"estop", "--release"}).exit, 0);
      ASSERT_EQ(Musher({"set", "Active"}).exit, 0);
      ASSERT_EQ(Pids(), pids_);
    } while (std::chrono::steady_clock::now() < end);
  }
  // By hand; from now on it has another pid.
  void ExpectARestart(const std::string& module) {
    const Ended restart = Musher({"restart", module});
    EXPECT_EQ(restart.exit, 0) << restart.err;
    AwaitStatus(AllHaveArrivedIn("Active"));
    EXPECT_NE(Pids()[module], pids_[module]);
    pids_ = Pids();
  }
  void ExpectNothingWasLost() const {
    EXPECT_EQ(Pids(), pids_);
    EXPECT_THAT(Musher({"history"}).out, Not(HasSubstr("hung")));
    const Ended down = Musher({"down"});
    EXPECT_EQ(down.exit, 0) << down.err;
  }

  std::map<std::string, pid_t> pids_;

 private:
  const NetworkNamespace before_ = NetworkNamespace::Current();
  std::optional<NetworkNamespace> far_;
  std::optional<NetworkNamespace> robot_;
};

TEST_F(OuterInterface, IsLostAndComesBackWithoutAnEffectOnTheProcessesOfTheRobot) {
  Connect();
  ASSERT_NO_FATAL_FAILURE(Start());
  AwaitFar(true);
  Ip({"link", "set", kOuter, "down"});
  ExpectTheRobotObeys(kOutage);
  Ip({"link", "set", kOuter, "up"});
  AwaitFar(true);
  ExpectTheRobotObeys({});
  ExpectNothingWasLost();
}

TEST_F(OuterInterface, IsLostAndTheMachineIsTakenDownMeanwhile) {
  Connect();
  ASSERT_NO_FATAL_FAILURE(Start());
  AwaitFar(true);
  Ip({"link", "set", kOuter, "down"});
  AwaitFar(false);
  const Ended down = Musher({"down"});
  EXPECT_EQ(down.exit, 0) << down.err;
  EXPECT_THAT(down.err, Not(AnyOf(HasSubstr("still run"), HasSubstr("not known"))));
  for (const auto& [name, pid] : pids_) EXPECT_TRUE(AwaitEnd(pid)) << name;
  EXPECT_TRUE(AwaitNoChildren());
}

TEST_F(OuterInterface, IsAbsentAtTheStartAndTheRobotObeysBeforeAndAfterItAppears) {
  ASSERT_NO_FATAL_FAILURE(Start());
  ExpectTheRobotObeys({});
  Connect();
  ExpectTheRobotObeys({});
  EXPECT_TRUE(Until([] {
    return Musher({"history"}).out.find("wlan7 with 10.77.0.1 has come") != std::string::npos;
  }));
  ExpectNothingWasLost();
}

TEST_F(OuterInterface, GetsAnotherAddressWithoutAnEffectOnTheProcessesOfTheRobot) {
  Connect();
  ASSERT_NO_FATAL_FAILURE(Start());
  Ip({"address", "flush", "dev", kOuter});
  ExpectTheRobotObeys({});
  Connect("10.77.0.9/24");
  ExpectTheRobotObeys({});
  ExpectNothingWasLost();
}

// A process that starts now has another address than those that reach it.
TEST_F(OuterInterface, GetsAnotherAddressAndAModuleIsRestartedMeanwhileAndTheRobotObeys) {
  Connect();
  ASSERT_NO_FATAL_FAILURE(Start());
  Ip({"address", "flush", "dev", kOuter});
  ExpectARestart("voice");
  Connect("10.77.0.9/24");
  ExpectARestart("eyes");
  const pid_t before = pids_["legs"];
  kill(before, SIGKILL);
  AwaitStatus([before](const auto& now) {
    return now["actuators"]["legs"]["pid"] != before && AllHaveArrivedIn("Active")(now);
  });
  pids_ = Pids();
  ExpectTheRobotObeys({});
  ExpectNothingWasLost();
}

TEST_F(OuterInterface, AndTheLoopbackAreGivenToARos2NodeThatTheControllerStarts) {
  Connect();
  for (const char* name : {"CYCLONEDDS_URI", "RMW_IMPLEMENTATION"}) unsetenv(name);
  unsetenv("MUSHER_NAMESPACE");
  Drop("namespace = \"" + name_space_ + "\"\n");  // where the program has its node
  const std::string file = folder_ / "env";
  Replace("\"eyes\"]", "\"eyes\", \"talker\"]");
  std::ofstream(config_, std::ios::app)
      << "[actuator.talker]\nprotocol = \"ros2_lifecycle\"\nstates = "
         "[\"SetUp\", \"TearDown\", \"Active\", \"LowPower\"]\ntimes = [60000, 20000, "
         "20000, 20000]\ncommand = [\"sh\", \"-c\", \"env > "
      << file << "; exec " << BinDir() << "/managed_node talker\"]\n";
  const Ended up = UpDetached();
  ASSERT_EQ(up.exit, 0) << up.err << ReadFile(config_);
  const std::string outer = transport::RosOnInterfaces({kOuter});
  EXPECT_THAT(outer, HasSubstr(kOuter));
  EXPECT_THAT(ReadFile(file), HasSubstr("CYCLONEDDS_URI=" + outer + "\n"));
  EXPECT_THAT(ReadFile(file), HasSubstr("RMW_IMPLEMENTATION=rmw_cyclonedds_cpp\n"));
  Ip({"link", "set", kOuter, "down"});
  const Ended set = Musher({"set", "LowPower"});
  EXPECT_EQ(set.exit, 0) << "it has obeyed over the loopback: " << set.err;
  EXPECT_EQ(Status()["actuators"]["talker"]["state"], "LowPower");
  EXPECT_EQ(Musher({"down"}).exit, 0);
}

}  // namespace musher::testing::outer_interface_test
