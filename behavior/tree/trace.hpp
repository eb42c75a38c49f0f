#pragma once
// What happened in a tree: its last changes, and for each node how often it was started and how
// long it was RUNNING. Only a change costs anything; a tick without one records nothing. Allocates
// its places once. Listeners also get the resets, for a recording.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/behavior/recent.hpp"
#include "musher/behavior/tree/status.hpp"

namespace musher::tree {

using NodeId = std::uint32_t;  // in the order of the XML, 0 is the root

// A change of a node's status. A reset after SUCCESS or FAILURE is not recorded.
struct Change {
  Time at{};
  NodeId node = 0;
  Status from = Status::kIdle;
  Status to = Status::kIdle;  // IDLE: halted

  friend bool operator==(const Change&, const Change&) = default;
};

// Gets every change as it is made, and every reset of a node that has ended, from SUCCESS or
// FAILURE to IDLE. It must not change the tree. One that throws gets nothing any more and is
// counted: the tree goes on without it.
class ChangeListener {
 public:
  virtual ~ChangeListener() = default;
  virtual void OnChange(const Change& change) = 0;
};

// Counts of one node, since the tree was built.
struct NodeRuns {
  std::uint32_t starts = 0;
  Duration spent{};             // in RUNNING, without the present time
  Time since{};                 // of the last RUNNING
  Status last = Status::kIdle;  // the last change; IDLE: never ticked, or halted
};

class Trace {
 public:
  explicit Trace(std::size_t history) : history_(history) {}

  void Resize(std::size_t nodes) { nodes_.assign(nodes, {}); }
  void Add(const Change& change) {
    ++changes_;
    history_.Emplace(change.at, change.node, change.from, change.to);
    NodeRuns& node = nodes_[change.node];
    if (change.from == Status::kRunning) {
      node.spent += change.at - node.since;
    } else if (change.to != Status::kIdle) {
      ++node.starts;
    }
    if (change.to == Status::kRunning) node.since = change.at;
    node.last = change.to;
    if (!listeners_.empty()) Notify({change.at, change.node, change.from, change.to});
  }
  void AddReset(const Change& change) {
    if (!listeners_.empty()) Notify(change);
  }
  // As long as it exists.
  void Listen(const std::shared_ptr<ChangeListener>& listener) {
    std::erase_if(listeners_, [](const auto& each) { return each.expired(); });
    listeners_.push_back(listener);
  }

  // How many there were, also those that the history has forgotten.
  std::uint64_t changes() const { return changes_; }
  // Listeners that have thrown.
  std::uint64_t dropped() const { return dropped_; }
  const Recent<Change>& history() const { return history_; }
  const NodeRuns& node(NodeId id) const { return nodes_.at(id); }

 private:
  void Notify(const Change& change) {
    for (auto& each : listeners_) {
      const auto listener = each.lock();
      if (!listener) continue;
      try {
        listener->OnChange(change);
      } catch (...) {
        each.reset();
        ++dropped_;
      }
    }
  }

  std::uint64_t changes_ = 0;
  std::uint64_t dropped_ = 0;
  Recent<Change> history_;
  std::vector<NodeRuns> nodes_;
  std::vector<std::weak_ptr<ChangeListener>> listeners_;
};

}  // namespace musher::tree
