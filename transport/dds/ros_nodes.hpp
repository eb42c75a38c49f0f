#pragma once
// The nodes of ROS 2 by their endpoints, as each process publishes them on `ros_discovery_info`:
// DDS itself knows only processes, and a process may have many nodes.
//
// Threads: loop thread only.

#include <functional>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "musher/messages/cdr.hpp"
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
  // several, separated by ", ", with "a node that is not known" for those of several clients whose
  // node is not published. Of one such client, or none, Node::RosNodeOf().
  std::string CallersOf(const std::string& service, ParticipantId participant) const;
  // Calls `then` once, on the loop, as soon as CallersOf() knows these, at the latest kKnownWithin
  // after the first such call for `participant`. Returns false, and does not call it, if that time
  // is over, or if too many wait.
  bool WhenKnown(const std::string& service, ParticipantId participant,
                 std::function<void()> then) const;

  // From a request to the list of nodes of its process, which may be discovered later.
  static constexpr Duration kKnownWithin = Milliseconds(1000);

 private:
  using Nodes = std::map<EndpointId, std::string>;  // by their endpoints
  // Every process of ROS 2 publishes its nodes at each change, and few are asked for: a sample is
  // decoded when one is.
  struct Process {
    std::optional<msg::Bytes> newest;  // not yet decoded
    Nodes nodes;
  };
  struct Waiting {
    std::string service;
    ParticipantId participant = 0;
    std::function<void()> then;
    LoopHandlePtr until;
  };
  void Keep(std::span<const std::byte> bytes, EndpointId process);
  void CallKnown() const;
  static const Nodes& NodesIn(Process& process);

  Node& node_;
  mutable std::map<EndpointId, Process> processes_;  // by their writers of the topic
  mutable std::list<Waiting> waiting_;
  mutable std::map<ParticipantId, Time> first_waited_;  // of those that were waited for
  std::unique_ptr<RawReader> reader_;
};

}  // namespace musher::transport
