#pragma once
// The matched endpoints of a writer or reader and the participants they belong to. A handful of
// entries, so a plain list in the order they were matched.

#include <vector>

#include "musher/transport/endpoint.hpp"

namespace musher::transport {

class PeerTable {
 public:
  void Add(EndpointId endpoint, ParticipantId participant);
  // Returns whether the endpoint was in the table.
  bool Remove(EndpointId endpoint);

  bool Contains(EndpointId endpoint) const;
  // 0 for an endpoint that is not matched.
  ParticipantId ParticipantOf(EndpointId endpoint) const;
  int size() const { return static_cast<int>(peers_.size()); }
  int CountOf(ParticipantId participant) const;
  std::vector<EndpointId> Endpoints() const;
  std::vector<ParticipantId> Participants() const;

 private:
  struct Peer {
    EndpointId endpoint;
    ParticipantId participant;
  };
  std::vector<Peer> peers_;
};

}  // namespace musher::transport
