#pragma once
// Which nodes a participant has and which endpoints are theirs, in the form of ROS 2: one latched
// sample of the whole participant on `ros_discovery_info`. With it `ros2 node list`, `ros2 node
// info` and rqt's graph show the processes of Musher by name.
//
//   NodeGraph (a participant) <-- ListedNode (a node) <-- ListedEndpoint (an endpoint)
//
// The changes of one turn of the loop are one sample. If permissions forbid the topic (keys made by
// an older Musher), no sample is written and everything else works.
//
// Threads: any; a sample is written on the loop of a node that has changed.

#include <dds/dds.h>

#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "musher/base/network_profile.hpp"
#include "musher/messages/rmw_dds_common/participant_entities.hpp"
#include "musher/transport/dds/entity.hpp"
#include "musher/transport/dds/notifier.hpp"

namespace musher::transport::dds {

// The GUID of a participant or an endpoint as ROS 2 writes it.
msg::Gid EntityGid(dds_entity_t entity);

class NodeGraph {
 public:
  // `distro`: the distribution whose layout the sample has.
  NodeGraph(dds_entity_t participant, RosDistro distro);

  // Whether the topic is written; permissions may forbid it.
  bool open() const { return writer_.get() > 0; }

  enum class Kind { kReader, kWriter };

  // Called by the nodes. Publish() writes the sample if it differs from the last one.
  using Nodes = std::list<msg::NodeEntitiesInfo>;
  Nodes::iterator Add(const std::string& name_space, const std::string& name);
  void Remove(Nodes::iterator node);
  void Add(Nodes::iterator node, Kind kind, const msg::Gid& endpoint);
  void Remove(Nodes::iterator node, Kind kind, const msg::Gid& endpoint);
  void Publish();

 private:
  const msg::Gid participant_;
  const RosDistro distro_;
  std::mutex mutex_;  // guards the members below
  Nodes nodes_;
  bool changed_ = false;
  Entity topic_;
  Entity writer_;  // none where permissions forbid it
};

// A node in the graph for as long as it exists.
class ListedNode : public Notifier {
 public:
  ListedNode(EventLoop& loop, NodeGraph& graph, const std::string& name_space,
             const std::string& name)
      : Notifier(loop), graph_(graph), node_(graph.Add(name_space, name)) {}
  ListedNode(const ListedNode&) = delete;
  ListedNode& operator=(const ListedNode&) = delete;
  ~ListedNode() override {
    graph_.Remove(node_);
    graph_.Publish();
  }

  void Add(NodeGraph::Kind kind, const msg::Gid& endpoint) {
    graph_.Add(node_, kind, endpoint);
    Notify();
  }
  void Remove(NodeGraph::Kind kind, const msg::Gid& endpoint) {
    graph_.Remove(node_, kind, endpoint);
    Notify();
  }

 private:
  void Visit() override { graph_.Publish(); }

  NodeGraph& graph_;
  const NodeGraph::Nodes::iterator node_;
};

// An endpoint of a node for as long as it exists; the node outlives it.
class ListedEndpoint {
 public:
  ListedEndpoint(ListedNode& node, NodeGraph::Kind kind, dds_entity_t endpoint)
      : node_(node), kind_(kind), gid_(EntityGid(endpoint)) {
    node_.Add(kind_, gid_);
  }
  ListedEndpoint(const ListedEndpoint&) = delete;
  ListedEndpoint& operator=(const ListedEndpoint&) = delete;
  ~ListedEndpoint() { node_.Remove(kind_, gid_); }

 private:
  ListedNode& node_;
  const NodeGraph::Kind kind_;
  const msg::Gid gid_;
};

// A name that ROS 2 accepts for a node: letters, digits and '_', not beginning with a digit.
std::string NodeNameFrom(std::string_view name);

// The namespace "dog1" as ROS 2 writes it: "/dog1"; "" is "/".
std::string NamespaceFrom(std::string_view name_space);

}  // namespace musher::transport::dds
