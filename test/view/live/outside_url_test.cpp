#include "musher/view/live/outside_url.hpp"

#include <gtest/gtest.h>

namespace musher::view::outside_url_test {

using transport::NetworkInterface;

NetworkInterface Interface(const std::string& name, const std::string& address) {
  NetworkInterface one;
  one.name = name;
  one.up = true;
  one.addresses = {address};
  return one;
}

TEST(OutsideUrl, IsThatOfADeviceThatAPhoneCanReach) {
  NetworkInterface loopback = Interface("lo", "127.0.0.1");
  loopback.loopback = true;
  NetworkInterface down = Interface("eth0", "10.0.0.1");
  down.up = false;
  NetworkInterface bridge = Interface("docker0", "172.17.0.1");
  bridge.kind = "bridge";
  const NetworkInterface wifi = Interface("wlan0", "192.168.1.7");
  EXPECT_EQ(OutsideUrl("0.0.0.0", {loopback, down, bridge, wifi}, 8765), "http://192.168.1.7:8765");
  EXPECT_EQ(OutsideUrl("::", {loopback, bridge}, 80), "http://172.17.0.1:80");
  EXPECT_EQ(OutsideUrl("0.0.0.0", {loopback, down}, 80), "");
}

TEST(OutsideUrl, IsOfTheNetworkOfAContainerAndNotOfABridgeBesideIt) {
  NetworkInterface bridge = Interface("docker0", "172.17.0.1");
  bridge.kind = "bridge";
  NetworkInterface container = Interface("eth0", "192.168.1.8");
  container.kind = "veth";
  EXPECT_EQ(OutsideUrl("0.0.0.0", {bridge, container}, 80), "http://192.168.1.8:80");
}

TEST(OutsideUrl, IsTheAddressOnWhichThePageListens) {
  EXPECT_EQ(OutsideUrl("10.0.0.9", {}, 8765), "http://10.0.0.9:8765");
  EXPECT_EQ(OutsideUrl("fd00::7", {}, 8765), "http://[fd00::7]:8765");
}

TEST(OutsideUrl, IsNoneOnTheLoopback) {
  EXPECT_EQ(OutsideUrl("127.0.0.1", {Interface("wlan0", "192.168.1.7")}, 8765), "");
  EXPECT_EQ(OutsideUrl("::1", {Interface("wlan0", "192.168.1.7")}, 8765), "");
}

}  // namespace musher::view::outside_url_test
