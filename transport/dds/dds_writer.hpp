#pragma once
// A RawWriter on Cyclone.

#include <dds/dds.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "musher/transport/dds/entity.hpp"
#include "musher/transport/dds/first_replies.hpp"
#include "musher/transport/dds/node_graph.hpp"
#include "musher/transport/dds/notifier.hpp"
#include "musher/transport/dds/qos.hpp"
#include "musher/transport/endpoint.hpp"
#include "musher/transport/peer_table.hpp"

namespace musher::transport::dds {

// The state that a writer's callback uses. Shared with a running visit, so that the callback may
// destroy the writer.
class WriterCore : public Notifier {
 public:
  // The type of a matched reader has the name of the topic's type, and another definition.
  using OnTypeDiffers =
      std::function<void(ParticipantId participant, const std::string& type_hash)>;

  // `type_tag`: TypeTag() of the type; empty: the tags of readers are not compared.
  WriterCore(EventLoop& loop, std::string topic_name, WriterCallbacks callbacks,
             std::string type_tag, OnTypeDiffers on_type_differs);

  Result<> Open(dds_entity_t participant, Entity topic, const QosPtr& qos);
  // No callback runs afterwards, also if a callback calls it.
  void Close();

  // `participant`: only its readers need the sample; 0: all do.
  Result<> Write(msg::Bytes bytes, ParticipantId participant = 0);
  void AfterWrites(std::function<void()> work);
  Result<> Flush(Duration timeout);
  const PeerTable& readers() const { return readers_; }
  std::uint64_t id() const { return id_; }
  dds_entity_t entity() const { return writer_.get(); }

 private:
  static void OnMatched(dds_entity_t writer, dds_publication_matched_status_t status, void* self);

  void Visit() override;
  Result<> Send(msg::Bytes bytes);

  std::string topic_name_;
  WriterCallbacks callbacks_;
  const std::string type_tag_;
  const OnTypeDiffers on_type_differs_;
  bool closed_ = false;
  PeerTable readers_;
  std::optional<FirstReplies> first_replies_;  // of a writer of replies
  dds_instance_handle_t id_ = 0;
  Entity topic_;
  Entity writer_;
};

class DdsWriter : public RawWriter {
 public:
  DdsWriter(std::shared_ptr<WriterCore> core, ListedNode& node)
      : core_(std::move(core)), listed_(node, NodeGraph::Kind::kWriter, core_->entity()) {}
  DdsWriter(const DdsWriter&) = delete;
  DdsWriter& operator=(const DdsWriter&) = delete;
  ~DdsWriter() override { core_->Close(); }

  Result<> Write(msg::Bytes bytes) override { return core_->Write(std::move(bytes)); }
  Result<> WriteFor(ParticipantId participant, msg::Bytes bytes) override {
    return core_->Write(std::move(bytes), participant);
  }
  void AfterWrites(std::function<void()> work) override { core_->AfterWrites(std::move(work)); }
  Result<> Flush(Duration timeout) override { return core_->Flush(timeout); }
  int MatchedReaders() const override { return core_->readers().size(); }
  int ReadersOf(ParticipantId participant) const override {
    return core_->readers().CountOf(participant);
  }
  std::uint64_t UniqueId() const override { return core_->id(); }

 private:
  std::shared_ptr<WriterCore> core_;
  ListedEndpoint listed_;
};

}  // namespace musher::transport::dds
