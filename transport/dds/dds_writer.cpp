#include "musher/transport/dds/dds_writer.hpp"

#include "musher/transport/dds/matched.hpp"
#include "musher/transport/dds/raw_type.hpp"

namespace musher::transport::dds {

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
  closed_ = true;
  writer_.Delete();
  topic_.Delete();
}

Result<> WriterCore::Write(msg::Bytes bytes) {
  constexpr std::size_t kEncapsulationHeader = 4;
  if (bytes.size() < kEncapsulationHeader) {
    return Error{kCodeParametersInvalid, topic_name_ + ": no encapsulation header"};
  }
  const RawSample sample{bytes};
  const dds_return_t result = dds_write(writer_.get(), &sample);
  if (result != DDS_RETCODE_OK) return DdsError(topic_name_ + ": cannot write", result);
  return Ok();
}

Result<> WriterCore::Flush(Duration timeout) {
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
  for (const PeerId reader : MatchedHandles(writer_.get(), dds_get_matched_subscriptions)) {
    const PeerId known = readers_.ParticipantOf(reader);
    readers.Add(reader, known != 0 ? known
                                   : ParticipantIn(
                                         dds_get_matched_subscription_data(writer_.get(), reader)));
  }
  readers_ = std::move(readers);
  if (callbacks_.on_match_changed) callbacks_.on_match_changed();
}

}  // namespace musher::transport::dds
