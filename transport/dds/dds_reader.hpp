#pragma once
// A RawReader on Cyclone.

#include <dds/dds.h>

#include <atomic>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "musher/transport/dds/entity.hpp"
#include "musher/transport/dds/node_graph.hpp"
#include "musher/transport/dds/notifier.hpp"
#include "musher/transport/dds/qos.hpp"
#include "musher/transport/endpoint.hpp"
#include "musher/transport/peer_table.hpp"

namespace musher::transport::dds {

// The state that a reader's callbacks use. Shared with a running visit, so that a callback may
// destroy the reader.
class ReaderCore : public Notifier {
 public:
  // `all_partitions`: each sample is delivered with the partition that it was written in.
  // `type_tag`: TypeTag() of the type; empty: the tags of writers are not compared.
  ReaderCore(EventLoop& loop, ReaderCallbacks callbacks, bool all_partitions, std::string type_tag)
      : Notifier(loop),
        callbacks_(std::move(callbacks)),
        all_partitions_(all_partitions),
        type_tag_(std::move(type_tag)) {}

  Result<> Open(dds_entity_t participant, Entity topic, const QosPtr& qos);
  // No callback runs afterwards, also if a callback calls it.
  void Close();

  const PeerTable& writers() const { return writers_; }
  dds_entity_t entity() const { return reader_.get(); }

 private:
  static void OnDataAvailable(dds_entity_t reader, void* self);
  static void OnMatched(dds_entity_t reader, dds_subscription_matched_status_t status, void* self);
  static void OnSampleLost(dds_entity_t reader, dds_sample_lost_status_t status, void* self);

  void Visit() override;
  bool Take();
  std::vector<EndpointId> LearnWriters();
  ParticipantId LearnWriter(EndpointId writer) const;
  ParticipantId ParticipantOf(EndpointId writer) const;
  SampleInfo InfoOf(EndpointId writer);

  ReaderCallbacks callbacks_;
  const bool all_partitions_;
  const std::string type_tag_;
  std::atomic<bool> match_changed_ = false;
  bool closed_ = false;
  PeerTable writers_;
  std::map<EndpointId, std::string> partitions_;  // of writers, if requested
  Entity topic_;
  Entity reader_;
};

class DdsReader : public RawReader {
 public:
  DdsReader(std::shared_ptr<ReaderCore> core, ListedNode& node)
      : core_(std::move(core)), listed_(node, NodeGraph::Kind::kReader, core_->entity()) {}
  DdsReader(const DdsReader&) = delete;
  DdsReader& operator=(const DdsReader&) = delete;
  ~DdsReader() override { core_->Close(); }

  int MatchedWriters() const override { return core_->writers().size(); }
  int WritersOf(ParticipantId participant) const override {
    return core_->writers().CountOf(participant);
  }
  std::vector<ParticipantId> WriterParticipants() const override {
    return core_->writers().Participants();
  }

 private:
  std::shared_ptr<ReaderCore> core_;
  ListedEndpoint listed_;
};

}  // namespace musher::transport::dds
