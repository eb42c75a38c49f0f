#include "musher/modules/wedding/states/safe_stop.hpp"

namespace musher::wedding {

void SafeStop::Declare(fsm::Transitions& transitions) {
  stop_ = transitions.On(command::kStop);
  idle_ = transitions.On(command::kIdle);
  to_idle_ = transitions.To(state::kIdle, "no guest is too close for a while");
}

void SafeStop::OnEnter(const fsm::Tick& /*tick*/) {
  clear_from_ = {};
  data_.safety_triggered = true;
  data_.motion.target_pose = pose::kNeutral;
  data_.motion.look_at_target = Gaze{};
  const PerceptionData& seen = data_.perception;
  if (seen.too_close && seen.too_close_number != data_.too_close_warned) {
    data_.Speak(sound::kTooClose);
  }
  data_.too_close_warned = seen.too_close_number;
}

fsm::Next SafeStop::CheckTransition(const fsm::Tick& tick) {
  if (data_.perception.too_close || data_.perception.blind) {
    clear_from_ = tick.elapsed;
    data_.too_close_warned = data_.perception.too_close_number;
    return fsm::Next::Stay();
  }
  const bool commanded =
      tick.command != fsm::kNoEvent && (tick.command == stop_ || tick.command == idle_);
  if (commanded) data_.LeaveAlone();
  if (commanded || tick.elapsed - clear_from_ >= rules_.clear) return fsm::Next::To(to_idle_);
  return fsm::Next::Stay();
}

void SafeStop::OnExit(const fsm::Tick& /*tick*/) {
  data_.safety_triggered = false;
}

}  // namespace musher::wedding
