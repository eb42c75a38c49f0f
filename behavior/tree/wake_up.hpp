#pragma once
// Lets a node ask for a tick before the next one is due, when what it awaits has come.
//
//   Grip(tree::Setup& setup, Hand& hand) : wake_up_(setup.wake_up()) {
//     hand.OnClosed([wake_up = wake_up_] { wake_up.Request(); });
//   }
//
// Within a tick of the tree, TickOnce() ticks once more. Between two ticks, what the program gave
// to Tree::OnWakeUp() is called; a TreeActuator ticks at once. Further requests before the next
// tick add nothing.
//
// Threads: one at a time, like the tree; another thread of an actuator uses RunOnLoop(). A request
// after the tree is gone does nothing.

#include <functional>
#include <memory>
#include <utility>

namespace musher::tree {

class WakeUp {
 public:
  WakeUp() = default;  // of no tree

  void Request() const;

 private:
  friend class Builder;
  friend class Tree;

  struct State {
    bool ticks = false;      // a tick goes on
    bool again = false;      // requested within it
    bool requested = false;  // between two ticks
    std::function<void()> notify{};
  };
  explicit WakeUp(std::shared_ptr<State> state) : state_(std::move(state)) {}

  std::shared_ptr<State> state_;
};

}  // namespace musher::tree
