#pragma once
// Finds out that several publishers of a topic are received in turn, where one is expected: a
// reader that believes all of them acts on two cameras, or on two robots. A publisher that was
// restarted is another one, and the one before it is never received again. Pure.

#include <vector>

#include "musher/transport/endpoint.hpp"

namespace musher::transport {

class PublisherTurns {
 public:
  // With each sample: whether its publisher is received again after another one.
  bool Note(EndpointId publisher) {
    if (!known_.empty() && known_.back() == publisher) return false;
    const bool again = std::erase(known_, publisher) > 0;
    known_.push_back(publisher);
    return again;
  }

 private:
  std::vector<EndpointId> known_;  // the newest is the last
};

}  // namespace musher::transport
