#include "musher/cli/nav2/nav2_config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <optional>
#include <span>
#include <string_view>

#include "musher/base/code.hpp"
#include "musher/base/toml/names.hpp"
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
  std::string name_space;               // "dog1"; empty: the root
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
  constexpr double kLongestSeconds = 3600;
  return static_cast<std::int64_t>(std::clamp(value, 0.0, kLongestSeconds) * 1000);
}

// As ROS 2's parser of parameter files takes a boolean.
bool IsTrue(const ParamsNode* value) {
  if (value == nullptr) return false;
  std::string text = value->text;
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text == "true" || text == "yes" || text == "on" || text == "y";
}

using KeyWords = std::vector<std::string>;

// "/dog1/amcl" as {"dog1", "amcl"}.
KeyWords WordsOf(std::string_view name) {
  KeyWords words;
  while (!name.empty()) {
    const std::size_t slash = std::min(name.find('/'), name.size());
    if (slash > 0) words.emplace_back(name.substr(0, slash));
    name.remove_prefix(std::min(slash + 1, name.size()));
  }
  return words;
}

std::string KeyOf(std::span<const std::string> words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : "/") + word;
  return text;
}

// Whether a key of a parameter file is for that node: "*" is any word, "**" any number of words.
bool IsFor(std::span<const std::string> key, std::span<const std::string> node) {
  if (key.empty()) return node.empty();
  if (key[0] == "**") {
    return IsFor(key.subspan(1), node) || (!node.empty() && IsFor(key, node.subspan(1)));
  }
  return !node.empty() && (key[0] == "*" || key[0] == node[0]) &&
         IsFor(key.subspan(1), node.subspan(1));
}

class Reader {
 public:
  // A node of the file may be below a namespace: "/dog1: amcl: ros__parameters: …". `above`: the
  // keys around `tree`.
  void Read(const ParamsNode& tree, const std::string& path, const KeyWords& above = {}) {
    for (const auto& [name, node] : tree.members) {
      KeyWords key = above;
      for (std::string& word : WordsOf(name)) key.push_back(std::move(word));
      const ParamsNode* parameters = ParametersOf(node);
      if (parameters == nullptr) {
        Read(node, path, key);
        continue;
      }
      if (const ParamsNode* starts = parameters->Find("autostart")) {
        starts_.emplace_back(key, IsTrue(starts));
      }
      if (const ParamsNode* names = parameters->Find("node_names")) {
        managers_.push_back(key);
        Manage(*parameters, *names, NamespaceOf(key));
      }
      with_parameters_.emplace_back(std::move(key), path);
    }
  }

  std::vector<Node> Nodes() {
    if (nodes_.empty()) {
      for (const KnownNode& known : kKnownNodes) {
        for (const auto& [key, path] : with_parameters_) {
          if (!key.empty() && key.back() == known.name) {
            Add(known.name, NamespaceOf(key), std::nullopt);
          }
        }
      }
    }
    for (Node& node : nodes_) {
      KeyWords full = WordsOf(node.name_space);
      full.push_back(node.name);
      for (const auto& [key, path] : with_parameters_) {
        const bool listed = std::ranges::count(node.files, path) != 0;
        if (!listed && IsFor(key, full)) node.files.push_back(path);
      }
    }
    return nodes_;
  }
  bool managed() const { return !managers_.empty(); }
  // As their managers start them; nav2's does by `autostart` only. Without a manager in the files
  // its launch files have one that does. A manager may have it in another block than its names, or
  // its names in a launch file. Which of two blocks ROS 2 would take is not decided here: one
  // without `true` suffices to wait.
  bool starts_at_once() const {
    return std::ranges::all_of(starts_, [](const auto& start) { return start.second; }) &&
           std::ranges::all_of(managers_, [this](const KeyWords& manager) {
             return std::ranges::any_of(
                 starts_, [&](const auto& start) { return IsFor(start.first, manager); });
           });
  }

 private:
  // Of a key that is for any namespace, the root.
  static std::string NamespaceOf(const KeyWords& key) {
    if (key.empty() || KeyOf(key).find('*') != std::string::npos) return "";
    return KeyOf(std::span(key).first(key.size() - 1));
  }

  // The names are below the namespace of the manager.
  void Manage(const ParamsNode& manager, const ParamsNode& names, const std::string& name_space) {
    last_.clear();
    const auto bond_ms = MillisecondsOf(manager.Find("bond_timeout"));
    for (const std::string& name : names.list) Add(name, name_space, bond_ms);
  }
  void Add(const std::string& name, const std::string& name_space,
           std::optional<std::int64_t> bond_ms) {
    const bool known = std::ranges::any_of(nodes_, [&](const Node& node) {
      return node.name == name && node.name_space == name_space;
    });
    if (known) return;
    nodes_.push_back({name, name_space, {}, last_, bond_ms});
    last_ = name;
  }

  std::vector<std::pair<KeyWords, std::string>> with_parameters_;  // key, file
  std::vector<Node> nodes_;
  std::string last_;
  std::vector<KeyWords> managers_;                 // with names, by their keys
  std::vector<std::pair<KeyWords, bool>> starts_;  // key, `autostart`
};

// A config has one namespace. ROS 2 gives a node in another one none of the parameters.
std::optional<Error> FaultOf(const std::vector<Node>& nodes) {
  if (nodes.empty()) {
    return Error{kCodeParametersInvalid,
                 "these files have no lifecycle manager with node_names, and no parameters of a "
                 "server of nav2"};
  }
  for (const Node& node : nodes) {
    if (!config_toml::IsName(node.name)) {
      return Error{kCodeParametersInvalid, "'" + node.name.substr(0, 64) +
                                               "' in node_names is not " +
                                               std::string(config_toml::kNameRule)};
    }
    for (const std::string& word : WordsOf(node.name_space)) {
      if (config_toml::IsName(word)) continue;
      return Error{
          kCodeParametersInvalid,
          "'" + word.substr(0, 64) + "' is no namespace of ROS 2; " + node.name + " is below it"};
    }
    if (node.name_space == nodes[0].name_space) continue;
    const auto full = [](const Node& one) {
      return (one.name_space.empty() ? "/" : "/" + one.name_space + "/") + one.name;
    };
    return Error{kCodeParametersInvalid,
                 full(nodes[0]) + " and " + full(node) +
                     " are in different namespaces, and a config has one: make one of each, from "
                     "files with the nodes of one namespace"};
  }
  return std::nullopt;
}

std::string CommandOf(const Node& node) {
  const auto* const known = std::ranges::find_if(
      kKnownNodes, [&](const KnownNode& one) { return node.name == one.name; });
  const bool is_known = known != std::end(kKnownNodes);
  std::string line =
      fmt::format("command = [\"ros2\", \"run\", \"{}\", \"{}\", \"--ros-args\"",
                  is_known ? known->package : "PACKAGE", is_known ? known->program : "PROGRAM");
  line += fmt::format(", \"-r\", \"__node:={}\"", node.name);
  if (!node.name_space.empty()) {
    line += fmt::format(", \"-r\", \"__ns:=/{}\"", node.name_space);
  }
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
  if (node.files.empty()) text += "# no file has parameters of it: it runs with its defaults\n";
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
  if (auto fault = FaultOf(nodes)) return *fault;
  std::string names;
  for (const Node& node : nodes) {
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
      "[controller]\nname = \"{}\"\n{}actuators = [{}]\n"
      "states = [\"SetUp\", \"TearDown\", \"SelfCheck\", \"Active\", \"DeActive\", \"LowPower\"]\n"
      "default_time = 5000               # ms\ndefault_state = \"Uninitialized\"\n"
      "shutdown_budget_ms = 20000\n",
      reader.managed() ? "the nodes of the lifecycle managers in the parameter files"
                       : "the servers of nav2 with parameters, in the order of its launch files",
      machine,
      nodes[0].name_space.empty() ? "" : fmt::format("namespace = \"{}\"\n", nodes[0].name_space),
      names);
  if (!reader.starts_at_once()) {
    text +=
        "\n# A lifecycle manager of these files has no `autostart: true`: nav2 waits for a call of "
        "its startup.\n"
        "# So the machine waits in SetUp until `musher set SelfCheck` and `musher set Active`, or "
        "a "
        "manager.\n"
        "# Without this table `musher up` brings it to Active.\n"
        "[ros2]\nstart = \"manager\"\n";
  }
  for (const Node& node : nodes) text += TableOf(node);
  return text;
}

}  // namespace musher::cli
