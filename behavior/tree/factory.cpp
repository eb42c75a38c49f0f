#include "musher/behavior/tree/factory.hpp"

#include <algorithm>
#include <array>
#include <cctype>

#include "musher/base/check.hpp"
#include "musher/base/suggest.hpp"

namespace musher::tree {
namespace {

class FunctionAction : public Action {
 public:
  explicit FunctionAction(LeafFunction function) : function_(std::move(function)) {}
  Status Do(const Tick& tick) override { return function_(tick); }

 private:
  LeafFunction function_;
};

class FunctionCondition : public Condition {
 public:
  explicit FunctionCondition(LeafFunction function) : function_(std::move(function)) {}
  Status Evaluate(const Tick& tick) override { return function_(tick); }

 private:
  LeafFunction function_;
};

// Bytes beyond ASCII are letters of other languages.
bool CanBeElement(std::string_view name) {
  const auto is_letter = [](char c) {
    return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_' ||
           static_cast<unsigned char>(c) >= 0x80;
  };
  const auto allowed = [&](char c) {
    return is_letter(c) || std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '.';
  };
  return !name.empty() && std::ranges::all_of(name, allowed) && is_letter(name[0]);
}

bool Matches(std::string_view pattern, std::string_view text) {
  std::size_t p = 0;
  std::size_t t = 0;
  std::size_t star = std::string_view::npos;
  std::size_t after = 0;
  while (t < text.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      after = t;
    } else if (p < pattern.size() && pattern[p] == text[t]) {
      ++p;
      ++t;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      t = ++after;
    } else {
      return false;
    }
  }
  while (p < pattern.size() && pattern[p] == '*') ++p;
  return p == pattern.size();
}

}  // namespace

std::string_view Name(NodeKind kind) {
  constexpr std::array<std::string_view, 5> kNames = {"Action", "Condition", "Decorator", "Control",
                                                      "SubTree"};
  return kNames[static_cast<std::size_t>(kind)];
}

Factory::Factory() {
  AddCleanups(*this);
  AddControls(*this);
  AddDecorators(*this);
  AddLeaves(*this);
  AddLoops(*this);
  AddManualSelector(*this);
}

Factory Factory::Empty() {
  return Factory(WithoutNodes{});
}

Result<> Factory::AddAction(std::string_view name, LeafFunction function) {
  return Register(name, {NodeKind::kAction, false,
                         [function = std::move(function)](Setup&) -> std::unique_ptr<Node> {
                           return std::make_unique<FunctionAction>(function);
                         }});
}

Result<> Factory::AddCondition(std::string_view name, LeafFunction function) {
  return Register(name, {NodeKind::kCondition, false,
                         [function = std::move(function)](Setup&) -> std::unique_ptr<Node> {
                           return std::make_unique<FunctionCondition>(function);
                         }});
}

Result<> Factory::Register(std::string_view name, Registered registered) {
  constexpr std::array<std::string_view, 7> kReserved = {
      "Action", "Condition", "Control", "Decorator", "SubTree", "BehaviorTree", "root"};
  if (!CanBeElement(name) || std::ranges::find(kReserved, name) != kReserved.end()) {
    return Error{kCodeFailed, "'" + std::string(name) + "' can not be the name of a node"};
  }
  for (const auto& [field, value] : registered.metadata) {
    if (CanBeElement(field)) continue;
    return Error{kCodeFailed, "'" + field +
                                  "' can not be the name of a field of the metadata of '" +
                                  std::string(name) + "'"};
  }
  if (!nodes_.emplace(name, std::move(registered)).second) {
    return Error{kCodeFailed, "there is already a node '" + std::string(name) + "'"};
  }
  return Ok();
}

void Factory::Substitute(std::string pattern, TestNodeConfig config) {
  substitutes_.push_back({std::move(pattern), std::move(config), ""});
}

Result<> Factory::SubstituteByNode(std::string pattern, std::string_view node) {
  if (Find(node) == nullptr) {
    return Error{kCodeFailed,
                 "there is no node '" + std::string(node) + "'" + DidYouMean(node, Names())};
  }
  substitutes_.push_back({std::move(pattern), {}, std::string(node)});
  return Ok();
}

const Factory::Registered* Factory::Find(std::string_view name) const {
  const auto found = nodes_.find(name);
  return found == nodes_.end() ? nullptr : &found->second;
}

std::vector<std::string> Factory::Names() const {
  std::vector<std::string> names;
  for (const auto& [name, registered] : nodes_) names.push_back(name);
  return names;
}

bool Substitution::Matches(const LeafNames& leaf) const {
  return pattern == leaf.id || tree::Matches(pattern, leaf.name) ||
         tree::Matches(pattern, leaf.path) || tree::Matches(pattern, leaf.tree_path);
}

const Substitution* Factory::Substituted(const LeafNames& leaf) const {
  const auto found =
      std::ranges::find_if(substitutes_, [&](const auto& each) { return each.Matches(leaf); });
  return found == substitutes_.end() ? nullptr : &*found;
}

std::vector<PortModel> Factory::PortsOf(std::string_view name) const {
  const Registered* registered = Find(name);
  if (registered == nullptr) return {};
  const Element element;
  Board board;
  Setup setup(nullptr, element, board, *enums_);
  static_cast<void>(registered->make(setup));
  return setup.ports();
}

}  // namespace musher::tree
