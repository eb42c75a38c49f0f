#pragma once
// Cyclone's data about the endpoints that a local endpoint is matched with.

#include <dds/dds.h>

#include <memory>
#include <string>
#include <vector>

#include "musher/transport/endpoint.hpp"

namespace musher::transport::dds {

struct ListenerDeleter {
  void operator()(dds_listener_t* listener) const { dds_delete_listener(listener); }
};
using ListenerPtr = std::unique_ptr<dds_listener_t, ListenerDeleter>;

// `get` is dds_get_matched_subscriptions or dds_get_matched_publications.
using GetMatched = dds_return_t (*)(dds_entity_t, dds_instance_handle_t*, std::size_t);
std::vector<EndpointId> MatchedHandles(dds_entity_t entity, GetMatched get);

// The id of the participant with that GUID.
ParticipantId ParticipantWith(const dds_guid_t& guid);

// The participant of an endpoint from `get`, which is freed; 0 if it was lost meanwhile.
ParticipantId ParticipantIn(dds_builtintopic_endpoint_t* endpoint);

// The partition of such an endpoint, likewise; empty if it has none, or more than one.
std::string PartitionIn(dds_builtintopic_endpoint_t* endpoint);

}  // namespace musher::transport::dds
