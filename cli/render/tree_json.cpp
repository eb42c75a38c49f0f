#include <nlohmann/json.hpp>

#include "musher/cli/console/json_line.hpp"
#include "musher/cli/render/tree.hpp"
#include "musher/cli/render/tree_nodes.hpp"

namespace musher::cli {
namespace {

OrderedJson PlaceOf(const msg::TreeNode& node) {
  return {{"name", node.name},
          {"type", node.type},
          {"kind", node.kind},
          {"parent", node.parent < 0 ? OrderedJson() : OrderedJson(node.parent)},
          {"file", Known(node.file)},
          {"line", Known(node.line)}};
}

OrderedJson TreeOf(const std::string& name, const msg::GetTree::Response& report) {
  OrderedJson nodes = OrderedJson::array();
  for (std::size_t id = 0; id < report.nodes.size(); ++id) {
    const msg::TreeNode& node = report.nodes[id];
    OrderedJson json = PlaceOf(node);
    json["status"] = TreeStatusName(StatusOf(report.state, id));
    json["spent_s"] = node.spent_s;
    json["runs"] = node.runs;
    nodes.push_back(std::move(json));
  }
  OrderedJson changes = OrderedJson::array();
  for (const msg::TreeChange& change : report.history) {
    changes.push_back({{"time_s", change.time_s},
                       {"node", change.node},
                       {"path", PathOf(report.nodes, change.node)},
                       {"from", TreeStatusName(change.from)},
                       {"to", TreeStatusName(change.to)}});
  }
  OrderedJson entries = OrderedJson::array();
  for (const msg::TreeEntry& entry : report.entries) {
    entries.push_back(
        {{"board", entry.board}, {"key", entry.key}, {"type", entry.type}, {"value", entry.value}});
  }
  return {{"actuator", name},
          {"tree", Known(report.state.tree)},
          {"status", TreeStatusName(StatusOf(report.state, 0))},
          {"ticking", report.state.ticking},
          {"ticks", report.state.ticks},
          {"time_s", report.state.time_s},
          {"revision", report.state.revision},
          {"last_fault", Known(report.state.last_fault)},
          {"nodes", nodes},
          {"history", changes},
          {"entries", entries}};
}

}  // namespace

std::string TreeJson(const std::string& name, const msg::GetTree::Response& report) {
  return JsonLine(TreeOf(name, report));
}

std::string RecordedTreeJson(const std::string& name, const RecordedMoment& moment) {
  OrderedJson json = TreeOf(name, moment.report);
  json.erase("ticks");  // which are not recorded
  json["number"] = moment.number;
  json["trees"] = moment.trees;
  json["end_s"] = moment.end_s;
  json["wall_us"] = Known(moment.wall_us);
  json["lost_lines"] = moment.lost_lines;
  json["cut_at_line"] = Known(moment.cut_at_line);
  return JsonLine(json);
}

std::string FileTreeJson(const std::vector<FileNode>& nodes) {
  OrderedJson all = OrderedJson::array();
  for (const FileNode& one : nodes) {
    OrderedJson json = PlaceOf(one.node);
    json["attributes"] = OrderedJson::object();
    for (const auto& [name, value] : one.attributes) json["attributes"][name] = value;
    all.push_back(std::move(json));
  }
  return JsonLine({{"nodes", all}});
}

}  // namespace musher::cli
