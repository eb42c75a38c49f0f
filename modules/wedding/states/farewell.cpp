#include "musher/modules/wedding/states/farewell.hpp"

namespace musher::wedding {

void Farewell::Declare(fsm::Transitions& transitions) {
  WeddingState::Declare(transitions);
  idle_ = transitions.To(state::kIdle, "it has waved");
}

void Farewell::OnEnter(const fsm::Tick& /*tick*/) {
  data().Speak(sound::kFarewell);
  data().motion.target_pose = pose::kWave;
}

fsm::Next Farewell::Decide(const fsm::Tick& tick) {
  return tick.elapsed >= rules_.time ? fsm::Next::To(idle_) : fsm::Next::Stay();
}

void Farewell::OnExit(const fsm::Tick& /*tick*/) {
  data().motion.target_pose = pose::kNeutral;
}

}  // namespace musher::wedding
