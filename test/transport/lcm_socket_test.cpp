// Multicast groups of LCM on the loopback of this computer.

#include "musher/transport/lcm_socket.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <sched.h>
#include <sys/socket.h>
#include <unistd.h>

#include <future>

#include "musher/test/support/lcm_group.hpp"
#include "musher/test/support/wait.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::transport::lcm_socket_test {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Of this process and test only.
LcmOptions Group(int test) {
  LcmOptions options;
  options.url.group = LcmGroup(TestDomain());
  options.url.port = static_cast<std::uint16_t>(LcmPort(TestDomain(), test));
  options.network_interface = "lo";
  options.ttl = 0;
  return options;
}

constexpr std::array kHello = {std::byte{'h'}, std::byte{'i'}};

TEST(LcmSocket, ReceivesWhatAnotherOneSendsAndNamesIt) {
  LinuxEventLoop loop;
  std::vector<std::string> got;
  std::string sender;
  const auto receiver = LcmSocket::Open(loop, Group(1), [&](const LcmSample& sample) {
                          ASSERT_TRUE(sample.packet);
                          got.push_back(std::string(sample.packet->channel) +
                                        std::to_string(sample.packet->sequence));
                          sender = sample.sender;
                        }).value();
  const auto other = LcmSocket::Open(loop, Group(1), [](const LcmSample&) {}).value();
  ASSERT_TRUE(other->Send("a", kHello));
  ASSERT_TRUE(other->Send("b", kHello));
  EXPECT_TRUE(
      loop.RunUntil([&] { return got.size() == 2; }, testing::In(std::chrono::seconds(120))));
  EXPECT_THAT(got, ElementsAre("a0", "b1"));
  EXPECT_EQ(sender, other->sender());
  EXPECT_NE(sender, receiver->sender());
  EXPECT_THAT(receiver->name(), HasSubstr("by lo (127.0.0.1)"));
}

// A report from before a stop may wait in the socket until after it. Where no other socket of the
// computer has asked, the kernel begins to stamp what arrives a moment after the first one asks
// (net_enable_timestamp is a work queue's).
TEST(LcmSocket, SaysHowLongADatagramHasWaitedForTheLoop) {
  LinuxEventLoop loop;
  std::optional<Duration> age;
  const auto receiver =
      LcmSocket::Open(loop, Group(9), [&](const LcmSample& sample) { age = sample.age; }).value();
  constexpr Duration kBusy = Milliseconds(30);
  const Time deadline = testing::In(std::chrono::seconds(120));
  do {
    age.reset();
    ASSERT_TRUE(receiver->Send("a", kHello));
    const Time sent_at = loop.Now();
    while (loop.Now() - sent_at < kBusy) {
    }
    ASSERT_TRUE(loop.RunUntil([&] { return age.has_value(); }, deadline));
  } while (*age < kBusy - Milliseconds(1) && loop.Now() < deadline);
  EXPECT_GE(*age, kBusy - Milliseconds(1));
  EXPECT_LE(*age, std::chrono::seconds(120));
}

TEST(LcmSocket, KnowsWhereTheHostOfASenderIs) {
  const HostAddresses here;
  EXPECT_EQ(here.PlaceOf("127.0.0.1:41234", "lo"), HostPlace::kThisComputer);
  EXPECT_EQ(here.PlaceOf("127.1.2.3:41234", "lo"), HostPlace::kThisNetwork);
  EXPECT_EQ(here.PlaceOf("127.1.2.3:41234", ""), HostPlace::kThisNetwork);
  EXPECT_EQ(here.PlaceOf("127.1.2.3:41234", "musher-none"), HostPlace::kElsewhere);
  EXPECT_EQ(here.PlaceOf("203.0.113.9:41234", "lo"), HostPlace::kElsewhere);
  EXPECT_EQ(here.PlaceOf("", ""), HostPlace::kElsewhere);
}

// The name of a network interface that is up with multicast and an address, beside lo; "": none.
std::string AnotherInterface() {
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return "";
  std::string found;
  constexpr unsigned kNeeded = IFF_UP | IFF_MULTICAST;
  for (const ifaddrs* one = list; one != nullptr; one = one->ifa_next) {
    const bool ip = one->ifa_addr != nullptr && one->ifa_addr->sa_family == AF_INET;
    const bool usable =
        (one->ifa_flags & kNeeded) == kNeeded && (one->ifa_flags & IFF_LOOPBACK) == 0;
    if (ip && usable) found = one->ifa_name;
  }
  freeifaddrs(list);
  return found;
}

// Linux gives a socket also what comes by the interfaces on which other sockets have joined.
TEST(LcmSocket, ReceivesByItsInterfaceOnly) {
  const LcmOptions by_loopback = Group(5);
  LcmOptions by_another = by_loopback;
  by_another.network_interface = AnotherInterface();
  if (by_another.network_interface.empty()) GTEST_SKIP() << "this computer has lo only";
  LinuxEventLoop loop;
  std::vector<std::string> got;
  std::vector<std::string> got_by_another;
  const auto keep = [](std::vector<std::string>& texts) {
    return [&texts](const LcmSample& sample) {
      ASSERT_TRUE(sample.packet);
      texts.emplace_back(sample.packet->channel);
    };
  };
  const auto receiver = LcmSocket::Open(loop, by_loopback, keep(got)).value();
  const auto another = LcmSocket::Open(loop, by_another, keep(got_by_another)).value();
  ASSERT_TRUE(another->Send("another", kHello));
  ASSERT_TRUE(loop.RunUntil([&] { return !got_by_another.empty(); },
                            testing::In(std::chrono::seconds(120))));
  ASSERT_TRUE(receiver->Send("loopback", kHello));
  EXPECT_TRUE(loop.RunUntil([&] { return !got.empty(); }, testing::In(std::chrono::seconds(120))));
  EXPECT_THAT(got, ElementsAre("loopback"));
}

TEST(LcmSocket, ReportsADatagramThatIsNoLcmMessage) {
  LinuxEventLoop loop;
  std::size_t bad = 0;
  const LcmOptions options = Group(2);
  const auto receiver = LcmSocket::Open(loop, options, [&](const LcmSample& sample) {
                          if (!sample.packet) bad = sample.size;
                        }).value();
  ASSERT_TRUE(RawLcmSender(ToText(options.url)).Send("junk"));
  EXPECT_TRUE(loop.RunUntil([&] { return bad == 4; }, testing::In(std::chrono::seconds(120))));
}

TEST(LcmSocket, NamesAnInterfaceThatDoesNotExist) {
  LinuxEventLoop loop;
  LcmOptions options = Group(3);
  options.network_interface = "eth77";
  const auto opened = LcmSocket::Open(loop, options, [](const LcmSample&) {});
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().message, AllOf(HasSubstr("'eth77'"), HasSubstr("ip -brief link")));
}

TEST(LcmSocket, SaysWhatToTypeWithoutAMulticastRoute) {
  // A thread with a network of its own, in which nothing is up.
  const auto message = std::async(std::launch::async, []() -> std::string {
                         if (unshare(CLONE_NEWNET) != 0) return "skip";
                         LinuxEventLoop loop;
                         LcmOptions options = Group(4);
                         options.network_interface = "";
                         const auto opened =
                             LcmSocket::Open(loop, options, [](const LcmSample&) {});
                         return opened ? "opened" : opened.error().message;
                       }).get();
  if (message == "skip") GTEST_SKIP() << "a network namespace needs root";
  EXPECT_THAT(message, AllOf(HasSubstr("no network route leads to the multicast group 239.254."),
                             HasSubstr("sudo ip route add 239.254.")));
}

}  // namespace musher::transport::lcm_socket_test
