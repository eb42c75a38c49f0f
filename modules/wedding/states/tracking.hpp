#pragma once
// TRACKING: the robot greets, and head and waist follow the face. A heart or a V requests a photo.

#include "musher/modules/wedding/data/show_rules.hpp"
#include "musher/modules/wedding/states/wedding_state.hpp"

namespace musher::wedding {

class Tracking : public WeddingState {
 public:
  Tracking(ShowData& data, const TrackingRules& rules)
      : WeddingState(data, state::kTracking), rules_(rules) {}

  void Declare(fsm::Transitions& transitions) override;
  void OnEnter(const fsm::Tick& tick) override;
  void Run(const fsm::Tick& tick) override;

 protected:
  fsm::Next Decide(const fsm::Tick& tick) override;

 private:
  const TrackingRules rules_;
  fsm::StateId photo_ = fsm::kNoState;
  fsm::StateId farewell_ = fsm::kNoState;
};

}  // namespace musher::wedding
