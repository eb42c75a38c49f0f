#pragma once
// What the renderings of trees share. Reports come from the network: a parent may be any number.

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/messages/musher_msgs/tree.hpp"

namespace musher::cli {

// Nothing: the node is a root. A parent has a smaller id.
inline std::optional<std::size_t> ParentOf(const std::vector<msg::TreeNode>& nodes,
                                           std::size_t id) {
  const std::int32_t parent = nodes[id].parent;
  if (parent < 0 || static_cast<std::size_t>(parent) >= id) return std::nullopt;
  return static_cast<std::size_t>(parent);
}

inline std::vector<std::size_t> DepthsOf(const std::vector<msg::TreeNode>& nodes) {
  std::vector<std::size_t> depths(nodes.size());
  for (std::size_t id = 0; id < nodes.size(); ++id) {
    const auto parent = ParentOf(nodes, id);
    depths[id] = parent ? depths[*parent] + 1 : 0;
  }
  return depths;
}

// "Sequence/approach/Move": the names from the root.
inline std::string PathOf(const std::vector<msg::TreeNode>& nodes, std::size_t id) {
  if (id >= nodes.size()) return "?";
  std::string path = nodes[id].name;
  for (auto parent = ParentOf(nodes, id); parent; parent = ParentOf(nodes, *parent)) {
    path = nodes[*parent].name + "/" + path;
  }
  return path;
}

inline std::uint8_t StatusOf(const msg::TreeState& state, std::size_t id) {
  return id < state.status.size() ? state.status[id] : msg::TreeState::kIdle;
}

// "SubTree Drive"; empty: the name says it.
inline std::string TypeText(const msg::TreeNode& node) {
  if (node.kind == "SubTree") return node.name == node.type ? "SubTree" : "SubTree " + node.type;
  return node.type == node.name ? "" : node.type;
}

}  // namespace musher::cli
