// Processes of this host that Cyclone would take for processes of another one.

#include "musher/transport/udp_sockets.hpp"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include "musher/base/unique_fd.hpp"

namespace musher::transport::udp_sockets_test {

using ::testing::Contains;
using ::testing::IsEmpty;

constexpr int kDomain = 2;
constexpr std::uint16_t kDiscovery = 7900;

UdpProcess DdsProcess(const std::vector<std::string>& addresses,
                      std::uint16_t discovery = kDiscovery) {
  UdpProcess process{7, 0, {{"0.0.0.0", discovery}, {"0.0.0.0", 45000}, {"127.0.0.1", 45001}}};
  for (const std::string& address : addresses) process.sockets.push_back({address, 45002});
  return process;
}

TEST(AProcessOfTheHost, IsUnreachableIfItSharesNoAddress) {
  const auto found = FindOtherAddress({DdsProcess({"10.0.0.1"})}, kDomain, {"10.0.0.9"});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->pid, 7);
  EXPECT_EQ(found->address, "10.0.0.1");
}

TEST(AProcessOfTheHost, IsReachableByTheLoopback) {
  const std::vector<std::string> own = {"10.0.0.9"};
  EXPECT_FALSE(FindOtherAddress({DdsProcess({})}, kDomain, own));  // it has the loopback only
  EXPECT_FALSE(FindOtherAddress({DdsProcess({"10.0.0.9"})}, kDomain, own));
  EXPECT_FALSE(FindOtherAddress({DdsProcess({"10.0.0.1", "10.0.0.9"})}, kDomain, own));
}

TEST(AProcessOfTheHost, IsOfNoConcernOutsideOfTheDomain) {
  EXPECT_FALSE(FindOtherAddress({DdsProcess({"10.0.0.1"}, 7400)}, kDomain, {"10.0.0.9"}));
  UdpProcess client = DdsProcess({});
  client.sockets.push_back({"10.0.0.1", 45003, true});  // of a browser
  EXPECT_FALSE(FindOtherAddress({client}, kDomain, {"10.0.0.9"}));
}

TEST(UdpSockets, AreReadWithTheirAddress) {
  const UniqueFd bound(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(bind(bound.get(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  const auto addresses = BoundAddresses(getpid());
  ASSERT_TRUE(addresses);
  EXPECT_THAT(*addresses, Contains("127.0.0.1"));
  EXPECT_EQ(BoundAddresses(0), std::nullopt);
  for (const UdpProcess& process : ReadProcessesBoundElsewhere({})) {
    EXPECT_NE(process.pid, getpid());
    EXPECT_THAT(process.sockets, ::testing::Not(IsEmpty()));
  }
}

}  // namespace musher::transport::udp_sockets_test
