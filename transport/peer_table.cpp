#include "musher/transport/peer_table.hpp"

#include <algorithm>

namespace musher::transport {

void PeerTable::Add(PeerId endpoint, PeerId participant) {
  if (!Contains(endpoint)) peers_.push_back({endpoint, participant});
}

bool PeerTable::Remove(PeerId endpoint) {
  return std::erase_if(peers_, [&](const Peer& peer) { return peer.endpoint == endpoint; }) > 0;
}

bool PeerTable::Contains(PeerId endpoint) const {
  return std::any_of(peers_.begin(), peers_.end(),
                     [&](const Peer& peer) { return peer.endpoint == endpoint; });
}

PeerId PeerTable::ParticipantOf(PeerId endpoint) const {
  const auto found = std::find_if(peers_.begin(), peers_.end(),
                                  [&](const Peer& peer) { return peer.endpoint == endpoint; });
  return found == peers_.end() ? 0 : found->participant;
}

int PeerTable::CountOf(PeerId participant) const {
  return static_cast<int>(std::count_if(peers_.begin(), peers_.end(), [&](const Peer& peer) {
    return peer.participant == participant;
  }));
}

std::vector<PeerId> PeerTable::Endpoints() const {
  std::vector<PeerId> endpoints;
  endpoints.reserve(peers_.size());
  for (const Peer& peer : peers_) endpoints.push_back(peer.endpoint);
  return endpoints;
}

std::vector<PeerId> PeerTable::Participants() const {
  std::vector<PeerId> participants;
  for (const Peer& peer : peers_) {
    if (std::find(participants.begin(), participants.end(), peer.participant) ==
        participants.end()) {
      participants.push_back(peer.participant);
    }
  }
  return participants;
}

}  // namespace musher::transport
