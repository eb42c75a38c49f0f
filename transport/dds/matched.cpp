#include "musher/transport/dds/matched.hpp"

#include <cstddef>

#include "musher/transport/dds/peers.hpp"

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

MatchedEndpoint Describe(dds_builtintopic_endpoint_t* endpoint) {
  if (endpoint == nullptr) return {};
  MatchedEndpoint matched;
  // Not the instance handle of the participant: the handle changes when the participant returns
  // after an outage longer than its lease, and an actuator that obeys it would refuse it.
  matched.participant = IdOfParticipant(endpoint->participant_key);
  void* data = nullptr;
  std::size_t size = 0;
  if (dds_qget_userdata(endpoint->qos, &data, &size) && data != nullptr) {
    matched.user_data.assign(static_cast<const char*>(data), size);
  }
  dds_free(data);
  dds_builtintopic_free_endpoint(endpoint);
  return matched;
}

ParticipantId ParticipantIn(dds_builtintopic_endpoint_t* endpoint) {
  return Describe(endpoint).participant;
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
