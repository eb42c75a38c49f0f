#pragma once
// PHOTO_POSING: the robot confirms, poses, counts down, takes the picture and thanks.
//
//   confirm 1.0 s -> pose 1.5 s -> countdown 3.0 s -> shutter 0.5 s -> done, back to TRACKING

#include <array>

#include "musher/modules/wedding/data/show_rules.hpp"
#include "musher/modules/wedding/states/wedding_state.hpp"

namespace musher::wedding {

class PhotoPosing : public WeddingState {
 public:
  enum class Phase { kConfirm, kPose, kCountdown, kShutter, kDone };

  PhotoPosing(ShowData& data, const PhotoRules& rules);

  void Declare(fsm::Transitions& transitions) override;
  void OnEnter(const fsm::Tick& tick) override;
  void OnExit(const fsm::Tick& tick) override;
  void Persist(fsm::Archive& archive) override { archive.Field("phase", phase_); }

  Phase phase() const { return phase_; }

 protected:
  fsm::Next Decide(const fsm::Tick& tick) override;

 private:
  void Begin(Phase phase);

  const std::array<Duration, 4> ends_;  // of the phases before kDone, since the state was entered
  Phase phase_ = Phase::kConfirm;
  fsm::StateId tracking_ = fsm::kNoState;
};

}  // namespace musher::wedding
