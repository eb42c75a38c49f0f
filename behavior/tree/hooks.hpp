#pragma once
// Breakpoints and results in place of nodes, for a person who debugs a tree while it runs.
//
// A hook stands before or after the tick of one node, behind its conditions. Before it, a
// breakpoint holds a node that is about to start: it is RUNNING for its parent, and stays IDLE
// itself, until it is released or its branch is halted. A node that is already RUNNING is not held,
// because nothing would watch what it does meanwhile. Without a breakpoint, the node is replaced in
// each tick: one that is RUNNING is halted first. After its tick, a node that has completed is
// held, or gets another result: it keeps its own one while it is held, is not ticked again, and
// runs the scripts of the last one.
//
//   auto hooks = std::make_shared<tree::Hooks>();
//   hooks->Set({.node = 5});                                    // hold it
//   hooks->Set({.node = 7, .holds = false, .instead = tree::Status::kFailure});
//   tree.Attach(hooks);                                         // as long as they exist
//   hooks->Release(5, tree::Status::kSkipped, true);            // it starts, once
//
// Threads: one at a time, like the tree.

#include <cstdint>
#include <functional>
#include <map>
#include <utility>

#include "musher/behavior/tree/status.hpp"
#include "musher/behavior/tree/trace.hpp"

namespace musher::tree {

struct Hook {
  NodeId node = 0;
  bool enabled = true;
  bool holds = true;                  // a breakpoint
  bool once = false;                  // is removed when the node goes on
  Status instead = Status::kSkipped;  // SUCCESS or FAILURE in place of a tick; SKIPPED: its tick
  bool after = false;                 // its tick
};

class Hooks {
 public:
  // A node is held, or is replaced.
  explicit Hooks(std::function<void(NodeId)> on_reached = {})
      : on_reached_(std::move(on_reached)) {}

  // Adds the hook, or replaces the hook at the same place. If the new one is no breakpoint, the
  // node is released.
  void Set(const Hook& hook);
  // False: there is none.
  bool Remove(NodeId node, bool after = false) { return hooks_.erase({node, after}) > 0; }
  // Lets a held node go on with the next tick, if that still reaches it. False: its hook does not
  // hold it, so that a release that comes late or twice does not let its next start through.
  bool Release(NodeId node, Status instead, bool once, bool after = false);
  bool Has(NodeId node, bool after = false) const { return hooks_.contains({node, after}); }
  bool IsEnabled(NodeId node, bool after = false) const;
  // Whether the node was held in the last tick, and its branch was not halted since.
  bool IsHeld(NodeId node, bool after = false) const;
  // Whether its hook held the node in the last tick, and it was not released since, or replaced it.
  // Also after a halt of the tree: the node would start with its next run.
  bool Acts(NodeId node, bool after = false) const;
  void Clear() { hooks_.clear(); }
  // None holds any more.
  void DisableAll();
  bool empty() const { return hooks_.empty(); }
  template <class Look>
  void ForEach(const Look& look) const {
    for (const auto& [at, state] : hooks_) look(state.hook);
  }

  // For the tree: a further tick; its end or halt, after which no node is held.
  void BeginTick() { ++ticks_; }
  void EndHolds();
  // For a node: SKIPPED: it is ticked; RUNNING: it is held; else its result.
  Status Before(NodeId node, bool running);
  // For a node that has completed. RUNNING: it is held; else its result.
  Status After(NodeId node, Status result);

 private:
  struct State {
    Hook hook;
    bool released = false;
    bool run_ended = false;         // since it was held
    std::uint64_t held_in = 0;      // tick
    std::uint64_t replaced_in = 0;  // tick
  };

  using Hooked = std::map<std::pair<NodeId, bool>, State>;  // by node, before and after its tick

  // Null: there is none that is enabled.
  State* Find(NodeId node, bool after);
  // Whether it waits for its release.
  bool Holds(State& state);
  Status Pass(State& state);

  const std::function<void(NodeId)> on_reached_;
  Hooked hooks_;
  std::uint64_t ticks_ = 1;
};

}  // namespace musher::tree
