#include "musher/cli/doctor/dds_trial.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <memory>
#include <sstream>
#include <string>

#include "musher/cli/doctor/in_child.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::cli {
namespace {

// The child exits without its destructors: another process may have killed the network meanwhile.
constexpr const char* kFailed = "failed ";
constexpr const char* kSucceeded = "done ";

struct Side {
  std::string publishes;
  std::string receives;
};

class Peer {
 public:
  explicit Peer(TransportProfile profile) {
    transport::DdsOptions options;
    options.profile = profile;
    options.discovery = transport::DiscoveryTiming::kAtOnce;
    options.hidden = true;
    auto node = transport::MakeDdsNode(loop_, options);
    if (!node) {
      error_ = node.error().message;
      return;
    }
    node_ = std::move(node).value();
  }

  void Open(const Side& side) {
    if (!error_.empty()) return;
    auto publisher = transport::MakePublisher<msg::String>(*node_, side.publishes);
    auto subscription = transport::MakeSubscription<msg::String>(
        *node_, side.receives, [this](msg::String&& sample, const transport::SampleInfo&) {
          received_ = std::move(sample.data);
          if (echoes_) static_cast<void>(publisher_->Publish({received_}));
        });
    if (!publisher || !subscription) {
      error_ = !publisher ? publisher.error().message : subscription.error().message;
      return;
    }
    publisher_ = std::move(publisher).value();
    subscription_ = std::move(subscription).value();
  }

  std::string Echo(Duration timeout) {
    echoes_ = true;
    if (error_.empty()) loop_.RunUntil([] { return false; }, loop_.Now() + timeout);
    return error_;
  }

  // Publishes until a sample comes back: the other side may not know this reader at first.
  std::string Measure(Duration timeout) {
    if (!error_.empty()) return kFailed + error_;
    const Time begin = loop_.Now();
    const auto matched = [this] {
      return publisher_->MatchedReaders() > 0 && subscription_->MatchedWriters() > 0;
    };
    loop_.RunUntil(matched, begin + timeout);
    if (!matched()) return std::string(kFailed) + "the other process was not discovered";
    const Time met = loop_.Now();
    for (int round = 0; loop_.Now() < begin + timeout; ++round) {
      const std::string sample = std::to_string(round);
      const Time sent = loop_.Now();
      static_cast<void>(publisher_->Publish({sample}));
      loop_.RunUntil([&] { return received_ == sample; }, sent + Milliseconds(200));
      if (received_ != sample || round < kWarmUp) continue;
      return fmt::format("{}{} {}", kSucceeded, (met - begin).count(),
                         (loop_.Now() - sent).count());
    }
    return std::string(kFailed) + "the other process was discovered, but no sample came back";
  }

 private:
  static constexpr int kWarmUp = 3;

  transport::LinuxEventLoop loop_;
  std::string error_;
  bool echoes_ = false;
  std::string received_;
  std::unique_ptr<transport::Node> node_;
  std::unique_ptr<transport::Publisher<msg::String>> publisher_;
  std::unique_ptr<transport::Subscription> subscription_;
};

DdsTrial ReadTrial(const std::string& text) {
  DdsTrial trial;
  std::istringstream in(text);
  std::string outcome;
  std::int64_t meeting = 0;
  std::int64_t exchange = 0;
  if (in >> outcome && outcome + " " == kSucceeded && in >> meeting >> exchange) {
    trial.meeting = Duration(meeting);
    trial.exchange = Duration(exchange);
  } else {
    trial.error = text.starts_with(kFailed) ? text.substr(std::string(kFailed).size()) : text;
  }
  return trial;
}

}  // namespace

DdsTrial TryDds(TransportProfile profile, Duration timeout) {
  const std::string topic = fmt::format("musher/doctor_{}", getpid());
  const Side measuring{topic + "/there", topic + "/back"};
  const Side echoing{measuring.receives, measuring.publishes};
  const auto run = [profile](const Side& side, const auto& then) {
    Peer peer(profile);
    peer.Open(side);
    return then(peer);
  };
  auto echo =
      InChild::Start([&] { return run(echoing, [&](Peer& peer) { return peer.Echo(timeout); }); });
  auto measure = InChild::Start(
      [&] { return run(measuring, [&](Peer& peer) { return peer.Measure(timeout); }); });
  if (!echo || !measure) return {!echo ? echo.error().message : measure.error().message};
  const auto text =
      measure.value().Await(std::chrono::steady_clock::now() + timeout + Milliseconds(500));
  if (!text) {
    return {fmt::format("a process did not join the DDS domain within {} ms ({})",
                        ToMilliseconds(timeout), text.error().message)};
  }
  return ReadTrial(text.value());
}

}  // namespace musher::cli
