#include "musher/cli/config/tree_file.hpp"

#include <algorithm>
#include <functional>
#include <set>

#include "musher/base/suggest.hpp"
#include "musher/behavior/tree/btcpp.hpp"
#include "musher/behavior/tree/models.hpp"
#include "musher/behavior/tree/nav2/nodes.hpp"
#include "musher/behavior/tree/xml/tree_xml.hpp"

namespace musher::cli {
namespace {

void Append(std::vector<Diagnostic>& all, const std::vector<Diagnostic>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

// The class of a node: <Move/> or <Action ID="Move"/>.
std::string ClassOf(const tree::Element& element) {
  const bool form = element.name == "Action" || element.name == "Condition" ||
                    element.name == "Decorator" || element.name == "Control";
  const tree::Attribute* id = form ? element.Find("ID") : nullptr;
  return id == nullptr ? element.name : id->value;
}

bool IsSubtree(const tree::Element& element) {
  return element.name == "SubTree" || element.name == "SubTreePlus";
}

void ForEach(const tree::Element& element,
             const std::function<void(const tree::Element&)>& function) {
  for (const tree::Element& child : element.children) {
    function(child);
    ForEach(child, function);
  }
}

// Makes the rows of a document.
class Rows {
 public:
  explicit Rows(const tree::Document& document) : document_(document) {
    static_cast<void>(tree::AddPlaceholders(factory_, document));
  }

  Result<> Add(const tree::Document::Tree& of, std::int32_t parent) {
    if (std::ranges::find(inside_, of.id) != inside_.end()) {
      return Error{kCodeParametersInvalid,
                   "the trees are recursive: '" + of.id + "' contains itself"};
    }
    inside_.push_back(of.id);
    for (const tree::Element& child : of.content.children) {
      if (auto added = Add(child, parent); !added) return added;
    }
    inside_.pop_back();
    return Ok();
  }
  std::vector<FileNode> Take() { return std::move(rows_); }

 private:
  Result<> Add(const tree::Element& element, std::int32_t parent) {
    if (rows_.size() >= tree::kMostNodes || inside_.size() > tree::kDeepestTree) {
      return Error{kCodeParametersInvalid,
                   "the tree has more than " + std::to_string(tree::kMostNodes) +
                       " nodes, or is deeper than " + std::to_string(tree::kDeepestTree)};
    }
    const auto id = static_cast<std::int32_t>(rows_.size());
    rows_.push_back(Row(element, parent));
    for (const tree::Element& child : element.children) {
      if (auto added = Add(child, id); !added) return added;
    }
    const tree::Attribute* other = IsSubtree(element) ? element.Find("ID") : nullptr;
    const tree::Document::Tree* tree = other == nullptr ? nullptr : document_.Find(other->value);
    return tree == nullptr ? Ok() : Add(*tree, id);
  }

  FileNode Row(const tree::Element& element, std::int32_t parent) const {
    FileNode row;
    const bool subtree = IsSubtree(element);
    const tree::Attribute* name = element.Find("name");
    const tree::Attribute* id = element.Find("ID");
    row.node.type = subtree && id != nullptr ? id->value : ClassOf(element);
    row.node.name = name != nullptr ? name->value : row.node.type;
    row.node.kind = subtree ? "SubTree" : KindOf(element, row.node.type);
    row.node.parent = parent;
    const Diagnostic at = document_.At(element.at, Severity::kNote, "");
    row.node.file = at.file;
    row.node.line = static_cast<std::uint32_t>(at.line);
    for (const tree::Attribute& attribute : element.attributes) {
      if (&attribute == name || &attribute == id) continue;
      row.attributes.emplace_back(attribute.name, attribute.value);
    }
    return row;
  }
  // Of an unknown node by its children.
  std::string KindOf(const tree::Element& element, const std::string& type) const {
    if (const auto* known = factory_.Find(type)) return std::string(tree::Name(known->kind));
    if (element.children.empty()) return "Action";
    return element.children.size() == 1 ? "Decorator" : "Control";
  }

  const tree::Document& document_;
  tree::Factory factory_;
  std::vector<FileNode> rows_;
  std::vector<std::string> inside_;
};

}  // namespace

TreeFile ReadTreeWithModels(const std::string& file, const TreeFileOptions& options) {
  TreeFile result;
  tree::Factory factory;
  for (const std::string& path : options.models) {
    const tree::Reading reading = tree::ReadModelsFile(path);
    Append(result.diagnostics, reading.diagnostics);
    Append(result.diagnostics, tree::AddPlaceholders(factory, reading.document));
  }
  tree::Reading reading = tree::ReadTreeFile(file);
  Append(result.diagnostics, reading.diagnostics);
  result.document = std::move(reading.document);
  if (HasError(reading.diagnostics)) return result;
  Append(result.diagnostics, tree::AddPlaceholders(factory, result.document));
  // A node of the program with the name of one of nav2 is that of the program.
  if (options.nav2) tree::nav2::AddForCheck(factory);
  std::set<std::string> placeholders;
  for (const tree::Document::Tree& each : result.document.trees) {
    ForEach(each.content, [&](const tree::Element& element) {
      if (IsSubtree(element)) return;
      const std::string type = ClassOf(element);
      const tree::Factory::Registered* known = factory.Find(type);
      if (known == nullptr) result.has_unknown = true;
      if (known != nullptr && known->placeholder) placeholders.insert(type);
    });
  }
  result.placeholders.assign(placeholders.begin(), placeholders.end());
  tree::Built built =
      tree::Build(result.document, factory, {.tree = options.tree, .any_root = true});
  Append(result.diagnostics, built.diagnostics);
  if (!options.as.empty()) {
    Append(result.diagnostics, tree::DifferencesToBtcpp(result.document, factory));
  }
  if (!HasError(result.diagnostics)) result.tree = std::move(built.tree);
  return result;
}

Result<std::vector<FileNode>> NodesOf(const tree::Document& document, const std::string& name) {
  std::vector<std::string> wanted = {name};
  if (name.empty() && document.main) {
    wanted = {document.main->value};
  } else if (name.empty()) {
    wanted.clear();
    for (const tree::Document::Tree& each : document.trees) wanted.push_back(each.id);
  }
  Rows rows(document);
  for (const std::string& id : wanted) {
    const tree::Document::Tree* found = document.Find(id);
    if (found == nullptr) {
      std::vector<std::string> names;
      for (const tree::Document::Tree& each : document.trees) names.push_back(each.id);
      return Error{kCodeParametersInvalid, "there is no tree '" + id + "'" + DidYouMean(id, names)};
    }
    if (auto added = rows.Add(*found, -1); !added) return added.error();
  }
  return rows.Take();
}

}  // namespace musher::cli
