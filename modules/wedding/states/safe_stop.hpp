#pragma once
// SAFE_STOP: a guest is too close, no detector publishes, or a state failed. The robot stands
// neutral and looks ahead until there has been no cause for a while.

#include "musher/behavior/fsm/state.hpp"
#include "musher/modules/wedding/data/show_data.hpp"
#include "musher/modules/wedding/data/show_rules.hpp"

namespace musher::wedding {

// Of the commands it accepts only stop and idle, and only once there is no cause any more.
class SafeStop : public fsm::State {
 public:
  SafeStop(ShowData& data, const SafeStopRules& rules) : data_(data), rules_(rules) {}

  void Declare(fsm::Transitions& transitions) override;
  void OnEnter(const fsm::Tick& tick) override;
  fsm::Next CheckTransition(const fsm::Tick& tick) override;
  void OnExit(const fsm::Tick& tick) override;
  void Persist(fsm::Archive& archive) override { archive.Field("clear_from", clear_from_); }

 private:
  ShowData& data_;
  const SafeStopRules rules_;
  Duration clear_from_{};  // time of the last cause, since the state was entered
  fsm::EventId stop_ = fsm::kNoEvent;
  fsm::EventId idle_ = fsm::kNoEvent;
  fsm::StateId to_idle_ = fsm::kNoState;
};

}  // namespace musher::wedding
