#include "musher/transport/peer_table.hpp"

#include <algorithm>

namespace musher::transport {

void PeerTable::Add(EndpointId endpoint, ParticipantId participant) {
  if (!Contains(endpoint)) peers_.push_back({endpoint, participant});
}

bool PeerTable::Remove(EndpointId endpoint) {
  return std::erase_if(peers_, [&](const Peer& peer) { return peer.endpoint == endpoint; }) > 0;
}

bool PeerTable::Contains(EndpointId endpoint) const {
  return std::any_of(peers_.begin(), peers_.end(),
                     [&](const Peer& peer) { return peer.endpoint == endpoint; });
}

ParticipantId PeerTable::ParticipantOf(EndpointId endpoint) const {
  const auto found = std::find_if(peers_.begin(), peers_.end(),
                                  [&](const Peer& peer) { return peer.endpoint == endpoint; });
  return found == peers_.end() ? 0 : found->participant;
}

int PeerTable::CountOf(ParticipantId participant) const {
  return static_cast<int>(std::count_if(peers_.begin(), peers_.end(), [&](const Peer& peer) {
    return peer.participant == participant;
  }));
}

std::vector<EndpointId> PeerTable::Endpoints() const {
  std::vector<EndpointId> endpoints;
  endpoints.reserve(peers_.size());
  for (const Peer& peer : peers_) endpoints.push_back(peer.endpoint);
  return endpoints;
}

std::vector<ParticipantId> PeerTable::Participants() const {
  std::vector<ParticipantId> participants;
  for (const Peer& peer : peers_) {
    if (std::find(participants.begin(), participants.end(), peer.participant) ==
        participants.end()) {
      participants.push_back(peer.participant);
    }
  }
  return participants;
}

}  // namespace musher::transport
