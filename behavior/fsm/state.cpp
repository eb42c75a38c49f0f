// The default functions of a state. Not in the header, where the compiler would speculate at each
// call that a state does not override them.

#include "musher/behavior/fsm/machine.hpp"

namespace musher::fsm {

void State::Declare(Transitions& /*ways*/) {}
void State::OnEnter(const Tick& /*tick*/) {}
void State::Run(const Tick& /*tick*/) {}
Next State::CheckTransition(const Tick& /*tick*/) {
  return Next::Stay();
}
bool State::Transition(const Tick& tick) {
  return tick.transition_elapsed >= tick.transition_time;
}
void State::OnExit(const Tick& /*tick*/) {}
void State::Persist(Archive& /*archive*/) {}
std::span<const std::unique_ptr<Machine>> State::inside() {
  return {};
}

}  // namespace musher::fsm
