#pragma once
// Opens the domain of a process and joins it.

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "musher/base/result.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/dds/entity.hpp"
#include "musher/transport/dds/node_graph.hpp"

namespace musher::transport::dds {

// This process's participant in a domain, for all its nodes; it is destroyed with the last of them:
// Cyclone 0.10 may miss endpoints of a process that it discovers while another participant of this
// process is being destroyed (eclipse-cyclonedds/cyclonedds#1874).
class Participant {
 public:
  Participant(Entity domain, Entity participant, std::optional<Credentials> credentials,
              RosDistro distro)
      : domain_(std::move(domain)),
        participant_(std::move(participant)),
        id_(IdOf(participant_.get())),
        credentials_(std::move(credentials)),
        graph_(participant_.get(), distro) {}

  dds_entity_t get() const { return participant_.get(); }
  ParticipantId id() const { return id_; }
  const std::optional<Credentials>& credentials() const { return credentials_; }

  // The nodes as ROS 2 lists them.
  NodeGraph& graph() { return graph_; }

  // A number for each node, from any thread.
  int NextNode() { return next_node_++; }

 private:
  static ParticipantId IdOf(dds_entity_t participant);

  Entity domain_;  // its configuration; none if the user provides it
  Entity participant_;
  const ParticipantId id_;
  const std::optional<Credentials> credentials_;
  NodeGraph graph_;
  std::atomic<int> next_node_ = 0;
};

// Fails with Cyclone's own message. `settings`: Cyclone's XML; empty: what CYCLONEDDS_URI names.
// `distro`: the layout of ros_discovery_info. `name`: see PeerInfo. The first node of the process
// in this domain determines all three. From any thread.
Result<std::shared_ptr<Participant>> OpenParticipant(int domain_id, const std::string& settings,
                                                     const std::optional<Credentials>& credentials,
                                                     RosDistro distro, const std::string& name);

// The participant of a node from MakeDdsNode; null for a node of another transport.
Participant* ParticipantOf(Node& node);

}  // namespace musher::transport::dds
