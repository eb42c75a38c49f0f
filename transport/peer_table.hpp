#pragma once
// The matched endpoints of a writer or reader and the participants they belong to. A handful of
// entries, so a plain list in the order they were matched.

#include <vector>

#include "musher/transport/endpoint.hpp"

namespace musher::transport {

class PeerTable {
 public:
  void Add(PeerId endpoint, PeerId participant);
  // Returns whether the endpoint was in the table.
  bool Remove(PeerId endpoint);

  bool Contains(PeerId endpoint) const;
  // 0 for an endpoint that is not matched.
  PeerId ParticipantOf(PeerId endpoint) const;
  int size() const { return static_cast<int>(peers_.size()); }
  int CountOf(PeerId participant) const;
  std::vector<PeerId> Endpoints() const;
  std::vector<PeerId> Participants() const;

 private:
  struct Peer {
    PeerId endpoint;
    PeerId participant;
  };
  std::vector<Peer> peers_;
};

}  // namespace musher::transport
