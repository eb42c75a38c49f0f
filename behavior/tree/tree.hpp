#pragma once
// A behaviour tree, built and ready to be ticked: its nodes, blackboards, status and history.
//
//   tree::Reading read = tree::ReadTreeFile("course.xml");          // xml/tree_xml.hpp
//   tree::Built built = tree::Build(read.document, factory);        // build.hpp
//   built.tree->TickOnce(now);                                      // as often as wanted
//
// A tick ends with SUCCESS, FAILURE, RUNNING or SKIPPED, or fails with the place and the path of
// the node that threw ("course.xml:9:13: Main/approach/Move: ..."): then every running node has
// been halted, and the next tick begins again at the root. After SUCCESS and FAILURE the next tick
// begins again, too.
//
// Time is an argument; one that is before the last is taken for the last. A tick allocates nothing
// of its own.
//
// Threads: one at a time. A node can neither tick nor halt its own tree: that is refused.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/behavior/tree/board.hpp"
#include "musher/behavior/tree/document.hpp"
#include "musher/behavior/tree/factory.hpp"
#include "musher/behavior/tree/hooks.hpp"
#include "musher/behavior/tree/node.hpp"
#include "musher/behavior/tree/wake_up.hpp"

namespace musher::tree {

inline constexpr NodeId kNoNode = static_cast<NodeId>(-1);

// What is known of a node beside its behaviour.
struct NodeInfo {
  std::string name;  // of the instance
  std::string id;    // of its class; of a subtree that of its tree
  NodeKind kind = NodeKind::kAction;
  NodeId parent = kNoNode;
  std::uint32_t board = 0;
  bool takes_time = false;
  Place place;
  int line = 0;  // of the place
  int column = 0;
};

class Tree {
 public:
  // How often TickOnce() ticks at most.
  static constexpr int kMostTicksAtOnce = 100;

  ~Tree();  // halts nothing
  Tree(const Tree&) = delete;
  Tree& operator=(const Tree&) = delete;

  // One tick.
  Result<Status> TickExactlyOnce(Time now);
  // One tick, and a further one as long as a node has asked for it (Repeat, RetryUntilSuccessful,
  // SequenceWithMemory, AsyncSequence, WakeUp), at most kMostTicksAtOnce.
  Result<Status> TickOnce(Time now);
  // Halts every running node once. An error has the path of a node that threw, and what it threw.
  Result<> Halt(Time now);
  // `notify` is called when a node asks for a tick between two ticks, by WakeUp. It returns at
  // once, and neither ticks nor destroys the tree: later. Null: nothing is called any more.
  void OnWakeUp(std::function<void()> notify);
  // The clock has jumped back: further ticks may be before the last. Nothing may be running.
  void SetTime(Time now) { tick_.now = now; }

  const std::string& name() const { return name_; }
  std::size_t size() const { return nodes_.size(); }
  const NodeInfo& info(NodeId id) const { return infos_.at(id); }
  Status status(NodeId id) const { return nodes_.at(id)->status(); }
  Status status() const { return nodes_.front()->status(); }
  // "Main/approach/Move": the names from the root. The second of two siblings with one name is
  // "Move#2".
  std::string Path(NodeId id) const;
  // "course.xml:9:13"
  std::string PlaceOf(NodeId id) const;
  std::optional<NodeId> Find(std::string_view path) const;
  std::vector<NodeId> Children(NodeId id) const;
  const Recent<Change>& history() const { return trace_.history(); }
  // How many changes there were, also those that the history has forgotten.
  std::uint64_t changes() const { return trace_.changes(); }
  const NodeRuns& runs(NodeId id) const { return trace_.node(id); }
  // How long a node was RUNNING up to `now`.
  Duration Spent(NodeId id, Time now) const;
  // "12.5 s Main/approach/Move: RUNNING -> SUCCESS", a line for each change.
  std::string HistoryText() const;

  // `listener` gets all changes and resets, `hooks` apply, as long as they exist. Attach again
  // when a hook was added. Between two ticks.
  void Listen(const std::shared_ptr<ChangeListener>& listener) { trace_.Listen(listener); }
  // How many listeners have thrown, and therefore get nothing any more.
  std::uint64_t dropped_listeners() const { return trace_.dropped(); }
  void Attach(const std::shared_ptr<Hooks>& hooks);

  // Board of the main tree.
  Board& board() { return *boards_.front(); }
  // Board of the subtree that a node belongs to.
  Board& board(NodeId id) { return *boards_.at(infos_.at(id).board); }
  // The boards of the main tree and of each subtree, in the order of their nodes.
  const std::vector<std::shared_ptr<Board>>& boards() const { return boards_; }

 private:
  friend class Builder;
  Tree(std::string name, std::size_t history);
  Result<Status> TickNodes();
  void HaltNodes();
  Error Fault(NodeId id, const std::string& what) const;
  void BeginAt(Time now);
  void BeginRun();
  void EndRun();
  std::string NameAmongSiblings(NodeId id) const;

  std::string name_;
  std::vector<std::string> files_;              // that its nodes come from
  bool busy_ = false;                           // within a tick or a halt
  std::shared_ptr<const Enums> enums_;          // of the scripts
  std::vector<std::shared_ptr<Board>> boards_;  // by subtree, the main tree first
  std::vector<std::unique_ptr<Node>> nodes_;    // by id
  std::vector<NodeInfo> infos_;
  std::vector<std::pair<Node*, RunObserver*>> run_observers_;
  bool begins_ = true;  // the next tick is the first one of a run
  Trace trace_;
  Tick tick_;
  std::weak_ptr<Hooks> hooks_;
  std::shared_ptr<WakeUp::State> wake_up_;  // null: no node has asked for one
};

// For Graphviz: the nodes with their status, in colour.
std::string ToDot(const Tree& tree);

}  // namespace musher::tree
