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
  // The nodes of `participant` with a client of `service` ("dog1/musher/set_state"), separated by
  // ", ". If one of several clients has no published node, "a node that is not known" stands for
  // it. If the only client has none, or there is no client: Node::RosNodeOf().
  std::string CallersOf(const std::string& service, ParticipantId participant) const;
  // Calls `then` once, on the loop, as soon as CallersOf() knows the nodes, at the latest
  // kKnownWithin after the first such call for `participant`. If that time is over, or too many
  // calls wait, returns false and does not call `then`.
  bool WhenKnown(const std::string& service, ParticipantId participant,
                 std::function<void()> then) const;

  // How long after a request the list of the nodes of its process may be discovered.
  static constexpr Duration kKnownWithin = Milliseconds(1000);

 private:
  using Nodes = std::map<EndpointId, std::string>;  // by their endpoints
  // Every ROS 2 process publishes its nodes at each change, and few of them are looked up: a sample
  // is decoded when its nodes are.
  struct Process {
    std::optional<msg::Bytes> newest;  // not yet decoded
    Nodes nodes;
  };
  struct WaitingCall {
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
  mutable std::list<WaitingCall> waiting_;
  mutable std::map<ParticipantId, Time> first_waited_;  // of those that were waited for
  std::unique_ptr<RawReader> reader_;
};

}  // namespace musher::transport
