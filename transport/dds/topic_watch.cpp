#include "musher/transport/dds/topic_watch.hpp"

#include <dds/dds.h>

#include <array>
#include <cstring>
#include <set>
#include <utility>

#include "musher/base/check.hpp"
#include "musher/base/checksum.hpp"
#include "musher/transport/dds/entity.hpp"
#include "musher/transport/dds/matched.hpp"
#include "musher/transport/dds/notifier.hpp"
#include "musher/transport/dds/participant.hpp"

namespace musher::transport {
namespace {

using OnFound = std::function<void(const DiscoveredEndpoint&)>;
using OnLost = std::function<void(EndpointId)>;

template <class Id>
Id IdOf(std::span<const std::uint8_t, 16> guid) {
  return Id(Fnv1a({reinterpret_cast<const char*>(guid.data()), guid.size()}) | 1U);
}
template <class Id>
Id IdOf(const dds_guid_t& guid) {
  return IdOf<Id>(std::span(guid.v));
}

std::string PartitionOf(const dds_qos_t* qos) {
  std::uint32_t count = 0;
  char** names = nullptr;
  std::string partition;
  if (dds_qget_partition(qos, &count, &names)) {
    if (count == 1) partition = names[0];
    for (std::uint32_t i = 0; i < count; ++i) dds_free(names[i]);
    dds_free(names);
  }
  return partition;
}

DiscoveredEndpoint EndpointOf(const dds_builtintopic_endpoint_t& sample, bool writer) {
  DiscoveredEndpoint endpoint;
  endpoint.id = IdOf<EndpointId>(sample.key);
  endpoint.participant = IdOf<ParticipantId>(sample.participant_key);
  endpoint.writer = writer;
  endpoint.topic = sample.topic_name;
  endpoint.type = sample.type_name;
  dds_reliability_kind_t reliability = DDS_RELIABILITY_BEST_EFFORT;
  dds_duration_t ignored = 0;
  dds_durability_kind_t durability = DDS_DURABILITY_VOLATILE;
  dds_qget_reliability(sample.qos, &reliability, &ignored);
  dds_qget_durability(sample.qos, &durability);
  endpoint.reliability = reliability == DDS_RELIABILITY_RELIABLE ? Qos::Reliability::kReliable
                                                                 : Qos::Reliability::kBestEffort;
  endpoint.durability = durability == DDS_DURABILITY_VOLATILE ? Qos::Durability::kVolatile
                                                              : Qos::Durability::kTransientLocal;
  endpoint.partition = PartitionOf(sample.qos);
  return endpoint;
}

// The endpoints of one kind. Shared with a running visit, so that a callback may drop the watch.
class Watched : public dds::Notifier {
 public:
  Watched(EventLoop& event_loop, bool writers, OnFound on_found, OnLost on_lost)
      : Notifier(event_loop),
        writers_(writers),
        on_found_(std::move(on_found)),
        on_lost_(std::move(on_lost)) {}

  Result<> Open(dds_entity_t participant) {
    dds_guid_t own{};
    dds_get_guid(participant, &own);
    own_ = IdOf<ParticipantId>(own);
    const dds::ListenerPtr listener(dds_create_listener(this));
    dds_lset_data_available(
        listener.get(), [](dds_entity_t, void* self) { static_cast<Watched*>(self)->Notify(); });
    const dds_entity_t topic =
        writers_ ? DDS_BUILTIN_TOPIC_DCPSPUBLICATION : DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION;
    const dds_entity_t reader = dds_create_reader(participant, topic, nullptr, listener.get());
    if (reader < 0) return dds::DdsError("discovery cannot be read", reader);
    reader_ = dds::Entity(reader);
    Notify();
    return Ok();
  }
  void Close() {
    closed_ = true;
    reader_.Delete();
  }

 private:
  static constexpr int kSamplesPerVisit = 32;

  void Visit() override {
    if (closed_) return;
    std::array<void*, kSamplesPerVisit> samples{};
    std::array<dds_sample_info_t, kSamplesPerVisit> infos{};
    const int count =
        dds_take(reader_.get(), samples.data(), infos.data(), kSamplesPerVisit, kSamplesPerVisit);
    for (int i = 0; i < count && !closed_; ++i) {
      const auto* sample = static_cast<const dds_builtintopic_endpoint_t*>(samples[i]);
      Handle(*sample, infos[i]);
    }
    if (count > 0 && !closed_) dds_return_loan(reader_.get(), samples.data(), count);
    if (count == kSamplesPerVisit && !closed_) Notify();
  }

  void Handle(const dds_builtintopic_endpoint_t& sample, const dds_sample_info_t& info) {
    const bool alive = info.instance_state == DDS_ALIVE_INSTANCE_STATE;
    if (alive && info.valid_data) {
      const DiscoveredEndpoint endpoint = EndpointOf(sample, writers_);
      if (endpoint.participant == own_ || !known_.insert(endpoint.id).second) return;
      if (on_found_) on_found_(endpoint);
    } else if (!alive && known_.erase(IdOf<EndpointId>(sample.key)) > 0 && on_lost_) {
      on_lost_(IdOf<EndpointId>(sample.key));
    }
  }

  const bool writers_;
  OnFound on_found_;
  OnLost on_lost_;
  ParticipantId own_ = 0;
  bool closed_ = false;
  std::set<EndpointId> known_;
  dds::Entity reader_;
};

class DdsTopicWatch : public TopicWatch {
 public:
  DdsTopicWatch(std::shared_ptr<Watched> writers, std::shared_ptr<Watched> readers)
      : writers_(std::move(writers)), readers_(std::move(readers)) {}
  DdsTopicWatch(const DdsTopicWatch&) = delete;
  DdsTopicWatch& operator=(const DdsTopicWatch&) = delete;
  ~DdsTopicWatch() override {
    writers_->Close();
    readers_->Close();
  }

 private:
  std::shared_ptr<Watched> writers_;
  std::shared_ptr<Watched> readers_;
};

}  // namespace

EndpointId EndpointIdOf(std::span<const std::uint8_t, 16> guid) {
  return IdOf<EndpointId>(guid);
}

Result<std::unique_ptr<TopicWatch>> WatchTopics(Node& node, OnFound on_found, OnLost on_lost) {
  node.loop().CheckThread();
  dds::Participant* participant = dds::ParticipantOf(node);
  MUSHER_CHECK(participant != nullptr, "only a node of DDS has topics to watch");
  auto writers = std::make_shared<Watched>(node.loop(), true, on_found, on_lost);
  auto readers =
      std::make_shared<Watched>(node.loop(), false, std::move(on_found), std::move(on_lost));
  if (auto opened = writers->Open(participant->get()); !opened) return opened.error();
  if (auto opened = readers->Open(participant->get()); !opened) return opened.error();
  return std::unique_ptr<TopicWatch>(
      std::make_unique<DdsTopicWatch>(std::move(writers), std::move(readers)));
}

}  // namespace musher::transport
