#include "musher/transport/dds/dds_reader.hpp"

#include <dds/ddsi/ddsi_serdata.h>

#include <algorithm>
#include <array>

#include "musher/transport/dds/matched.hpp"
#include "musher/transport/dds/raw_type.hpp"
#include "musher/transport/dds/type_tag.hpp"
#include "musher/transport/lost_samples.hpp"

namespace musher::transport::dds {

namespace {

constexpr int kSamplesPerVisit = 32;

}  // namespace

Result<> ReaderCore::Open(dds_entity_t participant, Entity topic, const QosPtr& qos) {
  topic_ = std::move(topic);
  const ListenerPtr listener(dds_create_listener(this));
  dds_lset_data_available(listener.get(), OnDataAvailable);
  dds_lset_subscription_matched(listener.get(), OnMatched);
  dds_lset_sample_lost(listener.get(), OnSampleLost);
  const dds_entity_t reader =
      dds_create_reader(participant, topic_.get(), qos.get(), listener.get());
  if (reader < 0) return DdsError("dds_create_reader", reader);
  reader_ = Entity(reader);
  return Ok();
}

void ReaderCore::Close() {
  loop().CheckThread();
  closed_ = true;
  reader_.Delete();
  topic_.Delete();
}

void ReaderCore::OnDataAvailable(dds_entity_t, void* self) {
  static_cast<ReaderCore*>(self)->Notify();
}

void ReaderCore::OnMatched(dds_entity_t, dds_subscription_matched_status_t, void* self) {
  auto* core = static_cast<ReaderCore*>(self);
  core->match_changed_ = true;
  core->Notify();
}

void ReaderCore::OnSampleLost(dds_entity_t, dds_sample_lost_status_t status, void*) {
  CountLostSamples(static_cast<std::uint64_t>(std::max(status.total_count_change, 0)));
}

// Reports new writers before their samples are delivered, lost ones after their last sample.
void ReaderCore::Visit() {
  if (closed_) return;
  const bool match_changed = match_changed_.exchange(false);
  std::vector<EndpointId> lost;
  if (match_changed) lost = LearnWriters();
  const bool more = Take();
  if (closed_) return;
  if (more) {
    if (match_changed) match_changed_ = true;
    Notify();
    return;
  }
  for (const EndpointId writer : lost) {
    writers_.Remove(writer);
    partitions_.erase(writer);
    if (callbacks_.on_writer_lost) callbacks_.on_writer_lost(writer);
    if (closed_) return;
  }
  if (match_changed && callbacks_.on_match_changed) callbacks_.on_match_changed();
}

// Delivers the received samples, up to a limit; returns whether there may be more.
bool ReaderCore::Take() {
  std::array<ddsi_serdata*, kSamplesPerVisit> samples{};
  std::array<dds_sample_info_t, kSamplesPerVisit> infos{};
  const int count =
      dds_takecdr(reader_.get(), samples.data(), kSamplesPerVisit, infos.data(), DDS_ANY_STATE);
  for (int i = 0; i < count; ++i) {
    if (!closed_ && infos[i].valid_data && callbacks_.on_sample) {
      SampleInfo info = InfoOf(EndpointId(infos[i].publication_handle));
      info.written_ns = std::max<dds_time_t>(infos[i].source_timestamp, 0);
      callbacks_.on_sample(BytesOf(samples[i]), info);
    }
    ddsi_serdata_unref(samples[i]);
  }
  return count == kSamplesPerVisit;
}

// Adds newly matched writers; returns the writers that are no longer matched.
std::vector<EndpointId> ReaderCore::LearnWriters() {
  const std::vector<EndpointId> matched =
      MatchedHandles(reader_.get(), dds_get_matched_publications);
  for (const EndpointId writer : matched) {
    if (!writers_.Contains(writer)) writers_.Add(writer, LearnWriter(writer));
  }
  std::vector<EndpointId> lost = writers_.Endpoints();
  std::erase_if(lost, [&](EndpointId writer) {
    return std::find(matched.begin(), matched.end(), writer) != matched.end();
  });
  return lost;
}

// Compares its type with ours.
ParticipantId ReaderCore::LearnWriter(EndpointId writer) const {
  const MatchedEndpoint matched =
      Describe(dds_get_matched_publication_data(reader_.get(), writer.value()));
  const std::string hash = OtherHash(matched.user_data, type_tag_);
  if (!hash.empty() && callbacks_.on_type_differs) {
    callbacks_.on_type_differs(matched.participant, hash);
  }
  return matched.participant;
}

ParticipantId ReaderCore::ParticipantOf(EndpointId writer) const {
  const ParticipantId known = writers_.ParticipantOf(writer);
  if (known != 0) return known;
  return ParticipantIn(dds_get_matched_publication_data(reader_.get(), writer.value()));
}

SampleInfo ReaderCore::InfoOf(EndpointId writer) {
  SampleInfo info{writer, ParticipantOf(writer)};
  if (!all_partitions_) return info;
  auto known = partitions_.find(writer);
  if (known == partitions_.end()) {
    const std::string partition =
        PartitionIn(dds_get_matched_publication_data(reader_.get(), writer.value()));
    known = partitions_.emplace(writer, partition).first;
  }
  info.partition = known->second;
  return info;
}

}  // namespace musher::transport::dds
