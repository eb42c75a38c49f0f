// Fast DDS, the default of most ROS 2 installations: topics work in both directions, and a machine
// says which process runs it.

#include <gmock/gmock.h>

#include <fstream>
#include <numeric>
#include <optional>

#include "musher/base/host.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/contract/world.hpp"
#include "musher/test/support/domain.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/process.hpp"
#include "musher/test/support/temp_folder.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::testing::fast_dds_test {

using transport::Must;

class FastDds : public ::testing::Test {
 protected:
  FastDds() {
    for (const char* name : {"CYCLONEDDS_URI", "MUSHER_TRANSPORT"}) unsetenv(name);
    transport::DdsOptions options;
    options.domain_id = transport::TestDomain();
    options.profile = TransportProfile::kLan;  // Fast DDS uses no multicast on the loopback alone
    node_ = Must(transport::MakeDdsNode(loop_, options));
  }
  // Publishes `sample` on /fast, and receives on /musher.
  template <msg::Message M>
  void StartPeer(const M& sample) {
    const msg::Bytes bytes = msg::Encode(sample);
    const std::string file = folder_ / "sample";
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    peer_.emplace(std::vector<std::string>{
        BinDir() + "/fast_dds_peer", std::to_string(transport::TestDomain()),
        std::string(M::kTypeName), "rt/fast", file, "rt/musher"});
    ASSERT_NE(peer_->LineWith("ready"), "");
  }
  // What the peer prints at the end of its line. Cyclone fills up the bytes to a multiple of four.
  template <msg::Message M>
  static std::string SumOf(const M& sample) {
    const msg::Bytes bytes = msg::Encode(sample);
    return " " + std::to_string(std::accumulate(
                     bytes.begin(), bytes.end(), std::uint64_t{0},
                     [](std::uint64_t all, std::byte one) { return all + std::uint8_t(one); }));
  }
  bool Until(const std::function<bool()>& done) {
    return loop_.RunUntil(done, loop_.Now() + std::chrono::seconds(120));
  }
  // A sample each way; the later one of each pair gets the latched sample of the earlier one.
  template <msg::Message M>
  void ExchangeBothWays(const M& sample) {
    const auto publisher =
        Must(transport::MakePublisher<M>(*node_, "musher", transport::kLatchedQos));
    ASSERT_TRUE(publisher->Publish(sample));
    ASSERT_NO_FATAL_FAILURE(StartPeer(sample));
    std::optional<M> received;
    const auto subscription = Must(transport::MakeSubscription<M>(
        *node_, "fast", [&](M&& one, const auto&) { received = std::move(one); },
        transport::kLatchedQos));
    EXPECT_TRUE(Until([&] { return received.has_value(); }));
    EXPECT_EQ(received, sample);
    EXPECT_THAT(peer_->LineWith("received"), ::testing::EndsWith(SumOf(sample)));
  }

  TempFolder folder_;
  transport::LinuxEventLoop loop_;
  std::unique_ptr<transport::Node> node_;
  std::optional<Process> peer_;
};

TEST_F(FastDds, ExchangesTextsBothWaysAlsoWithALateJoiner) {
  ExchangeBothWays(msg::String{"good morning"});
}

TEST_F(FastDds, ExchangesImagesBothWaysAlsoWithALateJoiner) {
  msg::Image image;
  image.width = 640;
  image.height = 480;
  image.step = 640 * 3;
  image.encoding = "rgb8";
  image.data.resize(640 * 480 * 3);
  for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = std::uint8_t(i * 7);
  ExchangeBothWays(image);
}

TEST_F(FastDds, IsKnownByItsVendorAndProcess) {
  ASSERT_NO_FATAL_FAILURE(StartPeer(msg::String{"good morning"}));
  transport::PeerInfo found;
  EXPECT_TRUE(Until([&] {
    for (const transport::PeerInfo& peer : node_->Peers()) {
      if (peer.vendor == 0x010f) found = peer;
    }
    return found.vendor != 0;
  }));
  EXPECT_EQ(found.pid, peer_->pid());
  EXPECT_EQ(found.host, HostName());
}

}  // namespace musher::testing::fast_dds_test
