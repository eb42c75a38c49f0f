#include "musher/modules/wedding/states/idle.hpp"

#include <cmath>
#include <numbers>

namespace musher::wedding {

void Idle::Declare(fsm::Transitions& transitions) {
  WeddingState::Declare(transitions);
  tracking_ = transitions.To(state::kTracking, "a face is seen");
}

void Idle::OnEnter(const fsm::Tick& /*tick*/) {
  data().motion.target_pose = pose::kNeutral;
}

void Idle::Run(const fsm::Tick& tick) {
  const double turns =
      static_cast<double>(tick.elapsed.count()) / static_cast<double>(rules_.sway_period.count());
  LookTo({0.5 + rules_.sway * std::sin(2 * std::numbers::pi * turns), 0.5}, tick);
}

fsm::Next Idle::Decide(const fsm::Tick& tick) {
  if (LeavesAlone() || !SeesGuest(tick)) return fsm::Next::Stay();
  return fsm::Next::To(tracking_);
}

bool Idle::SeesGuest(const fsm::Tick& /*tick*/) {
  const PerceptionData& seen = data().perception;
  return seen.face_detected && seen.face_seen_for >= rules_.confirm;
}

// The guest who is present when IDLE is commanded is ignored until he leaves or another one comes.
bool Idle::LeavesAlone() {
  const PerceptionData& seen = data().perception;
  int& ignored = data().left_alone_face;
  if (ignored < 0) ignored = seen.face_id;
  const bool another = seen.face_id >= 0 && seen.face_id != ignored;
  if (!seen.face_detected || another) data().left_alone = false;
  return data().left_alone;
}

}  // namespace musher::wedding
