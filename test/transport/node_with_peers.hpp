#pragma once

#include <vector>

#include "musher/test/transport/wrapped_node.hpp"

namespace musher::testing {

// A node of the simulation with participants that a test chooses.
class NodeWithPeers : public WrappedNode {
 public:
  using WrappedNode::WrappedNode;

  std::vector<transport::PeerInfo> Peers() const override { return peers; }

  std::vector<transport::PeerInfo> peers;
};

}  // namespace musher::testing
