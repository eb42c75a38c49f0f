#include "musher/transport/dds/dds_writer.hpp"

#include <cstddef>
#include <utility>

#include "musher/transport/dds/matched.hpp"
#include "musher/transport/dds/raw_type.hpp"
#include "musher/transport/dds/type_tag.hpp"

namespace musher::transport::dds {

WriterCore::WriterCore(EventLoop& loop, std::string topic_name, WriterCallbacks callbacks,
                       std::string type_tag, OnTypeDiffers on_type_differs)
    : Notifier(loop),
      topic_name_(std::move(topic_name)),
      callbacks_(std::move(callbacks)),
      type_tag_(std::move(type_tag)),
      on_type_differs_(std::move(on_type_differs)) {
  if (!topic_name_.starts_with("rr/")) return;
  first_replies_.emplace(loop, [this](msg::Bytes reply) { return Send(std::move(reply)); });
}

Result<> WriterCore::Open(dds_entity_t participant, Entity topic, const QosPtr& qos) {
  topic_ = std::move(topic);
  const ListenerPtr listener(dds_create_listener(this));
  dds_lset_publication_matched(listener.get(), OnMatched);
  const dds_entity_t writer =
      dds_create_writer(participant, topic_.get(), qos.get(), listener.get());
  if (writer < 0) return DdsError("dds_create_writer", writer);
  writer_ = Entity(writer);
  dds_get_instance_handle(writer, &id_);
  return Ok();
}

void WriterCore::Close() {
  loop().CheckThread();
  closed_ = true;
  if (first_replies_) first_replies_->Release();
  first_replies_.reset();
  writer_.Delete();
  topic_.Delete();
}

Result<> WriterCore::Write(msg::Bytes bytes, ParticipantId participant) {
  loop().CheckThread();
  constexpr std::size_t kEncapsulationHeader = 4;
  if (bytes.size() < kEncapsulationHeader) {
    return Error{kCodeParametersInvalid, topic_name_ + ": no encapsulation header"};
  }
  return first_replies_ ? first_replies_->Write(std::move(bytes), participant)
                        : Send(std::move(bytes));
}

Result<> WriterCore::Send(msg::Bytes bytes) {
  const RawSample sample{bytes};
  const dds_return_t result = dds_write(writer_.get(), &sample);
  if (result != DDS_RETCODE_OK) return DdsError(topic_name_ + ": cannot write", result);
  return Ok();
}

void WriterCore::AfterWrites(std::function<void()> work) {
  if (first_replies_) return first_replies_->AfterHeld(std::move(work));
  work();
}

Result<> WriterCore::Flush(Duration timeout) {
  if (first_replies_) first_replies_->Release();
  const dds_return_t result = dds_wait_for_acks(writer_.get(), timeout.count());
  if (result == DDS_RETCODE_TIMEOUT) {
    return Error{kCodeTimeout, topic_name_ + ": a reader has not got all that was written"};
  }
  if (result != DDS_RETCODE_OK) return DdsError(topic_name_ + ": cannot wait for readers", result);
  return Ok();
}

void WriterCore::OnMatched(dds_entity_t, dds_publication_matched_status_t, void* self) {
  static_cast<WriterCore*>(self)->Notify();
}

void WriterCore::Visit() {
  if (closed_) return;
  PeerTable readers;
  for (const EndpointId reader : MatchedHandles(writer_.get(), dds_get_matched_subscriptions)) {
    ParticipantId participant = readers_.ParticipantOf(reader);
    if (participant == 0) {
      const MatchedEndpoint matched =
          Describe(dds_get_matched_subscription_data(writer_.get(), reader.value()));
      participant = matched.participant;
      // A client that is not of Musher.
      const bool foreign = participant != 0 && !matched.user_data.ends_with(kOwnTag);
      if (first_replies_ && foreign) first_replies_->OnNewReader(participant);
      const std::string hash = OtherHash(matched.user_data, type_tag_);
      if (!hash.empty()) on_type_differs_(participant, hash);
      if (closed_) return;
    }
    readers.Add(reader, participant);
  }
  readers_ = std::move(readers);
  if (callbacks_.on_match_changed) callbacks_.on_match_changed();
}

}  // namespace musher::transport::dds
