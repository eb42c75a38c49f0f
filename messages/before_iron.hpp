#pragma once
// ROS 2 changed the layout of these messages with Iron. Here is the layout of Galactic and Humble;
// the IDL has the newer one.

#include <algorithm>
#include <cstdint>

#include "musher/messages/rmw_dds_common/participant_entities.hpp"
#include "musher/messages/sensor_msgs/range.hpp"

namespace musher::msg {

// A Gid has 24 bytes, of which the last eight are 0.
struct GidBeforeIron {
  static constexpr std::string_view kTypeName = Gid::kTypeName;
  std::array<std::uint8_t, 24> data{};

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.data);
  }
  friend bool operator==(const GidBeforeIron&, const GidBeforeIron&) = default;
};

struct NodeEntitiesInfoBeforeIron {
  static constexpr std::string_view kTypeName = NodeEntitiesInfo::kTypeName;
  std::string node_namespace;
  std::string node_name;
  std::vector<GidBeforeIron> reader_gid_seq;
  std::vector<GidBeforeIron> writer_gid_seq;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.node_namespace, m.node_name, m.reader_gid_seq, m.writer_gid_seq);
  }
  friend bool operator==(const NodeEntitiesInfoBeforeIron&,
                         const NodeEntitiesInfoBeforeIron&) = default;
};

struct ParticipantEntitiesInfoBeforeIron {
  static constexpr std::string_view kTypeName = ParticipantEntitiesInfo::kTypeName;
  GidBeforeIron gid;
  std::vector<NodeEntitiesInfoBeforeIron> node_entities_info_seq;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.gid, m.node_entities_info_seq);
  }
  friend bool operator==(const ParticipantEntitiesInfoBeforeIron&,
                         const ParticipantEntitiesInfoBeforeIron&) = default;
};

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

// A Range has no variance.
struct RangeBeforeIron {
  static constexpr std::string_view kTypeName = Range::kTypeName;
  Header header;
  std::uint8_t radiation_type = Range::kUltrasound;
  float field_of_view = 0;
  float min_range = 0;
  float max_range = 0;
  float range = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.header, m.radiation_type, m.field_of_view, m.min_range, m.max_range, m.range);
  }
  friend bool operator==(const RangeBeforeIron&, const RangeBeforeIron&) = default;
};

inline RangeBeforeIron BeforeIron(const Range& range) {
  return {range.header,    range.radiation_type, range.field_of_view,
          range.min_range, range.max_range,      range.range};
}

}  // namespace musher::msg
