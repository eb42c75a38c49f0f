#pragma once
// The nodes of ROS 2 by their endpoints, as each process publishes them on `ros_discovery_info`:
// DDS itself knows only processes, and a process may have many nodes.
//
// Threads: loop thread only.

#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "musher/transport/node.hpp"

namespace musher::transport {

class RosNodes {
 public:
  // `node` must outlive it. Where that is not one of MakeDdsNode, or permissions forbid the topic,
  // no node is known.
  explicit RosNodes(Node& node);
  RosNodes(const RosNodes&) = delete;
  RosNodes& operator=(const RosNodes&) = delete;

  // "/dog1/planner"; empty: not known.
  std::string NodeOf(EndpointId endpoint) const;
  // The nodes of `participant` with a client of `service` ("dog1/musher/set_state"): one, or
  // several, separated by ", ". If their process has not published them, Node::RosNodeOf().
  std::string CallersOf(const std::string& service, ParticipantId participant) const;

 private:
  using Nodes = std::map<EndpointId, std::string>;  // by their endpoints
  void Read(std::span<const std::byte> bytes, EndpointId process);

  Node& node_;
  std::map<EndpointId, Nodes> nodes_;  // of each process, by its writer of the topic
  std::unique_ptr<RawReader> reader_;
};

}  // namespace musher::transport
