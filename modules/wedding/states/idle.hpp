#pragma once
// IDLE: the robot looks about a little and waits for a guest.

#include "musher/modules/wedding/data/show_rules.hpp"
#include "musher/modules/wedding/states/wedding_state.hpp"

namespace musher::wedding {

class Idle : public WeddingState {
 public:
  Idle(ShowData& data, const IdleRules& rules) : WeddingState(data, state::kIdle), rules_(rules) {}

  void Declare(fsm::Transitions& transitions) override;
  void OnEnter(const fsm::Tick& tick) override;
  void Run(const fsm::Tick& tick) override;

 protected:
  fsm::Next Decide(const fsm::Tick& tick) override;
  // Whether a face has been seen for long enough to track it.
  virtual bool SeesGuest(const fsm::Tick& tick);

 private:
  bool LeavesAlone();

  const IdleRules rules_;
  fsm::StateId tracking_ = fsm::kNoState;
};

}  // namespace musher::wedding
