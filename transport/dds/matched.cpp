#include "musher/transport/dds/matched.hpp"

namespace musher::transport::dds {

std::vector<PeerId> MatchedHandles(dds_entity_t entity, GetMatched get) {
  std::vector<dds_instance_handle_t> handles(16);
  for (;;) {
    const dds_return_t count = get(entity, handles.data(), handles.size());
    if (count < 0) return {};
    const bool all = static_cast<std::size_t>(count) <= handles.size();
    handles.resize(static_cast<std::size_t>(count));
    if (all) return {handles.begin(), handles.end()};
  }
}

PeerId ParticipantIn(dds_builtintopic_endpoint_t* endpoint) {
  if (endpoint == nullptr) return 0;
  const PeerId participant = endpoint->participant_instance_handle;
  dds_builtintopic_free_endpoint(endpoint);
  return participant;
}

}  // namespace musher::transport::dds
