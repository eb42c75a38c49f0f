#include "musher/cli/nav2/nav2_config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <optional>

#include "musher/base/code.hpp"
#include "musher/cli/nav2/params_file.hpp"

namespace musher::cli {
namespace {

struct KnownNode {
  const char* name;
  const char* package;
  const char* program;
};

// Of nav2's launch files, in their order.
constexpr KnownNode kKnownNodes[] = {
    {"map_server", "nav2_map_server", "map_server"},
    {"amcl", "nav2_amcl", "amcl"},
    {"controller_server", "nav2_controller", "controller_server"},
    {"smoother_server", "nav2_smoother", "smoother_server"},
    {"planner_server", "nav2_planner", "planner_server"},
    {"route_server", "nav2_route", "route_server"},
    {"behavior_server", "nav2_behaviors", "behavior_server"},
    {"velocity_smoother", "nav2_velocity_smoother", "velocity_smoother"},
    {"collision_monitor", "nav2_collision_monitor", "collision_monitor"},
    {"bt_navigator", "nav2_bt_navigator", "bt_navigator"},
    {"waypoint_follower", "nav2_waypoint_follower", "waypoint_follower"},
    {"docking_server", "opennav_docking", "opennav_docking"},
};

struct Node {
  std::string name;
  std::vector<std::string> files;       // that have parameters of it
  std::string before;                   // the one that nav2's manager brings up before it; empty
  std::optional<std::int64_t> bond_ms;  // of its manager; 0: no bond
};

// In a TOML string.
std::string Escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '"' || c == '\\') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

// As ROS 2 accepts it for a node.
bool IsNodeName(const std::string& name) {
  return !name.empty() && name.size() <= 255 && std::ranges::all_of(name, [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_';
  });
}

const ParamsNode* ParametersOf(const ParamsNode& node) {
  return node.Find("ros__parameters");
}

// "4.0" s
std::optional<std::int64_t> MillisecondsOf(const ParamsNode* seconds) {
  if (seconds == nullptr) return std::nullopt;
  double value = 0;
  const std::string& text = seconds->text;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  constexpr double kLongest_s = 3600;
  return static_cast<std::int64_t>(std::clamp(value, 0.0, kLongest_s) * 1000);
}

class Reader {
 public:
  // A node of the file may be below a namespace: "/dog1: amcl: ros__parameters: …".
  void Read(const ParamsNode& tree, const std::string& path) {
    for (const auto& [name, node] : tree.members) {
      const ParamsNode* parameters = ParametersOf(node);
      if (parameters == nullptr) {
        Read(node, path);
        continue;
      }
      const std::string own = name.substr(name.rfind('/') + 1);
      with_parameters_.emplace_back(own, path);
      if (const ParamsNode* names = parameters->Find("node_names")) Manage(*parameters, *names);
    }
  }

  std::vector<Node> Nodes() {
    if (nodes_.empty()) {
      for (const KnownNode& known : kKnownNodes) {
        const bool present = std::ranges::any_of(
            with_parameters_, [&](const auto& one) { return one.first == known.name; });
        if (present) Add(known.name, std::nullopt);
      }
    }
    for (Node& node : nodes_) {
      for (const auto& [name, path] : with_parameters_) {
        const bool listed = std::ranges::count(node.files, path) != 0;
        if ((name == node.name || name == "**" || name == "*") && !listed) {
          node.files.push_back(path);
        }
      }
    }
    return nodes_;
  }
  bool managed() const { return managed_; }

 private:
  void Manage(const ParamsNode& manager, const ParamsNode& names) {
    managed_ = true;
    last_.clear();
    const auto bond_ms = MillisecondsOf(manager.Find("bond_timeout"));
    for (const std::string& name : names.list) Add(name, bond_ms);
  }
  void Add(const std::string& name, std::optional<std::int64_t> bond_ms) {
    if (std::ranges::count(nodes_, name, &Node::name) != 0) return;
    nodes_.push_back({name, {}, last_, bond_ms});
    last_ = name;
  }

  std::vector<std::pair<std::string, std::string>> with_parameters_;  // node, file
  std::vector<Node> nodes_;
  std::string last_;
  bool managed_ = false;
};

std::string CommandOf(const Node& node) {
  const auto* const known = std::ranges::find_if(
      kKnownNodes, [&](const KnownNode& one) { return node.name == one.name; });
  const bool is_known = known != std::end(kKnownNodes);
  std::string line =
      fmt::format("command = [\"ros2\", \"run\", \"{}\", \"{}\", \"--ros-args\"",
                  is_known ? known->package : "PACKAGE", is_known ? known->program : "PROGRAM");
  line += fmt::format(", \"-r\", \"__node:={}\"", node.name);
  for (const std::string& file : node.files)
    line += fmt::format(", \"--params-file\", \"{}\"", Escaped(file));
  return line + "]" + (is_known ? "" : "  # fill in the package and its program") + "\n";
}

std::string TableOf(const Node& node) {
  std::string text = fmt::format(
      "\n[actuator.{}]\n"
      "states = [\"SetUp\", \"TearDown\", \"SelfCheck\", \"Active\", \"DeActive\", \"LowPower\"]\n"
      "times = [20000, 5000, 1000, 65000, 5000, 5000]  # ms; a costmap may wait 60 s for a "
      "transform\n",
      node.name);
  text += CommandOf(node) + "cwd = \".\"\nprotocol = \"ros2_lifecycle\"\ncritical = true\n";
  if (!node.before.empty()) text += fmt::format("after = [\"{}\"]\n", node.before);
  if (node.bond_ms && *node.bond_ms > 0) {
    text += fmt::format(
        "checkpoint_ms = {}               # was bond_timeout: a longer hang ends its process\n",
        *node.bond_ms);
  }
  return text;
}

}  // namespace

Result<std::string> Nav2Config(const std::vector<NamedText>& files, const std::string& machine) {
  Reader reader;
  for (const NamedText& file : files) {
    const auto tree = ReadParams(file.text, file.path);
    if (!tree) return tree.error();
    reader.Read(tree.value(), file.path);
  }
  const std::vector<Node> nodes = reader.Nodes();
  if (nodes.empty()) {
    return Error{kCodeParametersInvalid,
                 "these files have no lifecycle manager with node_names, and no parameters of a "
                 "server of nav2"};
  }
  std::string names;
  for (const Node& node : nodes) {
    if (!IsNodeName(node.name)) {
      return Error{kCodeParametersInvalid,
                   "'" + node.name.substr(0, 64) + "' in node_names is no name of a ROS 2 node"};
    }
    names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", node.name);
  }
  std::string text = fmt::format(
      "# Made by `musher new ros2`: {}.\n"
      "#\n"
      "# What changes: Musher starts the nodes, so leave nav2's lifecycle manager and their launch "
      "file\n"
      "# out. A crash is known in about 1 ms, and the node is restarted, configured and activated "
      "again;\n"
      "# no bond is needed. `after` keeps nav2's order: remove it where a node needs no other, and "
      "the\n"
      "# start is parallel. `binds_to` would deactivate a node while another one is down.\n\n"
      "[controller]\nname = \"{}\"\nactuators = [{}]\n"
      "states = [\"SetUp\", \"TearDown\", \"SelfCheck\", \"Active\", \"DeActive\", \"LowPower\"]\n"
      "default_time = 5000               # ms\ndefault_state = \"Uninitialized\"\n"
      "shutdown_budget_ms = 20000\n",
      reader.managed() ? "the nodes of the lifecycle managers in the parameter files"
                       : "the servers of nav2 with parameters, in the order of its launch files",
      machine, names);
  for (const Node& node : nodes) text += TableOf(node);
  return text;
}

}  // namespace musher::cli
