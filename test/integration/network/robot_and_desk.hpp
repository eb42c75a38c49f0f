#pragma once
// A robot with ethernet and wifi, and the host of a person at a desk that is on both networks: two
// hosts with two links between them. Beside them what a robot has, too: docker's bridge, with the
// same address on both hosts, and a VPN's tunnel. Needs root.

#include <unistd.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "musher/test/integration/cli/host.hpp"
#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing {

// A network that both hosts are on: "eth7" at the robot, "far_eth7" at the desk.
struct TestNet {
  const char* robot;
  const char* net;  // the first three numbers of its addresses

  std::string Desk() const { return std::string("far_") + robot; }
  std::string Address(int host) const { return std::string(net) + "." + std::to_string(host); }
};

inline constexpr TestNet kEthernet{"eth7", "10.77.1"};
inline constexpr TestNet kWifi{"wlan7", "10.77.2"};
inline constexpr const char* kDocker = "172.17.0.1";
inline constexpr const char* kTunnel = "10.8.0.6";
inline constexpr Duration kOutage = Milliseconds(5000);  // longer than the lease

class RobotAndDesk : public MachineByCli {
 protected:
  void SetUp() override {
    if (geteuid() != 0) GTEST_SKIP() << "two hosts need root";
    setenv("MUSHER_TRANSPORT", "lan", 1);
    setenv("XDG_STATE_HOME", folder_.path().c_str(), 1);  // without machines of other tests
    robot_ = std::make_unique<Host>();
    desk_ = std::make_unique<Host>();
    if (!robot_->up() || !desk_->up()) GTEST_SKIP() << "no network or pid namespace here";
    for (const Host* host : {robot_.get(), desk_.get()}) {
      Ip(*host, {"link", "set", "lo", "up"});
      // Before the others: the kernel lists them first.
      Ip(*host, {"tuntap", "add", "tun7", "mode", "tun"});
      Ip(*host, {"address", "add", std::string(kTunnel) + "/24", "dev", "tun7"});
      Ip(*host, {"link", "set", "tun7", "up"});
      Ip(*host, {"link", "add", "docker0", "type", "bridge"});
      Ip(*host, {"address", "add", std::string(kDocker) + "/16", "dev", "docker0"});
      Ip(*host, {"link", "set", "docker0", "up"});
    }
    if (!made_) GTEST_SKIP() << "no bridge or tunnel here";
    for (const TestNet& net : {kEthernet, kWifi}) {
      // Not in the host's namespace of pids, which does not know the other host's.
      robot_->InNetwork([&] {
        made_ &= RunToEnd({"ip", "link", "add", net.robot, "type", "veth", "peer", "name",
                           net.Desk(), "netns", std::to_string(desk_->init())})
                     .exit == 0;
      });
      if (!made_) GTEST_SKIP() << "no pair of network interfaces (veth) here";
      Ip(*desk_, {"address", "add", net.Address(2) + "/24", "dev", net.Desk()});
      Ip(*desk_, {"link", "set", net.Desk(), "up"});
    }
  }
  ~RobotAndDesk() override {
    KillChildren();
    unsetenv("MUSHER_TRANSPORT");
    unsetenv("XDG_STATE_HOME");
  }

  void Ip(const Host& host, std::vector<std::string> words) {
    words.insert(words.begin(), "ip");
    made_ &= host.Do(std::move(words)).exit == 0;
  }
  // The robot's end.
  void Connect(const TestNet& net, int address = 1) {
    Ip(*robot_, {"address", "add", net.Address(address) + "/24", "dev", net.robot});
    Up(net);
  }
  void Up(const TestNet& net) { Ip(*robot_, {"link", "set", net.robot, "up"}); }
  void Down(const TestNet& net) { Ip(*robot_, {"link", "set", net.robot, "down"}); }
  // As DHCP does, where the network is lost.
  void LoseAddress(const TestNet& net) { Ip(*robot_, {"address", "flush", "dev", net.robot}); }

  void Start() {
    ASSERT_TRUE(made_) << "the network";
    const Ended up = robot_->Run({"up", config_, "--detach"});
    ASSERT_EQ(up.exit, 0) << up.err;
    ASSERT_TRUE(Until([this] { return AllHaveArrivedIn("Active")(robot_->Status()); }));
    pids_ = Pids();
    ASSERT_EQ(pids_.size(), 4U);
  }
  // On both networks; the desk reaches it.
  void StartOnBoth() {
    Connect(kEthernet);
    Connect(kWifi);
    ASSERT_NO_FATAL_FAILURE(Start());
    AwaitDesk(true);
  }
  // Of the controller and of each actuator.
  std::map<std::string, pid_t> Pids() const {
    const nlohmann::json status = robot_->Status();
    std::map<std::string, pid_t> pids;
    if (status.is_null()) return pids;
    pids["controller"] = status["pid"];
    for (const auto& [name, actuator] : status["actuators"].items()) pids[name] = actuator["pid"];
    return pids;
  }
  void AwaitDesk(bool reachable) const {
    EXPECT_TRUE(Until([&] { return desk_->Status().is_null() != reachable; }, kReachedWithin))
        << (reachable ? "the desk does not reach the robot" : "the desk still reaches the robot");
  }
  // A person at the desk: each command is done at once.
  void ExpectTheRobotObeysTheDesk() const { ExpectTheRobotObeys(*desk_); }
  void ExpectTheRobotObeys(const Host& host) const {
    const nlohmann::json status = host.Status();
    EXPECT_FALSE(status.is_null());
    for (const char* state : {"LowPower", "Active"}) {
      const Ended set = host.Run({"set", state});
      EXPECT_EQ(set.exit, 0) << set.err;
    }
    const Ended estop = host.Run({"estop", "--json"});
    EXPECT_EQ(estop.exit, 0) << estop.err;
    const nlohmann::json report = estop.exit == 0 ? Json(estop.out) : nlohmann::json::object();
    EXPECT_EQ(report.value("actuators", nlohmann::json::object()).size(), 3U);
    const Ended release = host.Run({"estop", "--release"});
    EXPECT_EQ(release.exit, 0) << release.err;
    const Ended set = host.Run({"set", "Active"});
    EXPECT_EQ(set.exit, 0) << set.err;
    EXPECT_EQ(Pids(), pids_);
  }
  void ExpectNothingWasLost() const {
    EXPECT_EQ(Pids(), pids_);
    EXPECT_THAT(robot_->Run({"history"}).out,
                ::testing::Not(::testing::AnyOf(::testing::HasSubstr("hung"),
                                                ::testing::HasSubstr("partitioned"),
                                                ::testing::HasSubstr("killed"))));
  }

  static constexpr Duration kReachedWithin = std::chrono::seconds(120);

  std::unique_ptr<Host> robot_;
  std::unique_ptr<Host> desk_;
  std::map<std::string, pid_t> pids_;
  bool made_ = true;  // each command for the network was done
};

}  // namespace musher::testing
