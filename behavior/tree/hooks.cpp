#include "musher/behavior/tree/hooks.hpp"

#include <utility>

namespace musher::tree {

void Hooks::Set(const Hook& hook) {
  hooks_[{hook.node, hook.after}].hook = hook;
}

bool Hooks::Release(NodeId node, Status instead, bool once, bool after) {
  if (!IsHeld(node, after)) return false;
  State& state = hooks_.at({node, after});
  state.hook.instead = instead;
  state.hook.once |= once;
  state.released = true;
  return true;
}

bool Hooks::IsEnabled(NodeId node, bool after) const {
  const auto found = hooks_.find({node, after});
  return found != hooks_.end() && found->second.hook.enabled;
}

bool Hooks::IsHeld(NodeId node, bool after) const {
  const auto found = hooks_.find({node, after});
  if (found == hooks_.end()) return false;
  const State& state = found->second;
  return state.hook.enabled && state.hook.holds && state.held_in == ticks_ && !state.run_ended;
}

bool Hooks::Acts(NodeId node, bool after) const {
  const auto found = hooks_.find({node, after});
  if (found == hooks_.end() || !found->second.hook.enabled) return false;
  const State& state = found->second;
  if (!state.hook.holds) return state.replaced_in == ticks_;
  return state.held_in == ticks_ && !state.released;
}

void Hooks::EndHolds() {
  for (auto& [at, state] : hooks_) {
    state.run_ended = true;
    state.released = false;
  }
}

void Hooks::DisableAll() {
  for (auto& [at, state] : hooks_) state.hook.enabled = false;
}

Hooks::State* Hooks::Find(NodeId node, bool after) {
  const auto found = hooks_.find({node, after});
  return found == hooks_.end() || !found->second.hook.enabled ? nullptr : &found->second;
}

bool Hooks::Holds(State& state) {
  // Ticks without it in between: its branch was halted, and it is reached again.
  const bool arrives = std::exchange(state.run_ended, false) || state.held_in + 1 < ticks_;
  if (std::exchange(state.released, false) && !arrives) return false;
  state.held_in = ticks_;
  if (arrives && on_reached_) on_reached_(state.hook.node);
  return true;
}

Status Hooks::Pass(State& state) {
  const Hook hook = state.hook;
  state.replaced_in = ticks_;
  state.held_in = 0;
  if (!hook.holds && on_reached_) on_reached_(hook.node);
  if (hook.once) Remove(hook.node, hook.after);
  return hook.instead;
}

Status Hooks::Before(NodeId node, bool running) {
  State* const state = Find(node, false);
  if (state == nullptr) return Status::kSkipped;
  if (state->hook.holds) {
    if (running) return Status::kSkipped;
    if (Holds(*state)) return Status::kRunning;
  }
  return Pass(*state);
}

Status Hooks::After(NodeId node, Status result) {
  State* const state = Find(node, true);
  if (state == nullptr) return result;
  if (state->hook.holds && Holds(*state)) return Status::kRunning;
  const Status instead = Pass(*state);
  return IsCompleted(instead) ? instead : result;
}

}  // namespace musher::tree
