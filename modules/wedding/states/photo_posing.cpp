#include "musher/modules/wedding/states/photo_posing.hpp"

namespace musher::wedding {
namespace {

std::string_view PoseFor(Gesture gesture) {
  switch (gesture) {
    case Gesture::kHeart:
      return pose::kHeart;
    case Gesture::kV:
      return pose::kVSign;
    default:
      return pose::kThumbsUp;
  }
}

}  // namespace

PhotoPosing::PhotoPosing(ShowData& data, const PhotoRules& rules)
    : WeddingState(data, state::kPhotoPosing),
      ends_{rules.confirm, rules.confirm + rules.pose, rules.confirm + rules.pose + rules.countdown,
            rules.confirm + rules.pose + rules.countdown + rules.shutter} {}

void PhotoPosing::Declare(fsm::Transitions& transitions) {
  WeddingState::Declare(transitions);
  tracking_ = transitions.To(state::kTracking, "the picture is taken");
}

void PhotoPosing::OnEnter(const fsm::Tick& /*tick*/) {
  phase_ = Phase::kConfirm;
  data().Speak(sound::kPhotoConfirm);
  data().motion.target_pose = PoseFor(data().perception.gesture);
}

// A late tick executes all missed phases in order.
fsm::Next PhotoPosing::Decide(const fsm::Tick& tick) {
  while (phase_ != Phase::kDone && tick.elapsed >= ends_.at(static_cast<std::size_t>(phase_))) {
    Begin(static_cast<Phase>(static_cast<int>(phase_) + 1));
  }
  return phase_ == Phase::kDone ? fsm::Next::To(tracking_) : fsm::Next::Stay();
}

void PhotoPosing::Begin(Phase phase) {
  phase_ = phase;
  switch (phase) {
    case Phase::kCountdown:
      return data().Speak(sound::kCountdown);
    case Phase::kShutter:
      data().photo_requested = true;
      return data().Speak(sound::kShutter);
    case Phase::kDone:
      return data().Speak(sound::kPhotoDone);
    default:
      return;
  }
}

void PhotoPosing::OnExit(const fsm::Tick& /*tick*/) {
  data().motion.target_pose = pose::kNeutral;
  // A gesture still held counts as answered by this photo, or by the photo that a command ended;
  // not by one that a safety stop interrupted.
  const PerceptionData& seen = data().perception;
  const bool broken_off = phase_ < Phase::kShutter && (seen.too_close || seen.blind);
  if (!broken_off) data().gesture_answered = seen.gesture_number;
}

}  // namespace musher::wedding
