#pragma once
// A state of the course in the machine. Its steps are run by the Runner. Internal to race.cpp.

#include <string>
#include <vector>

#include "musher/modules/race/race.hpp"

namespace musher::race {

class Race::CourseState : public fsm::State {
 public:
  CourseState(Race& race, Index index) : race_(race), index_(index) {}

  void Declare(fsm::Transitions& transitions) override;
  void OnEnter(const fsm::Tick& tick) override;
  fsm::Next CheckTransition(const fsm::Tick& tick) override;
  void OnExit(const fsm::Tick& tick) override;

 private:
  fsm::Next OnCommand(fsm::EventId command);
  fsm::Next Go(Index state) const;
  std::string Condition(const TransitionRule& transition) const;
  bool is_start() const { return index_ == race_.course_.start; }

  Race& race_;
  const Index index_;
  std::vector<fsm::StateId> ids_;  // by state of the course
  fsm::EventId start_ = fsm::kNoEvent;
  fsm::EventId stop_ = fsm::kNoEvent;
};

}  // namespace musher::race
