#include "musher/modules/wedding/states/tracking.hpp"

namespace musher::wedding {

void Tracking::Declare(fsm::Transitions& transitions) {
  WeddingState::Declare(transitions);
  photo_ = transitions.To(state::kPhotoPosing, "a heart or a V");
  farewell_ = transitions.To(state::kFarewell, "the face is lost");
}

void Tracking::OnEnter(const fsm::Tick& /*tick*/) {
  if (rules_.greets) data().Speak(sound::kGreeting);
}

void Tracking::Run(const fsm::Tick& tick) {
  FollowFace(tick);
}

fsm::Next Tracking::Decide(const fsm::Tick& tick) {
  const PerceptionData& seen = data().perception;
  const bool wants_photo = (seen.gesture == Gesture::kHeart || seen.gesture == Gesture::kV) &&
                           seen.gesture_confidence > rules_.gesture_threshold;
  if (wants_photo && seen.gesture_number != data().gesture_answered) return fsm::Next::To(photo_);
  if (Lost(tick) >= rules_.lost) return fsm::Next::To(farewell_);
  return fsm::Next::Stay();
}

}  // namespace musher::wedding
