#pragma once
// FAREWELL: the robot waves to guests who leave.

#include "musher/modules/wedding/data/show_rules.hpp"
#include "musher/modules/wedding/states/wedding_state.hpp"

namespace musher::wedding {

class Farewell : public WeddingState {
 public:
  Farewell(ShowData& data, const FarewellRules& rules)
      : WeddingState(data, state::kFarewell), rules_(rules) {}

  void Declare(fsm::Transitions& transitions) override;
  void OnEnter(const fsm::Tick& tick) override;
  void OnExit(const fsm::Tick& tick) override;

 protected:
  fsm::Next Decide(const fsm::Tick& tick) override;

 private:
  const FarewellRules rules_;
  fsm::StateId idle_ = fsm::kNoState;
};

}  // namespace musher::wedding
