#include "musher/modules/wedding/extension/search.hpp"

#include <cmath>
#include <numbers>

namespace musher::wedding {

void Search::Declare(fsm::Transitions& transitions) {
  WeddingState::Declare(transitions);
  tracking_ = transitions.To(state::kTracking, "a face stays");
  idle_ = transitions.To(state::kIdle, "no face is seen, or timeout");
}

void Search::OnEnter(const fsm::Tick& /*tick*/) {
  data().motion.target_pose = pose::kNeutral;
}

void Search::Run(const fsm::Tick& tick) {
  if (data().perception.face_detected) return FollowFace(tick);
  const double turns =
      static_cast<double>(tick.elapsed.count()) / static_cast<double>(rules_.scan_period.count());
  LookTo({0.5 + rules_.scan * std::sin(2 * std::numbers::pi * turns), 0.5}, tick);
}

fsm::Next Search::Decide(const fsm::Tick& tick) {
  if (Seen(tick) >= rules_.confirm) return fsm::Next::To(tracking_);
  if (Lost(tick) >= rules_.no_face || tick.elapsed >= rules_.timeout) return fsm::Next::To(idle_);
  return fsm::Next::Stay();
}

void SearchingIdle::Declare(fsm::Transitions& transitions) {
  Idle::Declare(transitions);
  command_ = transitions.On(command::kSearch);
  search_ = transitions.To(state::kSearch, "a face is seen, or command search");
}

// Of a face alone: the command tracking does not get here.
fsm::Next SearchingIdle::Decide(const fsm::Tick& tick) {
  const bool commanded = tick.command != fsm::kNoEvent && tick.command == command_;
  return commanded || !Idle::Decide(tick).stays() ? fsm::Next::To(search_) : fsm::Next::Stay();
}

}  // namespace musher::wedding
