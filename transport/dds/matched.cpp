#include "musher/transport/dds/matched.hpp"

#include "musher/base/checksum.hpp"

namespace musher::transport::dds {

std::vector<EndpointId> MatchedHandles(dds_entity_t entity, GetMatched get) {
  std::vector<dds_instance_handle_t> handles(16);
  for (;;) {
    const dds_return_t count = get(entity, handles.data(), handles.size());
    if (count < 0) return {};
    const bool all = static_cast<std::size_t>(count) <= handles.size();
    handles.resize(static_cast<std::size_t>(count));
    if (all) return {handles.begin(), handles.end()};
  }
}

ParticipantId ParticipantWith(const dds_guid_t& guid) {
  return ParticipantId(Fnv1a({reinterpret_cast<const char*>(&guid.v), sizeof(guid.v)}) |
                       1U);  // not 0, which means none
}

ParticipantId ParticipantIn(dds_builtintopic_endpoint_t* endpoint) {
  if (endpoint == nullptr) return 0;
  // Not its instance handle: that changes when a participant returns after an outage longer than
  // its lease, and an actuator that is attached to one participant would refuse it.
  const ParticipantId participant = ParticipantWith(endpoint->participant_key);
  dds_builtintopic_free_endpoint(endpoint);
  return participant;
}

std::string PartitionIn(dds_builtintopic_endpoint_t* endpoint) {
  if (endpoint == nullptr) return {};
  std::uint32_t count = 0;
  char** names = nullptr;
  std::string partition;
  if (dds_qget_partition(endpoint->qos, &count, &names)) {
    if (count == 1) partition = names[0];
    for (std::uint32_t i = 0; i < count; ++i) dds_free(names[i]);
    dds_free(names);
  }
  dds_builtintopic_free_endpoint(endpoint);
  return partition;
}

}  // namespace musher::transport::dds
