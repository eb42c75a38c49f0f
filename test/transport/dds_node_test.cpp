// How a node on Cyclone finds its domain and its configuration.

#include "musher/transport/dds/dds_node.hpp"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/support/domain.hpp"
#include "musher/transport/dds/settings.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::transport::dds_node_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// Another program's socket on a port of a DDS domain from 102 on.
class UdpPortHolder {
 public:
  UdpPortHolder() {
    for (domain_ = 102; domain_ < 215; ++domain_) {
      sockaddr_in address = {};
      address.sin_family = AF_INET;
      address.sin_port = htons(static_cast<std::uint16_t>(7400 + 250 * domain_));
      if (bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0) return;
    }
    ADD_FAILURE() << "all ports are taken";
  }
  ~UdpPortHolder() { close(socket_); }
  UdpPortHolder(const UdpPortHolder&) = delete;
  UdpPortHolder& operator=(const UdpPortHolder&) = delete;

  int domain() const { return domain_; }

 private:
  const int socket_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  int domain_ = 0;
};

class DdsNodes : public ::testing::Test {
 protected:
  DdsNodes() {
    for (const char* name : {"ROS_DOMAIN_ID", "CYCLONEDDS_URI", "MUSHER_TRANSPORT"}) unsetenv(name);
  }

  std::string Failure(const DdsOptions& options) {
    const auto node = MakeDdsNode(loop_, options);
    return node ? "" : node.error().message;
  }

  LinuxEventLoop loop_;
  const DdsOptions test_domain_{.domain_id = TestDomain()};
};

TEST(Names, JoinTheNamespaceUnlessTheyAreAbsolute) {
  EXPECT_EQ(ResolveName("dog1", "chat"), "dog1/chat");
  EXPECT_EQ(ResolveName("", "chat"), "chat");
  EXPECT_EQ(ResolveName("dog1", "/show/state"), "show/state");
  EXPECT_EQ(ResolveName("", "/show/state"), "show/state");
}

TEST_F(DdsNodes, UseTheDomainOfTheEnvironmentUnlessTheyAreGivenOne) {
  EXPECT_EQ(DomainId({}).value(), 0);
  setenv("ROS_DOMAIN_ID", "42", 1);
  EXPECT_EQ(DomainId({}).value(), 42);
  EXPECT_EQ(DomainId({.domain_id = 7}).value(), 7);
}

TEST_F(DdsNodes, RefuseADomainThatDoesNotExist) {
  for (const char* domain : {"233", "-1", "dog", "4 2"}) {
    setenv("ROS_DOMAIN_ID", domain, 1);
    EXPECT_THAT(Failure({}), AllOf(HasSubstr("0 to 232"), HasSubstr(domain)));
  }
}

// The benchmarks ran in domains whose ports the kernel gives to any socket, and failed now and
// then.
TEST_F(DdsNodes, SayWhichDomainsHaveTheirPortsToThemselvesWhenAnotherProgramHasOne) {
  const UdpPortHolder holder;
  EXPECT_THAT(Failure({.domain_id = holder.domain()}),
              AllOf(HasSubstr("address in use"), HasSubstr("0 to 101 and 215 to 232")));
}

TEST_F(DdsNodes, RefuseAProfileThatDoesNotExist) {
  setenv("MUSHER_TRANSPORT", "moon", 1);
  EXPECT_THAT(Failure(test_domain_), AllOf(HasSubstr("MUSHER_TRANSPORT"), HasSubstr("moon")));
}

TEST_F(DdsNodes, SayWhatIsWrongWithTheUsersConfiguration) {
  setenv("CYCLONEDDS_URI",
         "<CycloneDDS><Domain><General><Wheels>4</Wheels></General></Domain></CycloneDDS>", 1);
  EXPECT_THAT(Failure(test_domain_),
              AllOf(HasSubstr("cannot join DDS domain"), HasSubstr("Wheels")));
  EXPECT_THAT(Failure({.domain_id = 150}), Not(HasSubstr("0 to 101 and 215 to 232")));
}

TEST_F(DdsNodes, UseTheUsersConfigurationInsteadOfTheProfile) {
  setenv("MUSHER_TRANSPORT", "local", 1);
  setenv("CYCLONEDDS_URI",
         "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name=\"no_such_interface\"/>"
         "</Interfaces></General></Domain></CycloneDDS>",
         1);
  EXPECT_THAT(Failure(test_domain_), HasSubstr("no_such_interface"));
}

// With one for each node, Cyclone missed the endpoints of a process that it met just when another
// node went: a process that was started again was never seen.
TEST_F(DdsNodes, OfOneProcessAreOneParticipant) {
  const auto here = MakeDdsNode(loop_, test_domain_);
  std::vector<ParticipantId> from;
  const auto subscription = MakeSubscription<msg::String>(
      *here.value(), "chat",
      [&](const msg::String&, const SampleInfo& info) { from.push_back(info.participant); });
  for (int i = 0; i < 2; ++i) {
    const auto there = MakeDdsNode(loop_, test_domain_);
    const auto chat = MakePublisher<msg::String>(*there.value(), "chat");
    ASSERT_TRUE(chat.value()->Publish({"hello"}));
    ASSERT_TRUE(loop_.RunUntil([&] { return from.size() > static_cast<std::size_t>(i); },
                               loop_.Now() + std::chrono::seconds(120)));
  }
  EXPECT_EQ(from[0], from[1]);
}

TEST_F(DdsNodes, ShareTheDomainOfTheProcessAndOpenItAgain) {
  for (int i = 0; i < 2; ++i) {
    const auto one = MakeDdsNode(loop_, test_domain_);
    const auto two = MakeDdsNode(loop_, test_domain_);
    EXPECT_TRUE(one && two);
  }
}

TEST_F(DdsNodes, RefuseASampleWithoutItsHeader) {
  const auto node = MakeDdsNode(loop_, test_domain_);
  const auto writer = node.value()->MakeRawWriter("rt/short", "a::msg::dds_::B_", {}, {});
  const msg::Bytes bytes(3);
  EXPECT_FALSE(writer.value()->Write(bytes));
}

// The last sample of a program that exited was lost to a reader that had just discovered it.
TEST_F(DdsNodes, HaveDeliveredTheirSamplesAfterAFlushThoughTheyExitThen) {
  std::string received;
  const auto there = MakeDdsNode(loop_, test_domain_);
  ASSERT_TRUE(there);
  const auto subscription = MakeSubscription<msg::String>(
      *there.value(), "last_output",
      [&](const msg::String& message, const SampleInfo&) { received = message.data; });
  ASSERT_TRUE(subscription);
  {
    auto here = MakeDdsNode(loop_, test_domain_);
    ASSERT_TRUE(here);
    const auto publisher = MakePublisher<msg::String>(*here.value(), "last_output");
    ASSERT_TRUE(publisher);
    const auto deadline = loop_.Now() + std::chrono::seconds(120);
    ASSERT_TRUE(loop_.RunUntil([&] { return publisher.value()->MatchedReaders() == 1; }, deadline));
    ASSERT_TRUE(publisher.value()->Publish({"farewell"}));
    ASSERT_TRUE(publisher.value()->Flush(std::chrono::seconds(120)));
  }
  loop_.RunUntil([&] { return !received.empty(); }, loop_.Now() + std::chrono::seconds(120));
  EXPECT_EQ(received, "farewell");
}

// As a client that was stopped with Ctrl-Z, and a reply of a thousand entries: the loop of the
// writer must not wait until such a reader takes what it was sent.
TEST_F(DdsNodes, DoNotWaitForAReaderThatIsStopped) {
  const pid_t reader = fork();
  ASSERT_GE(reader, 0);
  if (reader == 0) {
    LinuxEventLoop loop;
    const auto node = MakeDdsNode(loop, test_domain_);
    const auto subscription = MakeSubscription<msg::String>(
        *node.value(), "large", [](const msg::String&, const SampleInfo&) { raise(SIGSTOP); });
    loop.RunUntil([] { return false; }, loop.Now() + std::chrono::seconds(60));
    _exit(0);
  }
  const auto node = MakeDdsNode(loop_, test_domain_);
  ASSERT_TRUE(node);
  const auto writer = MakePublisher<msg::String>(*node.value(), "large");
  ASSERT_TRUE(writer);
  EXPECT_TRUE(loop_.RunUntil([&] { return writer.value()->MatchedReaders() == 1; },
                             loop_.Now() + std::chrono::seconds(120)));
  EXPECT_TRUE(writer.value()->Publish({"stop"}));
  int status = 0;
  EXPECT_EQ(waitpid(reader, &status, WUNTRACED), reader);
  EXPECT_TRUE(WIFSTOPPED(status));
  // A write that waits takes 100 ms, and fails.
  const std::string large(300'000, 'x');
  for (int i = 0; i < 50; ++i) {
    const auto written = writer.value()->Publish({large});
    EXPECT_TRUE(written) << "write " << i << ": " << written.error().message;
  }
  EXPECT_EQ(writer.value()->MatchedReaders(), 1) << "it was out of reach meanwhile";
  kill(reader, SIGKILL);
  waitpid(reader, &status, 0);
}

TEST_F(DdsNodes, RefuseATopicWithANameThatDdsCannotHave) {
  const auto node = MakeDdsNode(loop_, test_domain_);
  EXPECT_FALSE(node.value()->MakeRawWriter("", "a::msg::dds_::B_", {}, {}));
}

TEST(Settings, TakeTheProfileOfTheEnvironmentBeforeTheConfigs) {
  unsetenv("MUSHER_TRANSPORT");
  EXPECT_EQ(dds::ChosenProfile(TransportProfile::kLan).value(), TransportProfile::kLan);
  setenv("MUSHER_TRANSPORT", "local", 1);
  EXPECT_EQ(dds::ChosenProfile(TransportProfile::kLan).value(), TransportProfile::kLocal);
  setenv("MUSHER_TRANSPORT", "lan", 1);
  EXPECT_EQ(dds::ChosenProfile(TransportProfile::kLocal).value(), TransportProfile::kLan);
}

TEST(Settings, KeepOneHostOnLoopbackInEveryProfileAndLetItsProcessesBeMany) {
  const std::string local = dds::SettingsXml(TransportProfile::kLocal, {});
  const std::string lan = dds::SettingsXml(TransportProfile::kLan, {}, DiscoveryTiming::kCombined,
                                           false, {"eth0", "wlan0"});
  for (const auto& xml : {local, lan}) {
    EXPECT_THAT(xml, HasSubstr("<NetworkInterface name=\"lo\" multicast=\"true\"/>"));
    EXPECT_THAT(xml, HasSubstr("<ParticipantIndex>none</ParticipantIndex>"));
  }
  for (const std::string outer : {"eth0", "wlan0"}) {
    EXPECT_THAT(
        lan, HasSubstr("<NetworkInterface name=\"" + outer + "\" presence_required=\"false\"/>"));
  }
}

TEST(Settings, OfAProcessThatUsesOneNetworkAloneSendToNoAddressOfAnother) {
  const std::vector<std::string> outer = {"wlan0"};
  const auto xml = [&outer](bool own_networks_only) {
    return dds::SettingsXml(TransportProfile::kLan, {}, DiscoveryTiming::kCombined, false, outer,
                            own_networks_only);
  };
  EXPECT_THAT(xml(true), HasSubstr("<DontRoute>true</DontRoute>"));
  EXPECT_THAT(xml(false), Not(HasSubstr("DontRoute")));
}

TEST(Settings, DiscoverByMulticastAndReadPicturesByUnicast) {
  for (const auto profile : {TransportProfile::kLocal, TransportProfile::kLan}) {
    EXPECT_THAT(dds::SettingsXml(profile, {}), Not(HasSubstr("AllowMulticast")));
    EXPECT_THAT(dds::SettingsXml(profile, {}, DiscoveryTiming::kCombined, true),
                HasSubstr("<AllowMulticast>spdp</AllowMulticast>"));
  }
}

// With Cyclone's 10 ms an actuator that has just started drops the controller's request, and the
// next one comes after a heartbeat.
TEST(Settings, LetAnActuatorDiscoverTheControllerBeforeTheControllerRequests) {
  const auto xml = [](DiscoveryTiming timing) {
    return dds::SettingsXml(TransportProfile::kLocal, {}, timing);
  };
  EXPECT_THAT(xml(DiscoveryTiming::kOnceKnown),
              HasSubstr("<PreEmptiveAckDelay>30ms</PreEmptiveAckDelay>"));
  EXPECT_THAT(xml(DiscoveryTiming::kAtOnce), Not(HasSubstr("PreEmptiveAckDelay")));
}

// With an actuator's timing the start of a hundred processes takes twice as long.
TEST(Settings, RequestRepetitionsSeldomInACrowd) {
  const auto xml = [](DiscoveryTiming timing) {
    return dds::SettingsXml(TransportProfile::kLocal, {}, timing);
  };
  EXPECT_THAT(xml(DiscoveryTiming::kCombined), HasSubstr("<NackDelay>10ms</NackDelay>"));
  EXPECT_THAT(xml(DiscoveryTiming::kCombinedLong), HasSubstr("<NackDelay>100ms</NackDelay>"));
}

TEST(Settings, TakeTheRequestedLease) {
  const std::string xml = dds::SettingsXml(TransportProfile::kLocal, Milliseconds(800));
  EXPECT_THAT(xml, HasSubstr("<LeaseDuration>800ms</LeaseDuration>"));
  EXPECT_THAT(xml, HasSubstr("<SPDPInterval>200ms</SPDPInterval>"));
}

}  // namespace musher::transport::dds_node_test
