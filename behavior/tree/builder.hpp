#pragma once
// The build of one tree; only for build.cpp, warnings.cpp and setup.cpp.

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <typeinfo>
#include <unordered_map>
#include <utility>
#include <vector>

#include "musher/behavior/tree/build.hpp"

namespace musher::tree {

class Builder {
 public:
  Builder(const Document& document, const Factory& factory);

  // Null: the tree has errors.
  std::unique_ptr<Tree> Make(const Document::Tree& main, std::size_t history,
                             std::shared_ptr<Board> board);
  void Report(Place place, Severity severity, std::string message) {
    found_.emplace_back(place, severity, std::move(message));
  }
  // Values of the given board of the tree that was made last, as its ports have them.
  using FittingValues = std::vector<std::pair<Entry*, Value>>;
  FittingValues TakeFittingValues() { return std::exchange(fitting_, {}); }
  bool failed() const;
  // The diagnostics by place, each once.
  std::vector<Diagnostic> Take() &&;
  const std::vector<std::string>& used() const { return used_; }  // ids of trees
  // At the end, when all trees were made: substitutions that match no leaf.
  void CheckSubstitutions();

  // An input that neither the element nor its model sets: one warning for each class of nodes.
  void NoteUnset(const Element& element, const std::string& port);

  void ReportScript(const Attribute& attribute, const Script::Finding& finding);

  // Connection of a port of the present node, for Setup.
  Setup::Connection Connect(const Element& element, Board& board, const PortModel& model);
  WakeUp wake_up() const;
  void MarkUsed(const Attribute& attribute) { used_attributes_.push_back(&attribute); }

  // What a node does with an entry, for the warnings.
  void NoteRead(const Entry& entry, Place place) { reads_.emplace_back(&entry, place); }
  void NoteWrite(const Entry& entry, Place place) {
    writes_.emplace(&entry, place);
    made_[&entry].push_back(present());
  }
  // `always`: it runs in each tick of the present node.
  void NoteScript(const Script& script, Place place, bool always);

 private:
  struct Around {
    NodeId parent = kNoNode;
    std::uint32_t board = 0;
    int depth = 0;
  };

  // Null: an error, which is reported.
  Node* MakeNode(const Element& element, const Around& around);
  Node* MakeSubtree(const Element& element, const Around& around);
  Node* MakeRegistered(const Element& element, std::string_view id,
                       const Factory::Registered& registered, const Around& around);
  std::unique_ptr<Node> Call(const Factory::Registered& registered, Setup& setup,
                             const Element& element, std::string_view id);
  void MakeChildren(const Element& element, Node* node, NodeId id, const Around& around);
  void CheckChildren(const Element& element, Node& node, std::string_view id);
  // Null: it is none.
  static Control* AsControl(Node* node);
  static Decorator* AsDecorator(Node* node);
  Node* MakeContent(const Document::Tree& tree, const Around& around);
  std::uint32_t MakeBoard(const Element& element, std::string_view id, std::uint32_t outer);
  void SetConditions(const Element& element, Node& node, Board& board);
  void CheckAttributes(const Element& element, const Setup& setup);
  void UnknownNode(Place place, std::string_view id);
  std::string PlainPath(NodeId id) const;
  std::string TreePath(NodeId id) const;  // "arm/hand/close": the subtrees, and the node
  Entry& Use(Entry& entry, Place place, const PortModel& model);
  void Unify(Entry& entry, Place place, const PortModel& model);
  void UnifyPointers();
  NodeId Reserve(const Element& element, std::string_view id, NodeKind kind,
                 const Factory::Registered* registered, const Around& around);
  Node* Keep(NodeId id, std::unique_ptr<Node> node);
  void FitValues();
  void SetConstants();
  void Warn();  // warnings.cpp
  void WarnOfReactive(NodeId id, const std::vector<NodeId>& children);
  void WarnOfTime(NodeId id, const std::vector<NodeId>& children, bool unsure);
  void WarnOfParallel(NodeId id, std::size_t children);
  void WarnOfShared(NodeId id, const std::vector<NodeId>& children,
                    const std::vector<std::set<std::string>>& uses);
  void WarnOfUnset();
  void WarnOfUnmade();
  bool StartsBefore(NodeId node, NodeId later) const;
  NodeId present() const { return static_cast<NodeId>(tree_->infos_.size() - 1); }

  const Document& document_;
  const Factory& factory_;
  std::unique_ptr<Tree> tree_;
  // What the factory has by each name of the document so far; of null: nothing.
  struct Class {
    const Factory::Registered* registered = nullptr;
    bool is_own = false;  // of the program, not of the library
  };
  std::unordered_map<std::string_view, Class> classes_;
  std::vector<const std::type_info*> no_observers_;  // types of nodes that are no RunObserver
  std::vector<const Element*> elements_;             // by node
  // By node: the class of its name; null: a subtree whose name is no class.
  std::vector<const Factory::Registered*> registered_;
  std::vector<std::tuple<Place, Severity, std::string>> found_;
  std::vector<std::vector<std::uint32_t>> lines_;  // where the lines of each file begin
  // Classes that are not registered, and where nodes of each stand: reported once for a class.
  std::map<std::string, std::set<Place>, std::less<>> unknown_;
  struct Unset {
    std::set<Place> places;
    std::set<std::string> ports;
  };
  std::map<std::string, Unset, std::less<>> unset_;
  std::vector<std::string> inside_;  // the trees around the present node
  std::vector<std::string> used_;
  std::vector<LeafNames> leaves_;  // where there are substitutions
  std::vector<const Attribute*> used_attributes_;
  struct FirstUse {
    const Type* type = nullptr;
    Place place;
    bool elsewhere = false;  // in another tree with the same board
    bool writes = false;     // one of the ports with the type does
    std::optional<Place> read_at{};
  };
  std::map<Entry*, FirstUse> types_;
  // Further uses, with another type that has a base in common with the first.
  std::map<Entry*, std::vector<FirstUse>> pointers_;
  std::set<const Entry*> read_as_text_;
  struct Constant {
    Entry* entry = nullptr;
    const Attribute* attribute = nullptr;
    std::string text;
    Place place;
  };
  std::vector<Constant> constants_;
  FittingValues fitting_;
  // Entries with a place that reads or sets them.
  std::vector<std::pair<const Entry*, Place>> reads_;
  std::vector<std::pair<const Entry*, Place>> script_reads_;  // of them, those of scripts
  std::map<const Entry*, Place> writes_;
  // Entries with the nodes that set them also where they do not exist yet.
  std::map<const Entry*, std::vector<NodeId>> made_;
  // An entry that '=' in a script needs.
  struct Need {
    const Entry* entry = nullptr;
    Place place;
    NodeId node = kNoNode;
    bool always = false;
  };
  std::vector<Need> needed_;
  bool too_large_ = false;
};

}  // namespace musher::tree
