#include "musher/behavior/tree/hooks.hpp"

#include <utility>

namespace musher::tree {

void Hooks::Set(const Hook& hook) {
  hooks_[hook.node].hook = hook;
}

bool Hooks::Release(NodeId node, Status instead, bool once) {
  const auto found = hooks_.find(node);
  if (found == hooks_.end()) return false;
  State& state = found->second;
  state.hook.instead = instead;
  state.hook.once |= once;
  state.released = state.hook.holds;
  return true;
}

void Hooks::DisableAll() {
  for (auto& [node, state] : hooks_) state.hook.enabled = false;
}

Status Hooks::Before(NodeId node, bool running) {
  const auto found = hooks_.find(node);
  if (found == hooks_.end() || !found->second.hook.enabled) return Status::kSkipped;
  State& state = found->second;
  if (state.hook.holds) {
    if (running) return Status::kSkipped;
    if (!std::exchange(state.released, false)) {
      // Ticks without it in between: its branch was halted, and it is reached again.
      const bool arrives = state.held_in + 1 < ticks_;
      state.held_in = ticks_;
      if (arrives && on_reached_) on_reached_(node);
      return Status::kRunning;
    }
  } else if (on_reached_) {
    on_reached_(node);
  }
  const Status instead = state.hook.instead;
  if (state.hook.once) hooks_.erase(found);
  return instead;
}

}  // namespace musher::tree
