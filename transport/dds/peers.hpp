#pragma once
// What discovery knows now of the other participants of a domain, by DDS's builtin topics. Each
// call reads these topics as a whole: for rare events, not for every sample.
//
// Threads: any.

#include <dds/dds.h>

#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "musher/transport/endpoint.hpp"

namespace musher::transport::dds {

// In the user data of a participant, before its name and ";".
inline constexpr std::string_view kNameKey = "musher=";

ParticipantId IdOfParticipant(const dds_guid_t& guid);

// The participants but `own`.
std::vector<PeerInfo> PeersOf(dds_entity_t own);

// The nodes of `participant` that offer a service of every ROS 2 node, as ListOf(); empty: none.
std::string RosNodeOf(dds_entity_t own, ParticipantId participant);

// The writers of `participant` on `topic`, "rq/planner/get_stateRequest".
std::vector<EndpointId> WritersOf(dds_entity_t own, ParticipantId participant,
                                  const std::string& topic);

// "/amcl, /planner"; of many the first ones, and how many more.
std::string ListOf(const std::set<std::string>& names);

}  // namespace musher::transport::dds
