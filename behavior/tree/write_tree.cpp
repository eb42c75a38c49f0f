#include "musher/behavior/tree/write_tree.hpp"

#include <map>
#include <set>
#include <string_view>
#include <utility>

#include "musher/behavior/tree/model_types.hpp"

namespace musher::tree {
namespace {

std::string Quoted(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    switch (c) {
      case '&':
        quoted += "&amp;";
        break;
      case '<':
        quoted += "&lt;";
        break;
      case '>':
        quoted += "&gt;";
        break;
      case '"':
        quoted += "&quot;";
        break;
      case '\n':
        quoted += "&#10;";
        break;
      default:
        quoted += c;
    }
  }
  return quoted + "\"";
}

class TreeWriter {
 public:
  TreeWriter(const Tree& tree, const Document& document, const WriteOptions& options)
      : tree_(tree), options_(options), paths_(SubtreePaths(tree)) {
    for (const Document::Tree& each : document.trees) Note(each.content);
  }

  std::string Write() && {
    text_ = "<root BTCPP_format=\"4\" main_tree_to_execute=" + Quoted(tree_.name()) + ">\n";
    waiting_.push_back({tree_.name(), "", 0});
    std::size_t next = 0;
    while (next < waiting_.size()) {  // which grows
      const Part part = waiting_[next++];
      if (!options_.with_ids && !written_.insert(part.id).second) continue;
      text_ += "  <BehaviorTree ID=" + Quoted(part.id);
      if (options_.with_ids) text_ += " _fullpath=" + Quoted(part.path);
      text_ += ">\n";
      WriteNode(part.root, 2);
      text_ += "  </BehaviorTree>\n";
    }
    if (options_.models != nullptr) WriteModels();
    return std::move(text_) + "</root>\n";
  }

 private:
  struct Part {
    std::string id;
    std::string path;
    NodeId root = 0;
  };

  void Note(const Element& element) {
    elements_.emplace(element.at, &element);
    for (const Element& child : element.children) Note(child);
  }

  // Returns the first node that is not below this one: ids are in the order of the XML.
  NodeId WriteNode(NodeId id, std::size_t depth) {
    const NodeInfo& info = tree_.info(id);
    const bool subtree = info.kind == NodeKind::kSubtree;
    const std::string indent(2 * depth, ' ');
    const std::string name = OpenElement(id, indent);
    NodeId next = id + 1;
    if (subtree) {
      waiting_.push_back({info.id, paths_.at(id), next});
      next = Behind(next);
      text_ += "/>\n";
      return next;
    }
    bool empty = true;
    while (next < tree_.size() && tree_.info(next).parent == id) {
      text_ += std::exchange(empty, false) ? ">\n" : "";
      next = WriteNode(next, depth + 1);
    }
    text_ += empty ? "/>\n" : indent + "</" + name + ">\n";
    return next;
  }

  std::string OpenElement(NodeId id, const std::string& indent) {
    const NodeInfo& info = tree_.info(id);
    const auto found = elements_.find(info.place);
    const Element* element = found == elements_.end() ? nullptr : found->second;
    std::string name = element != nullptr ? element->name : info.id;
    text_ += indent + "<" + name;
    bool named = false;
    if (element != nullptr) {
      for (const Attribute& attribute : element->attributes) {
        named = named || attribute.name == "name";
        if (options_.with_ids && (attribute.name == "_uid" || attribute.name == "_fullpath")) {
          continue;
        }
        text_ += " " + attribute.name + "=" + Quoted(attribute.value);
      }
    }
    if (options_.with_ids) {
      if (!named) text_ += " name=" + Quoted(info.name);
      if (info.kind == NodeKind::kSubtree) text_ += " _fullpath=" + Quoted(paths_.at(id));
      text_ += " _uid=\"" + std::to_string(id + 1) + "\"";
    }
    return name;
  }

  NodeId Behind(NodeId id) const {
    NodeId next = id + 1;
    while (next < tree_.size() && tree_.info(next).parent != kNoNode &&
           tree_.info(next).parent >= id) {
      ++next;
    }
    return next;
  }

  void WriteModels() {
    std::map<std::string, NodeKind> used;
    for (NodeId id = 0; id < tree_.size(); ++id) {
      if (tree_.info(id).kind != NodeKind::kSubtree) {
        used.emplace(tree_.info(id).id, tree_.info(id).kind);
      }
    }
    text_ += "  <TreeNodesModel>\n";
    for (const auto& [id, kind] : used) {
      text_ += "    <" + std::string(Name(kind)) + " ID=" + Quoted(id) + ">\n";
      for (const PortModel& port : options_.models->PortsOf(id)) {
        const std::string element(PortElement(port.direction));
        text_ += "      <" + element + " name=" + Quoted(port.name);
        const std::string type = TypeNameOf(port);
        if (!type.empty()) text_ += " type=" + Quoted(type);
        text_ += "/>\n";
      }
      text_ += "    </" + std::string(Name(kind)) + ">\n";
    }
    text_ += "  </TreeNodesModel>\n";
  }

  const Tree& tree_;
  const WriteOptions& options_;
  const std::map<NodeId, std::string> paths_;
  std::map<Place, const Element*> elements_;
  std::vector<Part> waiting_;
  std::set<std::string> written_;
  std::string text_;
};

}  // namespace

std::map<NodeId, std::string> SubtreePaths(const Tree& tree) {
  std::map<NodeId, std::string> paths;
  std::map<std::uint32_t, std::string> of_board;  // with '/' at its end
  std::set<std::string> all;
  for (NodeId id = 0; id < tree.size(); ++id) {
    const NodeInfo& info = tree.info(id);
    if (info.kind != NodeKind::kSubtree) continue;
    std::string path = of_board[info.board] + info.name;
    const bool named = info.name != info.id && !all.contains(path);
    if (!named) path += "::" + std::to_string(id + 1);
    all.insert(path);
    if (id + 1 < tree.size()) of_board[tree.info(id + 1).board] = path + "/";
    paths.emplace(id, std::move(path));
  }
  return paths;
}

std::string WriteTree(const Tree& tree, const Document& document, const WriteOptions& options) {
  return TreeWriter(tree, document, options).Write();
}

}  // namespace musher::tree
