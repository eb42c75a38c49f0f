// The default functions of states and listeners. Not in the headers, where the compiler would
// speculate at each call that they are not overridden.

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

void Listener::OnChange(const Machine& /*machine*/, const Change& /*change*/) {}
void Listener::OnChangeInside(const Machine& /*machine*/, const Machine& /*inside*/,
                              const Change& /*change*/) {}
void Listener::OnKept(const Machine& /*machine*/, EventId /*command*/, StateId /*state*/) {}
void Listener::OnUnhandled(const Machine& /*machine*/, EventId /*command*/, StateId /*state*/) {}
void Listener::OnFault(const Machine& /*machine*/, const Fault& /*fault*/) {}

}  // namespace musher::fsm
