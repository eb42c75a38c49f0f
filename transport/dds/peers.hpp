#pragma once
// What discovery knows now of the other participants of a domain, by DDS's builtin topics. Each
// call reads these topics as a whole: for rare events, not for every sample.
//
// Threads: any.

#include <dds/dds.h>

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

// The shortest name of a node of `participant` that offers a service of every ROS 2 node; empty:
// none.
std::string RosNodeOf(dds_entity_t own, ParticipantId participant);

}  // namespace musher::transport::dds
