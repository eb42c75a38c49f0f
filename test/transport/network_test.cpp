// Which interfaces a process of the profile lan uses beside the loopback.

#include "musher/transport/network.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

namespace musher::transport::network_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

NetworkInterface Device(const std::string& name, const std::string& address = "10.0.0.1") {
  NetworkInterface one{name, true, false, true, {}};
  if (!address.empty()) one.addresses = {address};
  return one;
}
NetworkInterface Down(const std::string& name) {
  NetworkInterface one = Device(name, "");
  one.up = false;
  return one;
}
NetworkInterface Virtual(const std::string& name, const std::string& kind) {
  NetworkInterface one = Device(name);
  one.kind = kind;
  return one;
}
NetworkInterface Tunnel(const std::string& name) {
  NetworkInterface one = Virtual(name, "tun");
  one.ethernet = false;  // with multicast, as the kernel makes it
  return one;
}
NetworkInterface Can(const std::string& name) {
  NetworkInterface one = Device(name, "");
  one.ethernet = false;
  return one;
}
const NetworkInterface kLoopback{"lo", true, true, false, {"127.0.0.1"}};

struct Host {
  const char* name;
  std::vector<NetworkInterface> present;
  std::vector<std::string> configured;
  std::vector<std::string> used;
};

class OuterInterfaces : public ::testing::TestWithParam<Host> {};

TEST_P(OuterInterfaces, AreChosen) {
  std::vector<std::string> used;
  for (const InterfaceUse& use : ChooseInterfaces(GetParam().present, GetParam().configured)) {
    EXPECT_NE(use.reason, "") << use.name;
    EXPECT_NE(use.name, "lo");
    if (use.used) used.push_back(use.name);
  }
  EXPECT_EQ(used, GetParam().used);
}

const Host kHosts[] = {
    {"ARobotWithEthernetAndWifi",
     {kLoopback, Device("eth0"), Device("wlan0"), Can("can0")},
     {},
     {"eth0", "wlan0"}},
    {"ARobotWithDockerAndAVpn",
     {kLoopback, Device("wlan0"), Virtual("docker0", "bridge"), Virtual("veth1a", "veth"),
      Virtual("wg0", "wireguard"), Tunnel("tun0")},
     {},
     {"wlan0"}},
    {"ARobotWhoseWifiIsDownBesideDocker",
     {kLoopback, Down("wlan0"), Virtual("docker0", "bridge")},
     {},
     {}},
    {"ARobotThatWaitsForItsAddress", {kLoopback, Device("wlan0", "")}, {}, {}},
    {"ARobotWithABondAndAVlan",
     {kLoopback, Device("eth0", ""), Virtual("bond0", "bond"), Virtual("eth0.7", "vlan")},
     {},
     {"bond0", "eth0.7"}},
    {"AHostWithMoreThanCycloneUses",
     {kLoopback, Device("a"), Device("b"), Device("c"), Device("d")},
     {},
     {"a", "b", "c"}},
    {"AContainer", {kLoopback, Virtual("eth0", "veth")}, {}, {"eth0"}},
    {"AContainerWithATunnel", {kLoopback, Tunnel("tun0"), Virtual("eth0", "veth")}, {}, {"eth0"}},
    {"AContainerWithTwoNetworks",
     {kLoopback, Virtual("eth0", "veth"), Virtual("eth1", "veth")},
     {},
     {"eth0", "eth1"}},
    {"AContainerWithAnEmptyInterface",
     {kLoopback, Virtual("dummy0", "dummy"), Virtual("eth0", "macvlan")},
     {},
     {"eth0"}},
    {"AHostWithATunnelOnly", {kLoopback, Tunnel("tun0")}, {}, {}},
    {"AHostOfContainersOnly", {kLoopback, Virtual("docker0", "bridge")}, {}, {}},
    {"NoNetwork", {kLoopback}, {}, {}},
    {"AVpnThatIsConfigured",
     {kLoopback, Device("wlan0"), Virtual("wg0", "wireguard")},
     {"wg0"},
     {"wg0"}},
    {"AConfiguredOrder", {kLoopback, Device("a"), Device("b")}, {"b", "a"}, {"b", "a"}},
    {"AConfiguredOneThatIsAbsent", {kLoopback, Device("a")}, {"wlan0", "a"}, {"a"}},
    {"AConfiguredOneThatIsDown", {kLoopback, Down("wlan0"), Device("a")}, {"wlan0"}, {}},
};
INSTANTIATE_TEST_SUITE_P(Of, OuterInterfaces, ::testing::ValuesIn(kHosts),
                         [](const auto& each) { return each.param.name; });

TEST(AnInterfaceThatComesLate, IsMissedUnlessItOnlyComesBack) {
  const std::vector<NetworkInterface> before = {kLoopback, Device("wlan0"), Down("eth0")};
  const auto missed = [&](const std::vector<NetworkInterface>& now) {
    return MissedInterfaces(before, now, {});
  };
  EXPECT_THAT(missed(before), ElementsAre());
  EXPECT_THAT(missed({kLoopback, Down("wlan0"), Down("eth0")}), ElementsAre());
  EXPECT_THAT(missed({kLoopback, Device("wlan0"), Device("eth0", "10.0.1.1")}),
              ElementsAre("eth0 with 10.0.1.1"));
  EXPECT_THAT(missed({kLoopback, Device("wlan0", "10.0.0.9")}), ElementsAre("wlan0 with 10.0.0.9"));
  EXPECT_THAT(missed({kLoopback, Device("wlan0"), Virtual("docker0", "bridge")}), ElementsAre());
}

TEST(AnInterfaceThatIsNotUsed, HasAReason) {
  const auto reason = [](const NetworkInterface& one, std::vector<std::string> configured = {}) {
    const auto uses = ChooseInterfaces({kLoopback, Device("eth9"), one}, configured);
    for (const InterfaceUse& use : uses) {
      if (use.name == one.name && !use.used) return use.reason;
    }
    return std::string("used");
  };
  EXPECT_EQ(reason(Down("wlan0")), "it is down");
  EXPECT_EQ(reason(Device("wlan0", "")), "it has no IPv4 address");
  EXPECT_THAT(reason(Virtual("docker0", "bridge")), HasSubstr("virtual (bridge)"));
  EXPECT_THAT(reason(Can("can0")), HasSubstr("no ethernet or wifi"));
  EXPECT_EQ(reason(Device("wlan0"), {"eth9"}), "[transport] interfaces does not name it");
  EXPECT_EQ(ChooseInterfaces({kLoopback}, {"wlan0"})[0].reason, "it does not exist");
}

TEST(Interfaces, AreThoseOfTheNetworkNamespace) {
  const pid_t child = fork();
  if (child == 0) {
    if (unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) _exit(2);
    const auto found = ReadInterfaces();
    _exit(found.size() == 1 && found[0].loopback && !found[0].up ? 0 : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  if (WEXITSTATUS(status) == 2) GTEST_SKIP() << "no network namespace here";
  EXPECT_EQ(status, 0);
}

TEST(Interfaces, IncludeTheLoopbackWithItsAddress) {
  for (const NetworkInterface& one : ReadInterfaces()) {
    if (!one.loopback) continue;
    EXPECT_EQ(one.name, "lo");
    EXPECT_TRUE(one.up);
    EXPECT_THAT(one.addresses, ::testing::Contains("127.0.0.1"));
    return;
  }
  ADD_FAILURE() << "no loopback";
}

}  // namespace musher::transport::network_test
