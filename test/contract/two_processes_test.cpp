// What only a second process can show: discovery, fragments and loss over the real network stack.

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <cstdlib>
#include <optional>
#include <string>

#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/contract/world.hpp"
#include "musher/test/support/domain.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/process.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher/transport/service.hpp"

namespace musher::transport::two_processes_test {

constexpr int kLeaseMs = 1000;

// contract_peer, until the end of the test.
class PeerProcess : public testing::Process {
 public:
  explicit PeerProcess(const std::string& name)
      : Process({BinDir() + "/contract_peer", std::to_string(TestDomain()),
                 std::to_string(kLeaseMs), name}) {}
};

class TwoProcesses : public ::testing::TestWithParam<const char*> {
 protected:
  TwoProcesses() {
    setenv("MUSHER_TRANSPORT", GetParam(), 1);
    DdsOptions options;
    options.domain_id = TestDomain();
    options.lease = Milliseconds(kLeaseMs);
    node_ = Must(MakeDdsNode(loop_, options));
  }
  bool RunUntil(const std::function<bool()>& done) {
    return loop_.RunUntil(done, loop_.Now() + std::chrono::seconds(120));
  }
  Node& node() { return *node_; }
  LinuxEventLoop& loop() { return loop_; }
  const std::string name_ = "two_processes_" + std::to_string(getpid());

 private:
  LinuxEventLoop loop_;
  std::unique_ptr<Node> node_;
};
INSTANTIATE_TEST_SUITE_P(, TwoProcesses, ::testing::Values("local", "lan"),
                         [](const auto& profile) { return std::string(profile.param); });

TEST_P(TwoProcesses, AnswerACallMadeBeforeTheyDiscoverEachOther) {
  const auto client = Must(MakeClient<msg::SetState>(node(), name_ + "/set_state"));
  std::optional<Result<msg::SetState::Response>> answer;
  client->Call({"Active", ""}, std::chrono::seconds(100),
               [&](Result<msg::SetState::Response> response) { answer = std::move(response); });
  PeerProcess peer(name_);
  ASSERT_TRUE(RunUntil([&] { return answer.has_value(); }));
  ASSERT_TRUE(*answer) << answer->error().message;
  EXPECT_EQ(answer->value().outcome, "Active");
}

TEST_P(TwoProcesses, CarrySamplesOfMoreThanOnePacket) {
  PeerProcess peer(name_);
  std::string received;
  const auto back = Must(MakeSubscription<msg::String>(
      node(), name_ + "/image_back",
      [&](const msg::String& message, const SampleInfo&) { received = message.data; }));
  const auto image = Must(MakePublisher<msg::String>(node(), name_ + "/image"));
  ASSERT_TRUE(
      RunUntil([&] { return image->MatchedReaders() == 1 && back->MatchedWriters() == 1; }));
  std::string large(1 << 20, ' ');
  for (std::size_t i = 0; i < large.size(); ++i) large[i] = static_cast<char>('a' + i * 7 % 26);
  // Again until it has come: the peer may match this writer later than the reverse, and a volatile
  // sample of before is not for it.
  const auto publish = [&] { EXPECT_TRUE(image->Publish({large})); };
  const LoopHandlePtr again = loop().Every(Milliseconds(500), publish);
  publish();
  ASSERT_TRUE(RunUntil([&] { return !received.empty(); }));
  EXPECT_TRUE(received == large);
}

TEST_P(TwoProcesses, NoticeThatTheOtherWasKilled) {
  PeerProcess peer(name_);
  EndpointId writer = 0, lost = 0;
  SubscriptionEvents events;
  events.on_writer_lost = [&](EndpointId who) { lost = who; };
  const auto status = Must(MakeSubscription<msg::String>(
      node(), name_ + "/status",
      [&](const msg::String&, const SampleInfo& info) { writer = info.writer; }, kLatchedQos,
      std::move(events)));
  const auto client = Must(MakeClient<msg::SetState>(node(), name_ + "/set_state"));
  ASSERT_TRUE(RunUntil([&] { return writer != 0 && client->Ready(); }));
  const Time killed = loop().Now();
  peer.Signal(SIGKILL);
  ASSERT_TRUE(RunUntil([&] { return lost != 0 && !client->Ready(); }));
  EXPECT_EQ(lost, writer);
  // By the configured lease: without it, "local" has one of ten seconds.
  EXPECT_LT(loop().Now() - killed, Milliseconds(8 * kLeaseMs));
}

TEST_P(TwoProcesses, DiscoverEachOtherAgainAfterAnOutageThatWasLongerThanTheLease) {
  PeerProcess peer(name_);
  ParticipantId before = 0, after = 0;
  bool lost = false;
  SubscriptionEvents events;
  events.on_writer_lost = [&](EndpointId) { lost = true; };
  const auto status = Must(MakeSubscription<msg::String>(
      node(), name_ + "/status",
      [&](const msg::String&, const SampleInfo& info) {
        (lost ? after : before) = info.participant;
      },
      kLatchedQos, std::move(events)));
  ASSERT_TRUE(RunUntil([&] { return before != 0; }));
  peer.Signal(SIGSTOP);
  ASSERT_TRUE(RunUntil([&] { return lost; }));
  peer.Signal(SIGCONT);
  ASSERT_TRUE(RunUntil([&] { return after != 0; }));  // its latched sample once more
  EXPECT_EQ(before, after);
}

}  // namespace musher::transport::two_processes_test
