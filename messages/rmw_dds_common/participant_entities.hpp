#pragma once
// By which ROS 2's nodes are listed (`ros2 node list`): topic `ros_discovery_info`, without "rt/".
// Field comments: messages/idl/rmw_dds_common.idl.

#include <algorithm>

#include "musher/messages/cdr.hpp"

namespace musher::msg {

// rmw_dds_common/msg/Gid. The layout depends on the ROS 2 distribution: 16 bytes since Iron, 24 in
// Galactic and Humble, where the last eight are 0.
template <std::size_t kBytes>
struct GidOf {
  static constexpr std::string_view kTypeName = "rmw_dds_common::msg::dds_::Gid_";
  std::array<std::uint8_t, kBytes> data{};

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.data);
  }
  friend auto operator<=>(const GidOf&, const GidOf&) = default;
};

// rmw_dds_common/msg/NodeEntitiesInfo: a node and its endpoints.
template <std::size_t kBytes>
struct NodeEntitiesInfoOf {
  static constexpr std::string_view kTypeName = "rmw_dds_common::msg::dds_::NodeEntitiesInfo_";
  std::string node_namespace;
  std::string node_name;
  std::vector<GidOf<kBytes>> reader_gid_seq;
  std::vector<GidOf<kBytes>> writer_gid_seq;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.node_namespace, m.node_name, m.reader_gid_seq, m.writer_gid_seq);
  }
  friend bool operator==(const NodeEntitiesInfoOf&, const NodeEntitiesInfoOf&) = default;
};

// rmw_dds_common/msg/ParticipantEntitiesInfo: all nodes of a participant.
template <std::size_t kBytes>
struct ParticipantEntitiesInfoOf {
  static constexpr std::string_view kTypeName =
      "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_";
  GidOf<kBytes> gid;
  std::vector<NodeEntitiesInfoOf<kBytes>> node_entities_info_seq;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.gid, m.node_entities_info_seq);
  }
  friend bool operator==(const ParticipantEntitiesInfoOf&,
                         const ParticipantEntitiesInfoOf&) = default;
};

using Gid = GidOf<16>;
using NodeEntitiesInfo = NodeEntitiesInfoOf<16>;
using ParticipantEntitiesInfo = ParticipantEntitiesInfoOf<16>;

// The same in the layout of ROS 2 Galactic and Humble.
using GidBeforeIron = GidOf<24>;
using ParticipantEntitiesInfoBeforeIron = ParticipantEntitiesInfoOf<24>;

inline GidBeforeIron BeforeIron(const Gid& gid) {
  GidBeforeIron older;
  std::copy(gid.data.begin(), gid.data.end(), older.data.begin());
  return older;
}

inline ParticipantEntitiesInfoBeforeIron BeforeIron(const ParticipantEntitiesInfo& info) {
  const auto all = [](const std::vector<Gid>& gids) {
    std::vector<GidBeforeIron> older;
    older.reserve(gids.size());
    for (const Gid& gid : gids) older.push_back(BeforeIron(gid));
    return older;
  };
  ParticipantEntitiesInfoBeforeIron older{BeforeIron(info.gid), {}};
  older.node_entities_info_seq.reserve(info.node_entities_info_seq.size());
  for (const NodeEntitiesInfo& node : info.node_entities_info_seq) {
    older.node_entities_info_seq.push_back(
        {node.node_namespace, node.node_name, all(node.reader_gid_seq), all(node.writer_gid_seq)});
  }
  return older;
}

}  // namespace musher::msg
