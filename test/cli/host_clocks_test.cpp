// The clocks of other hosts, with a script in the place of ssh. With a real one they are read in
// test/integration/hosts.

#include "musher/cli/machine/host_clocks.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/host.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/test/cli/fake_controller.hpp"
#include "musher/test/cli/program.hpp"
#include "musher/test/support/domain.hpp"
#include "musher/test/support/temp_folder.hpp"
#include "musher/test/support/wait.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::cli::host_clocks_test {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr double kThreeHours = 3 * 3600;  // s
constexpr double kSlow = 60;              // s: on a busy computer

// On `vision` it is three hours later; `payload` refuses the key; `arm` hangs.
class ClocksOfOtherHosts : public ::testing::Test {
 protected:
  ClocksOfOtherHosts() {
    const std::string ssh = folder_ / "ssh";
    std::ofstream(ssh) << R"sh(#!/bin/sh
for address; do case $address in 10.*) break;; esac; done
case $address in
10.0.0.2) echo "musher-clock $(($(date +%s%N) + 10800000000000))"; exec sleep 1000;;
10.0.0.3) echo 'root@10.0.0.3: Permission denied (publickey).' >&2; exit 255;;
esac
exec sleep 1000
)sh";
    std::filesystem::permissions(ssh, std::filesystem::perms::owner_all);
    setenv("PATH", (folder_.path() + ":" + path_).c_str(), 1);
  }
  ~ClocksOfOtherHosts() override { setenv("PATH", path_.c_str(), 1); }

  void AddHost(const std::string& name, const std::string& address) {
    HostConfig& host = config_.hosts.emplace_back();
    host.name = name;
    host.address = address;
    host.user = "root";
  }
  void AddActuator(const std::string& name, const std::string& host) {
    ActuatorConfig actuator;
    actuator.name = name;
    actuator.host = host;
    config_.actuators.push_back(actuator);
  }

  const std::string path_ = getenv("PATH");
  const TempFolder folder_;
  MachineConfig config_;
  transport::LinuxEventLoop loop_;
};

TEST_F(ClocksOfOtherHosts, AreReadThoughOneHangsAndOneRefusesTheKey) {
  AddHost("arm", "10.0.0.4");
  AddHost("payload", "10.0.0.3");
  AddHost("spare", "10.0.0.5");
  AddHost("vision", "10.0.0.2");
  AddActuator("legs", "");
  AddActuator("eyes", "vision");
  AddActuator("hand", "arm");
  AddActuator("lamp", "payload");
  AddActuator("map", "vision");
  const HostClocks clocks(loop_, config_);
  std::vector<HostClock> now;
  const auto two_have_ended = [&] {
    now = clocks.Now(std::chrono::seconds(8));
    return now.size() == 3 && now[2].ahead && now[1].trouble.find("denied") != std::string::npos;
  };
  ASSERT_TRUE(loop_.RunUntil(two_have_ended, testing::In(std::chrono::seconds(30))));
  EXPECT_FALSE(clocks.Complete());
  EXPECT_EQ(now[0].name, "arm");
  EXPECT_FALSE(now[0].ahead);
  EXPECT_THAT(now[0].trouble,
              AllOf(HasSubstr("host arm (root@10.0.0.4): "), HasSubstr("no answer within 8 s")));
  EXPECT_FALSE(now[1].ahead);
  EXPECT_THAT(now[1].trouble,
              AllOf(HasSubstr("host payload (root@10.0.0.3): "), HasSubstr("authorized_keys")));
  EXPECT_EQ(now[2].login, "root@10.0.0.2");
  EXPECT_THAT(now[2].actuators, ElementsAre("eyes", "map"));
  EXPECT_NEAR(ToSeconds(*now[2].ahead), kThreeHours, kSlow);
  EXPECT_THAT(now[2].trouble, IsEmpty());
}

TEST_F(ClocksOfOtherHosts, AreNoneOfAMachineOfOneHost) {
  AddActuator("legs", "");
  const HostClocks clocks(loop_, config_);
  EXPECT_TRUE(clocks.Complete());
  EXPECT_THAT(clocks.Now({}), IsEmpty());
}

TEST(ClockText, HasTheUnitOfItsSize) {
  EXPECT_EQ(ClockText(Milliseconds(-12)), "12 ms behind");
  EXPECT_EQ(ClockText(Milliseconds(999)), "999 ms ahead");
  EXPECT_EQ(ClockText(Milliseconds(1500)), "1.5 s ahead");
  EXPECT_EQ(ClockText(std::chrono::hours(-3)), "10800.0 s behind");
}

// --- musher status --hosts ---

class StatusOfHosts : public ClocksOfOtherHosts {
 protected:
  StatusOfHosts() {
    setenv("ROS_DOMAIN_ID", std::to_string(transport::TestDomain()).c_str(), 1);
    std::ofstream(folder_ / "robot.toml") << R"(
[controller]
name = "dog"
actuators = ["legs", "eyes", "lamp"]
states = ["SetUp", "TearDown", "Active"]
default_time = 1000
default_state = "Uninitialized"
[transport]
profile = "lan"
[host.vision]
address = "10.0.0.2"
user = "root"
[host.payload]
address = "10.0.0.3"
user = "root"
[actuator.legs]
states = ["SetUp", "TearDown", "Active"]
times = [1, 1, 1]
command = ["legs"]
critical = true
[actuator.eyes]
states = ["SetUp", "TearDown", "Active"]
times = [1, 1, 1]
command = ["/opt/eyes"]
host = "vision"
[actuator.lamp]
states = ["SetUp", "TearDown", "Active"]
times = [1, 1, 1]
command = ["/opt/lamp"]
host = "payload"
)";
  }
  ~StatusOfHosts() override { unsetenv("ROS_DOMAIN_ID"); }

  void SetUp() override {
    if (!SupportsHosts()) GTEST_SKIP() << "built without hosts";
  }

  // Of a controller on `host`.
  Ran Status(const std::string& host, std::vector<std::string> words) const {
    FakeController dog(name_space_, "dog", "d0900000-0000-4000-8000-000000000002", "Active");
    dog.Serve<msg::GetStatus>("get_status", [&](const auto&, const auto& reply) {
      msg::GetStatus::Response now;
      now.status.machine = "dog";
      now.status.state = "Active";
      now.status.host = host;
      now.status.config_file = folder_ / "robot.toml";
      reply(now);
    });
    dog.Serve<msg::GetHistory>("get_history", [this](const auto&, const auto& reply) {
      msg::GetHistory::Response history;
      history.entries.emplace_back().state = "Active";
      history.entries.back().wall_ns = WallNow() - 3'600'000'000'000;
      if (steady_ns_) history.steady_ns = {*steady_ns_};
      reply(history);
    });
    words.insert(words.begin(), {"--namespace", name_space_, "status"});
    return RunProgram(words);
  }

  const std::string name_space_ = "host_clocks_test_" + std::to_string(getpid());
  std::optional<std::int64_t> steady_ns_;  // of the change of state; nullopt: an older controller
};

TEST_F(StatusOfHosts, HasTheirClocksAndNamesTheOneThatDoesNotAnswer) {
  const Ran text = Status(HostId(), {"--hosts"});
  EXPECT_EQ(text.exit, 0) << text.err;
  EXPECT_THAT(text.out,
              ::testing::ContainsRegex("HOST +LOGIN +CLOCK +ACTUATORS\n"
                                       "vision +root@10.0.0.2 +1[0-9]+\\.[0-9] s ahead +eyes\n"
                                       "payload +root@10.0.0.3 +- +lamp\n"));
  EXPECT_THAT(text.err, HasSubstr("host payload (root@10.0.0.3): "));
  const Ran json = Status(HostId(), {"--hosts", "--json"});
  EXPECT_EQ(json.exit, 0) << json.err;
  const nlohmann::json hosts = nlohmann::json::parse(json.out)["hosts"];
  EXPECT_NEAR(hosts["vision"]["clock_ahead_s"].get<double>(), kThreeHours, kSlow);
  EXPECT_TRUE(hosts["vision"]["trouble"].is_null());
  EXPECT_EQ(hosts["vision"]["runs"], nlohmann::json::array({"eyes"}));
  EXPECT_TRUE(hosts["payload"]["clock_ahead_s"].is_null());
  EXPECT_THAT(hosts["payload"]["trouble"].get<std::string>(), HasSubstr("denied"));
}

TEST_F(StatusOfHosts, AsksNoHostUnlessThatIsWanted) {
  const Ran ran = Status(HostId(), {"--json"});
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_TRUE(nlohmann::json::parse(ran.out)["hosts"].is_null());
  EXPECT_THAT(ran.err, Not(HasSubstr("payload")));
}

TEST_F(StatusOfHosts, NeedsTheComputerOfTheController) {
  const Ran ran = Status("another boot/1", {"--hosts"});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_EQ(ran.out, "");
  EXPECT_THAT(ran.err, HasSubstr("on the computer of the controller: run it there"));
}

// The clock of a controller on another computer may be hours behind: "for 3 h", after some seconds.
TEST_F(StatusOfHosts, DoesNotSayForHowLongByTheClockOfAnotherComputer) {
  EXPECT_THAT(Status(HostId(), {}).out, HasSubstr("  for 60 min"));
  const Ran elsewhere = Status("another boot/1", {});
  EXPECT_EQ(elsewhere.exit, 0) << elsewhere.err;
  EXPECT_THAT(elsewhere.out, Not(HasSubstr("  for ")));
}

// "for 365 d" of a robot that has got its time from the network a minute ago.
TEST_F(StatusOfHosts, SaysForHowLongByTheSteadyClockWhereTheWallClockWasSet) {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  steady_ns_ = std::chrono::nanoseconds(now - std::chrono::minutes(7)).count();
  EXPECT_THAT(Status(HostId(), {}).out, HasSubstr("  for 7 min"));
  EXPECT_THAT(Status("another boot/1", {}).out, Not(HasSubstr("  for ")));
}

TEST_F(StatusOfHosts, NeedsAConfigThatIsValidYet) {
  std::ofstream(folder_ / "robot.toml") << "[controller";
  const Ran ran = Status(HostId(), {"--hosts"});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.err, HasSubstr("--hosts needs the config; see `musher check "));
}

}  // namespace musher::cli::host_clocks_test
