#include "musher/modules/wedding/states/wedding_state.hpp"

#include <algorithm>

namespace musher::wedding {

void WeddingState::Declare(fsm::Transitions& transitions) {
  stop_ = transitions.On(command::kStop);
  idle_ = transitions.On(command::kIdle);
  photo_ = transitions.On(command::kPhoto);
  tracking_ = transitions.On(command::kTracking);
  if (name_ != state::kIdle) to_idle_ = transitions.To(state::kIdle, "command stop or idle");
  if (name_ != state::kPhotoPosing)
    to_photo_ = transitions.To(state::kPhotoPosing, "command photo");
  if (name_ != state::kTracking)
    to_tracking_ = transitions.To(state::kTracking, "command tracking");
}

fsm::Next WeddingState::CheckTransition(const fsm::Tick& tick) {
  fsm::StateId target = fsm::kNoState;
  if (tick.command != fsm::kNoEvent) {
    if (tick.command == stop_ || tick.command == idle_) {
      data_.LeaveAlone();
      if (to_idle_ == fsm::kNoState) return fsm::Next::Handle();
      target = to_idle_;
    }
    if (tick.command == photo_) target = to_photo_;
    if (tick.command == tracking_) target = to_tracking_;
  }
  return target == fsm::kNoState ? Decide(tick) : fsm::Next::To(target);
}

void WeddingState::FollowFace(const fsm::Tick& tick) {
  const PerceptionData& seen = data_.perception;
  if (seen.face_detected && seen.face_gaze_known) LookTo(seen.face_gaze, tick);
}

void WeddingState::LookTo(Gaze target, const fsm::Tick& tick) {
  Gaze& gaze = data_.motion.look_at_target;
  gaze = Follow(gaze, data_.look_override.value_or(target), data_.follow, tick.step);
}

Duration WeddingState::Lost(const fsm::Tick& tick) const {
  return std::min(tick.elapsed, data_.perception.face_unseen_for);
}

Duration WeddingState::Seen(const fsm::Tick& tick) const {
  if (!data_.perception.face_detected) return {};
  return std::min(data_.perception.face_seen_for,
                  std::max(Duration(0), tick.elapsed - data_.perception.face_unseen_for));
}

}  // namespace musher::wedding
